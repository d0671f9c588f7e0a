"""Notebook 06: random questions for its exercises, and right answers in other styles and types."""

from __future__ import annotations

import torch

from .draw import Draw, Question, Questions, shaped, wave


def _adaptation(draw: Draw) -> Question:
    size = draw.whole(2, 6)
    waves = wave(draw, size), wave(draw, size)
    weights = (draw.between(0.2, 2) for _ in range(2))
    return draw.leaf(size), *waves, *weights, draw.between(0.02, 0.3)


QUESTIONS: Questions = {
    "adaptation_step": _adaptation,
    "warm_start_step": _adaptation,
    "surrogate": shaped("leaf", "normal", "normal", "mask"),
}


def adaptation_step__two_gradients(theta, rl_loss, bc_loss, w_rl, w_bc, alpha):
    (rl,) = torch.autograd.grad(rl_loss(theta), theta, create_graph=True)
    (bc,) = torch.autograd.grad(bc_loss(theta), theta, create_graph=True)
    return theta.sub(alpha * (w_rl * rl + w_bc * bc))


def adaptation_step__functional(theta, rl_loss, bc_loss, w_rl, w_bc, alpha):
    return theta - alpha * torch.func.grad(lambda x: w_rl * rl_loss(x) + w_bc * bc_loss(x))(theta)


def adaptation_step__double(theta, rl_loss, bc_loss, w_rl, w_bc, alpha):
    return adaptation_step__two_gradients(theta.double(), rl_loss, bc_loss, w_rl, w_bc, alpha)


def warm_start_step__functional(theta, rl_loss, bc_loss, w_rl, w_bc, alpha):
    warm = theta - alpha * torch.func.grad(bc_loss)(theta)
    return adaptation_step__functional(warm, rl_loss, bc_loss, w_rl, w_bc, alpha)


def warm_start_step__reused(theta, rl_loss, bc_loss, w_rl, w_bc, alpha):
    warm = adaptation_step__two_gradients(theta, rl_loss, bc_loss, 0.0, 1.0, alpha)
    return adaptation_step__two_gradients(warm, rl_loss, bc_loss, w_rl, w_bc, alpha)


def surrogate__boolean_mask(new_log_prob, old_log_prob, advantages, mask):
    taken = mask > 0
    return -((new_log_prob - old_log_prob).exp() * advantages)[taken].mean()


def surrogate__quotient(new_log_prob, old_log_prob, advantages, mask):
    ratio = new_log_prob.exp().double() / old_log_prob.exp().double()
    return (ratio * -advantages * mask).sum().view(1) / mask.sum()
