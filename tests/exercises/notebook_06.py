"""Notebook 06: random questions for its exercises, and right answers in other styles and types."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import torch

from .draw import Draw, Question, Questions, episodes, shaped, wave


def _adaptation(draw: Draw) -> Question:
    size = draw.whole(2, 6)
    waves = wave(draw, size), wave(draw, size)
    weights = (draw.between(0.2, 2) for _ in range(2))
    return draw.leaf(size), *waves, *weights, draw.between(0.02, 0.3)


def _surrogate(new, old, advantages, mask):
    return -((new - old).exp() * advantages * mask).sum() / mask.sum()


def _one_task(draw: Draw, size: int) -> SimpleNamespace:
    shape = episodes(draw)
    matrix, offset = draw.normal(*shape, size), draw.normal(*shape)
    return SimpleNamespace(
        log_prob=lambda theta: -0.1 * (matrix @ theta + offset).square(),
        collected_with=0.5 * draw.normal(size),
        advantages=draw.normal(*shape),
        mask=draw.mask(*shape),
        bend=draw.normal(size),
    )


def _meta_loss(draw: Draw) -> Question:
    size = draw.whole(2, 5)
    tasks = tuple(_one_task(draw, size) for _ in range(draw.whole(1, 5)))
    return draw.leaf(size), tasks, lambda x, task: x - 0.1 * (x - task.bend).pow(3), _surrogate


def _experiment(draw: Draw) -> Question:
    strength, luck = draw.random.normal(size=4), draw.random.normal(size=(30, 4))

    def run(w_rl, w_bc, warm, seed):
        switched = np.array([w_rl, w_bc, warm * w_bc, warm], dtype=float)
        return float((strength + luck[seed]) @ switched + 5 * luck[seed, 0])

    seeds = tuple(draw.random.permutation(30)[: draw.whole(2, 9)].tolist())
    return run, (draw.between(0.1, 1), draw.between(0.5, 2), True), seeds


QUESTIONS: Questions = {
    "adaptation_step": _adaptation,
    "surrogate": shaped("leaf", "normal", "normal", "mask"),
    "meta_loss": _meta_loss,
    "what_parts_add": _experiment,
}


def adaptation_step__two_gradients(theta, rl_loss, bc_loss, w_rl, w_bc, alpha):
    (rl,) = torch.autograd.grad(rl_loss(theta), theta, create_graph=True)
    (bc,) = torch.autograd.grad(bc_loss(theta), theta, create_graph=True)
    return theta.sub(alpha * (w_rl * rl + w_bc * bc))


def adaptation_step__functional(theta, rl_loss, bc_loss, w_rl, w_bc, alpha):
    return theta - alpha * torch.func.grad(lambda x: w_rl * rl_loss(x) + w_bc * bc_loss(x))(theta)


def adaptation_step__double(theta, rl_loss, bc_loss, w_rl, w_bc, alpha):
    return adaptation_step__two_gradients(theta.double(), rl_loss, bc_loss, w_rl, w_bc, alpha)


def surrogate__boolean_mask(new_log_prob, old_log_prob, advantages, mask):
    taken = mask > 0
    return -((new_log_prob - old_log_prob).exp() * advantages)[taken].mean()


def surrogate__quotient(new_log_prob, old_log_prob, advantages, mask):
    ratio = new_log_prob.exp().double() / old_log_prob.exp().double()
    return (ratio * -advantages * mask).sum().view(1) / mask.sum()


def meta_loss__sum_over_count(theta, tasks, adapted, surrogate):
    total = 0.0
    for task in tasks:
        old = task.log_prob(task.collected_with).detach()
        total = total + surrogate(
            task.log_prob(adapted(theta, task)), old, task.advantages, task.mask
        )
    return total / len(tasks)


def meta_loss__written_out(theta, tasks, adapted, surrogate):
    def one(task):
        change = task.log_prob(adapted(theta, task)) - task.log_prob(task.collected_with)
        return (change.exp() * task.advantages * task.mask).sum() / task.mask.sum()

    return -torch.stack([one(task) for task in tasks]).mean().reshape(1)


def meta_loss__double(theta, tasks, adapted, surrogate):
    return meta_loss__sum_over_count(theta, tasks, adapted, surrogate).double()


def what_parts_add__numpy(run, full, seeds):
    def without(place):
        setting = list(full)
        setting[place] = type(full[place])(0)
        return np.array([run(*full, seed) - run(*setting, seed) for seed in seeds])

    drops = {name: without(place) for place, name in enumerate(("RL", "cloning", "warm start"))}
    return {
        name: np.array([drop.mean(), drop.std(ddof=1) / np.sqrt(len(seeds))])
        for name, drop in drops.items()
    }


def what_parts_add__by_hand(run, full, seeds):
    w_rl, w_bc, _ = full
    answer = {}
    for part, setting in (
        ("warm start", (w_rl, w_bc, False)),
        ("RL", (0, w_bc, True)),
        ("cloning", (w_rl, 0, True)),
    ):
        drops = [run(*full, seed) - run(*setting, seed) for seed in seeds]
        mean = sum(drops) / len(drops)
        square = sum((drop - mean) ** 2 for drop in drops) / (len(drops) - 1)
        answer[part] = [mean, (square / len(drops)) ** 0.5]
    return answer
