"""Policy, advantages, losses, adaptation and TRPO against independent answers."""

import dataclasses
import math

import jaxtyping
import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from torch.distributions import Independent, Normal
from torch.distributions.kl import kl_divergence as library_kl

from emrld_lite import advantage, losses, policy, rollout, trpo
from emrld_lite.adapt import Adaptation, adapt, warm_start
from emrld_lite.envs import make
from emrld_lite.learners import TaskData, policies_after
from emrld_lite.validation import InputError

from .conftest import random_demonstrations, random_params, random_rollout

EMRLD = Adaptation(w_rl=0.7, w_bc=1.0, adapt_lr=0.05)
EMRLD_WS = dataclasses.replace(EMRLD, warm_start=True)
MAML = Adaptation(w_rl=1.0, w_bc=0.0, adapt_lr=0.05)


def meta_gradient(params, data, rule):
    """Return the surrogate's gradient through the adaptation."""
    return trpo.surrogate_gradient(
        params, lambda theta: policies_after(theta, data, rule, keep_graph=True), data.after
    )


# --- policy -------------------------------------------------------------------------------------


def test_density_and_divergence_equal_the_library_s():
    params, other = random_params(0, tasks=3), random_params(1, tasks=3)
    batch = random_rollout(2)
    ours = policy.distribution(params, batch.states)
    theirs = policy.distribution(other, batch.states)
    library = [Independent(Normal(g.mean, g.log_sigma.exp()), 1) for g in (ours, theirs)]
    torch.testing.assert_close(
        policy.log_density(ours, batch.actions), library[0].log_prob(batch.actions)
    )
    torch.testing.assert_close(policy.kl_divergence(ours, theirs), library_kl(*library))


def test_mean_equals_a_plain_loop_over_tasks_and_layers():
    params, batch = random_params(0, tasks=3), random_rollout(2)
    mean = policy.distribution(params, batch.states).mean
    for task in range(3):
        for episode in range(4):
            hidden = batch.states[task, episode]
            for layer in range(3):
                hidden = hidden @ params[f"weight_{layer}"][task] + params[f"bias_{layer}"][task]
                hidden = hidden.clamp_min(0) if layer < 2 else hidden
            torch.testing.assert_close(mean[task, episode], hidden)


def test_shared_parameters_equal_their_per_task_copies():
    params, batch = random_params(0), random_rollout(2)
    shared = policy.distribution(params, batch.states)
    copies = policy.distribution(policy.per_task(params, 3), batch.states)
    for one, other in zip(shared, copies, strict=True):
        torch.testing.assert_close(one, other)


def test_vector_round_trip():
    params = random_params(0)
    back = policy.from_vector(policy.to_vector(params), params)
    assert all(torch.equal(back[name], params[name]) for name in params)


def test_fixed_sigma_is_one():
    params = policy.initialise(2, 2, seed=0, learn_sigma=False)
    assert (policy.distribution(params, torch.zeros(1, 3, 2)).log_sigma == 0).all()


# --- shapes -------------------------------------------------------------------------------------


@pytest.mark.parametrize("learn_sigma", [True, False])
def test_without_noise_a_policy_acts_by_its_mean(learn_sigma):
    params = policy.per_task(policy.initialise(3, 2, learn_sigma=learn_sigma, seed=1), 4)
    states = torch.randn(4, 5, 3)
    quiet = policy.distribution(policy.without_noise(params), states)
    assert torch.equal(quiet.mean, policy.mean(params, states))
    assert quiet.log_sigma.exp().max() < 1e-5
    assert "log_sigma" in params or not learn_sigma  # the policies given are left as they are


def test_a_wrong_shape_in_an_annotation_is_caught_while_tests_run():
    ragged = torch.ones(2, 3), torch.ones(2, 4)  # no episode axis, and times that disagree
    with pytest.raises(jaxtyping.TypeCheckError, match="task episode time"):
        losses.task_mean(*ragged)


# --- rollouts -----------------------------------------------------------------------------------


def test_rollout_equals_single_episodes_and_masks_what_follows_the_end():
    environment = make("point2d")
    tasks = environment.training_tasks()[:3]
    # a policy that walks straight to the first goal, (2, 0), nearly without noise
    params = policy.initialise(2, 2, seed=0)
    params = {name: torch.zeros_like(value) for name, value in params.items()}
    params["bias_2"] = torch.tensor([0.95, 0.0])
    params["log_sigma"] = torch.full((2,), -8.0)
    batch = rollout.collect(environment, tasks, params, 4, torch.Generator().manual_seed(0))
    assert batch.success[0].all() and not batch.success[1:].any()
    assert batch.mask[0].sum(-1).tolist() == [21.0] * 4
    by_hand = (1 - 0.195) + (1 - 0.1) + (100 - 20 - 1)  # two steps inside D_1, then D_2 at t = 20
    assert batch.rewards[0].sum(-1).tolist() == pytest.approx([by_hand] * 4, abs=0.01)
    assert (batch.states[0][:, 21:] == 0).all() and (batch.rewards[0][:, 21:] == 0).all()
    assert batch.mask[1:].all()


