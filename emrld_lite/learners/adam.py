"""The meta-update by Adam: the demonstrations' likelihood after adaptation, as in Meta-BC and GMPS."""

from __future__ import annotations

import copy

import torch

from ..adapt import Adaptation
from ..losses import task_mean
from ..policy import Params, detach, kl_divergence, own_memory
from ..trpo import Step
from .base import Learner, TaskData, chunks, cloning_gradient, policies_after

LARGE_KL = 10.0  # nats; TRPO's steps stay under 0.06
UNBOUNDED = "nothing bounds Adam's step"  # ends the note of a step that was made all the same


class Adam(Learner):
    """torch's Adam on mean_i L^BC_i(theta_i), the demonstrations' likelihood after adaptation.

    Section 4.1, "Baselines": with cloning in the adaptation this is Meta-BC, with RL it is GMPS. A
    gradient longer than ``max_grad_norm``, unless that is None, is shortened to it before Adam sees it.
    """

    def __init__(
        self, theta: Params, learning_rate: float, max_grad_norm: float | None = None
    ) -> None:
        self.max_grad_norm = max_grad_norm
        self.leaves = detach(own_memory(theta), requires_grad=True)
        self.optimiser = torch.optim.Adam(self.leaves.values(), lr=learning_rate)
        self.load({})

    def update(
        self, theta: Params, data: TaskData, rule: Adaptation, random: torch.Generator
    ) -> tuple[Params, Step]:
        """Return theta_{k+1} after one step of Adam.

        D^val only measures: the KL is that between the old and the new adapted policies on its
        states, which nothing here bounds; the note says where it is large. A step after which the
        policy or Adam's memory is not finite is not made.
        """
        parts = chunks(data)
        gradient = cloning_gradient(theta, parts, rule)
        if not all(torch.isfinite(part).all() for part in gradient.values()):
            return theta, Step(0.0, 0, "skipped: the gradient is not finite")
        kept = copy.deepcopy(self.optimiser.state_dict())
        for name, leaf in self.leaves.items():
            leaf.data.copy_(theta[name])
            leaf.grad = gradient[name]
        if self.max_grad_norm is not None:
            torch.nn.utils.clip_grad_norm_(self.leaves.values(), self.max_grad_norm)
        self.optimiser.step()
        stepped = detach(own_memory(self.leaves))
        for what, made in (("step", stepped), ("memory", self.state())):
            if not all(torch.isfinite(value).all() for value in made.values()):
                self.optimiser.load_state_dict(kept)
                return theta, Step(0.0, 0, f"skipped: Adam's {what} is not finite")
        kl = adapted_kl(theta, stepped, parts, rule)
        note = "" if kl <= LARGE_KL else f"KL of {kl:.2g} nats: {UNBOUNDED}"
        return stepped, Step(kl, 0, note)

    def state(self) -> Params:
        """Return Adam's number of steps and running means, under names that no parameter has."""
        return {
            f"adam.{key}.{name}": value.clone()
            for name, leaf in self.leaves.items()
            for key, value in self.optimiser.state[leaf].items()
        }

    def load(self, state: Params) -> None:
        """Go on from the memory of a checkpoint; an empty one is a fresh start."""
        for name, leaf in self.leaves.items():
            zero = torch.zeros_like(leaf.detach())
            fresh = {"step": torch.tensor(0.0), "exp_avg": zero, "exp_avg_sq": zero}
            self.optimiser.state[leaf] = {
                key: state.get(f"adam.{key}.{name}", value).to(value.device, copy=True)
                for key, value in fresh.items()
            }


@torch.no_grad()
def adapted_kl(old: Params, new: Params, parts: list[TaskData], rule: Adaptation) -> float:
    """Return the mean KL from the policies adapted from ``old`` to those from ``new``, nats."""
    total, tasks = 0.0, 0
    for part in parts:
        policies = [policies_after(params, part, rule) for params in (old, new)]
        kl = task_mean(kl_divergence(*policies), part.after.mask)
        total, tasks = total + float(kl.sum()), tasks + len(kl)
    return total / tasks
