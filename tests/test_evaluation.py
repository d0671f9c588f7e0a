"""Cloning against the demonstrations it copies."""

import pytest
import torch

from emrld_lite.demonstrations import load_demonstrations
from emrld_lite.demonstrators.cloning import clone
from emrld_lite.losses import bc_loss
from emrld_lite.policy import distribution, initialise, per_task
from emrld_lite.validation import InputError


def test_a_clone_acts_like_its_own_demonstration():
    data = load_demonstrations("optimal", "point2d").take(slice(0, 3))
    task_params = clone(data)
    start = per_task(initialise(2, 2, seed=0), 3)
    assert (bc_loss(task_params, data) < bc_loss(start, data) - 0.5).all()
    error = (distribution(task_params, data.states).mean - data.actions) * data.mask[..., None]
    other = (distribution(task_params, data.states).mean - data.actions.flip(0)) * data.mask[
        ..., None
    ]
    assert error.norm() < 0.5 * other.norm()


def test_tasks_are_cloned_apart():
    both = clone(load_demonstrations("optimal", "point2d").take(slice(0, 2)), steps=20)
    alone = clone(load_demonstrations("optimal", "point2d").take(slice(0, 1)), steps=20)
    for name, value in alone.items():
        assert torch.allclose(both[name][0], value[0], atol=1e-5)


def test_cloning_refuses_numbers_it_cannot_use():
    with pytest.raises(InputError, match="steps"):
        clone(load_demonstrations("optimal", "point2d"), steps=0)
    with pytest.raises(InputError, match="rate"):
        clone(load_demonstrations("optimal", "point2d"), rate=-1.0)
