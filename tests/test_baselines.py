"""Meta-BC and GMPS against finite differences and plain loops; every pair of the comparison runs."""

import dataclasses

import numpy as np
import pytest
import torch

from emrld_lite import adapt, losses, policy, runs, supervised_update, train, trpo
from emrld_lite.algorithms import ALGORITHMS
from emrld_lite.config import TrainConfig
from emrld_lite.demonstrations import find
from emrld_lite.envs import ENVIRONMENTS, make
from emrld_lite.envs.base import Transition
from emrld_lite.evaluate import adaptation_curve
from emrld_lite.policy import initialise
from emrld_lite.rollout import collect, episode_returns
from emrld_lite.train import meta_train
from emrld_lite.validation import InputError

from .conftest import random_demonstrations, random_params, random_rollout

META_BC = ALGORITHMS["meta-bc"].adaptation("optimal", adapt_lr=0.1)
GMPS = ALGORITHMS["gmps"].adaptation("optimal", adapt_lr=0.1)
SMALL = TrainConfig(
    iterations=1,
    episodes=2,
    trust_region=trpo.TrustRegion(cg_iterations=2, fisher_samples=10),
)


def all_finite(params):
    return all(bool(torch.isfinite(value).all()) for value in params.values())


# --- the table ----------------------------------------------------------------------------------


def test_the_table_is_the_paper_s():
    table = {
        name: (row.warm_start, row.w_rl, row.w_bc, row.meta_update)
        for name, row in ALGORITHMS.items()
    }
    assert table == {
        "emrld": (False, None, 1.0, "rl"),  # None: 0.2 or 1, by the data's quality
        "emrld-ws": (True, None, 1.0, "rl"),
        "maml": (False, 1.0, 0.0, "rl"),
        "meta-bc": (False, 0.0, 1.0, "bc"),
        "gmps": (False, 1.0, 0.0, "bc"),
    }


@pytest.mark.parametrize("env", ENVIRONMENTS)
@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize("quality", ["optimal", "suboptimal"])
def test_every_pair_trains_and_adapts(env, algorithm, quality):
    config = dataclasses.replace(SMALL, env=env, algorithm=algorithm, demos=quality)
    data = find(quality, env)
    few = data.map(lambda values: values[[0, len(data.tasks) - 1]])
    iterate = next(meta_train(config, few))
    assert all_finite(iterate.meta_params)
    curve = adaptation_curve(
        config.environment(),
        iterate.meta_params,
        few,
        config.adaptation(quality),
        steps=1,
        episodes=2,
        random=torch.Generator().manual_seed(0),
    )
    assert all(bool(torch.isfinite(episode_returns(part)).all()) for part in curve.rollouts)


# --- the supervised meta-update -----------------------------------------------------------------


@pytest.mark.parametrize("rule", [META_BC, GMPS], ids=["meta-bc", "gmps"])
def test_its_gradient_equals_finite_differences(rule):
    params = random_params(0)
    before, demos = random_rollout(2), random_demonstrations(1)

    def loss(vector):
        trial = policy.from_vector(vector, params)
        return float(losses.bc_loss(adapt.adapt(trial, before, demos, rule), demos).mean())

    gradient = policy.to_vector(supervised_update.cloning_gradient(params, before, demos, rule))
    at = policy.to_vector(params)
    random = torch.Generator().manual_seed(0)
    for _ in range(4):
        direction = torch.randn(at.shape, generator=random, dtype=torch.float64)
        direction /= direction.norm()
        slope = (loss(at + 1e-5 * direction) - loss(at - 1e-5 * direction)) / 2e-5
        assert slope == pytest.approx(float(gradient @ direction), rel=1e-5)


def test_more_tasks_than_one_chunk_give_the_mean_over_tasks():
    params, before, demos = random_params(0), random_rollout(2, 6), random_demonstrations(1, 6)
    together = supervised_update.cloning_gradient(params, before, demos, META_BC)
    alone = [
        supervised_update.cloning_gradient(
            params,
            type(before)(*(values[task : task + 1] for values in before)),
            demos.take(slice(task, task + 1)),
            META_BC,
        )
        for task in range(6)
    ]
    for name, value in together.items():
        torch.testing.assert_close(value, torch.stack([one[name] for one in alone]).mean(0))


