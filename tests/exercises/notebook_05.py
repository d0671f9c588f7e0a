"""Notebook 05: random questions for its exercises, and right answers in other styles and types."""

from __future__ import annotations

from collections.abc import Callable

import torch

from .draw import D, Draw, Question, Questions, wave


def _matrix(draw: Draw, size: int) -> torch.Tensor:
    root = draw.normal(size, size)
    return root @ root.T + 0.1 * torch.eye(size, dtype=D)


def _product(matrix: torch.Tensor) -> Callable[[torch.Tensor], torch.Tensor]:
    return lambda vector: matrix @ vector


def _meta(draw: Draw) -> Question:
    size = draw.whole(2, 5)
    data = []
    for _ in range(2):
        steps = draw.whole(3, 20)
        data.append((draw.normal(steps, size), draw.normal(steps), draw.normal(steps)))
    return draw.normal(size), *data, draw.between(0.05, 0.5)


def _meta_loss(draw: Draw) -> Question:
    size = draw.whole(2, 5)
    tasks = [(wave(draw, size), wave(draw, size)) for _ in range(draw.whole(1, 5))]
    return draw.leaf(size), tasks, draw.between(0.02, 0.3)


def _vector(draw: Draw) -> Question:
    size = draw.whole(2, 7)
    return draw.normal(size), _product(_matrix(draw, size)), draw.between(0.005, 0.5)


def _target(draw: Draw) -> Question:
    size = draw.whole(4, 9)
    zero = draw.whole(0, 6) == 0
    target = torch.zeros(size, dtype=D) if zero else draw.between(0.01, 2) * draw.normal(size)
    return _product(_matrix(draw, size)), target, draw.whole(1, 4)


QUESTIONS: Questions = {
    "meta_gradient": _meta,
    "conjugate_gradient": _target,
    "full_step": _vector,
    "supervised_meta_loss": _meta_loss,
}


def meta_gradient__autograd(w, before, after, alpha):
    def loss(weights, data):
        states, actions, advantages = data
        return 0.5 * (advantages * (states @ weights - actions) ** 2).mean()

    leaf = w.clone().requires_grad_()
    (inner,) = torch.autograd.grad(loss(leaf, before), leaf, create_graph=True)
    return torch.autograd.grad(loss(leaf - alpha * inner, after), leaf)[0]


def meta_gradient__numpy(w, before, after, alpha):
    return meta_gradient__autograd(w, before, after, alpha).numpy()


def conjugate_gradient__in_its_own_memory(product, target, iterations):
    x, r = torch.zeros_like(target), target.clone()
    p, rr = r.clone(), r.dot(r)
    for _ in range(iterations):
        if rr < 1e-20:
            break
        image = product(p)
        alpha = rr / p.dot(image)
        x += alpha * p
        r -= alpha * image
        new = r.dot(r)
        p.mul_(new / rr).add_(r)
        rr = new
    return x


def conjugate_gradient__residual_anew(product, target, iterations):
    x, p, r = 0 * target, target, target
    for _ in range(iterations):
        if float(r.norm()) == 0.0:
            return x
        image = product(p)
        x = x + (r @ p) / (p @ image) * p
        new = r - (r @ p) / (p @ image) * image
        p = new + (new @ new) / (r @ r) * p
        r = new
    return x.numpy()


def full_step__power(direction, product, max_kl):
    return direction * (2 * max_kl / float(direction @ product(direction))) ** 0.5


def full_step__numpy(direction, product, max_kl):
    return full_step__power(direction, product, max_kl).numpy()


def supervised_meta_loss__stacked(theta, tasks, alpha):
    losses = []
    for adapt_loss, bc_loss in tasks:
        gradient = torch.autograd.grad(adapt_loss(theta), [theta], create_graph=True)[0]
        losses.append(bc_loss(theta - alpha * gradient))
    return torch.stack(losses).mean()


def supervised_meta_loss__functional(theta, tasks, alpha):
    adapted = [theta - alpha * torch.func.grad(adapt)(theta) for adapt, _ in tasks]
    return sum(bc(point) for (_, bc), point in zip(tasks, adapted, strict=True)) / len(tasks)
