"""Finite MDPs, Theorem 1 and exact EMRLD, against plain loops, enumeration and formulas by hand."""

import itertools

import pytest
import torch
from hypothesis import given, settings, target
from hypothesis import strategies as st

from emrld_lite.adapt import Adaptation
from emrld_lite.tabular import (
    LEFT_RIGHT,
    Claims,
    ExactMetaRL,
    TabularMDP,
    exact_meta_train,
    gridworld,
    many_families,
    mixed,
    optimal_policy,
    proof_lines,
    random_family,
    related_bounds,
    slippery_pair,
    theorem_1,
)
from emrld_lite.tabular.search import hunt
from emrld_lite.tabular.theorem import as_dict
from emrld_lite.validation import InputError

VALID = ("bound", "bound_group_2", "bound_average_delta")


def one_family(seed, tasks=2, states=3, actions=2, discount=0.9):
    """Return a random family without a batch axis."""
    random = torch.Generator().manual_seed(seed)
    mdps, weights, *policies = random_family(random, 1, tasks, states, actions, [discount])
    single = [
        TabularMDP(mdp.transition[0], mdp.reward[0], mdp.initial[0], discount) for mdp in mdps
    ]
    return single, weights[:, 0], *([policy[0] for policy in chosen] for chosen in policies)


def in_steps(mdp, policy, steps=400):
    """Return value and visitation by following the chain for many steps, in plain loops."""
    states, actions, discount = mdp.states, mdp.actions, float(mdp.discount)
    value = [0.0] * states
    for _ in range(steps):
        value = [
            sum(
                float(policy[s, a])
                * (
                    float(mdp.reward[s, a])
                    + discount
                    * sum(float(mdp.transition[s, a, t]) * value[t] for t in range(states))
                )
                for a in range(actions)
            )
            for s in range(states)
        ]
    now, visits = mdp.initial.tolist(), [0.0] * states
    for step in range(steps):
        visits = [v + (1 - discount) * discount**step * p for v, p in zip(visits, now, strict=True)]
        now = [
            sum(
                now[s] * float(policy[s, a]) * float(mdp.transition[s, a, t])
                for s in range(states)
                for a in range(actions)
            )
            for t in range(states)
        ]
    return torch.tensor(value, dtype=torch.float64), torch.tensor(visits, dtype=torch.float64)


# --- the MDP --------------------------------------------------------------------------------------


def test_value_and_visitation_equal_those_of_following_the_chain():
    (mdp,), _, (policy,), *_ = one_family(0, tasks=1)
    value, visits = in_steps(mdp, policy)
    assert torch.allclose(mdp.value(policy), value, atol=1e-10)
    assert torch.allclose(mdp.visitation(policy), visits, atol=1e-10)
    assert float(mdp.objective(policy)) == pytest.approx(float(mdp.initial @ value))


def test_advantage_is_the_gain_of_one_other_action():
    (mdp,), _, (policy,), *_ = one_family(1, tasks=1)
    value, _ = in_steps(mdp, policy)
    for s, a in itertools.product(range(3), range(2)):
        other = mdp.reward[s, a] + 0.9 * mdp.transition[s, a] @ value - value[s]
        assert float(mdp.advantage(policy)[s, a]) == pytest.approx(float(other), abs=1e-9)


def test_two_states_by_hand():
    # from state 0 to state 1 for a reward of 2, then 1 for ever: V(1) = 1/(1-g), V(0) = 2 + g V(1)
    mdp = TabularMDP([[[0, 1]], [[0, 1]]], [[2], [1]], [1, 0], 0.5)
    policy = torch.ones(2, 1)
    assert mdp.value(policy).tolist() == pytest.approx([3.0, 2.0])
    assert mdp.visitation(policy).tolist() == pytest.approx([0.5, 0.5])


def test_a_batch_equals_its_members():
    random = torch.Generator().manual_seed(3)
    mdps, weights, old, new, demo = random_family(random, 5, 2, 4, 3)
    together = as_dict(theorem_1(mdps, weights, old, new, demo))
    for member in range(5):
        alone = theorem_1(
            [
                TabularMDP(
                    m.transition[member], m.reward[member], m.initial[member], m.discount[member]
                )
                for m in mdps
            ],
            weights[:, member],
            *([policy[member] for policy in chosen] for chosen in (old, new, demo)),
        )
        for name, value in as_dict(alone).items():
            assert torch.allclose(value, together[name][member], rtol=1e-9, atol=1e-12), name


