"""The lottery: what is drawn, what is kept, how it is summed up; one real draw as on another machine."""

import dataclasses
import hashlib
import json

import numpy as np
import pytest

from emrld_lite.config import TrainConfig
from emrld_lite.experiments import lottery
from emrld_lite.trpo import TrustRegion
from emrld_lite.validation import InputError

TINY = TrainConfig(
    iterations=2,
    episodes=2,
    stop_at_return=70.0,
    trust_region=TrustRegion(cg_iterations=2, fisher_samples=20),
)
DRAW = lottery.Draw(
    "point2d", "emrld-ws", "optimal", "", "abc", "own", 1, 0, 70.0, 100, 42, 71.5, 30.0
)


def drawn(**changes):
    return DRAW._replace(**changes)


def test_a_draw_is_a_training_as_on_another_processor(tmp_path):
    folder = tmp_path / "a folder's run"  # neither blank nor quote may part the command
    draw = lottery.play(TINY, "plain", 1, folder)
    facts = json.loads((folder / "provenance.json").read_text())
    assert facts["processor"].endswith("DEFAULT")  # torch's word for no vector kernels
    assert (draw.reached, draw.lot, draw.seed, draw.options) == (
        None,
        "plain",
        0,
        "--episodes 2 --cg-iterations 2 --fisher-samples 20",
    )


def test_a_training_that_fails_is_told_with_its_lot_and_seed(tmp_path):
    config = dataclasses.replace(TINY, demos="nowhere.npz", seed=3)
    with pytest.raises(InputError, match=r"lot own, seed 3: .*nowhere\.npz"):
        lottery.play(config, "own", 1, tmp_path / "run")


def test_what_the_table_holds_is_not_played_again(tmp_path, monkeypatch):
    played = []

    def remembering(config, lot, threads, folder):
        played.append((config.seed, lot, threads))
        return drawn(settings=lottery.settings_hash(config), lot=lot, seed=config.seed)

    monkeypatch.setattr(lottery, "play", remembering)
    table = tmp_path / "draws.csv"
    first = lottery.lottery(TINY, [0, 1], ["own"], [1], table, tmp_path / "runs")
    assert len(list(first)) == 2
    again = lottery.lottery(TINY, [0, 1, 2], ["own", "plain"], [1], table, tmp_path / "runs")
    assert len(list(again)) == 4
    assert len(played) == len(set(played)) == len(lottery.load_draws(table)) == 6


def test_a_draw_that_gave_up_goes_on_with_a_larger_budget(tmp_path, monkeypatch):
    played = []

    def remembering(config, lot, threads, folder):
        played.append((config.iterations, folder))
        return drawn(settings=lottery.settings_hash(config), reached=None, budget=config.iterations)

    monkeypatch.setattr(lottery, "play", remembering)
    table = tmp_path / "draws.csv"
    for budget in (2, 2, 9, 5):
        config = dataclasses.replace(TINY, iterations=budget)
        list(lottery.lottery(config, [0], ["own"], [1], table, tmp_path / "runs"))
    assert [iterations for iterations, _ in played] == [2, 9]
    assert len({folder for _, folder in played}) == 1  # so the run there is resumed
    assert [draw.budget for draw in lottery.load_draws(table)] == [9]


def test_an_unknown_lot_is_refused_before_anything_is_played(tmp_path):
    with pytest.raises(InputError, match="Did you mean 'plain'"):
        list(lottery.lottery(TINY, [0], ["own", "plane"], [1], tmp_path / "d.csv", tmp_path))
    assert not list(tmp_path.iterdir())


def test_the_table_is_read_as_it_was_written(tmp_path):
    draws = [drawn(seed=0), drawn(seed=1, reached=None), drawn(lot="plain", seed=10)]
    lottery.write_draws(tmp_path / "draws.csv", draws)
    assert lottery.load_draws(tmp_path / "draws.csv") == draws


def test_a_cell_that_is_no_number_is_refused_by_its_line(tmp_path):
    path = tmp_path / "draws.csv"
    lottery.write_draws(path, [DRAW])
    path.write_text(path.read_text().replace(",42,", ",many,"))
    with pytest.raises(InputError, match="line 2"):
        lottery.load_draws(path)


@pytest.mark.parametrize(
    ("reached", "median", "latest"),
    [([30, 50, 40], 40, 50), ([30, None, 40], 40, np.inf), ([None, None, 40], np.inf, np.inf)],
)
def test_a_draw_that_did_not_get_there_is_later_than_all_others(reached, median, latest):
    group = [drawn(seed=seed, reached=value) for seed, value in enumerate(reached)]
    assert lottery.median_and_latest(group) == (median, latest)


def test_the_summary_has_a_line_per_training_lot_and_threads():
    draws = [drawn(), drawn(seed=1, reached=None), drawn(lot="plain"), drawn(threads=2)]
    lines = lottery.summary(draws).splitlines()[2:]
    assert lines[0] == "| point2d optimal emrld-ws | own | 1 | 2 | 1 | 42 | none | 30 |"
    assert len(lines) == 3


def test_the_hash_tells_every_setting_but_seed_budget_and_target():
    same = dataclasses.replace(TINY, seed=5, iterations=9, stop_at_return=None)
    assert lottery.settings_hash(same) == lottery.settings_hash(TINY)
    other = dataclasses.replace(TINY, meta_momentum=0.0)
    assert lottery.settings_hash(other) != lottery.settings_hash(TINY)


def test_the_stored_lottery_was_played_with_the_present_defaults():
    """A default that changes makes the stored table untrue: play it again."""
    for draw in lottery.load_draws():
        if not draw.options:
            config = TrainConfig(env=draw.env, algorithm=draw.algorithm, demos=draw.demos)
            assert draw.settings == lottery.settings_hash(config)


def test_only_what_differs_from_the_default_counts_in_the_settings_hash():
    """So a draw stays valid when a switch is added that is left off."""
    nothing = hashlib.sha256(b"{}").hexdigest()[:8]
    assert lottery.settings_hash(TrainConfig(seed=3, iterations=7, stop_at_return=70.0)) == nothing
    assert lottery.settings_hash(TrainConfig(adapt_lr=0.02)) != nothing