def test_the_episodes_that_end_first_are_kept_whole():
    batch = random_rollout(3, tasks=3, episodes=9, horizon=12)
    kept = rollout.first_to_end(batch, 4)
    for task in range(3):
        lengths = [int(mask.sum()) for mask in batch.mask[task]]
        chosen = sorted(range(9), key=lambda episode: (lengths[episode], episode))[:4]
        for place, episode in enumerate(chosen):
            assert torch.equal(kept.states[task, place], batch.states[task, episode])
            assert torch.equal(kept.rewards[task, place], batch.rewards[task, episode])
            assert kept.success[task, place] == batch.success[task, episode]
    assert rollout.first_to_end(batch, 9) is batch


@pytest.mark.parametrize("function", [rollout.pack, lambda r: rollout.pack(rollout.pack(r))])
def test_packing_keeps_every_loss(function):
    params, batch = random_params(0, tasks=3), random_rollout(2)
    packed = function(batch)
    assert packed.mask.shape[-1] == int(batch.mask.sum((1, 2)).max())
    torch.testing.assert_close(losses.rl_loss(params, packed), losses.rl_loss(params, batch))


def test_subsample_draws_only_steps_that_were_taken():
    batch = random_rollout(2)
    drawn = rollout.subsample(batch, 50, torch.Generator().manual_seed(0))
    assert drawn.states.shape == (3, 1, 50, 2) and drawn.mask.all()
    for task in range(3):
        taken = {tuple(s.tolist()) for s in batch.states[task][batch.mask[task] > 0]}
        assert {tuple(s.tolist()) for s in drawn.states[task, 0]} <= taken


# --- advantages ---------------------------------------------------------------------------------


@given(st.integers(0, 10_000), st.floats(0, 1), st.floats(0, 1))
@settings(max_examples=30, deadline=None)
def test_returns_and_gae_equal_a_plain_loop_over_ragged_episodes(seed, discount, gae_lambda):
    batch = random_rollout(seed)
    values = (
        torch.randn(3, 4, 6, generator=torch.Generator().manual_seed(seed)).double() * batch.mask
    )
    returns = advantage.discounted_returns(batch.rewards, discount)
    gae = advantage.generalised_advantage(batch.rewards, values, discount, gae_lambda)
    for task in range(3):
        for episode in range(4):
            length = int(batch.mask[task, episode].sum())
            reward = batch.rewards[task, episode, :length].tolist()
            value = [*values[task, episode, :length].tolist(), 0.0]
            for t in range(length):
                expected = sum(discount ** (k - t) * reward[k] for k in range(t, length))
                assert float(returns[task, episode, t]) == pytest.approx(expected, abs=1e-9)
                expected = sum(
                    (discount * gae_lambda) ** (k - t)
                    * (reward[k] + discount * value[k + 1] - value[k])
                    for k in range(t, length)
                )
                assert float(gae[task, episode, t]) == pytest.approx(expected, abs=1e-9)


def test_baseline_equals_ridge_regression_by_its_normal_equations():
    batch = random_rollout(5, tasks=2, episodes=20, horizon=10)
    features = advantage.baseline_features(batch)
    returns = advantage.discounted_returns(batch.rewards, 0.9)
    weights = advantage.fit_baseline(features, returns)
    for task in range(2):
        x = features[task].reshape(-1, 8).numpy()
        y = returns[task].reshape(-1).numpy()
        ridge = advantage.RIDGE * (x**2).sum() / 8
        direct = np.linalg.solve(x.T @ x + ridge * np.eye(8), x.T @ y)
        np.testing.assert_allclose(weights[task], direct, rtol=1e-6)


def test_baseline_features_use_the_time_of_the_episode():
    batch = random_rollout(5)
    features = advantage.baseline_features(batch)
    state = batch.states[0, 0, 3]
    expected = [*state.tolist(), *(state**2).tolist(), 0.03, 0.03**2, 0.03**3, 1.0]
    assert features[0, 0, 3].tolist() == pytest.approx(expected)