def test_policy_iteration_beats_every_deterministic_policy():
    (mdp,), *_ = one_family(4, tasks=1, states=3, actions=3)
    best = mdp.value(optimal_policy(mdp))
    for choice in itertools.product(range(3), repeat=3):
        policy = torch.nn.functional.one_hot(torch.tensor(choice), 3).double()
        assert (mdp.value(policy) <= best + 1e-9).all()


# --- the theorem ----------------------------------------------------------------------------------


def by_loops(mdps, weights, old, new, demo):
    """Return the theorem's parts from plain loops over tasks, states and actions."""
    parts = dict.fromkeys(("surrogate", "tv_old", "tv_demo", "average_delta", "improvement"), 0.0)
    c1, delta = 0.0, float("inf")
    for i, mdp in enumerate(mdps):
        weight, (value, before), (after_value, after) = (
            float(weights[i]),
            in_steps(mdp, old[i]),
            in_steps(mdp, new[i]),
        )
        parts["improvement"] += weight * float(mdp.initial @ (after_value - value))
        for s in range(mdp.states):
            total, toward = 0.0, 0.0
            for a in range(mdp.actions):
                gain = float(mdp.reward[s, a] + 0.9 * mdp.transition[s, a] @ value - value[s])
                c1 = max(c1, abs(gain))
                total += float(new[i][s, a]) * gain
                toward += float(demo[i][s, a]) * gain
                half = 0.5 * weight
                parts["tv_old"] += half * float(before[s] * abs(new[i][s, a] - old[i][s, a]))
                parts["tv_demo"] += half * float(after[s] * abs(new[i][s, a] - demo[i][s, a]))
            delta = min(delta, toward)
            parts["surrogate"] += weight * float(before[s]) * total
            parts["average_delta"] += weight * float(after[s]) * toward
    group_1 = (parts["surrogate"] - 2 * c1 * parts["tv_old"]) / 0.1
    group_2 = (delta - 2 * c1 * parts["tv_demo"]) / 0.1
    return parts | {
        "c1": c1, "delta": delta, "group_1": group_1, "group_2": group_2, "bound": group_1 + group_2,
        "bound_group_2": group_2,
        "bound_average_delta": (parts["average_delta"] - 2 * c1 * parts["tv_demo"]) / 0.1,
    }  # fmt: skip


def test_every_part_equals_plain_loops():
    family = one_family(5)
    expected = by_loops(*family)
    got = as_dict(theorem_1(*family))
    assert set(got) == set(expected)
    for name, value in expected.items():
        assert float(got[name]) == pytest.approx(value, rel=1e-7, abs=1e-9), name


def excess(family, name):
    """Return bound - improvement, relative to the larger of the two and 1."""
    both = as_dict(theorem_1(*family)) | as_dict(related_bounds(*family))
    scale = torch.maximum(both[name].abs(), both["improvement"].abs()).clamp(min=1.0)
    return (both[name] - both["improvement"]) / scale


def test_no_violation_in_ten_thousand_families():
    seen = 0
    for family in many_families(seed=0, total=10_000):
        seen += len(family[2][0])
        for name in (*VALID, "trust_region", "repaired"):
            assert excess(family, name).max() <= 1e-9, name
        theorem = theorem_1(*family)
        scale = 1e-9 * (1 + theorem.bound.abs())
        assert (theorem.group_1 <= scale).all()
        assert (theorem.bound <= theorem.bound_group_2 + scale).all()
        assert (theorem.bound_group_2 <= theorem.bound_average_delta + scale).all()
    assert seen >= 10_000


@st.composite
def families(draw):
    """Draw a family from small whole numbers, so that a failure shrinks to something readable."""
    tasks, states, actions = (draw(st.integers(1, high)) for high in (2, 3, 3))
    discount = draw(st.sampled_from([0.0, 0.5, 0.9, 0.999]))

    def table(*shape, low=0):
        size = torch.Size(shape).numel()
        values = draw(st.lists(st.integers(low, 9), min_size=size, max_size=size))
        return torch.tensor(values, dtype=torch.float64).reshape(shape)

    def rows(*shape):
        weights = table(*shape)
        weights[..., 0] += (weights.sum(-1) == 0).double()
        return weights / weights.sum(-1, keepdim=True)

    mdps = [
        TabularMDP(
            rows(states, actions, states), table(states, actions, low=-9), rows(states), discount
        )
        for _ in range(tasks)
    ]
    policies = [[rows(states, actions) for _ in range(tasks)] for _ in range(3)]
    return mdps, rows(tasks), *policies


