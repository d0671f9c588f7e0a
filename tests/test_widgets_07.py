"""What notebooks 07 and 08 show on the page: sliders on seeds and drift, deals, curves and plans."""

import math
import re

import matplotlib.pyplot as plt
import numpy as np
import pytest

from emrld_lite.classroom import by_weight, few_seeds, made_up_curves, own_experiment, plans
from emrld_lite.classroom.sketches import deals, one_change
from emrld_lite.classroom.widgets import drift, seeds
from emrld_lite.experiments.intervals import AHEAD, BEHIND, EVEN, shift_interval, verdict
from emrld_lite.experiments.plotting import LOOKS
from emrld_lite.experiments.results import training_scores
from emrld_lite.experiments.runs import SHIPPED
from emrld_lite.experiments.studies import SENSITIVITY_END, sensitivity_runs
from emrld_lite.rollout import episode_returns
from emrld_lite.validation import InputError


@pytest.mark.parametrize("number", [3, 4, 7, 20])
@pytest.mark.parametrize("gap", [0.0, 2.0, 10.0])
@pytest.mark.parametrize("spread", [0.5, 8.0])
def test_the_shares_are_those_of_the_rank_interval(gap, spread, number):
    shares = seeds.verdict_shares(gap, spread, number)
    assert sum(shares.values()) == pytest.approx(1.0)
    draws = [seeds.drawn_experiment(gap, spread, number, draw)[1] for draw in range(300)]
    for word in (AHEAD, EVEN, BEHIND):
        counted = np.mean([verdict(interval) == word for interval in draws])
        assert counted == pytest.approx(shares[word], abs=0.09)


def test_without_a_gap_either_verdict_is_rare_and_with_one_more_seeds_see_it():
    for number in range(3, 21):
        none = seeds.verdict_shares(0.0, 3.0, number)
        assert max(none[AHEAD], none[BEHIND]) < 0.065
    few, many = (seeds.verdict_shares(3.0, 3.0, number)[AHEAD] for number in (3, 20))
    assert few < 0.35 and many > 0.85


def test_the_picture_says_what_it_shows_over_the_whole_range():
    for gap in (0.0, 3.0, 10.0):
        for spread in seeds.SPREADS:
            for number in seeds.SEEDS:
                bars, one = seeds.seeds_picture(gap, spread, number, draw=7).axes
                share = seeds.verdict_shares(gap, spread, number)[AHEAD]
                assert bars.get_title().endswith(f"ahead in {100 * share:.0f} %")
                interval = shift_interval(*seeds.drawn_experiment(gap, spread, number, 7)[0])
                assert one.get_title() == f"one experiment: {verdict(interval)}"
                low, high = one.get_xlim()
                assert low < interval.low < interval.high < high
                plt.close("all")


@pytest.mark.parametrize("wrong", [(-1, 3, 3), (11, 3, 3), (3, 0.1, 3), (3, 3, 2), (3, 3, 21)])
def test_what_no_slider_on_seeds_gives_is_refused(wrong):
    with pytest.raises(InputError, match=r"gap|spread|seeds"):
        seeds.seeds_picture(*wrong)


def test_the_sliders_on_seeds_draw(monkeypatch):
    shown = []
    monkeypatch.setattr(seeds, "display", shown.append)
    seeds.seeds_sliders()
    assert shown and "gap 3.0" in shown[-1].alt


def test_every_deal_is_drawn_once_and_the_framed_one_loses_no_pair():
    figure = deals.rank_deals()
    (axes,) = figure.axes
    written = [int(text.get_text()) for text in axes.texts]
    assert len(written) == math.comb(6, 3) and written == sorted(written)
    assert [written.count(lost) for lost in range(10)] == [1, 1, 2, 3, 3, 3, 3, 2, 1, 1]
    (frame,) = axes.patches
    assert frame.get_x() == pytest.approx(-0.42)


@pytest.fixture(scope="module")
def driven():
    """Return the stored policies' episodes on every drift, by whether they see their heading."""
    return {seen: drift.drive(SHIPPED, seen) for seen in (True, False)}


@pytest.mark.parametrize("seen", [True, False])
@pytest.mark.parametrize("value", [-0.8, -0.3, 0.0, 0.5, 0.8])
def test_a_panel_states_the_returns_of_the_episodes_it_draws(driven, value, seen):
    driven = driven[seen]
    figure = drift.drift_picture(driven, value)
    task = round((value + 0.8) / 0.1)
    assert figure._suptitle.get_text() == f"drift {value:+.1f} rad/s"
    for axes, (name, episodes) in zip(figure.axes, driven.items(), strict=True):
        returns = [float(episode_returns(part)[task].mean()) for part in episodes]
        said = [float(number) for number in re.findall(r"-?\d+(?=,|$)", axes.get_title())]
        assert said == [round(value) for value in returns]
        first = episodes.after.states[task, 0, 0, :2].numpy()
        colour = plt.matplotlib.colors.to_rgba(LOOKS[name]["color"])
        path = next(one for one in axes.collections if tuple(one.get_edgecolor()[0]) == colour)
        assert np.allclose(path.get_segments()[0][0], first)
        assert axes.lines[-1].get_marker() == LOOKS[name]["marker"]


