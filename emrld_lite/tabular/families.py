"""Task families to try a theorem on: random ones in batches, and gridworlds whose tasks are goals."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import torch
from torch import Tensor

from ..validation import InputError, check_choice, positive_count, real_number
from .mdp import TabularMDP

Family = tuple[list[TabularMDP], Tensor, list[Tensor], list[Tensor], list[Tensor]]
MOVES = ((-1, 0), (0, 1), (1, 0), (0, -1))  # up, right, down, left, as (row, column)
LEFT_RIGHT = ((0, -1), (0, 1))


def random_family(
    random: torch.Generator,
    families: int,
    tasks: int,
    states: int,
    actions: int,
    discounts: Sequence[float] = (0.0, 0.5, 0.9, 0.99, 0.999),
) -> Family:
    """Return ``families`` random task families as one batch: mdps, task_weights, old, new, demo.

    They are as different as we can make them: transitions from even to nearly deterministic,
    rewards dense or zero but for one state and action in ten, policies from uniform to nearly
    deterministic, independent of each other or close together, in a random order of closeness.
    """
    counts = {"families": families, "tasks": tasks, "states": states, "actions": actions}
    for name, count in counts.items():
        positive_count(name, count)

    def uniform(*shape: int) -> Tensor:
        return torch.rand(*shape, generator=random, dtype=torch.float64)

    def logits(*shape: int) -> Tensor:
        """Return normal numbers times a random sharpness per family, 0.1 to 30."""
        sharpness = 10 ** (uniform(families) * 2.5 - 1)
        normal = torch.randn(families, *shape, generator=random, dtype=torch.float64)
        return normal * sharpness.reshape(-1, *[1] * len(shape))

    picked = torch.randint(len(discounts), (families,), generator=random)
    discount = torch.tensor(discounts, dtype=torch.float64)[picked]
    sparse = uniform(families, 1, 1) < 0.5
    mdps = []
    for _ in range(tasks):
        reward = torch.randn(families, states, actions, generator=random, dtype=torch.float64)
        rare = uniform(families, states, actions) < 0.1
        mdps.append(
            TabularMDP(
                logits(states, actions, states).softmax(-1),
                torch.where(sparse & ~rare, 0.0, reward),
                logits(states).softmax(-1),
                discount,
            )
        )
    weights = logits(tasks).softmax(-1).movedim(-1, 0)  # (task, family)
    policies: dict[str, list[Tensor]] = {"old": [], "new": [], "demo": []}
    order = torch.rand(families, 3, generator=random).argsort(-1)
    for _ in range(tasks):
        first = logits(states, actions)
        chain = [first, first + logits(states, actions), first + logits(states, actions)]
        stacked = torch.stack(chain, dim=1)[torch.arange(families)[:, None], order]
        for position, name in enumerate(policies):
            policies[name].append(stacked[:, position].softmax(-1))
    return mdps, weights, policies["old"], policies["new"], policies["demo"]


def many_families(seed: int, total: int = 10_000, batch: int = 250) -> Iterator[Family]:
    """Yield at least ``total`` random families in batches of one shape each, all shapes drawn anew.

    Two to eight states, two to five actions, one to six tasks.
    """
    random = torch.Generator().manual_seed(seed)
    for _ in range(-(-total // batch)):
        states, actions, tasks = (
            int(torch.randint(low, high + 1, (), generator=random))
            for low, high in ((2, 8), (2, 5), (1, 6))
        )
        yield random_family(random, batch, tasks, states, actions)


def gridworld(
    rows: int,
    columns: int,
    goals: Sequence[tuple[int, int]],
    start: tuple[int, int],
    discount: float = 0.95,
    at_goal: str = "restart",
    moves: Sequence[tuple[int, int]] = MOVES,
) -> list[TabularMDP]:
    """Return one MDP a goal: moves on a grid, reward 1 for the move into the goal, else 0.

    ``at_goal``: that move ends in the start cell ("restart"), or the goal keeps the walker for
    good and pays nothing more ("absorb"). A move off the grid stays where it is. Cells are (row,
    column); actions are ``moves``, by default up, right, down, left. Raises InputError for a cell
    off the grid.
    """
    positive_count("rows", rows)
    positive_count("columns", columns)
    real_number("discount", discount, minimum=0.0, maximum=1.0)
    check_choice("at_goal", at_goal, ("restart", "absorb"))
    for name, cell in [("start", start), *((f"goals[{i}]", g) for i, g in enumerate(goals))]:
        row, column = cell
        if not (0 <= row < rows and 0 <= column < columns):
            raise InputError(f"{name}: expected a cell of the {rows} x {columns} grid, got {cell}")
    first = start[0] * columns + start[1]
    initial = torch.zeros(rows * columns, dtype=torch.float64)
    initial[first] = 1.0
    mdps = []
    for row, column in goals:
        goal = row * columns + column
        landing = _landing(rows, columns, moves)  # (state, action)
        reward = (landing == goal).double()
        if at_goal == "restart":
            landing[landing == goal] = first
        else:
            landing[goal], reward[goal] = goal, 0.0
        transition = torch.nn.functional.one_hot(landing, rows * columns).double()
        mdps.append(TabularMDP(transition, reward, initial, discount))
    return mdps


def _landing(rows: int, columns: int, moves: Sequence[tuple[int, int]]) -> Tensor:
    """Return the cell that each move ends in, (state, action)."""
    landing = torch.empty(rows * columns, len(moves), dtype=torch.long)
    for row in range(rows):
        for column in range(columns):
            for action, (down, right) in enumerate(moves):
                to_row = min(max(row + down, 0), rows - 1)
                to_column = min(max(column + right, 0), columns - 1)
                landing[row * columns + column, action] = to_row * columns + to_column
    return landing


def mixed(policy: Tensor, noise: float) -> Tensor:
    """Return the policy that acts at random, uniformly, with probability ``noise``."""
    real_number("noise", noise, minimum=0.0, maximum=1.0)
    return (1 - noise) * policy + noise / policy.shape[-1]


def corridor_step(
    quality: float = 0.8, share: float = 0.5, discount: float = 0.9, stubbornness: float = 0.0
) -> Family:
    """Return two tasks on five cells in a row, and a step from a coin-tossing policy to a demonstrator.

    The goals are the two ends, the walk begins in the middle and begins again at the goal. The
    demonstrator makes the right move with probability (1 + ``quality``) / 2; but in the cell before the
    left goal it makes the wrong one with probability ``stubbornness`` in place of that. The new policy is
    the old one with ``share`` of the demonstrator mixed in.
    """
    for name, value in (("quality", quality), ("share", share), ("stubbornness", stubbornness)):
        real_number(name, value, minimum=0.0, maximum=1.0)
    mdps = gridworld(1, 5, [(0, 0), (0, 4)], (0, 2), discount, moves=LEFT_RIGHT)
    coin = torch.full((5, 2), 0.5, dtype=torch.float64)
    left, right = [(1, 0)] * 5, [(0, 1)] * 5
    demo = [mixed(torch.tensor(best, dtype=torch.float64), 1 - quality) for best in (left, right)]
    if stubbornness:
        demo[0][1] = torch.tensor([1 - stubbornness, stubbornness])
    new = [(1 - share) * coin + share * policy for policy in demo]
    return mdps, torch.tensor([0.5, 0.5]), [coin, coin], new, demo


def slippery_pair(discount: float = 0.9, slip: float = 0.1, lead: float = 0.25) -> Family:
    """Return the two-state family on which Theorem 1 fails under the demonstrator's states.

    State 0 is the path, where the walk begins; state 1 a swamp. In both, action 0 pays 1 and action 1
    costs 1, and both lead to the path; action 2 leads into the swamp, for nothing from the path, for a
    cost of 1 from the swamp itself. The old policy tosses a coin between 0 and 1; the demonstrator
    takes 0 with ``lead`` more; the new policy does as the demonstrator does, but takes action 2 with
    probability ``slip`` (in place of action 1), and in the swamp it takes action 2 always. So every
    advantage is 1, -1, 0 or -1, whatever the discount, and the demonstrator's is 2 ``lead`` everywhere.
    """
    real_number("slip", slip, minimum=0.0, maximum=0.5)
    real_number("lead", lead, minimum=0.0, maximum=0.5 - slip)
    path, swamp = [1, 0], [0, 1]
    transition = torch.tensor([[path, path, swamp]] * 2, dtype=torch.float64)
    reward = torch.tensor([[1, -1, 0], [1, -1, -1]], dtype=torch.float64)
    mdp = TabularMDP(transition, reward, torch.tensor([1.0, 0.0]), discount)
    old = torch.tensor([[0.5, 0.5, 0]] * 2, dtype=torch.float64)
    demo = torch.tensor([[0.5 + lead, 0.5 - lead, 0]] * 2, dtype=torch.float64)
    new = torch.tensor([[0.5 + lead, 0.5 - lead - slip, slip], [0, 0, 1]], dtype=torch.float64)
    return [mdp], torch.ones(1), [old], [new], [demo]
