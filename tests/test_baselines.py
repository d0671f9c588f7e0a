"""Meta-BC and GMPS against finite differences and plain loops; every pair of the comparison runs."""

import dataclasses

import numpy as np
import pytest
import torch

from emrld_lite import adapt, losses, policy, trpo
from emrld_lite.advantage import Score
from emrld_lite.algorithms import ALGORITHMS
from emrld_lite.config import TrainConfig
from emrld_lite.demonstrations import load_demonstrations
from emrld_lite.envs import ENVIRONMENTS, make
from emrld_lite.envs.base import Transition
from emrld_lite.evaluate import adaptation_curve
from emrld_lite.experiments import checkpoints, runs
from emrld_lite.learners import (
    Adam,
    CloningTrpo,
    RlAndCloningTrpo,
    TaskData,
    Trpo,
    adapted_kl,
    chunks,
    cloning_gradient,
    policies_after,
)
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
        name: (row.warm_start, row.w_rl, row.w_bc, row.learner) for name, row in ALGORITHMS.items()
    }
    assert table == {
        "emrld": (False, None, 1.0, Trpo),  # None: 0.2 or 1, by the data's quality
        "emrld-ws": (True, None, 1.0, Trpo),
        "maml": (False, 1.0, 0.0, Trpo),
        "meta-bc": (False, 0.0, 1.0, Adam),
        "gmps": (False, 1.0, 0.0, Adam),
    }


@pytest.mark.parametrize("env", ENVIRONMENTS)
@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize("quality", ["optimal", "suboptimal"])
def test_every_pair_trains_and_adapts(env, algorithm, quality):
    config = dataclasses.replace(SMALL, env=env, algorithm=algorithm, demos=quality)
    data = load_demonstrations(quality, env)
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
        adapted = adapt.adapt(trial, before, demos, rule)
        return float(losses.bc_loss(adapted, demos, density="averaged").mean())

    data = TaskData(before, before, demos)
    gradient = policy.to_vector(cloning_gradient(params, [data], rule))
    at = policy.to_vector(params)
    random = torch.Generator().manual_seed(0)
    for _ in range(4):
        direction = torch.randn(at.shape, generator=random, dtype=torch.float64)
        direction /= direction.norm()
        slope = (loss(at + 1e-5 * direction) - loss(at - 1e-5 * direction)) / 2e-5
        assert slope == pytest.approx(float(gradient @ direction), rel=1e-5)


def test_more_tasks_than_one_chunk_give_the_mean_over_tasks():
    params, before, demos = random_params(0), random_rollout(2, 6), random_demonstrations(1, 6)
    parts = chunks(TaskData(before, before, demos))
    assert [len(part.demonstrations.tasks) for part in parts] == [4, 2]
    together = cloning_gradient(params, parts, META_BC)
    single = [slice(task, task + 1) for task in range(6)]
    alone = [
        cloning_gradient(
            params, [TaskData(before.take(one), before.take(one), demos.take(one))], META_BC
        )
        for one in single
    ]
    for name, value in together.items():
        torch.testing.assert_close(value, torch.stack([one[name] for one in alone]).mean(0))


def test_adam_equals_its_formula_written_out():
    data = TaskData(random_rollout(2), random_rollout(3), random_demonstrations(1))
    params, rate = random_params(0), 0.01
    learner = Adam(params, rate)
    expected = policy.to_vector(params)
    mean, square = torch.zeros_like(expected), torch.zeros_like(expected)
    for step in range(1, 6):
        gradient = policy.to_vector(cloning_gradient(params, chunks(data), META_BC))
        params, _ = learner.update(params, data, META_BC, torch.Generator())
        mean = 0.9 * mean + 0.1 * gradient  # Kingma and Ba (2015), algorithm 1
        square = 0.999 * square + 0.001 * gradient**2
        corrected = mean / (1 - 0.9**step), square / (1 - 0.999**step)
        expected = expected - rate * corrected[0] / (corrected[1].sqrt() + 1e-8)
        torch.testing.assert_close(policy.to_vector(params), expected)
    assert learner.state()["adam.step.weight_0"] == 5