def test_adam_equals_its_formula_written_out():
    random = torch.Generator().manual_seed(0)
    params = {"weight": torch.randn(3, generator=random, dtype=torch.float64)}
    moments, rate = None, 0.01
    expected, mean, square = params["weight"].clone(), torch.zeros(3), torch.zeros(3)
    for step in range(1, 6):
        gradient = torch.randn(3, generator=random, dtype=torch.float64)
        params, moments = supervised_update.adam_step(params, {"weight": gradient}, moments, rate)
        mean = 0.9 * mean + 0.1 * gradient  # Kingma and Ba (2015), algorithm 1
        square = 0.999 * square + 0.001 * gradient**2
        corrected = mean / (1 - 0.9**step), square / (1 - 0.999**step)
        expected = expected - rate * corrected[0] / (corrected[1].sqrt() + 1e-8)
        torch.testing.assert_close(params["weight"], expected)
    assert moments.step == 5


def test_the_recorded_divergence_is_that_of_the_adapted_policies():
    old, new = random_params(0), random_params(5)
    before, after, demos = random_rollout(2), random_rollout(3), random_demonstrations(1)
    measured = supervised_update.adapted_kl(old, new, before, after, demos, META_BC)
    pair = [
        policy.distribution(adapt.adapt(params, before, demos, META_BC), after.states)
        for params in (old, new)
    ]
    normal = [torch.distributions.Normal(g.mean, g.log_sigma.exp()) for g in pair]
    each = torch.distributions.kl_divergence(*normal).sum(-1) * after.mask
    assert measured == pytest.approx(float((each.sum((1, 2)) / after.mask.sum((1, 2))).mean()))


def test_a_gradient_that_is_not_finite_changes_nothing(monkeypatch):
    params = random_params(0)
    broken = {name: torch.full_like(value, torch.nan) for name, value in params.items()}
    monkeypatch.setattr(supervised_update, "cloning_gradient", lambda *_: broken)
    same, moments, step = supervised_update.supervised_update(
        params, None, random_rollout(2), random_rollout(3), random_demonstrations(1), GMPS, 0.01
    )
    assert same is params and moments is None
    assert "not finite" in step.note


def test_a_policy_file_without_adam_s_memory_is_refused(tmp_path):
    config = dataclasses.replace(SMALL, algorithm="meta-bc")
    run = runs.train_run(config, tmp_path / "run")
    smaller = run.moments._replace(square={})
    runs.save_checkpoint(tmp_path / "run", run._replace(moments=smaller))
    with pytest.raises(InputError, match=r"policy\.safetensors: expected tensors"):
        runs.load_run(tmp_path / "run")


# --- the trust region grows with the action ------------------------------------------------------


def test_the_bound_is_a_hundredth_of_a_nat_for_each_dimension_unless_told():
    assert trpo.TrustRegion().for_actions(2).max_kl == pytest.approx(0.02)
    assert trpo.TrustRegion().for_actions(6).max_kl == pytest.approx(0.06)
    assert trpo.TrustRegion(max_kl=0.5).for_actions(6).max_kl == 0.5


# --- evaluation on unseen tasks ------------------------------------------------------------------


def test_the_cheetah_is_tested_in_both_directions():
    tasks = make("half_cheetah").test_tasks(5, np.random.default_rng(0))
    assert tasks[:, 0].tolist() == [1, -1, 1, -1, 1]


def test_later_steps_are_shorter_by_the_rate():
    data, params = find("optimal", "point2d").take(slice(0, 2)), initialise(2, 2, seed=0)
    rule = ALGORITHMS["meta-bc"].adaptation("optimal")  # cloning alone: no draws in the step

    def policies(later_rate):
        random = torch.Generator().manual_seed(0)
        return adaptation_curve(
            make("point2d"), params, data, rule, 2, 2, random, later_rate=later_rate
        ).policies

    whole, half, none = (policies(rate) for rate in (1.0, 0.5, 0.0))
    for name in params:
        torch.testing.assert_close(none[2][name], none[1][name])
        full_step = whole[2][name] - whole[1][name]
        torch.testing.assert_close(half[2][name] - half[1][name], 0.5 * full_step)


@pytest.mark.parametrize("env", ["two_wheeled", "half_cheetah"])
def test_a_test_task_learns_nothing_from_the_others(env):
    """A task's rollouts after two steps do not depend on what the other tasks are or were shown."""
    data = find("optimal", env)
    last = len(data.tasks) - 1
    family = make(env)
    params = initialise(family.state_dim, family.action_dim, seed=0)
    rule = ALGORITHMS["emrld-ws"].adaptation("optimal")

    def first_task(chosen):
        few = data.map(lambda values: values[chosen])
        random = torch.Generator().manual_seed(0)
        curve = adaptation_curve(make(env), params, few, rule, 2, 2, random)
        return torch.stack([rollout.rewards[0].sum() for rollout in curve.rollouts]), [
            rollout.states[0, :, :20] for rollout in curve.rollouts
        ]

    one, other = first_task([0, 1, 2]), first_task([0, last, last - 1])
    for left, right in zip(one[1], other[1], strict=True):
        torch.testing.assert_close(left, right, atol=1e-3, rtol=1e-3)