@settings(max_examples=150, deadline=None, derandomize=True)
@given(families())
def test_a_hunt_for_violations_finds_none(family):
    worst = max(float(excess(family, name)) for name in (*VALID, "trust_region", "repaired"))
    target(worst)
    assert worst <= 1e-9


@settings(max_examples=80, deadline=None, derandomize=True)
@given(families())
def test_every_line_of_the_proof_holds(family):
    assert [line.name for line in proof_lines(*family) if not line.holds()] == []


def test_climbing_breaks_the_substituted_bounds_and_no_valid_one():
    settings = {"families": 32, "steps": 150, "discount": 0.99}
    for name in ("bound_average_delta", "repaired"):
        assert hunt(name, **settings).violation.max() <= 1e-9, name
    for name in ("substituted", "substituted_group_2"):
        found = hunt(name, **settings)
        assert found.violation.max() > 0.1, name
        assert excess(found.family, name).max() > 0.1


def test_the_two_state_counterexample_by_hand():
    discount, slip, lead = 0.9, 0.1, 0.25
    family = slippery_pair(discount, slip, lead)
    theorem, related = theorem_1(*family), related_bounds(*family)
    swamp = discount * slip / (1 - discount + discount * slip)  # share of time spent there
    per_step = (1 - swamp) * (2 * lead + slip) - swamp
    assert float(theorem.improvement) == pytest.approx(per_step / (1 - discount))
    assert float(theorem.delta) == pytest.approx(2 * lead)
    assert float(theorem.c1) == pytest.approx(1.0)
    assert float(related.tv_demo_states) == pytest.approx(slip)
    promised = 2 * lead - 3 * slip
    assert float(related.substituted) == pytest.approx(promised / (1 - discount))
    assert (
        promised > 0 > per_step
    )  # Assumption 1 holds, the bound promises a gain, the policy loses
    assert theorem.bound <= theorem.improvement


def test_the_bound_is_tight_on_the_way_to_the_demonstrator():
    mdp = TabularMDP(torch.ones(1, 2, 1), [[1, -1]], [1], 0.9)
    coin = torch.tensor([[0.5, 0.5]], dtype=torch.float64)
    demo = torch.tensor([[0.8, 0.2]], dtype=torch.float64)
    for share in (0.0, 0.3, 1.0):
        new = (1 - share) * coin + share * demo
        theorem = theorem_1([mdp], [1], [coin], [new], [demo])
        assert float(theorem.improvement) == pytest.approx(6 * share)  # 2 * 0.3 * share / (1 - 0.9)
        assert float(theorem.bound) == pytest.approx(6 * share, abs=1e-12)


def test_each_bound_wins_somewhere():
    newer = [0, 0]
    for family in many_families(seed=1, total=1000):
        theorem, related = theorem_1(*family), related_bounds(*family)
        newer[0] += int((related.trust_region > theorem.bound_average_delta).sum())
        newer[1] += int((related.trust_region < theorem.bound).sum())
    assert min(newer) > 100


def test_an_absorbing_state_forces_delta_down():
    mdps = gridworld(1, 5, [(0, 4)], (0, 2), 0.9, "absorb", LEFT_RIGHT)
    uniform = torch.full((5, 2), 0.5, dtype=torch.float64)
    demo = optimal_policy(mdps[0])
    theorem = theorem_1(mdps, [1], [uniform], [mixed(demo, 0.5)], [demo])
    assert theorem.delta <= 1e-12 < theorem.average_delta


# --- the proof ------------------------------------------------------------------------------------

FALSE_CLAIMS = {
    "lemma_1": Claims(value_error=torch.tensor([0.3, -0.2, 0.1], dtype=torch.float64)),
    "a_assumption": Claims(delta=10.0),
    "b_demo": Claims(c1=0.01),
}


@pytest.mark.parametrize("first", FALSE_CLAIMS)
def test_a_false_claim_fells_its_line_first(first):
    family = one_family(6)
    lines = proof_lines(*family, FALSE_CLAIMS[first])
    assert next(line.name for line in lines if not line.holds()) == first


def test_the_demonstrators_states_fell_the_step_b():
    lines = proof_lines(*slippery_pair(), Claims(demonstrator_states=True))
    assert [line.name for line in lines if not line.holds()] == ["b_demo", "b", "theorem"]


def test_a_relation_is_read_the_right_way():
    line = proof_lines(*one_family(7))[0]
    one, two = torch.tensor(1.0), torch.tensor(2.0)
    for relation, fits in (("=", False), (">=", False), ("<=", True)):
        assert line._replace(left=one, right=two, relation=relation).holds() == fits


