"""Check of notebook 06: an experiment that says which part of the adaptation matters, and how surely."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import torch

from .answers import Student, Wrong, answered
from .calls import ask
from .values import as_number, as_parts, judge

PARTS = ("RL", "cloning", "warm start")
Setting = tuple[float, float, bool]


@answered
def what_parts_add(student: Student) -> None:
    """Check an experiment: f(run, full, seeds) -> {part: (drop, error)}, one part left out at a time."""
    for number, seeds in enumerate(((3, 8, 11, 40), (0, 1, 2, 3, 4, 5, 6), (17, 5)), start=31):
        random = np.random.default_rng(number)
        full: Setting = (float(random.uniform(0.1, 0.9)), float(random.uniform(0.5, 1.5)), True)
        strengths = random.uniform(2, 20, 5)
        asked_for: list[tuple[Setting, int]] = []

        def run(
            w_rl: float, w_bc: float, warm: bool, seed: int, asked_for=asked_for, k=strengths
        ) -> float:
            asked_for.append(((float(w_rl), float(w_bc), bool(warm)), int(seed)))
            return _return_of(w_rl, w_bc, warm, seed, k)

        right, mistakes = _effects(strengths, full, seeds)
        answer = ask(student, run, full, seeds).answer
        _judge_calls(asked_for, full, seeds)
        judge(_table(answer), right, mistakes, "the numbers differ. Leave out one part at a time.")


def _return_of(w_rl: float, w_bc: float, warm: bool, seed: int, k: np.ndarray) -> float:
    """Return a made-up mean return: three parts, their interplay, a seed's luck and its leftovers."""
    luck = np.random.default_rng([seed, 7])
    shared, own = 10 * luck.normal(), luck.normal(size=3)
    switched = np.array([w_rl > 0, w_bc > 0, warm], dtype=float)
    parts = k[0] * w_rl + k[1] * w_bc + k[2] * warm + k[3] * w_rl * w_bc + k[4] * warm * w_bc
    return float(20 + parts + shared + 2 * (own @ switched))


def _judge_calls(
    asked_for: list[tuple[Setting, int]], full: Setting, seeds: tuple[int, ...]
) -> None:
    """Name what is wrong with an experiment by what it ran."""
    if not asked_for:
        raise Wrong("you never call `run`: the numbers must come from your experiment.")
    if {seed for _, seed in asked_for} - set(seeds):
        raise Wrong("use the seeds that you are given, the same ones in every setting.")
    for w_rl, w_bc, _ in {setting for setting, _ in asked_for}:
        if w_rl not in (0.0, full[0]) or w_bc not in (0.0, full[1]):
            raise Wrong("a part is either as in `full` or left out: its weight then is 0.")
    if full not in {setting for setting, _ in asked_for}:
        raise Wrong("nothing to compare with: run the setting `full` itself, too.")
    if {seed for _, seed in asked_for} != set(seeds):
        raise Wrong("run every setting with every seed.")


def _table(answer: Any) -> torch.Tensor:
    """Return an answer as drops and errors, (part, 2)."""
    what = 'a dict with the parts "RL", "cloning" and "warm start"'
    if not isinstance(answer, Mapping) or set(answer) != set(PARTS):
        got = list(answer) if isinstance(answer, Mapping) else type(answer).__name__
        raise Wrong(f"expected {what}, got {got}.")
    pairs = [as_parts(answer[part], 2, "a pair (drop, error) per part") for part in PARTS]
    numbers = [[as_number(value, "a number") for value in pair] for pair in pairs]
    return torch.tensor(numbers, dtype=torch.float64)


def _effects(
    k: np.ndarray, full: Setting, seeds: tuple[int, ...]
) -> tuple[torch.Tensor, dict[str, torch.Tensor]]:
    """Return the right table, and those of plausible mistakes by their sentences."""
    w_rl, w_bc, warm = full
    without = [(0.0, w_bc, warm), (w_rl, 0.0, warm), (w_rl, w_bc, False)]
    alone = [(w_rl, 0.0, False), (0.0, w_bc, False), (0.0, 0.0, warm)]
    no_demonstration = [without[0], (w_rl, 0.0, False), without[2]]

    def returns(settings: list[Setting]) -> np.ndarray:  # (part, seed)
        return np.array([[_return_of(*setting, seed, k) for seed in seeds] for setting in settings])

    def table(drops: np.ndarray, errors: np.ndarray | None = None) -> torch.Tensor:
        error = drops.std(1, ddof=1) / np.sqrt(len(seeds)) if errors is None else errors
        return torch.as_tensor(np.stack([drops.mean(1), error], 1))

    whole, less = returns([full] * 3), returns(without)
    drops, count = whole - less, len(seeds)
    spread = drops.std(1, ddof=1)
    unpaired = np.sqrt((whole.var(1, ddof=1) + less.var(1, ddof=1)) / count)
    nothing = returns([(0.0, 0.0, False)] * 3)
    return table(drops), {
        "the sign is turned: the drop is the full setting's return minus the one without.": (
            table(-drops)
        ),
        "that is the standard deviation of the differences; the error of their mean is smaller by "
        "the root of the number of seeds.": table(drops, spread),
        "divide by the number of seeds less one in the standard deviation: two seeds "
        "alone say little.": table(drops, drops.std(1) / np.sqrt(count)),
        "both settings share their seeds' luck: take the error of the differences, seed by seed.": (
            table(drops, unpaired)
        ),
        "you divide by the number of seeds; the error of a mean goes with its root.": (
            table(drops, spread / count)
        ),
        "that is the variance of the mean; the error is its root.": table(drops, spread**2 / count),
        "one thing at a time: without cloning in the step, the warm start stays.": (
            table(whole - returns(no_demonstration))
        ),
        "that is what each part gives on its own; leave it out of the full setting instead.": (
            table(returns(alone) - nothing)
        ),
        "the other two parts are left out, too: leave out one at a time.": (
            table(whole - returns(alone))
        ),
        "those are the returns without the part; the drop is their distance from `full`.": (
            table(less)
        ),
    }