@pytest.mark.parametrize("case", ["collinear", "no rewards", "one step"])
def test_baseline_survives_degenerate_data(case):
    batch = random_rollout(5)
    if case == "collinear":
        batch = batch._replace(states=torch.ones_like(batch.states) * batch.mask[..., None])
    if case == "no rewards":
        batch = batch._replace(rewards=torch.zeros_like(batch.rewards))
    if case == "one step":
        batch = rollout.Rollout(
            *(None if v is None else v[:, :1, :1] for v in batch[:4]), batch.success
        )
    scored = advantage.Score()(batch)
    assert torch.isfinite(scored.advantages).all()
    if case == "no rewards":
        assert (scored.advantages == 0).all()


def test_normalised_advantages_have_mean_zero_and_deviation_one_over_the_steps_taken():
    batch = random_rollout(5)
    scored = advantage.Score()(batch).advantages
    for task in range(3):
        taken = scored[task][batch.mask[task] > 0]
        assert float(taken.mean()) == pytest.approx(0.0, abs=1e-6)
        assert float(taken.std(correction=0)) == pytest.approx(1.0, abs=1e-6)


# --- losses -------------------------------------------------------------------------------------


def test_cloning_loss_as_mean_and_as_sum():
    params, demos = random_params(0, tasks=3), random_demonstrations(1)
    mean, total = (losses.bc_loss(params, demos, how) for how in ("mean", "sum"))
    for task in range(3):
        length = int(demos.lengths()[task])
        one = {name: value[task : task + 1] for name, value in params.items()}
        gaussian = policy.distribution(one, demos.states[task : task + 1, 0, :length])
        by_hand = -sum(
            float(
                Normal(gaussian.mean[0, t], gaussian.log_sigma[0, t].exp())
                .log_prob(demos.actions[task, 0, t])
                .sum()
            )
            for t in range(length)
        )
        assert float(total[task]) == pytest.approx(by_hand)
        assert float(mean[task]) == pytest.approx(by_hand / length)


def test_ratio_is_one_and_divergence_zero_at_the_old_parameters():
    params, batch = random_params(0, tasks=3), random_rollout(2)
    old = policy.distribution(params, batch.states)
    assert float(policy.kl_divergence(old, old).abs().max()) == 0.0
    expected = -losses.task_mean(batch.advantages, batch.mask)
    torch.testing.assert_close(losses.surrogate_loss(old, old, batch), expected)


# --- adaptation ---------------------------------------------------------------------------------


@pytest.mark.parametrize("density", ["averaged", "joint"])
@pytest.mark.parametrize("rule", [EMRLD, EMRLD_WS, MAML], ids=["emrld", "emrld-ws", "maml"])
def test_all_tasks_at_once_equal_a_loop_over_tasks(rule, density):
    params, batch, demos = random_params(0), random_rollout(2), random_demonstrations(1)
    together = adapt(params, batch, demos, dataclasses.replace(rule, log_density=density))
    dimensions = batch.actions.shape[-1]  # over which an averaged log-density's gradient is shared
    rate = rule.adapt_lr / dimensions if density == "averaged" else rule.adapt_lr
    for task in range(3):
        part = slice(task, task + 1)
        leaves = {name: value.clone().requires_grad_() for name, value in params.items()}
        if rule.warm_start:
            loss = losses.bc_loss(leaves, demos.take(part))[0]
            gradient = torch.autograd.grad(loss, list(leaves.values()))
            leaves = {
                name: (value - rate * g).detach().requires_grad_()
                for (name, value), g in zip(leaves.items(), gradient, strict=True)
            }
        loss = rule.w_rl * losses.rl_loss(leaves, batch.take(part))[0]
        loss = loss + rule.w_bc * losses.bc_loss(leaves, demos.take(part))[0]
        gradient = torch.autograd.grad(loss, list(leaves.values()))
        for (name, value), g in zip(leaves.items(), gradient, strict=True):
            torch.testing.assert_close(together[name][task], value.detach() - rate * g)


def test_only_the_warm_started_row_changes_the_policy_that_collects():
    params, demos = random_params(0), random_demonstrations(1)
    assert warm_start(params, demos, EMRLD) is params
    assert warm_start(params, demos, EMRLD_WS)["weight_0"].shape[0] == 3