# --- exact EMRLD ----------------------------------------------------------------------------------


def corridor(**settings):
    mdps = gridworld(1, 5, [(0, 0), (0, 4)], (0, 2), 0.9, "restart", LEFT_RIGHT)
    demo = [mixed(optimal_policy(mdp), 0.1) for mdp in mdps]
    chosen = {"w_rl": 1.0, "w_bc": 1.0, "adapt_lr": 2.0} | settings
    inner_loss = chosen.pop("inner_loss", "exact")
    return ExactMetaRL(mdps, [0.3, 0.7], demo, Adaptation(**chosen), inner_loss)


def slopes(function, theta, step=1e-5):
    """Return the central finite differences of a scalar function of a table."""
    result = torch.zeros_like(theta)
    for index in itertools.product(*map(range, theta.shape)):
        nudge = torch.zeros_like(theta)
        nudge[index] = step
        result[index] = (function(theta + nudge) - function(theta - nudge)) / (2 * step)
    return result


def a_table(seed=0):
    return torch.randn(5, 2, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)


@pytest.mark.parametrize("warm", [False, True])
def test_adaptation_is_one_step_of_finite_differences(warm):
    problem, theta = corridor(warm_start=warm), a_table()
    adapted = problem.adapt(theta)
    for task, mdp in enumerate(problem.mdps):
        demo = problem.demo[task]
        visits = in_steps(mdp, demo)[1][:, None] * demo

        def cloning(table, visits=visits):
            return -(visits * table.log_softmax(-1)).sum()

        def both(table, mdp=mdp, cloning=cloning):
            return cloning(table) - mdp.objective(table.softmax(-1))

        start = theta - 2.0 * slopes(cloning, theta) if warm else theta
        assert torch.allclose(adapted[task], start - 2.0 * slopes(both, start), atol=1e-6)


@pytest.mark.parametrize("w_bc", [0.0, 1.0])
def test_exact_meta_gradient_equals_finite_differences(w_bc):
    problem, theta = corridor(w_bc=w_bc), a_table(1)
    expected = slopes(problem.meta_objective, theta)
    assert torch.allclose(problem.meta_gradient(theta), expected, atol=1e-7)


@pytest.mark.parametrize("inner_loss", ["log", "ratio"])
def test_the_surrogates_share_the_first_derivative(inner_loss):
    theta = a_table(2)
    exact, surrogate = corridor().adapt(theta), corridor(inner_loss=inner_loss).adapt(theta)
    assert torch.allclose(exact, surrogate, atol=1e-12)


def test_the_log_surrogate_has_no_second_derivative_on_softmax_tables():
    # grad^2 log pi(a|s) does not depend on a, and the advantages average to zero
    theta = a_table(3)
    problem = corridor(w_bc=0.0, inner_loss="log")
    assert torch.allclose(
        problem.meta_gradient(theta), problem.first_order_gradient(theta), atol=1e-12
    )
    exact = corridor(w_bc=0.0).meta_gradient(theta)
    assert (exact - problem.meta_gradient(theta)).norm() > 0.01 * exact.norm()


def test_the_log_surrogate_is_the_expectation_of_sampled_hessians():
    theta, mdp = a_table(4), corridor().mdps[0]
    policy = theta.softmax(-1)
    visits, advantage = mdp.visitation(policy), mdp.advantage(policy)
    expected = torch.zeros(10, 10, dtype=torch.float64)
    for s, a in itertools.product(range(5), range(2)):  # every sample, with its probability
        hessian = torch.autograd.functional.hessian(
            lambda table, s=s, a=a: -table.reshape(5, 2).log_softmax(-1)[s, a] * advantage[s, a],
            theta.flatten(),
        )
        expected += visits[s] * policy[s, a] * hessian / 0.1
    problem = corridor(inner_loss="log")
    got = torch.autograd.functional.hessian(
        lambda flat: problem.rl_loss(flat.reshape(1, 5, 2).expand(2, 5, 2))[0], theta.flatten()
    )
    assert torch.allclose(got, expected, atol=1e-10)


def test_exact_training_improves_and_obeys_the_theorem():
    iterates = list(exact_meta_train(corridor(adapt_lr=1.0), meta_lr=0.5, iterations=20))
    objectives = [iterate.objective for iterate in iterates]
    assert objectives == sorted(objectives)
    assert objectives[-1] > 1.1 * objectives[0]
    for now, then in itertools.pairwise(iterates):
        assert float(now.theorem.improvement) == pytest.approx(then.objective - now.objective)
        assert now.theorem.bound <= now.theorem.improvement


