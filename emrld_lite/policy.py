"""The Gaussian policy: a multilayer perceptron for the mean, a learned sigma, plain tensors.

The parameters of one policy are ``params``, a dict of tensors. One set per task is ``task_params``,
the same dict with a leading task axis on every tensor; every function takes either.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Literal, NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor

from . import first_calls  # noqa: F401  (its import makes MKL's first calls)

LOG_SIGMA_BOUNDS = (math.log(1e-6), math.log(1e6))  # beyond, float32 has no room for the densities

Params = dict[str, Tensor]
Vector = Float[Tensor, " parameter"]
NetworkStart = Literal["biased", "xavier"]
LogDensity = Literal["averaged", "joint"]
NETWORK_START: NetworkStart = "biased"  # unless told otherwise


class Gaussian(NamedTuple):
    """Independent normal distributions, one per action dimension."""

    mean: Float[Tensor, "... action"]
    """Mean of each action dimension."""
    log_sigma: Float[Tensor, "... action"]
    """Natural log of its standard deviation."""


def initialise(
    state_dim: int,
    action_dim: int,
    seed: int,
    hidden: tuple[int, ...] = (100, 100),
    learn_sigma: bool = True,
    start: NetworkStart = NETWORK_START,
) -> Params:
    """Return new parameters: Xavier-uniform weights, uniform biases, a small last layer, sigma = 1.

    The paper's meta-policies have two hidden layers of 100 ReLU units (appendix C); how they start
    is not said. With zero biases every unit is 0 at the origin, where all episodes begin, and
    cloning has nothing to hold on to there; with a last layer at a tenth of its size the first
    actions are nearly centred. ``start="xavier"`` is the released code's: zero biases, and a last
    layer like the others. A policy without the entry "log_sigma" keeps sigma = 1 for ever, as
    the paper writes.
    """
    random = torch.Generator().manual_seed(seed)
    sizes = (state_dim, *hidden, action_dim)
    params: Params = {}
    for layer, (fan_in, fan_out) in enumerate(pairwise(sizes)):
        weight = 2.0 * torch.rand(fan_in, fan_out, generator=random) - 1.0
        bias = 2.0 * torch.rand(fan_out, generator=random) - 1.0
        params[f"weight_{layer}"] = weight * math.sqrt(6.0 / (fan_in + fan_out))
        params[f"bias_{layer}"] = bias / math.sqrt(fan_in)
    if start == "biased":
        params[f"weight_{len(hidden)}"] *= 0.1
    for name in params:
        if name == f"bias_{len(hidden)}" or (start == "xavier" and name.startswith("bias")):
            params[name] *= 0.0
    if learn_sigma:
        params["log_sigma"] = torch.zeros(action_dim)
    return params


def layer_count(params: Params) -> int:
    """Return the number of linear layers."""
    return sum(name.startswith("weight_") for name in params)


def has_task_axis(params: Params) -> bool:
    """Return whether ``params`` holds one set per task."""
    return params["weight_0"].dim() == 3


def per_task(params: Params, tasks: int) -> Params:
    """Return one set of parameters per task, sharing memory, so gradients flow back to ``params``."""
    if has_task_axis(params):
        return params
    return {name: value.expand(tasks, *value.shape) for name, value in params.items()}


def take_params(params: Params, tasks: slice) -> Params:
    """Return the parameters of some tasks; one set for all tasks is theirs too."""
    if not has_task_axis(params):
        return params
    return {name: value[tasks] for name, value in params.items()}


def mean(
    params: Params, states: Float[Tensor, "task *between state"]
) -> Float[Tensor, "task *between action"]:
    """Return the perceptron's mean action at every state."""
    features = states.reshape(states.shape[0], -1, states.shape[-1])  # (task, sample, state)
    layers = layer_count(params)
    for layer in range(layers):
        features = linear(features, params[f"weight_{layer}"], params[f"bias_{layer}"])
        if layer < layers - 1:
            features = torch.relu(features)  # (task, sample, unit)
    return features.reshape(*states.shape[:-1], -1)


def linear(
    features: Float[Tensor, "task sample in"],
    weight: Float[Tensor, "*task in out"],
    bias: Float[Tensor, "*task out"],
) -> Float[Tensor, "task sample out"]:
    """Return features @ weight + bias in one operation."""
    if weight.dim() == 3:  # one weight matrix per task
        return torch.baddbmm(bias.unsqueeze(-2), features, weight)
    return torch.nn.functional.linear(features, weight.T, bias)


def distribution(params: Params, states: Float[Tensor, "task ... state"]) -> Gaussian:
    """Return pi(. | s) for every state.

    Sigma is kept between 1e-6 and 1e6, whatever its parameter says.
    """
    means = mean(params, states)
    if "log_sigma" not in params:
        return Gaussian(means, torch.zeros_like(means))
    log_sigma = params["log_sigma"].clamp(*LOG_SIGMA_BOUNDS)  # (action,) or (task, action)
    between = (1,) * (means.dim() - 2)
    shape = (-1, *between, log_sigma.shape[-1])
    return Gaussian(means, log_sigma.reshape(shape).expand_as(means))


def without_noise(params: Params) -> Params:
    """Return the same policies with the smallest sigma there is: they act by their mean."""
    last = layer_count(params) - 1
    bias = params[f"bias_{last}"]  # (action,) or (task, action)
    return dict(params, log_sigma=torch.full_like(bias, LOG_SIGMA_BOUNDS[0]))


def log_density(
    gaussian: Gaussian, actions: Float[Tensor, "*at action"], kind: LogDensity = "joint"
) -> Float[Tensor, "*at"]:
    """Return log pi(a | s) of each joint action, or averaged over the action's dimensions."""
    standardised = (actions - gaussian.mean) * torch.exp(-gaussian.log_sigma)
    each = -0.5 * standardised**2 - gaussian.log_sigma - 0.5 * math.log(2.0 * math.pi)
    return each.sum(-1) if kind == "joint" else each.mean(-1)


def kl_divergence(old: Gaussian, new: Gaussian) -> Float[Tensor, ...]:
    """Return KL(old || new) of the joint action at each state, in nats."""
    variance_ratio = torch.exp(2.0 * (old.log_sigma - new.log_sigma))
    shift = ((old.mean - new.mean) * torch.exp(-new.log_sigma)) ** 2
    each = 0.5 * (variance_ratio + shift - 1.0) + new.log_sigma - old.log_sigma
    return each.sum(-1)


def to_vector(params: Params) -> Vector:
    """Return all parameters as one vector, in the order of the dict."""
    return torch.cat([value.reshape(-1) for value in params.values()])


def from_vector(vector: Vector, like: Params) -> Params:
    """Return a dict of the shapes of ``like`` filled from ``vector``; undoes ``to_vector``."""
    pieces = vector.split([value.numel() for value in like.values()])
    return {
        name: piece.reshape(value.shape)
        for (name, value), piece in zip(like.items(), pieces, strict=True)
    }


def detach(params: Params, requires_grad: bool = False) -> Params:
    """Return the same numbers cut from their graph, as new leaves that may ask for a gradient."""
    return {name: value.detach().requires_grad_(requires_grad) for name, value in params.items()}


def own_memory(params: Params, order: Params | None = None, device: str | None = None) -> Params:
    """Return copies, each in memory of its own, in the order of ``order``.

    A product of matrices may differ in its last bit with where its operands lie, and a sum with its
    order: without this, a policy read from a file would not train on bit for bit as one that
    stayed in memory.
    """
    names = params if order is None else order
    return {name: params[name].to(device=device, copy=True) for name in names}
