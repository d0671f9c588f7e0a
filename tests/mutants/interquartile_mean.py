import numpy as np


def plain_mean(scores):
    """plain mean"""
    return scores.mean()


def median(scores):
    """that is the median"""
    return np.median(scores)


def highest_only(scores):
    """lowest quarter must go too"""
    ordered = np.sort(scores, axis=None)
    return ordered[: len(ordered) - len(ordered) // 4].mean()


def unsorted(scores):
    """sort first"""
    flat = scores.ravel()
    return flat[len(flat) // 4 : len(flat) - len(flat) // 4].mean()


def in_place(scores):
    """in place"""
    flat = scores.reshape(-1)
    flat.sort()
    return flat[len(flat) // 4 : len(flat) - len(flat) // 4].mean()


def empty_middle(scores):
    """not finite"""
    ordered = np.sort(scores, axis=None)
    cut = len(ordered) // 4
    return ordered[cut:-cut].mean()