def test_adam_goes_on_from_a_checkpoint_as_if_it_had_not_stopped():
    data = TaskData(random_rollout(2), random_rollout(3), random_demonstrations(1))
    theta = random_params(0)
    learner = Adam(theta, 0.01)
    theta, _ = learner.update(theta, data, META_BC, torch.Generator())
    resumed = Adam(theta, 0.01)
    resumed.load(learner.state())
    forgetful = Adam(theta, 0.01)
    straight, again, other = (
        policy.to_vector(one.update(theta, data, META_BC, torch.Generator())[0])
        for one in (learner, resumed, forgetful)
    )
    assert torch.equal(straight, again) and not torch.allclose(straight, other)


def test_the_recorded_divergence_is_that_of_the_adapted_policies():
    old, new = random_params(0), random_params(5)
    before, after, demos = random_rollout(2), random_rollout(3), random_demonstrations(1)
    measured = adapted_kl(old, new, chunks(TaskData(before, after, demos)), META_BC)
    pair = [
        policy.distribution(adapt.adapt(params, before, demos, META_BC), after.states)
        for params in (old, new)
    ]
    normal = [torch.distributions.Normal(g.mean, g.log_sigma.exp()) for g in pair]
    each = torch.distributions.kl_divergence(*normal).sum(-1) * after.mask
    assert measured == pytest.approx(float((each.sum((1, 2)) / after.mask.sum((1, 2))).mean()))


@pytest.mark.parametrize(
    ("spoiled", "rate"), [("the gradient", 0.01), ("Adam's step", 1e308)], ids=["gradient", "step"]
)
def test_a_step_that_is_not_finite_changes_neither_policy_nor_memory(spoiled, rate):
    params, demos = random_params(0), random_demonstrations(1)
    data = TaskData(random_rollout(2), random_rollout(3), demos)
    learner = Adam(params, rate)
    if spoiled == "the gradient":
        far = demos.map(lambda values: values).actions * 1e200  # its square overflows
        data = data._replace(demonstrations=dataclasses.replace(demos, actions=far))
    else:
        learner.load({name: value + 1e300 for name, value in learner.state().items()})
    kept = learner.state()
    same, step = learner.update(params, data, GMPS, torch.Generator())
    assert same is params and step.note == f"skipped: {spoiled} is not finite"
    for name, value in learner.state().items():
        torch.testing.assert_close(value, kept[name])


def mean_cloning_loss(params, data, rule):
    """Return mean_i L^BC_i(theta_i), one task after the other."""
    losses = []
    for task in range(len(data.demonstrations.tasks)):
        one = slice(task, task + 1)
        demos = data.demonstrations.take(one)
        adapted = adapt.adapt(params, data.before.take(one), demos, rule)
        losses.append(float(adapt.cloning_loss(adapted, demos, rule).detach()))
    return sum(losses) / len(losses)


@pytest.mark.parametrize("rule", [META_BC, GMPS], ids=["cloning", "rl"])
def test_cloning_by_trpo_lowers_the_cloning_loss_within_the_bound(rule):
    params = random_params(0)
    data = TaskData(random_rollout(2, 6), random_rollout(3, 6), random_demonstrations(1, 6))
    learner = CloningTrpo(params, trpo.TrustRegion(max_kl=0.02, fisher_samples=20))
    stepped, step = learner.update(params, data, rule, torch.Generator().manual_seed(0))
    assert step.note == ""
    assert mean_cloning_loss(stepped, data, rule) < mean_cloning_loss(params, data, rule)
    measured = adapted_kl(params, stepped, chunks(data), rule)
    assert step.kl == pytest.approx(measured) and 0 < measured <= 0.02


def test_cloning_by_trpo_starts_from_the_loss_and_gradient_of_meta_bc():
    params = random_params(0)
    data = TaskData(random_rollout(2, 6), random_rollout(3, 6), random_demonstrations(1, 6))
    parts = chunks(data)
    learner = CloningTrpo(params, trpo.TrustRegion())
    objective = learner.objective(params, parts, META_BC)
    assert objective.value == pytest.approx(mean_cloning_loss(params, data, META_BC))
    torch.testing.assert_close(
        objective.gradient, policy.to_vector(cloning_gradient(params, parts, META_BC))
    )