def test_the_drift_has_a_slider_and_its_ends_are_the_environment_s(driven, monkeypatch):
    shown = []
    monkeypatch.setattr(drift, "display", shown.append)
    drift.drift_sliders(driven)
    assert shown[-1].data.startswith(b"\x89PNG")
    assert [float(end) for end in drift.drifts()[[0, -1], 0]] == pytest.approx([-0.8, 0.8])
    for wrong in (-0.9, 0.81, math.nan):
        with pytest.raises(InputError, match="drift"):
            drift.drift_picture(driven[True], wrong)


def test_only_the_policies_that_see_it_are_given_the_heading(driven):
    for seen, state_dim in ((True, 3), (False, 2)):
        for episodes in driven[seen].values():
            assert episodes.after.states.shape[-1] == state_dim


def test_no_runs_with_the_seed_are_told(tmp_path):
    with pytest.raises(InputError, match="expected runs of two_wheeled_drift"):
        drift.drive(tmp_path)
    with pytest.raises(InputError, match="expected runs of two_wheeled_drift-headless with seed 3"):
        drift.drive(tmp_path, heading=False, seed=3)


def test_the_four_curves_are_the_four_cases_and_none_is_a_close_call():
    panels = made_up_curves.trainings()
    assert len({training.truth for training in panels.values()}) == 4
    for training in panels.values():
        assert not 0.02 < training.rise < 0.12
        assert not 0.1 < training.kl.max() < 10
    figure = made_up_curves.curves_to_read()
    assert [axes.get_title()[-1] for axes in figure.axes[:4]] == list(panels)


def test_what_stands_for_a_reader_s_own_is_right(capsys):
    from emrld_lite.classroom import checks  # noqa: PLC0415

    for name in ("rank_interval", "false_ahead_rate", "seeds_needed", "hidden_by_mean"):
        assert getattr(checks, name)(getattr(few_seeds, name)), capsys.readouterr().out
    assert checks.which_sentence(plans.which_sentence), capsys.readouterr().out
    assert checks.own_experiment(lambda: own_experiment.EXAMPLE), capsys.readouterr().out


def test_every_question_has_one_answer_or_none():
    found = {number: plans.answers(question) for number, question in plans.QUESTIONS.items()}
    assert [len(pairs) for pairs in found.values()] == [1, 1, 1, 0, 1]
    assert all(name in plans.table() for name in plans.TRAININGS)


def test_the_four_cases_are_the_four_sentences():
    worth, said = 5.0, []
    for number, ends in plans.CASES.items():
        rule, sides = plans.case_rule(number), (np.zeros(5), np.ones(5))
        assert tuple(rule(*sides)[1:]) == ends
        assert tuple(rule(*sides[::-1])[1:]) == (-ends[1], -ends[0])
        said.append(plans.which_sentence(rule, *sides, worth))
        assert plans.four_cases(worth).axes[0].get_yticklabels()[number - 1].get_text()[-1] == str(
            number
        )
    assert len(set(said)) == 4


def test_the_sketch_hatches_what_changed():
    boxes = one_change.one_change().axes[0].patches
    count = len(one_change.SETTINGS)
    rows = [boxes[row * count : (row + 1) * count] for row in range(len(one_change.ROWS))]
    hatched = [tuple(i for i, box in enumerate(row) if box.get_hatch()) for row in rows]
    assert hatched == [changed for _, changed, _ in one_change.ROWS]


def test_a_live_experiment_trains_both_sides_from_the_same_seeds():
    curves = list(own_experiment.live_curves({"episodes": 2}, (3, 4), iterations=2))
    assert [side for side, _ in curves] == ["control", "switched"] * 2
    assert all(len(curve) == 2 for _, curve in curves)
    sides = {
        side: np.array([curve for name, curve in curves if name == side])
        for side in ("control", "switched")
    }
    axes = own_experiment.draw_own_curves(sides).axes[0]
    assert len(axes.lines) == 6 and [text.get_text() for text in axes.get_legend().texts] == [
        "control",
        "switched",
    ]


def test_a_weight_is_drawn_with_every_seed_s_return_and_speed():
    figure = by_weight.return_and_speed(SHIPPED)
    late, speed = figure.axes[:2]
    panel = sensitivity_runs(SHIPPED, "emrld", "w_bc")
    means = [line for line in late.lines if line.get_label().endswith("varied")]
    assert list(means[1].get_ydata()) == pytest.approx(
        [training_scores(seeds, SENSITIVITY_END["emrld"]).mean() for seeds in panel.values()]
    )
    points = [line for line in speed.lines if not line.get_label().endswith("varied")]
    seeds_drawn = sum(len(line.get_ydata()) for line in points)
    both = [sensitivity_runs(SHIPPED, "emrld", varied) for varied in ("w_rl", "w_bc")]
    assert seeds_drawn == sum(len(seeds) for one in both for seeds in one.values())
