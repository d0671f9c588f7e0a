"""A slider on GAE's lambda: what it does to the bias and to the noise of an advantage.

How much better is a first step towards the goal than one away from it? Episodes that begin with either
step answer that without an error, if there are enough of them; GAE answers from a few, and from V.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import ipywidgets
import matplotlib.pyplot as plt
import numpy as np
import torch
from IPython.display import display
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from torch import Tensor

from ...advantage import baseline_features, discounted_returns, fit_baseline
from ...envs import make
from ...policy import Params, distribution
from ...rollout import Rollout, collect
from ...validation import check_choice, real_number
from .answer import as_image

DISCOUNT = 0.95  # Table 1
GOAL = torch.tensor([[0.0, 2.0]])
LAMBDAS = tuple(float(value) for value in np.linspace(0, 1, 21).round(2))
COUNTS = (1, 4, 16, 64, 256)  # pairs of episodes that are averaged
VALUES = ("the linear baseline", "zero")
Sequences = Float[Tensor, "episode time"]
Estimator = Callable[[Sequences, Sequences, float, float], Sequences]


class Differences(NamedTuple):
    """Estimates of Q(s_0, towards) - Q(s_0, away), one per pair of episodes, by V and lambda."""

    exact: float
    """The mean difference of the returns, from the same draws for both steps."""
    estimates: dict[tuple[str, float], Float[Tensor, " pair"]]
    """By (what V is, lambda); the two episodes of a pair share no draws."""
    biases: dict[tuple[str, float], float]
    """By (what V is, lambda): the mean estimate less the exact difference, same draws for both."""

    def error_parts(self, values: str, gae_lambda: float, count: int) -> tuple[float, float]:
        """Return bias and noise of the mean of ``count`` estimates."""
        noise = float(self.estimates[values, gae_lambda].std()) / count**0.5
        return self.biases[values, gae_lambda], noise


def first_steps(params: Params, episodes: int, seed: int) -> Rollout:
    """Return episodes (step, episode, ...): the first action leads towards the goal, or away from it."""
    environment, tasks = make("point2d", reward="dense"), GOAL.expand(2, 2)
    horizon = environment.horizon
    random = torch.Generator().manual_seed(seed)
    noise = torch.randn(1, episodes, horizon, 2, generator=random)  # the same for both steps
    first = torch.tensor([[[0.0, 1.0]], [[0.0, -1.0]]]).expand(2, episodes, 2)
    states, steps = environment.reset(tasks, episodes), []
    alive = torch.ones(2, episodes)
    with torch.inference_mode():
        for time in range(horizon):
            mean, log_sigma = distribution(params, states)
            actions = first if time == 0 else mean + log_sigma.exp() * noise[:, :, time]
            moved = environment.step(tasks, states, actions, time)
            steps.append((states, actions, moved.rewards * alive, alive))
            alive = alive * ~moved.terminated
            states = moved.states
    seen, actions, rewards, mask = (torch.stack(part, 2) for part in zip(*steps, strict=True))
    return Rollout(seen * mask[..., None], actions, rewards, mask, alive == 0)


def baseline_of(params: Params, rollout: Rollout, seed: int, episodes: int = 20) -> Tensor:
    """Return V(s_t) along ``rollout``: linear, fitted to ``episodes`` others of the same policy."""
    random = torch.Generator().manual_seed(seed)
    seen = collect(make("point2d", reward="dense"), GOAL, params, episodes, random)
    weights = fit_baseline(baseline_features(seen), discounted_returns(seen.rewards, DISCOUNT))
    return (baseline_features(rollout) @ weights[0]).float()


def advantage_differences(
    params: Params, estimate: Estimator, pairs: int = 2000, seed: int = 3
) -> Differences:
    """Return the estimates by ``estimate(rewards, values, discount, gae_lambda)`` for every lambda."""
    rollout = first_steps(params, pairs, seed)
    fitted = baseline_of(params, rollout, seed + 1)
    returns = discounted_returns(rollout.rewards, DISCOUNT)[:, :, 0]  # (step, pair)
    exact = float((returns[0] - returns[1]).double().mean())
    estimates, biases = {}, {}
    for name, values in zip(VALUES, (fitted, torch.zeros_like(fitted)), strict=True):
        for gae_lambda in LAMBDAS:
            found = estimate(
                rollout.rewards.flatten(0, 1), values.flatten(0, 1), DISCOUNT, gae_lambda
            )
            towards, away = torch.as_tensor(found).double()[:, 0].reshape(2, pairs)
            biases[name, gae_lambda] = float((towards - away).mean()) - exact
            estimates[name, gae_lambda] = towards - away.roll(pairs // 2)  # draws of others
    return Differences(exact, estimates, biases)


def best_lambda(differences: Differences, values: str, count: int) -> float:
    """Return the lambda at which the mean of ``count`` estimates has the smallest error."""
    check_choice("values", values, VALUES)
    parts = [differences.error_parts(values, gae_lambda, count) for gae_lambda in LAMBDAS]
    return LAMBDAS[int(np.argmin([np.hypot(*part) for part in parts]))]


def gae_sliders(differences: Differences) -> None:
    """Show controls for lambda, for V and for how many pairs are averaged, and the errors."""

    def show(gae_lambda: float, values: str, count: int) -> None:
        display(as_image(gae_picture(differences, gae_lambda, values, count)))

    ipywidgets.interact(
        show,
        gae_lambda=ipywidgets.SelectionSlider(
            options=LAMBDAS, value=0.95, description="lambda", continuous_update=False
        ),
        values=ipywidgets.Dropdown(options=VALUES, description="V is"),
        count=ipywidgets.SelectionSlider(
            options=COUNTS, value=16, description="pairs", continuous_update=False
        ),
    )


def gae_picture(
    differences: Differences, gae_lambda: float = 0.95, values: str = VALUES[0], count: int = 16
) -> Figure:
    """Return the estimates at one lambda beside the exact number, and bias and noise at all of them."""
    real_number("lambda", gae_lambda, 0.0, 1.0)
    check_choice("values", values, VALUES)
    nearest = min(LAMBDAS, key=lambda value: abs(value - gae_lambda))
    figure, (left, right) = plt.subplots(1, 2, figsize=(8.4, 3.2), layout="none")  # which is slow
    figure.subplots_adjust(left=0.08, right=0.99, bottom=0.16, top=0.9, wspace=0.2)
    _estimates(differences, nearest, values, count, left)
    _errors(differences, nearest, values, count, right)
    plt.close(figure)
    return figure


def _estimates(
    differences: Differences, gae_lambda: float, values: str, count: int, axes: Axes
) -> None:
    every = differences.estimates[values, gae_lambda]
    means = every[: len(every) // count * count].reshape(-1, count).mean(1)
    exact, bias = differences.exact, differences.biases[values, gae_lambda]
    reach = max(4.2, 3 * differences.error_parts(values, 1.0, count)[1])  # the same for all lambdas
    density, edges = np.histogram(means, bins=np.linspace(exact - reach, exact + reach, 60))
    axes.stairs(density / len(means), edges, fill=True, color="#56B4E9")
    axes.axvline(exact, color="black", label=f"exact: {exact:.2f}")
    axes.axvline(
        exact + bias, color="#D55E00", linestyle="--", label=f"expected: {exact + bias:.2f}"
    )
    axes.set(xlabel="towards less away (return)", ylabel="share of the estimates")
    axes.set(xlim=(exact - reach, exact + reach))
    averaged = f", means of {count} pairs" if count > 1 else ", one pair each"
    axes.set_title(f"lambda {gae_lambda:g}{averaged}", fontsize=10)
    axes.legend(loc="upper right")


def _errors(
    differences: Differences, gae_lambda: float, values: str, count: int, axes: Axes
) -> None:
    parts = np.array([differences.error_parts(values, value, count) for value in LAMBDAS])
    total = np.hypot(parts[:, 0], parts[:, 1])
    axes.plot(LAMBDAS, np.abs(parts[:, 0]), "--", color="#D55E00", label="bias")
    axes.plot(LAMBDAS, parts[:, 1], ":", color="#0072B2", label="noise")
    axes.plot(LAMBDAS, total, "-", color="black", label="error")
    best = LAMBDAS.index(best_lambda(differences, values, count))
    axes.plot(LAMBDAS[best], total[best], "*", color="black", markersize=11)
    axes.axvline(gae_lambda, color="grey", linewidth=1)
    axes.set(xlabel="lambda", ylabel="error (return)", xticks=[0, 0.5, 1])
    axes.set_ylim(0, 1.3 * total.max())
    axes.set_title(f"V is {values}: least error at {LAMBDAS[best]:g}", fontsize=10)
    axes.legend(loc="upper left", ncols=3)