def test_cloning_by_trpo_reads_no_reward_of_d_val():
    params = random_params(0)
    before, after, demos = random_rollout(2), random_rollout(3), random_demonstrations(1)
    unpaid = after._replace(rewards=0 * after.rewards, advantages=0 * after.advantages)
    one, other = (
        CloningTrpo(params, trpo.TrustRegion(fisher_samples=20)).update(
            params, TaskData(before, late, demos), META_BC, torch.Generator().manual_seed(0)
        )[0]
        for late in (after, unpaid)
    )
    assert torch.equal(policy.to_vector(one), policy.to_vector(other))


@pytest.mark.parametrize("weight", [0.0, 0.1, 1.0])
def test_rl_and_cloning_by_trpo_start_from_the_sum_of_both_losses_and_gradients(weight):
    params = random_params(0)
    data = TaskData(random_rollout(2, 6), random_rollout(3, 6), random_demonstrations(1, 6))
    rule = dataclasses.replace(META_BC, w_rl=0.2)
    config = dataclasses.replace(SMALL, meta_update="rl-and-cloning-trpo", meta_w_bc=weight)
    rl, cloning, both = (
        learner.objective(params, chunks(data), rule)
        for learner in (
            Trpo(params, trpo.TrustRegion()),
            CloningTrpo(params, trpo.TrustRegion()),
            config.learner(params),
        )
    )
    assert both.value == pytest.approx(rl.value + weight * cloning.value)
    torch.testing.assert_close(both.gradient, rl.gradient + weight * cloning.gradient)


def test_rl_and_cloning_by_trpo_accept_a_step_that_lowers_the_sum_within_the_bound():
    params = random_params(0)
    data = TaskData(random_rollout(2, 6), random_rollout(3, 6), random_demonstrations(1, 6))
    region = trpo.TrustRegion(max_kl=0.02, fisher_samples=20)
    learner = RlAndCloningTrpo(params, region, weight=0.5)
    stepped, step = learner.update(params, data, META_BC, torch.Generator().manual_seed(0))
    assert step.note == ""
    old = policies_after(params, data, META_BC)
    totals = [
        float(losses.surrogate_loss(policies_after(theta, data, META_BC), old, data.after).mean())
        + 0.5 * mean_cloning_loss(theta, data, META_BC)
        for theta in (params, stepped)
    ]
    assert totals[1] < totals[0]
    assert 0 < step.kl <= 0.02


def test_a_meta_update_that_is_chosen_replaces_the_algorithm_s():
    own = dataclasses.replace(SMALL, algorithm="meta-bc")
    chosen = dataclasses.replace(own, meta_update="cloning-trpo")
    assert own.learner_type() is Adam and chosen.learner_type() is CloningTrpo
    named = dataclasses.replace(own, meta_update="cloning-adam")
    assert runs.differences(own, named) == []  # it says what Meta-BC does anyway
    assert "meta_update" in runs.differences(own, chosen)
    with pytest.raises(InputError, match="meta_update"):
        dataclasses.replace(own, meta_update="adam")
    for setting in (None, "cloning-trpo"):  # nothing would read it
        with pytest.raises(InputError, match=r"meta_w_bc: expected 1\.0, got 0\.1"):
            dataclasses.replace(own, meta_update=setting, meta_w_bc=0.1)


@pytest.mark.parametrize("share", [0.25, 4.0], ids=["longer than the bound", "shorter"])
def test_a_gradient_is_clipped_to_its_bound_and_keeps_its_direction(share):
    params, rule = random_params(0), META_BC
    data = TaskData(random_rollout(2), random_rollout(3), random_demonstrations(1))
    gradient = policy.to_vector(cloning_gradient(params, chunks(data), rule))
    bound = share * float(gradient.norm())
    learner = Adam(params, 0.01, max_grad_norm=bound)
    learner.update(params, data, rule, torch.Generator().manual_seed(0))
    seen = torch.cat([learner.state()[f"adam.exp_avg.{name}"].flatten() for name in params]) / 0.1
    expected = min(1.0, share) * gradient  # 0.1 is Adam's 1 - beta_1
    torch.testing.assert_close(seen, expected, rtol=1e-4, atol=1e-7)


