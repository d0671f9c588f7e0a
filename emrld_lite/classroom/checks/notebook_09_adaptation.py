"""Check of notebook 09: one adaptation on a robot, with the package's parts, on a robot that takes notes."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import torch

from ...adapt import Adaptation, adapt, warm_start
from ...advantage import Score
from ...demonstrations import Demonstrations, from_arrays
from ...policy import Params, initialise, mean, per_task
from ...rollout import Rollout
from .answers import Student, Wrong, answered
from .values import close

TRIALS, HORIZON = 5, 6  # trajectories that the paper's robot drives, and steps of each here
STATE, ACTION = 3, 2


class NotedRobot:
    """A robot of a few lines that keeps which policy drove it, and for how many trajectories."""

    def __init__(self, seed: int) -> None:
        self.seed, self.drives = seed, list[tuple[Params, int]]()

    def __call__(self, params: Params, trajectories: int) -> Rollout:
        """Return trajectories (1, trajectory, time) of a policy."""
        self.drives.append(
            ({name: value.detach().clone() for name, value in params.items()}, trajectories)
        )
        random = torch.Generator().manual_seed(self.seed)
        noise = torch.randn(1, trajectories, HORIZON, ACTION, generator=random)
        place, steps = torch.zeros(1, trajectories, STATE), []
        for time in range(HORIZON):
            action = mean(params, place).detach() + noise[:, :, time]
            moved = place + torch.cat([action, action[..., :1] * action[..., 1:]], dim=-1)
            steps.append((place, action, moved[..., 0].clamp_min(0.0)))
            place = moved
        states, actions, rewards = (torch.stack(part, dim=2) for part in zip(*steps, strict=True))
        won = torch.zeros(1, trajectories, dtype=torch.bool)
        return Rollout(states, actions, rewards, torch.ones_like(rewards), won)


def _demonstration(seed: int) -> Demonstrations:
    """Return one demonstration of one task."""
    random = torch.Generator().manual_seed(seed)
    states = torch.randn(1, 1, 4, STATE, generator=random).numpy()
    actions = torch.randn(1, 1, 4, ACTION, generator=random).tanh().numpy()
    return from_arrays(
        torch.tensor([[0.1]]).numpy(), states, actions, torch.tensor([[4]]).numpy(),
        environment="two_wheeled_drift", quality="optimal", maker="random", seed=seed,
    )  # fmt: skip


def same_policy(one: Any, other: Params) -> bool:
    """Return whether two sets of parameters hold the same numbers."""
    if not isinstance(one, dict) or one.keys() != other.keys():
        return False
    return all(
        isinstance(one[name], torch.Tensor)
        and one[name].numel() == value.numel()
        and close(one[name].detach().double().flatten(), value.detach().double().flatten(), 1e-5)
        for name, value in other.items()
    )


@answered
def one_adaptation(student: Student) -> None:
    """Check Section 4.2: f(meta_params, drive, demonstration, rule, score) -> adapted parameters."""
    plain = Adaptation(w_rl=0.7, w_bc=1.0, adapt_lr=0.3)
    for seed, rule in enumerate(
        (plain, replace(plain, warm_start=True), replace(plain, w_rl=2.0)), 94
    ):
        meta_params = per_task(initialise(STATE, ACTION, seed), 1)
        shown, score, robot = _demonstration(seed), Score(), NotedRobot(seed)
        before = {name: value.clone() for name, value in meta_params.items()}
        start = warm_start(meta_params, shown, rule)
        trial = NotedRobot(seed)(start, TRIALS)
        expected = adapt(meta_params, score(trial), shown, rule)
        answer = _answer(student, meta_params, robot, shown, rule, score)
        if not same_policy(meta_params, before):
            raise Wrong("you changed the meta-policy in place: the next drift begins from it, too.")
        _judge_drives(robot, before, start, rule)
        if same_policy(answer, expected):
            continue
        _judge_answer(answer, before, start, trial, shown, rule, score)


def _answer(student: Student, *arguments: Any) -> Any:
    """Return what the function returns; raise Wrong where its trajectories lack their advantages."""
    try:
        return student(*arguments)
    except TypeError as error:
        if "NoneType" in str(error):
            raise Wrong(
                "the trajectories have no advantages yet: score(trajectories) estimates them, and "
                "adapt needs them."
            ) from error
        raise


def _judge_drives(robot: NotedRobot, meta_params: Params, start: Params, rule: Adaptation) -> None:
    """Raise Wrong where the robot was not driven once, by the right policy, for five trajectories."""
    if not robot.drives:
        raise Wrong("the robot never moved: drive(params, trajectories) collects the trajectories.")
    if len(robot.drives) > 1 or robot.drives[0][1] != TRIALS:
        asked = " and then ".join(str(count) for _, count in robot.drives)
        raise Wrong(
            f"the paper's robot drives {TRIALS} trajectories, at once; yours drove {asked}."
        )
    driver = robot.drives[0][0]
    if rule.warm_start and same_policy(driver, meta_params):
        raise Wrong(
            "with a warm start the trajectories are those of the warm-started policy, and the "
            "meta-policy drove them: warm_start returns what should drive."
        )
    if not same_policy(driver, start):
        raise Wrong("another policy than the one that collects in Algorithm 1, line 6, drove.")


def _judge_answer(
    answer: Any,
    meta_params: Params,
    start: Params,
    trial: Rollout,
    shown: Demonstrations,
    rule: Adaptation,
    score: Score,
) -> None:
    """Raise Wrong with the mistake that the adapted parameters show."""
    if not isinstance(answer, dict):
        raise Wrong(
            f"expected the adapted parameters, as adapt returns them, got {type(answer).__name__}."
        )
    scored = score(trial)
    twice = adapt(start, scored, shown, rule)
    mistakes = {
        "adapt does the warm start itself: give it the meta-policy, or the policy is warmed twice.": twice,
        "that is the policy that collected; one adaptation step is missing.": start,
        "the meta-policy comes back as it was: where is the adaptation?": meta_params,
        "that is cloning alone: the trajectories do not count.": adapt(
            meta_params, scored, shown, replace(rule, w_rl=0.0)
        ),
        "those are two adaptation steps; the paper takes one.": adapt(
            adapt(meta_params, scored, shown, rule), scored, shown, rule
        ),
    }
    for sentence, mistaken in mistakes.items():
        if same_policy(answer, mistaken):
            raise Wrong(sentence)
    raise Wrong(
        "the adapted policy differs: adapt the meta-policy to the scored trajectories, once."
    )
