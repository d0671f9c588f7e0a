import torch


def _cosines(gradients):
    units = gradients / gradients.norm(dim=1, keepdim=True)
    return units @ units.T


def with_itself(gradients):
    """agrees perfectly with itself"""
    return _cosines(gradients).mean()


def lengths_left_in(gradients):
    """divide by both lengths"""
    count = len(gradients)
    products = gradients @ gradients.T
    return (products.sum() - products.trace()) / (count * (count - 1))


def without_sign(gradients):
    """keep the sign"""
    count = len(gradients)
    return (_cosines(gradients).abs().sum() - count) / (count * (count - 1))


def neighbours(gradients):
    """all pairs"""
    return torch.cosine_similarity(gradients[1:], gradients[:-1], dim=1).mean()


def with_the_mean(gradients):
    """the mean of all batches contains"""
    return torch.cosine_similarity(gradients, gradients.mean(0, keepdim=True), dim=1).mean()


def summed(gradients):
    """not their sum"""
    return torch.triu(_cosines(gradients), diagonal=1).sum()