def test_a_bound_on_the_gradient_is_for_adam():
    own = dataclasses.replace(SMALL, algorithm="gmps")
    assert (
        dataclasses.replace(own, max_grad_norm=0.5).learner(random_params(0)).max_grad_norm == 0.5
    )
    for change in ({"algorithm": "emrld"}, {"meta_update": "cloning-trpo"}):
        with pytest.raises(InputError, match=r"max_grad_norm: expected None, got 0\.5"):
            dataclasses.replace(own, max_grad_norm=0.5, **change)
    with pytest.raises(InputError, match="max_grad_norm"):
        dataclasses.replace(own, max_grad_norm=0.0)


def test_a_policy_file_without_adam_s_memory_is_refused(tmp_path):
    config = dataclasses.replace(SMALL, algorithm="meta-bc")
    run = checkpoints.train_run(config, tmp_path / "run")
    smaller = {name: value for name, value in run.learner_state.items() if "_sq" not in name}
    checkpoints.save_checkpoint(tmp_path / "run", run._replace(learner_state=smaller))
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
    data, params = (
        load_demonstrations("optimal", "point2d").take(slice(0, 2)),
        initialise(2, 2, seed=0),
    )
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
    data = load_demonstrations("optimal", env)
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
def test_a_sigma_gone_astray_is_survived(env, algorithm, log_sigma):
    config = dataclasses.replace(SMALL, env=env, algorithm=algorithm)
    family = config.environment()
    start = initialise(family.state_dim, family.action_dim, seed=0)
    start["log_sigma"] = torch.full((family.action_dim,), log_sigma)
    iterate = next(meta_train(config, load_demonstrations("optimal", env).take(slice(0, 2)), start))
    assert all_finite(iterate.meta_params)
    for rollout in (iterate.before, iterate.after):
        assert all_finite({"rewards": rollout.rewards, "actions": rollout.actions})
    assert not np.isnan(iterate.record.kl)


def exploding(demos):
    """Return the demonstrations with actions in tasks 1 and 2 that no step survives: inf, and 1e7 off."""
    actions = demos.actions.clone()
    actions[1], actions[2] = 1e200, 1e12
    return dataclasses.replace(demos, actions=actions)


@pytest.mark.parametrize("warm", [False, True], ids=["emrld", "emrld-ws"])
@pytest.mark.parametrize("keep_graph", [False, True], ids=["values", "graph"])
def test_a_task_whose_step_explodes_keeps_its_policy_and_the_others_theirs(warm, keep_graph):
    params, before, demos = random_params(0), random_rollout(2), random_demonstrations(1)
    rule = dataclasses.replace(META_BC, w_rl=0.5, warm_start=warm)
    leaves = policy.detach(params, requires_grad=True)
    kept = adapt.adapt(leaves, before, exploding(demos), rule, keep_graph)
    usual = adapt.adapt(params, before, demos, rule)
    assert adapt.unmoved_tasks(params, kept) == 2
    for name, value in kept.items():
        torch.testing.assert_close(value[0], usual[name][0])
        torch.testing.assert_close(value[1], params[name])
        torch.testing.assert_close(value[2], params[name])


@pytest.mark.parametrize("warm", [False, True], ids=["emrld", "emrld-ws"])
def test_the_meta_gradient_of_a_lost_task_is_that_of_no_adaptation(warm):
    """The old policy is the one that collected D^val, and its derivative is the identity's."""
    params, before, after = random_params(0), random_rollout(2), random_rollout(3)
    demos = exploding(random_demonstrations(1))
    rule = dataclasses.replace(META_BC, w_rl=0.5, warm_start=warm)
    for task in (0, 1, 2):
        one = slice(task, task + 1)
        data = TaskData(before.take(one), after.take(one), demos.take(one))
        piece = trpo.surrogate_gradient(
            params, lambda theta, data=data: policies_after(theta, data, rule, True), data.after
        )
        bare = trpo.surrogate_gradient(
            params,
            lambda theta, data=data: policy.distribution(theta, data.after.states),
            data.after,
        )
        same = torch.allclose(piece.gradient, bare.gradient)
        assert torch.isfinite(piece.gradient).all() and same == (task > 0)
        together = TaskData(before, after, demos)
    whole = trpo.surrogate_gradient(
        params, lambda theta: policies_after(theta, together, rule, True), after
    )
    assert torch.isfinite(whole.gradient).all()


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
    iterate = next(
        meta_train(config, load_demonstrations("optimal", "point2d").take(slice(0, 3)), start)
    )
    assert iterate.before.mask.shape == (3, 2, 1)
    assert all_finite(iterate.meta_params)
    uses_trpo = config.comparison_row().learner is Trpo
    assert ("nothing rewarded" in iterate.record.note) == uses_trpo