# --- bad input ------------------------------------------------------------------------------------

GOOD = {
    "transition": torch.full((2, 2, 2), 0.5), "reward": torch.zeros(2, 2),
    "initial": torch.tensor([1.0, 0.0]), "discount": 0.9,
}  # fmt: skip
BAD_MDPS = {
    "transition": [torch.full((2, 2, 3), 0.5), torch.full((2, 2, 2), 0.4), "abc", torch.ones(2)],
    "reward": [torch.zeros(2, 3), torch.full((2, 2), float("nan")), None],
    "initial": [torch.tensor([1.5, -0.5]), torch.ones(3)],
    "discount": [1.0, -0.1, float("inf"), torch.full((3,), 0.9)],
}


@pytest.mark.parametrize(
    ("field", "value"), [(field, value) for field, values in BAD_MDPS.items() for value in values]
)
def test_a_bad_mdp_is_refused_by_field(field, value):
    with pytest.raises(InputError, match=f"^{field}: "):
        TabularMDP(**{**GOOD, field: value})


@pytest.mark.parametrize(
    "policy", [torch.ones(2, 2), torch.full((3, 2), 0.5), [[0.5, 0.5], [1.5, -0.5]]]
)
def test_a_bad_policy_is_refused(policy):
    with pytest.raises(InputError, match=r"^policy: "):
        TabularMDP(**GOOD).value(policy)


def spoiled(argument, value):
    family = dict(zip(("mdps", "task_weights", "old", "new", "demo"), one_family(8), strict=True))
    return family | {argument: value}


def test_single_precision_is_made_exact():
    (mdp,), *_ = one_family(8, tasks=1)
    rough = torch.tensor([[0.1, 0.9], [0.7, 0.3], [1 / 3, 2 / 3]])  # float32
    advantage = mdp.advantage(rough)
    exact = rough.double() / rough.double().sum(-1, keepdim=True)
    assert (exact * advantage).sum(-1).abs().max() < 1e-14


@pytest.mark.parametrize("function", [theorem_1, related_bounds, proof_lines])
@pytest.mark.parametrize(
    ("argument", "value", "named"),
    [
        ("mdps", [], "mdps"),
        ("mdps", [TabularMDP(**GOOD)] * 2, "old[0]"),
        ("mdps", [one_family(8)[0][0], TabularMDP(**GOOD)], "mdps[1].transition"),
        ("mdps", [one_family(8)[0][0], one_family(8, discount=0.5)[0][0]], "mdps[1].discount"),
        ("task_weights", [1.0], "task_weights"),
        ("task_weights", [0.5, 0.6], "task_weights"),
        ("old", one_family(8)[2][:1], "old"),
        ("new", [torch.ones(3, 2), torch.ones(3, 2)], "new[0]"),
        ("demo", [one_family(8)[4][0], torch.ones(4, 2)], "demo[1]"),
    ],
)
def test_a_bad_family_is_refused_by_argument(function, argument, value, named):
    with pytest.raises(InputError) as refusal:
        function(**spoiled(argument, value))
    assert str(refusal.value).startswith(f"{named}: ")


def test_other_bad_input_is_refused():
    for call, named in (
        (lambda: gridworld(2, 2, [(0, 2)], (0, 0)), "goals[0]"),
        (lambda: gridworld(2, 2, [(0, 1)], (5, 0)), "start"),
        (lambda: gridworld(2, 2, [(0, 1)], (0, 0), at_goal="stop"), "unknown at_goal"),
        (lambda: slippery_pair(slip=0.4, lead=0.4), "lead"),
        (lambda: hunt("bond"), "unknown bound"),
        (lambda: corridor().meta_gradient(torch.zeros(2, 2)), "theta"),
        (lambda: corridor(inner_loss="second"), "unknown inner_loss"),
        (lambda: corridor(second_order=False), "adaptation.second_order"),
        (lambda: corridor(bc_reduction="sum"), "adaptation.bc_reduction"),
        (lambda: ExactMetaRL(corridor().mdps, [0.5, 0.5], [torch.ones(5, 2)] * 2, None), "demo[0]"),
        (lambda: list(exact_meta_train(corridor(), -1.0, 3)), "meta_lr"),
        (lambda: list(exact_meta_train(corridor(), 1.0, 0)), "iterations"),
        (lambda: proof_lines(*one_family(9), Claims(value_error=torch.ones(7))), "value_error"),
    ):
        with pytest.raises(InputError) as refusal:
            call()
        assert str(refusal.value).startswith(named), named