# --- what a policy may do to itself -----------------------------------------------------------------


@pytest.mark.parametrize("log_sigma", [-50.0, -20.0, -4.0, 5.0, 20.0, 100.0])
@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize("env", ["point2d", "half_cheetah"])
def test_a_sigma_gone_astray_is_survived_and_told(env, algorithm, log_sigma):
    config = dataclasses.replace(SMALL, env=env, algorithm=algorithm)
    family = config.environment()
    start = initialise(family.state_dim, family.action_dim, seed=0)
    start["log_sigma"] = torch.full((family.action_dim,), log_sigma)
    iterate = next(meta_train(config, find("optimal", env).take(slice(0, 2)), start))
    assert all_finite(iterate.meta_params)
    for rollout in (iterate.before, iterate.after):
        assert all_finite({"rewards": rollout.rewards, "actions": rollout.actions})
    assert not np.isnan(iterate.record.kl)
    assert ("sigma has drifted" in iterate.record.note) == (abs(log_sigma) > 7)


def test_a_task_whose_step_explodes_keeps_its_policy_and_the_others_theirs():
    start = random_params(0)
    stepped = policy.per_task(random_params(3), 3)
    stepped = {name: value.clone() for name, value in stepped.items()}
    stepped["bias_1"][1, 0] = torch.nan
    stepped["weight_0"][2, 0, 0] = 1e7
    kept, undone = adapt.usable(stepped, start)
    assert undone == 2
    for name, value in kept.items():
        torch.testing.assert_close(value[0], stepped[name][0])
        torch.testing.assert_close(value[1], start[name])
        torch.testing.assert_close(value[2], start[name])
    assert "adaptation undone for 2 tasks" in train.told(trpo.Step(0, 0, ""), undone, {}).note


class EndsAtOnce(type(make("point2d"))):
    """Point2D in which every episode ends with its first step: out of the arena at once."""

    def step(self, tasks, states, actions, time):
        moved = super().step(tasks, states, actions, time)
        return Transition(
            moved.states, moved.rewards, torch.ones_like(moved.terminated), moved.success
        )


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_episodes_of_one_step_without_a_reward_are_survived_and_told(algorithm, monkeypatch):
    monkeypatch.setattr(TrainConfig, "environment", lambda self: EndsAtOnce())
    config = dataclasses.replace(SMALL, algorithm=algorithm)
    start = initialise(2, 2, seed=0)
    iterate = next(meta_train(config, find("optimal", "point2d").take(slice(0, 3)), start))
    assert iterate.before.mask.shape == (3, 2, 1)
    assert all_finite(iterate.meta_params)
    assert ("nothing rewarded" in iterate.record.note) == (config.row().meta_update == "rl")


def test_a_robot_that_leaves_its_arena_stops_there():
    fast = dataclasses.replace(make("two_wheeled"))
    tasks = fast.training_tasks()[:1]
    straight = initialise(3, 2, seed=0)
    straight = {name: torch.zeros_like(value) for name, value in straight.items()}
    straight["bias_2"] = torch.tensor([5.0, 0.0])  # full speed ahead
    straight["log_sigma"] = torch.full((2,), -9.0)
    rollout = collect(fast, tasks * torch.tensor([-1.0, 1.0]), straight, 2, torch.Generator())
    lengths = rollout.mask.sum(-1)
    assert (lengths == np.ceil(2.5 / 0.11)).all()  # 0.22 units a second, half a second a step


# --- the switches of the ledger -------------------------------------------------------------------


def test_a_tiny_reward_everywhere_gives_advantages_of_full_size_and_changes_no_return():
    rollout = random_rollout(0)._replace(rewards=torch.zeros_like(random_rollout(0).rewards))
    nothing = TrainConfig().scored(rollout)
    tiny = TrainConfig(reward_elsewhere=1e-5).scored(rollout)
    assert float(nothing.advantages.abs().max()) == 0.0
    assert float(tiny.advantages.abs().max()) > 0.5  # normalisation blows up what the baseline left
    assert float(episode_returns(tiny).abs().max()) == 0.0


def test_advantages_without_normalisation_keep_their_size():
    rollout = random_rollout(0)
    raw = TrainConfig(normalise=False).scored(rollout).advantages
    tenfold = rollout._replace(rewards=10 * rollout.rewards)
    larger = TrainConfig(normalise=False).scored(tenfold).advantages
    torch.testing.assert_close(larger, 10 * raw)
    assert not torch.allclose(TrainConfig().scored(rollout).advantages, raw)
