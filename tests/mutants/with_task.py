import torch


def task_first(states, tasks):
    """first the state"""
    return torch.cat([tasks[:, None].expand(*states.shape[:2], -1), states], dim=-1)


def only_the_task(states, tasks):
    """the task alone"""
    return tasks[:, None].expand(*states.shape[:2], -1)


def first_task_for_all(states, tasks):
    """the same context"""
    return torch.cat([states, tasks[:1, None].expand(*states.shape[:2], -1)], dim=-1)


def without_the_task(states, tasks):
    """of shape"""
    return states
