"""The sliders on the adaptation: what they draw over their whole range, and what they say of it."""

import itertools
import re
from dataclasses import replace

import matplotlib.pyplot as plt
import pytest
import torch

from emrld_lite.adapt import adapt, warm_start
from emrld_lite.advantage import Score
from emrld_lite.classroom.widgets import adaptation
from emrld_lite.classroom.widgets.adaptation import Adapter, Weights
from emrld_lite.config import TrainConfig
from emrld_lite.demonstrations import load_demonstrations
from emrld_lite.experiments.plotting import LOOKS
from emrld_lite.rollout import collect, episode_returns

CONFIG = TrainConfig(algorithm="emrld-ws", demos="optimal")
RULE = CONFIG.adaptation("optimal")
CORNERS = [
    Weights(*weights) for weights in itertools.product((0.0, 0.2, 2.0), (0.0, 2.0), (True, False))
]


@pytest.fixture(scope="module")
def adapter():
    """Return the adapter of a policy that walks: an untrained one would stay near the start."""
    demonstrations = load_demonstrations("optimal", "point2d")
    policy = CONFIG.initial_policy()
    policy["bias_2"] = torch.tensor([0.8, 0.5])  # towards task 2, 0.55 radians above the x axis
    policy["log_sigma"] -= 1.0
    return Adapter(CONFIG.environment(), policy, demonstrations, RULE)


def returns_in(title):
    """Return the returns that a panel's title states, before and after the step."""
    return [int(number) for number in re.search(r"return (-?\d+) .*?(-?\d+) after", title).groups()]


@pytest.mark.parametrize("weights", CORNERS, ids=str)
def test_a_panel_states_the_returns_of_the_adaptation_it_draws(adapter, weights):
    figure = adaptation.adaptation_picture(adapter, 2, [weights])
    one = adapter.demonstrations.take(slice(2, 3))
    random = torch.Generator().manual_seed(adapter.seed)
    rule = replace(RULE, warm_start=weights.warm)
    params = warm_start(adapter.meta_params, one, rule)
    before = Score()(collect(adapter.environment, one.tasks, params, 20, random))
    after = before
    if weights.w_rl or weights.w_bc:
        chosen = replace(rule, w_rl=weights.w_rl, w_bc=weights.w_bc)
        adapted = adapt(adapter.meta_params, before, one, chosen)
        after = collect(adapter.environment, one.tasks, adapted, 20, random)
    expected = [round(float(episode_returns(part).mean())) for part in (before, after)]
    assert returns_in(figure.axes[0].get_title()) == expected


def test_the_weights_alone_decide_the_picture_and_not_what_was_drawn_before(adapter):
    first = adapter.after(4, Weights(0.2, 1.0, True))
    adapter.after(4, Weights(2.0, 0.0, False))
    again = adapter.after(4, Weights(0.2, 1.0, True))
    assert torch.equal(first.states, again.states)


@pytest.mark.parametrize(
    ("weights", "algorithm"),
    [
        (Weights(0.2, 1.0, True), "emrld-ws"),
        (Weights(0.2, 1.0, False), "emrld"),
        (Weights(0.2, 0.0, False), "maml"),
    ],
)
def test_each_corner_has_the_colour_and_the_marker_of_its_algorithm(adapter, weights, algorithm):
    axes = adaptation.adaptation_picture(adapter, 0, [weights]).axes[0]
    ends = axes.lines[-1]
    assert ends.get_color() == LOOKS[algorithm]["color"]
    assert ends.get_marker() == LOOKS[algorithm]["marker"]


def test_the_sliders_draw_over_their_whole_range(adapter, monkeypatch):
    shown = []
    monkeypatch.setattr(adaptation, "display", shown.append)
    sliders = adaptation.adaptation_sliders(adapter, task=2)
    controls = {control.description: control for control in sliders.children[:-1]}
    moves = [
        {"task": task, "w_rl": w_rl, "w_bc": w_bc, "warm start": warm}
        for task in (0, 11)
        for w_rl in (0.0, 2.0)
        for w_bc in (0.0, 2.0)
        for warm in (True, False)
    ]
    for move in moves:
        for name, value in move.items():
            controls[name].value = value
        sliders.update()
        assert shown[-1].data.startswith(b"\x89PNG")
        word = "no warm start" if not move["warm start"] else ", warm start"
        assert word in shown[-1].alt and f"w_bc = {move['w_bc']:.1f}" in shown[-1].alt
    controls["w_rl"].value = 3.0  # beyond the end of the slider
    assert controls["w_rl"].value == adaptation.LARGEST_WEIGHT


def test_a_slider_leaves_nothing_of_the_picture_before(adapter, monkeypatch):
    shown, others = [], plt.get_fignums()
    monkeypatch.setattr(adaptation, "display", shown.append)
    sliders = adaptation.adaptation_sliders(adapter, task=2)
    sliders.update()
    first = shown[-1].data
    sliders.children[2].value = 0.0
    sliders.children[2].value = RULE.w_bc
    sliders.update()
    assert shown[-1].data == first
    assert plt.get_fignums() == others
