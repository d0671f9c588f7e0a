"""Finite Markov decision processes, solved exactly: expectations are sums, values linear solves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from ..validation import InputError

SUM_TOLERANCE = 1e-6  # how far a given distribution's sum may lie from 1: float32 fits


@dataclass(frozen=True, eq=False)
class TabularMDP:
    """A finite MDP, or a batch of them along leading axes (...); everything becomes float64.

    ======================  ==================================  ===============================
    field                   shape                               values
    ======================  ==================================  ===============================
    transition, P           (..., state, action, next state)    rows >= 0 that sum to 1
    reward, R               (..., state, action)                finite
    initial, rho            (..., state)                        >= 0, sums to 1
    discount, gamma         () or (...)                         0 <= discount < 1
    ======================  ==================================  ===============================

    Policies are (..., state, action) with rows that sum to 1. Everything can be differentiated with
    respect to a policy. Raises InputError that names the field. Section 2, Preliminaries.
    """

    transition: Tensor
    reward: Tensor
    initial: Tensor
    discount: Tensor

    def __post_init__(self) -> None:
        for field in ("transition", "reward", "initial", "discount"):
            object.__setattr__(self, field, numbers(field, getattr(self, field)))
        shape = tuple(self.transition.shape)
        if len(shape) < 3 or shape[-1] != shape[-3] or 0 in shape:
            raise InputError(f"transition: expected shape (..., state, action, state), got {shape}")
        expect_shape("reward", self.reward, shape[:-1])
        expect_shape("initial", self.initial, shape[:-2])
        if self.discount.dim():
            expect_shape("discount", self.discount, shape[:-3])
        if ((self.discount < 0) | (self.discount >= 1)).any():
            worst = self.discount[(self.discount < 0) | (self.discount >= 1)].flatten()[0]
            raise InputError(f"discount: expected 0 <= discount < 1, got {worst:.6g}")
        for field in ("transition", "initial"):
            object.__setattr__(self, field, distributions(field, getattr(self, field)))

    @property
    def states(self) -> int:
        """Number of states."""
        return self.reward.shape[-2]

    @property
    def actions(self) -> int:
        """Number of actions."""
        return self.reward.shape[-1]

    def value(self, policy: Tensor) -> Tensor:
        """Return V (..., state), the solution of (I - gamma P_pi) V = R_pi."""
        policy = self.policy(policy)
        reward = (policy * self.reward).sum(-1)  # (..., state)
        return torch.linalg.solve(self._resolvent(policy), reward.unsqueeze(-1)).squeeze(-1)

    def action_value(self, policy: Tensor) -> Tensor:
        """Return Q (..., state, action) = R + gamma P V."""
        following = (self.transition * self.value(policy)[..., None, None, :]).sum(-1)
        return self.reward + self.discount[..., None, None] * following

    def advantage(self, policy: Tensor) -> Tensor:
        """Return A (..., state, action) = Q - V, whose mean under the policy is 0 in every state."""
        return self.action_value(policy) - self.value(policy).unsqueeze(-1)

    def visitation(self, policy: Tensor) -> Tensor:
        """Return d (..., state) = (1 - gamma) sum_t gamma^t P(s_t = s), which sums to 1."""
        policy = self.policy(policy)
        start = ((1 - self.discount)[..., None] * self.initial).unsqueeze(-1)
        return torch.linalg.solve(self._resolvent(policy).mT, start).squeeze(-1)

    def objective(self, policy: Tensor) -> Tensor:
        """Return J (...) = E_{s ~ rho} V(s)."""
        return (self.initial * self.value(policy)).sum(-1)

    def policy(self, policy: Tensor) -> Tensor:
        """Return ``policy`` as float64 if it is one for this MDP; otherwise raise InputError."""
        policy = numbers("policy", policy)
        expected = tuple(self.reward.shape)
        trailing = tuple(policy.shape[-2:])
        if policy.dim() > len(expected) or trailing != expected[-2:]:
            raise InputError(f"policy: expected shape {expected}, got {tuple(policy.shape)}")
        return distributions("policy", policy)

    def _resolvent(self, policy: Tensor) -> Tensor:
        """Return I - gamma P_pi, (..., state, next state)."""
        step = torch.einsum("...sa,...sat->...st", policy, self.transition)
        identity = torch.eye(self.states, dtype=torch.float64)
        return identity - self.discount[..., None, None] * step


def numbers(name: str, values: object) -> Tensor:
    """Return finite float64 numbers; anything else raises InputError under ``name``."""
    try:
        tensor = torch.as_tensor(values, dtype=torch.float64)
    except (TypeError, ValueError, RuntimeError) as error:
        raise InputError(f"{name}: expected numbers, got {type(values).__name__}") from error
    bad = ~torch.isfinite(tensor)
    if bad.any():
        index = tuple(bad.nonzero()[0].tolist())
        raise InputError(f"{name}: a value that is not finite at index {index}")
    return tensor


def expect_shape(name: str, tensor: Tensor, shape: Sequence[int]) -> None:
    """Raise InputError unless ``tensor`` has ``shape``."""
    if tuple(tensor.shape) != tuple(shape):
        raise InputError(f"{name}: expected shape {tuple(shape)}, got {tuple(tensor.shape)}")


def distributions(name: str, tensor: Tensor) -> Tensor:
    """Return ``tensor`` with its last axis as distributions; raises InputError if they are none.

    Sums within SUM_TOLERANCE of 1, as float32 leaves them, are made exactly 1.
    """
    if (tensor < 0).any():
        index = tuple((tensor < 0).nonzero()[0].tolist())
        raise InputError(
            f"{name}: expected probabilities, got {tensor[index]:.6g} at index {index}"
        )
    total = tensor.detach().sum(-1)
    wrong = (total - 1).abs() > SUM_TOLERANCE
    if wrong.any():
        index = tuple(wrong.nonzero()[0].tolist())
        raise InputError(
            f"{name}: expected a sum of 1 over the last axis, got {total[index]:.8g} at index {index}"
        )
    return tensor / total.unsqueeze(-1)


def stack(mdps: Sequence[TabularMDP]) -> TabularMDP:
    """Return tasks as one MDP with a leading task axis; raises InputError where they do not match.

    The tasks share states, actions and discount, as Section 2 and Theorem 1 assume.
    """
    mdps = list(mdps)
    if not mdps or not all(isinstance(mdp, TabularMDP) for mdp in mdps):
        raise InputError(f"mdps: expected a list of TabularMDP, one per task, got {mdps!r:.80}")
    for task, mdp in enumerate(mdps):
        expect_shape(f"mdps[{task}].transition", mdp.transition, mdps[0].transition.shape)
        if not torch.equal(mdp.discount.expand_as(mdps[0].discount), mdps[0].discount):
            raise InputError(f"mdps[{task}].discount: expected that of mdps[0], got another")
    shared = mdps[0].discount
    return TabularMDP(
        torch.stack([mdp.transition for mdp in mdps]),
        torch.stack([mdp.reward for mdp in mdps]),
        torch.stack([mdp.initial for mdp in mdps]),
        shared.expand(len(mdps), *mdps[0].transition.shape[:-3]) if shared.dim() else shared,
    )


def optimal_policy(mdp: TabularMDP, iterations: int = 1000) -> Tensor:
    """Return an optimal policy (..., state, action) by policy iteration; ties share evenly.

    Raises RuntimeError if it has not settled after ``iterations`` rounds. Howard (1960).
    """
    policy = torch.full_like(mdp.reward, 1 / mdp.actions)
    for _ in range(iterations):
        action_value = mdp.action_value(policy)
        scale = action_value.abs().amax((-2, -1), keepdim=True).clamp(min=1e-300)
        best = action_value >= action_value.amax(-1, keepdim=True) - 1e-10 * scale
        greedy = best.double() / best.sum(-1, keepdim=True)
        if torch.equal(greedy, policy):
            return policy
        policy = greedy
    raise RuntimeError(f"policy iteration did not settle in {iterations} rounds")
