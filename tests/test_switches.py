"""Every setting of a run acts: with it changed, the curve is another one than the control's."""

import dataclasses
import functools

import pytest

from emrld_lite.config import TrainConfig
from emrld_lite.demonstrations import load_demonstrations
from emrld_lite.train import meta_train
from emrld_lite.trpo import TrustRegion

from .conftest import without_time

# two iterations with a reward in every step, so that every part of an iteration has work to do
CONTROL = TrainConfig(
    iterations=2,
    episodes=2,
    reward="dense",
    trust_region=TrustRegion(cg_iterations=4, fisher_samples=20),
)
SPARSE = dataclasses.replace(CONTROL, reward="sparse")
WHEELED = dataclasses.replace(CONTROL, env="two_wheeled")
ENDING = dataclasses.replace(WHEELED, seed=2)  # robots leave the arena before the time is up
CHEETAH = dataclasses.replace(CONTROL, env="half_cheetah", episodes=4)
META_BC = dataclasses.replace(CONTROL, algorithm="meta-bc")
FAR = dataclasses.replace(CONTROL.trust_region, max_kl=5.0)  # of no use before it is halved
TOO_FAR = dataclasses.replace(CONTROL, trust_region=FAR)

CHANGES = {  # setting: another value, and the control where it is not CONTROL
    "env": ("two_wheeled", CONTROL),
    "algorithm": ("emrld", CONTROL),
    "demos": ("suboptimal", CONTROL),
    "iterations": (1, CONTROL),
    "seed": (1, CONTROL),
    "episodes": (3, CONTROL),
    "started_episodes": (4, ENDING),
    "discount": (0.9, CONTROL),
    "gae_lambda": (0.9, CONTROL),
    "adapt_lr": (0.02, CONTROL),
    "w_rl": (0.5, CONTROL),
    "w_bc": (0.5, CONTROL),
    "meta_update": ("cloning-trpo", CONTROL),
    "meta_w_bc": (0.5, dataclasses.replace(CONTROL, meta_update="rl-and-cloning-trpo")),
    "meta_momentum": (0.0, CONTROL),
    "meta_lr": (0.02, META_BC),
    "max_grad_norm": (0.01, META_BC),
    "bc_reduction": ("sum", CONTROL),
    "log_density": ("joint", CONTROL),
    "second_order": (False, CONTROL),
    "normalise": (False, CONTROL),
    "reward_elsewhere": (1e-5, SPARSE),
    "learn_sigma": (False, CONTROL),
    "network_start": ("xavier", CONTROL),
    "reward": ("sparse", CONTROL),
    "step_rule": ("exact", CONTROL),
    "heading": (False, WHEELED),
    "start": ("random", CHEETAH),
    "paid_side": ("correct", dataclasses.replace(CHEETAH, reward="sparse")),
    "stop_at_return": (-1e9, CONTROL),
}
REGION_CHANGES = {
    "max_kl": (0.005, CONTROL),
    "cg_iterations": (2, CONTROL),
    "damping": (0.5, CONTROL),
    "backtracks": (1, TOO_FAR),
    "fisher_samples": (30, CONTROL),
    "aliased_cg": (True, CONTROL),
}


@functools.cache
def curve(config):
    """Return the curve of a run, without its seconds."""
    demonstrations = load_demonstrations(config.demos, config.env)
    return without_time([iterate.record for iterate in meta_train(config, demonstrations)])


@pytest.mark.parametrize("name", CHANGES)
def test_a_setting_that_is_changed_changes_the_curve(name):
    value, control = CHANGES[name]
    assert curve(dataclasses.replace(control, **{name: value})) != curve(control)


@pytest.mark.parametrize("name", REGION_CHANGES)
def test_a_setting_of_the_trust_region_that_is_changed_changes_the_curve(name):
    value, control = REGION_CHANGES[name]
    region = dataclasses.replace(control.trust_region, **{name: value})
    assert curve(dataclasses.replace(control, trust_region=region)) != curve(control)


def test_the_control_is_the_same_twice():
    assert curve(CONTROL) == curve.__wrapped__(CONTROL)


def test_no_setting_is_left_out():
    settings = {field.name for field in dataclasses.fields(TrainConfig)} - {"trust_region"}
    assert settings == set(CHANGES)
    assert {field.name for field in dataclasses.fields(TrustRegion)} == set(REGION_CHANGES)
