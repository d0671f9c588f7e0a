"""The Gaussian policy: a multilayer perceptron for the mean, a learned sigma, plain tensors.

The parameters of one policy are ``params``, a dict of tensors. One set a task is ``task_params``,
the same dict with a leading task axis on every tensor; every function takes either.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import torch

Params = dict[str, torch.Tensor]


class Gaussian(NamedTuple):
    """Independent normal distributions, one an action dimension.

    ========== ============= =====================================
    Symbol     Shape         Description
    ========== ============= =====================================
    mean       (..., action) mean of each action dimension
    log_sigma  (..., action) natural log of the standard deviation
    ========== ============= =====================================
    """

    mean: torch.Tensor
    log_sigma: torch.Tensor


def initialise(
    state_dim: int,
    action_dim: int,
    seed: int,
    hidden: tuple[int, ...] = (100, 100),
    learn_sigma: bool = True,
) -> Params:
    """Return new parameters: Xavier-uniform weights, zero biases, sigma = 1.

    The paper's meta-policies have two hidden layers of 100 ReLU units (appendix C). A policy
    without the entry "log_sigma" keeps sigma = 1 for ever, as the paper writes.
    """
    random = torch.Generator().manual_seed(seed)
    sizes = (state_dim, *hidden, action_dim)
    params: Params = {}
    for layer, (fan_in, fan_out) in enumerate(pairwise(sizes)):
        bound = math.sqrt(6.0 / (fan_in + fan_out))
        uniform = torch.rand(fan_in, fan_out, generator=random)
        params[f"weight_{layer}"] = bound * (2.0 * uniform - 1.0)
        params[f"bias_{layer}"] = torch.zeros(fan_out)
    if learn_sigma:
        params["log_sigma"] = torch.zeros(action_dim)
    return params


def layer_count(params: Params) -> int:
    """Return the number of linear layers."""
    return sum(name.startswith("weight_") for name in params)


def has_task_axis(params: Params) -> bool:
    """Return whether ``params`` holds one set a task."""
    return params["weight_0"].dim() == 3


def per_task(params: Params, tasks: int) -> Params:
    """Return one set of parameters a task, sharing memory, so gradients flow back to ``params``."""
    if has_task_axis(params):
        return params
    return {name: value.expand(tasks, *value.shape) for name, value in params.items()}


def distribution(params: Params, states: torch.Tensor) -> Gaussian:
    """Return pi(. | s) for every state, (task, ..., action) from states (task, ..., state)."""
    leading = states.shape[:-1]
    features = states.reshape(states.shape[0], -1, states.shape[-1])  # (task, sample, state)
    layers = layer_count(params)
    for layer in range(layers):
        bias = params[f"bias_{layer}"].unsqueeze(-2)  # (1, unit) or (task, 1, unit)
        features = features @ params[f"weight_{layer}"] + bias  # (task, sample, unit)
        if layer < layers - 1:
            features = torch.relu(features)
    if "log_sigma" in params:
        log_sigma = params["log_sigma"].unsqueeze(-2).expand_as(features)  # (task, sample, action)
    else:
        log_sigma = torch.zeros_like(features)
    return Gaussian(features.reshape(*leading, -1), log_sigma.reshape(*leading, -1))


def log_density(gaussian: Gaussian, actions: torch.Tensor) -> torch.Tensor:
    """Return log pi(a | s) of each joint action, (...) from actions (..., action)."""
    standardised = (actions - gaussian.mean) * torch.exp(-gaussian.log_sigma)
    each = -0.5 * standardised**2 - gaussian.log_sigma - 0.5 * math.log(2.0 * math.pi)
    return each.sum(-1)


def kl_divergence(old: Gaussian, new: Gaussian) -> torch.Tensor:
    """Return KL(old || new) of the joint action at each state, (...), in nats."""
    variance_ratio = torch.exp(2.0 * (old.log_sigma - new.log_sigma))
    shift = ((old.mean - new.mean) * torch.exp(-new.log_sigma)) ** 2
    each = 0.5 * (variance_ratio + shift - 1.0) + new.log_sigma - old.log_sigma
    return each.sum(-1)


def to_vector(params: Params) -> torch.Tensor:
    """Return all parameters as one vector, in the order of the dict."""
    return torch.cat([value.reshape(-1) for value in params.values()])


def from_vector(vector: torch.Tensor, like: Params) -> Params:
    """Return a dict of the shapes of ``like`` filled from ``vector``; undoes ``to_vector``."""
    pieces = vector.split([value.numel() for value in like.values()])
    return {
        name: piece.reshape(value.shape)
        for (name, value), piece in zip(like.items(), pieces, strict=True)
    }


def detach(params: Params, requires_grad: bool = False) -> Params:
    """Return the same numbers cut from their graph, as new leaves that may ask for a gradient."""
    return {name: value.detach().requires_grad_(requires_grad) for name, value in params.items()}