def test_a_robot_that_leaves_its_arena_stops_there():
    fast = dataclasses.replace(make("two_wheeled"))
    tasks = fast.training_tasks()[:1]
    straight = initialise(3, 2, seed=0)
    straight = {name: torch.zeros_like(value) for name, value in straight.items()}
    straight["bias_2"] = torch.tensor([5.0, 0.0])  # full speed ahead
    straight["log_sigma"] = torch.full((2,), -9.0)
    rollout = collect(fast, tasks * torch.tensor([-1.0, 1.0]), straight, 2, torch.Generator())
    lengths = rollout.mask.sum(-1)
    assert (lengths == np.ceil(2.5 / 0.11)).all()  # 0.22 units per second, half a second per step


# --- the switches of the ledger -------------------------------------------------------------------


def test_a_tiny_reward_everywhere_gives_advantages_of_full_size_and_changes_no_return():
    rollout = random_rollout(0)._replace(rewards=torch.zeros_like(random_rollout(0).rewards))
    nothing = Score()(rollout)
    tiny = Score(reward_elsewhere=1e-5)(rollout)
    assert float(nothing.advantages.abs().max()) == 0.0
    assert float(tiny.advantages.abs().max()) > 0.5  # normalisation blows up what the baseline left
    assert float(episode_returns(tiny).abs().max()) == 0.0


def test_advantages_without_normalisation_keep_their_size():
    rollout = random_rollout(0)
    raw = Score(normalise=False)(rollout).advantages
    tenfold = rollout._replace(rewards=10 * rollout.rewards)
    larger = Score(normalise=False)(tenfold).advantages
    torch.testing.assert_close(larger, 10 * raw)
    assert not torch.allclose(Score()(rollout).advantages, raw)


# --- the running mean of the meta-gradients -----------------------------------------------------


def learner_with(momentum):
    theta = {"weight": torch.zeros(3)}
    return Trpo(theta, trpo.TrustRegion(), momentum)


def test_the_running_mean_weighs_the_gradients_geometrically():
    learner = learner_with(0.5)
    gradients = torch.randn(4, 3, generator=torch.Generator().manual_seed(0))
    for gradient in gradients:
        smooth = learner.smoothed(gradient)
    weights = torch.tensor([1 / 8, 1 / 8, 1 / 4, 1 / 2])
    torch.testing.assert_close(smooth, weights @ gradients)


def test_without_momentum_a_gradient_is_as_it_was_and_nothing_is_remembered():
    learner = learner_with(0.0)
    learner.smoothed(torch.ones(3))
    assert learner.smoothed(torch.full((3,), 2.0)).tolist() == [2.0, 2.0, 2.0]
    assert learner.state() == {}


@pytest.mark.parametrize("lost", [[0.0, 0.0, 0.0], [1.0, float("nan"), 1.0]])
def test_a_gradient_of_no_use_stays_out_of_the_mean(lost):
    learner = learner_with(0.5)
    learner.smoothed(torch.ones(3))
    torch.testing.assert_close(
        learner.smoothed(torch.tensor(lost)), torch.tensor(lost), equal_nan=True
    )
    assert learner.smoothed(torch.full((3,), 3.0)).tolist() == [2.0, 2.0, 2.0]


def test_a_loaded_learner_goes_on_where_the_saved_one_was():
    learner, other = learner_with(0.5), learner_with(0.5)
    learner.smoothed(torch.ones(3))
    other.load(learner.state())
    following = torch.tensor([1.0, 2.0, 3.0])
    assert torch.equal(learner.smoothed(following), other.smoothed(following))
