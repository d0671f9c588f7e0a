"""Wrong answers to notebook 05's `full_step`; each docstring is the sentence the check must say."""

import torch


def no_two(direction, product, max_kl):
    """there is a factor of 2 under the root"""
    return torch.sqrt(max_kl / (direction @ product(direction))) * direction


def no_root(direction, product, max_kl):
    """the root is missing"""
    return 2 * max_kl / (direction @ product(direction)) * direction


def backwards(direction, product, max_kl):
    """the step points backwards"""
    return -torch.sqrt(2 * max_kl / (direction @ product(direction))) * direction


def plain_length(direction, product, max_kl):
    """that is a length in parameters"""
    return (2 * max_kl) ** 0.5 * direction / direction.norm()


def fixed_divergence(direction, product, max_kl):
    """numbers differ"""
    return (0.04 / (direction @ product(direction))).sqrt() * direction


def absolute_in_place(direction, product, max_kl):
    """you changed `direction` in place"""
    return (2 * max_kl / (direction @ product(direction))).sqrt() * direction.abs_()
