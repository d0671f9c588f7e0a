import torch


def every_distance(states, data):
    """smallest of each row"""
    return torch.cdist(states, data)


def squared(states, data):
    """take the root"""
    return torch.cdist(states, data).min(1).values.square()


def mean_distance(states, data):
    """the mean distance"""
    return torch.cdist(states, data).mean(1)


def farthest(states, data):
    """farthest"""
    return torch.cdist(states, data).max(1).values


def to_the_centre(states, data):
    """centre of the data"""
    return (states - data.mean(0)).norm(dim=-1)