@pytest.mark.parametrize("rule", [EMRLD, EMRLD_WS, MAML], ids=["emrld", "emrld-ws", "maml"])
def test_meta_gradient_equals_finite_differences(rule):
    params = random_params(0)
    data = TaskData(random_rollout(2), random_rollout(3), random_demonstrations(1))
    piece = meta_gradient(params, data, rule)
    vector = policy.to_vector(params)
    random = torch.Generator().manual_seed(0)
    for _ in range(4):
        direction = torch.randn(vector.shape, generator=random, dtype=torch.float64)
        moved = (policy.from_vector(vector + sign * 1e-5 * direction, params) for sign in (1, -1))
        ends = [
            trpo.surrogate_and_kl(policies_after(theta, data, rule), piece.old, data.after)[0]
            for theta in moved
        ]
        slope = (ends[0] - ends[1]) / 2e-5
        assert float(piece.gradient @ direction) == pytest.approx(slope, rel=1e-5)


@pytest.mark.parametrize("rule", [EMRLD, EMRLD_WS, MAML], ids=["emrld", "emrld-ws", "maml"])
def test_first_order_gradient_is_the_tasks_own_at_their_adapted_policies(rule):
    params = random_params(0)
    data = TaskData(random_rollout(2), random_rollout(3), random_demonstrations(1))
    first = dataclasses.replace(rule, second_order=False)
    piece = meta_gradient(params, data, first)
    task_params = policy.detach(adapt(params, data.before, data.demonstrations, rule), True)
    loss = losses.rl_loss(task_params, data.after).sum()  # the surrogate's gradient at ratio one
    parts = torch.autograd.grad(loss, list(task_params.values()))
    expected = torch.cat([part.sum(0).flatten() for part in parts])
    torch.testing.assert_close(piece.gradient, expected)


def test_meta_gradient_has_second_order_terms():
    params = random_params(0)
    data = TaskData(random_rollout(2), random_rollout(3), random_demonstrations(1))
    leaves = policy.detach(params, requires_grad=True)
    adapted = adapt(params, data.before, data.demonstrations, EMRLD)
    first_order = {name: leaves[name] + (adapted[name] - params[name]) for name in leaves}
    new = policy.distribution(first_order, data.after.states)
    old = policy.Gaussian(*(part.detach() for part in new))
    loss = losses.surrogate_loss(new, old, data.after).sum()
    parts = torch.autograd.grad(loss, list(leaves.values()))
    cheap = torch.cat([part.reshape(-1) for part in parts])
    full = meta_gradient(params, data, EMRLD).gradient
    assert float((full - cheap).norm() / full.norm()) > 0.01


@pytest.mark.parametrize(
    ("field", "value"), [("w_rl", -1.0), ("w_bc", math.nan), ("adapt_lr", math.inf), ("w_rl", "1")]
)
def test_adaptation_refuses_bad_numbers(field, value, shapes_unchecked):
    with pytest.raises(InputError, match=field):
        dataclasses.replace(EMRLD, **{field: value})


def test_adaptation_needs_a_loss():
    with pytest.raises(InputError, match="w_rl and w_bc"):
        Adaptation(w_rl=0.0, w_bc=0.0)


# --- TRPO ---------------------------------------------------------------------------------------


def spd_matrix(seed, size, condition):
    """Return a symmetric positive definite matrix with the given condition number."""
    random = np.random.default_rng(seed)
    basis = np.linalg.qr(random.normal(size=(size, size)))[0]
    return torch.from_numpy(basis @ np.diag(np.geomspace(1.0, condition, size)) @ basis.T)


@given(st.integers(0, 10_000))
@settings(max_examples=20, deadline=None)
def test_conjugate_gradient_equals_a_direct_solve(seed):
    matrix = spd_matrix(seed, 30, 1e3)
    target = torch.from_numpy(np.random.default_rng(seed).normal(size=30))
    kept = target.clone()
    found = trpo.conjugate_gradient(lambda v: matrix @ v, target, 120, tolerance=1e-24)
    assert torch.equal(target, kept)
    direct = torch.linalg.solve(matrix, target)
    assert float((found - direct).norm() / direct.norm()) < 1e-8


def test_conjugate_directions_are_conjugate():
    """The released code aliases residual and direction; then this fails."""
    matrix = spd_matrix(0, 8, 50.0)
    asked = []

    def product(v):
        asked.append(v.clone())
        return matrix @ v

    trpo.conjugate_gradient(product, torch.ones(8, dtype=torch.float64), 8, tolerance=0.0)
    directions = torch.stack(asked)
    gram = directions @ matrix @ directions.T
    off = gram - torch.diag(gram.diagonal())
    assert float(off.abs().max() / gram.diagonal().max()) < 1e-6


def test_the_aliased_solver_takes_the_first_step_and_then_goes_astray():
    matrix, target = spd_matrix(0, size=12, condition=1e3), torch.ones(12, dtype=torch.float64)

    def both(iterations):
        return [
            trpo.conjugate_gradient(lambda v: matrix @ v, target, iterations, aliased=aliased)
            for aliased in (False, True)
        ]

    torch.testing.assert_close(*both(1))
    exact = torch.linalg.solve(matrix, target)
    right, astray = ((found - exact).norm() for found in both(40))
    assert right < 1e-3 * exact.norm() < astray
    assert torch.equal(target, torch.ones(12, dtype=torch.float64))


def test_conjugate_gradient_of_zero_is_zero():
    assert not trpo.conjugate_gradient(lambda v: v, torch.zeros(3), 5).any()


@pytest.mark.parametrize("rule", [EMRLD, EMRLD_WS], ids=["emrld", "emrld-ws"])
def test_fisher_product_equals_the_hessian_of_the_divergence(rule):
    params = random_params(0, hidden=(4, 3))
    before, after, demos = random_rollout(2), random_rollout(3), random_demonstrations(1)
    shapes = policy.to_vector(params)

    def outputs(vector):
        task_params = adapt(
            policy.from_vector(vector, params), before, demos, rule, keep_graph=True
        )
        return policy.distribution(task_params, after.states)

    weight = after.mask / after.mask.sum()
    old = policy.Gaussian(*(part.detach() for part in outputs(shapes.requires_grad_())))

    def mean_divergence(vector):
        return (policy.kl_divergence(old, outputs(vector)) * weight).sum()

    hessian = torch.autograd.functional.hessian(mean_divergence, shapes.detach())
    leaves = policy.detach(params, requires_grad=True)
    task_params = adapt(leaves, before, demos, rule, keep_graph=True)
    gaussian = policy.distribution(task_params, after.states)
    product = trpo.fisher_product(gaussian, weight, leaves, damping=0.01)
    for seed in range(3):
        v = torch.randn(len(shapes), generator=torch.Generator().manual_seed(seed)).double()
        torch.testing.assert_close(product(v), hessian @ v + 0.01 * v, rtol=1e-7, atol=1e-9)


def quadratic_policy_problem():
    """Return a one-parameter policy, mean = theta and sigma = 1, and its Fisher product at theta = 0."""
    params = {"theta": torch.zeros(1, dtype=torch.float64)}
    leaves = policy.detach(params, requires_grad=True)
    gaussian = policy.Gaussian(leaves["theta"].expand(1, 1), torch.zeros(1, 1, dtype=torch.float64))
    return params, trpo.fisher_product(gaussian, torch.ones(1, dtype=torch.float64), leaves)


def test_a_step_lands_on_the_trust_region_s_edge():
    params, product = quadratic_policy_problem()

    def surrogate_and_kl(p):
        theta = float(p["theta"])
        return -theta, 0.999 * theta**2 / 2

    region = trpo.TrustRegion(max_kl=0.02)
    moved, step = trpo.trpo_step(
        params, 0.0, torch.tensor([-1.0]).double(), product, surrogate_and_kl, region
    )
    assert float(moved["theta"]) == pytest.approx(0.2, rel=1e-6)  # theta^2 / 2 = 0.02
    assert step.kl == pytest.approx(0.999 * 0.02) and step.backtracks == 0 and step.note == ""


def test_line_search_halves_until_the_exact_surrogate_falls():
    params, product = quadratic_policy_problem()

    def surrogate_and_kl(p):  # falls only up to 0.06
        theta = float(p["theta"])
        return (theta - 0.03) ** 2 - 0.03**2, 0.999 * theta**2 / 2

    region = trpo.TrustRegion(max_kl=0.02)
    moved, step = trpo.trpo_step(
        params, 0.0, torch.tensor([-0.06]).double(), product, surrogate_and_kl, region
    )
    assert step.backtracks == 2 and float(moved["theta"]) == pytest.approx(0.05)


@pytest.mark.parametrize(
    ("gradient", "surrogate", "kl", "words"),
    [
        (0.0, -1.0, 0.0, "gradient is zero"),
        (math.nan, -1.0, 0.0, "gradient is not finite"),
        (-1.0, math.nan, 0.0, "no improvement"),
        (-1.0, -1.0, math.nan, "no improvement"),
        (-1.0, -1.0, 9.9, "no improvement"),
    ],
)
def test_a_step_that_cannot_be_trusted_leaves_the_policy_alone(gradient, surrogate, kl, words):
    params, product = quadratic_policy_problem()
    moved, step = trpo.trpo_step(
        params,
        0.0,
        torch.tensor([gradient]).double(),
        product,
        lambda p: (surrogate, kl),
        trpo.TrustRegion(max_kl=0.02),
    )
    assert moved is params and step.kl == 0.0 and words in step.note
