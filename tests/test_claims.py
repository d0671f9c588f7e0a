"""Every number that the prose says of the stored runs is computed from them again.

Covered are the README's findings, the ledger's rows named in CLAIMS, and in notebooks 07 to 09 each
paragraph that begins with "**Measured.**" and the table of the paper's claims. A number that is added,
taken away or changed fails here until its computation says the same.
"""

import re
import tomllib
from pathlib import Path
from typing import NamedTuple

import jupytext
import numpy as np
import pytest
import torch

from emrld_lite.algorithms import ALGORITHMS
from emrld_lite.demonstrations import load, load_demonstrations
from emrld_lite.demonstrators.recipes import unseen_demonstrations
from emrld_lite.envs import make
from emrld_lite.envs.two_wheeled_drift import ROBOT_DRIFT, ROBOT_TRIALS
from emrld_lite.experiments.evaluation import (
    BY_MEAN,
    CUT,
    SAMPLED,
    UNSEEN_TASKS,
    cloning_before_and_after_warm_start,
)
from emrld_lite.experiments.intervals import interquartile_mean, shift_interval
from emrld_lite.experiments.lottery import TARGET, load_draws, median_and_latest
from emrld_lite.experiments.results import (
    BACKWARD,
    BOTH_WAYS,
    EARNED,
    FLAT,
    FORWARD,
    PLACES,
    STEPS_SHOWN,
    TITLES,
    best_and_last,
    iterations_to,
    largest_fall,
    late_rise,
    run_scores,
    seeds_of,
    stored_seeds,
    task_scores,
    training_scores,
    updates_without_step,
)
from emrld_lite.experiments.robot_figures import sweep_of
from emrld_lite.experiments.robot_study import AFTER, BEFORE, TRIAL, controller_name, load_study
from emrld_lite.experiments.runs import SHIPPED, load_config, load_curve, load_run
from emrld_lite.experiments.studies import (
    ABLATION_END,
    CLONING_ALONE,
    CONTROL,
    DOUBLE_USE,
    NARROW_DRIFT,
    READINGS,
    SENSITIVITY_END,
    SHORTER_STEP,
    WEIGHTS,
    WITHOUT_RL,
    WITHOUT_RL_AGAIN,
    ablation_runs,
    sensitivity_runs,
    switch_runs,
)
from emrld_lite.policy import detach, distribution
from emrld_lite.trpo import TrustRegion

ROOT = Path(__file__).resolve().parent.parent
NUMBER = re.compile(r"(?<![-\w.,/])([+-]?\d+(?:\.\d+)?)( ?%)?(?![\w/])")
REFERENCES = r"(?:Figs?\.|Figures?|Section|Table|notebooks?) \d+(?:(?:,| to| and) \d+)*"
NOT_A_RESULT = re.compile(rf"`[^`]*`|\$[^$]*\$|\[[^]]*\]\([^)]*\)|{REFERENCES}")


def numbers(text):
    """Return the numbers of a text, each with half a unit of its last digit."""
    found = []
    for number, percent in NUMBER.findall(NOT_A_RESULT.sub(" ", text.replace("−", "-"))):
        unit = 0.01 if percent else 1.0
        decimals = len(number.partition(".")[2])
        found.append((unit * float(number), unit * 0.5 * 10.0**-decimals))
    return found


def measured_paragraphs(number):
    """Return the paragraphs "**Measured.** ..." of a notebook by the tag of the code cell before them."""
    (source,) = (ROOT / "notebooks").glob(f"{number}_*.py")
    found, tag = {}, None
    for cell in jupytext.read(source).cells:
        if cell.cell_type == "code":
            tag = next((t for t in cell.metadata.get("tags", []) if not t.startswith("nbval")), tag)
            continue
        for paragraph in cell.source.split("\n\n"):
            if paragraph.startswith("**Measured.**"):
                before = found.get(f"{number}#{tag}")
                found[f"{number}#{tag}"] = f"{before}\n\n{paragraph}" if before else paragraph
    return found


def findings():
    """Return the README's findings by their bold beginnings."""
    readme = (ROOT / "README.md").read_text().partition("## What holds and what does not")[2]
    bullets = re.findall(r"^- \*\*(.+?)\*\*(.*?)(?=^- |^$)", readme, re.MULTILINE | re.DOTALL)
    return {f"README#{lead.rstrip('.')}": lead + text for lead, text in bullets}


def ledger():
    """Return what the ledger's rows measured, by their ids."""
    rows = tomllib.loads((ROOT / "data/paper_ledger.toml").read_text())["row"]
    return {f"ledger#{row['id']}": row["measured"] for row in rows}


PLENTIFUL = ("point2d", "two_wheeled")
NOT_STORED = (
    "README#Later adaptation steps need a smaller rate"  # evaluate --later-rate 1 prints it
)
COSTLY = (
    "first-order meta-gradient",
    "released start of the network",
    "advantages not normalised",
    "cloning loss summed",
    "sigma fixed at 1",
)
OURS, BASELINES = ("emrld", "emrld-ws"), ("maml", "meta-bc", "gmps")
STARVED = "starved-two_wheeled-suboptimal-emrld"
LEAST, MOST = WEIGHTS[0], WEIGHTS[-1]
HALFWAY = 35  # of a return of about 70, by which the panels of Fig. 7 are compared
WORTH = 5.0  # points on Point2D: a loss that matters in notebook 08
WINDOW = 10  # iterations over which a late return is a mean
SEARCH_END = 20  # the same, for the baselines' search


def scores(env, quality, name, step=None, goal=None, table=SAMPLED):
    """Return the score of each seed on test tasks, by default after the steps the paper shows."""
    seeds = stored_seeds(SHIPPED, env, quality)[name]
    return run_scores(seeds, STEPS_SHOWN[quality] if step is None else step, goal, table)


def at(place, quality, name, step=1):
    """Return the score of each seed in an environment or a direction of HalfCheetah."""
    return scores(place.env, quality, name, step, place.goal)


def means(quality, *names, step=1, places=PLACES):
    """Return each algorithm's mean score after ``step`` steps, place by place."""
    return [at(place, quality, name, step).mean() for place in places for name in names]


def best(quality, place, step=1):
    """Return the best baseline's mean score."""
    return max(at(place, quality, name, step).mean() for name in BASELINES)


def by_mean(quality, *names):
    """Return each algorithm's mean score by the mean action, Point2D and TwoWheeled in turn."""
    return [
        run_scores(stored_seeds(SHIPPED, place.env, quality)[name], 1, table=BY_MEAN).mean()
        for name in names
        for place in GOALS
    ]


def by_mean_on(place, quality, name):
    """Return an algorithm's mean score by the mean action in an environment, or in one direction."""
    seeds = stored_seeds(SHIPPED, place.env, quality)[name]
    return run_scores(seeds, 1, place.goal, BY_MEAN).mean()


def behind_by_the_mean(name, env):
    """Return by how much, least and most, an algorithm is behind Meta-BC by its mean action."""
    found = stored_seeds(SHIPPED, env, "optimal")
    gap = shift_interval(*(run_scores(found[n], 1, table=BY_MEAN) for n in (name, "meta-bc")))
    return -gap.high, -gap.low


def lead(quality, place, name, step=1):
    """Return the interval of one of our variants less the best baseline."""
    baseline = max((at(place, quality, other, step) for other in BASELINES), key=np.mean)
    return shift_interval(at(place, quality, name, step), baseline)


def smallest_lead(quality, places, step=1):
    """Return the least lower end of the intervals of our variants less the best baseline."""
    return min(lead(quality, place, name, step).low for place in places for name in OURS)


def falls(*names, quality="optimal", worlds=tuple(TITLES)):
    """Return the largest fall of the ten-iteration mean in each world, worst seed of the algorithms."""
    found = []
    for env in worlds:
        seeds = stored_seeds(SHIPPED, env, quality)
        found.append(max(largest_fall([run]) for name in names for run in seeds[name]))
    return found


def mean_falls(*names, worlds=tuple(TITLES), qualities=tuple(STEPS_SHOWN)):
    """Return the largest fall of the mean over seeds, in any of some worlds."""
    found = [stored_seeds(SHIPPED, env, quality) for env in worlds for quality in qualities]
    return max(largest_fall(seeds[name]) for seeds in found for name in names)


def peaks_and_ends(env, name):
    """Return the range over seeds of the best mean of ten iterations, and that of the last."""
    found = [best_and_last(seed) for seed in stored_seeds(SHIPPED, env, "optimal")[name]]
    peaks, ends = zip(*found, strict=True)
    return *min_and_max(peaks), *min_and_max(ends)


def most_without_a_step(env, name):
    """Return in how many iterations one seed took no step, the worst, and of how many."""
    seeds = stored_seeds(SHIPPED, env, "optimal")[name]
    return max((updates_without_step(run), load_config(run).iterations) for run in seeds)


def restricted(name):
    """Return the intervals of optimal less sub-optimal data after one step, place by place."""
    pairs = [[at(place, quality, name) for quality in STEPS_SHOWN] for place in PLACES]
    return [shift_interval(good, bad) for good, bad in pairs]


def better_data():
    """Return what better data gain on the goals for Meta-BC, and on Point2D for GMPS."""
    cloned, guided = restricted("meta-bc"), restricted("gmps")
    return [cloned[0].estimate, cloned[1].estimate, guided[0].estimate]


def data_alone(name, place):
    """Return what better data gain with each setting of the search, one seed, after one step."""
    gained = []
    for setting in ("table1", "alpha0.1", "rate0.002", "fixed-sigma", "clip0.5"):
        good, bad = (
            run_scores(
                seeds_of(SHIPPED, f"search-{place.env}-{quality}-{name}-{setting}"), 1, place.goal
            )
            for quality in STEPS_SHOWN
        )
        gained.append(float(good[0] - bad[0]))
    return gained


def paid_correctly(name):
    """Return HalfCheetah's runs that are paid in the correct direction only."""
    return seeds_of(SHIPPED, f"half_cheetah-correct-side-optimal-{name}")


def correct_side(name, *places):
    """Return the mean scores of those runs."""
    return [run_scores(paid_correctly(name), 1, place.goal).mean() for place in places]


def correct_lead():
    """Return the interval of EMRLD less MAML, both paid in the correct direction only, both ways."""
    found = map(paid_correctly, ("emrld", "maml"))
    return shift_interval(*(run_scores(seeds, 1, BOTH_WAYS.goal) for seeds in found))


def ahead_of_one_way():
    """Return what 07 says of EMRLD and MAML there: the lead, the budgets, and what MAML could reach."""
    emrld, maml = map(paid_correctly, ("emrld", "maml"))
    budgets = [load_config(seeds[0]).iterations for seeds in (emrld, maml)]
    assert budgets[1] == 2 * budgets[0]
    return [
        correct_lead().low,
        budgets[0],
        training_scores(maml, budgets[0]).mean(),
        late_rise(maml, EARNED["half_cheetah"]),
        2 * correct_side("emrld", BOTH_WAYS)[0],
        BACKWARD.earned,
    ]


def better_for(name):
    """Return the interval of what better data gain on HalfCheetah, mean over directions."""
    return shift_interval(*(at(BOTH_WAYS, quality, name) for quality in STEPS_SHOWN))


def shares(quality, name):
    """Return each run's share of the optimal demonstrations' return, the environments pooled."""
    return np.concatenate([scores(env, quality, name) / EARNED[env] for env in TITLES])


def warm_start_gain(place):
    """Return the interval of EMRLD-WS less EMRLD after one step on optimal data."""
    return shift_interval(at(place, "optimal", "emrld-ws"), at(place, "optimal", "emrld"))


def quicker(quality, env):
    """Return the interval of EMRLD-WS less EMRLD over the first thirty training iterations."""
    seeds = stored_seeds(SHIPPED, env, quality)
    warm, plain = (training_scores(seeds[n], end=30, window=30) for n in ("emrld-ws", "emrld"))
    return shift_interval(warm, plain)


def nats_of(seeds):
    """Return how many updates moved the adapted policies by more than one nat, and of how many."""
    moved = [row.kl for seed in seeds for row in load_curve(seed / "curve.csv")]
    return [sum(kl > 1 for kl in moved), len(moved)]


def stayed_in_bounds(seeds):
    """Return how many updates each run makes before one that exceeds one nat."""
    curves = [load_curve(seed / "curve.csv") for seed in seeds]
    return [next(n for n, row in enumerate(curve) if row.kl > 1) for curve in curves]


def above_one_nat(name, env, quality):
    """Return the same for the runs of one algorithm in one environment, with one quality of data."""
    return nats_of(stored_seeds(SHIPPED, env, quality)[name])


def at_the_first_budget(end=150):
    """Return what 07 says of HalfCheetah's trainings when they were first stopped."""
    stored = stored_seeds(SHIPPED, "half_cheetah", "optimal")
    ours = [training_scores(stored[name], end) for name in OURS]
    cloned = training_scores(stored["meta-bc"])
    assert all(gap.low < 0 < gap.high for gap in (shift_interval(one, cloned) for one in ours))
    return [
        end,
        *[late_rise(stored[name], EARNED["half_cheetah"], end) for name in OURS],
        iterations("half_cheetah", "optimal"),
        iterations("half_cheetah", "optimal", "meta-bc"),
        end,
        *[scores.mean() for scores in (*ours, cloned)],
    ]


def cloned_both_ways():
    """Return what Meta-BC has on HalfCheetah: at least backward, and its range forward."""
    forward = min_and_max(at(FORWARD, "optimal", "meta-bc"))
    return at(BACKWARD, "optimal", "meta-bc").min(), *forward


def trained(*worlds):
    """Return the runs of EMRLD and EMRLD-WS in some worlds, with either quality of the data."""
    stored = [stored_seeds(SHIPPED, env, quality) for env in worlds for quality in STEPS_SHOWN]
    return [seed for found in stored for name in OURS for seed in found[name]]


def minutes(*worlds):
    """Return how long each training of EMRLD and EMRLD-WS took in some worlds."""
    return [load_curve(seed / "curve.csv")[-1].seconds / 60 for seed in trained(*worlds)]


def iterations_of(*worlds):
    """Return the iterations of each training of EMRLD and EMRLD-WS in some worlds."""
    return [load_config(seed).iterations for seed in trained(*worlds)]


def unclipped(quality="optimal"):
    """Return Meta-BC's runs on HalfCheetah without the clipped gradient of the comparison."""
    return seeds_of(SHIPPED, f"half_cheetah-{quality}-meta-bc-unclipped")


def unclipped_shares():
    """Return Meta-BC's shares with optimal data, HalfCheetah's of its unclipped runs."""
    goals_only = [scores(env, "optimal", "meta-bc") / EARNED[env] for env in PLENTIFUL]
    return np.concatenate([*goals_only, run_scores(unclipped(), 1) / EARNED["half_cheetah"]])


def broken_down():
    """Return the best of Meta-BC's unclipped seed that lost all on HalfCheetah, and when it did."""
    seed = unclipped()[0]
    moved = [row.kl for row in load_curve(seed / "curve.csv")]
    best, last = best_and_last(seed)
    assert abs(last) < 5 < 100 < best
    return best, int(np.argmax(moved)) + 1, len(moved)


def without_clipping():
    """Return what 07 says of Meta-BC's unclipped runs on HalfCheetah."""
    both = {q: run_scores(unclipped(q), 1).mean() for q in STEPS_SHOWN}
    raw = run_scores(unclipped(), 1)
    assert all(shift_interval(at(BOTH_WAYS, "optimal", n), raw).low > 14.6 for n in OURS)
    worst = max(row.kl for run in unclipped() for row in load_curve(run / "curve.csv"))
    return [
        *(*nats_of(unclipped()), worst, *nats_of(unclipped("suboptimal"))),
        *both.values(),
        *[at(BOTH_WAYS, q, "meta-bc").mean() for q in STEPS_SHOWN],
        *broken_down(),
        run_scores(unclipped(), 1, FORWARD.goal).min(),
    ]


DRIFTS = SEEN, SEEN_LITERAL, HIDDEN, HIDDEN_LITERAL = [reading.runs for reading in READINGS]
PRINTED = (SEEN_LITERAL, HIDDEN_LITERAL)
DRIVEN_DRIFTS = (-0.8, -0.65, -0.4, -0.2, 0.0, 0.2, 0.4, 0.65, 0.8)  # on the robot


def reading_of(name):
    """Return the reading of the drift experiment that runs of this name belong to."""
    return next(one for one in READINGS if name in (one.runs, one.narrow))


def unseen_drifts(reading):
    """Return the drifts of the test in one reading of the experiment."""
    found = unseen_demonstrations(reading_of(reading).env, "optimal", UNSEEN_TASKS)
    return found.tasks[:, 0].numpy()


def drift(name, step, reading=SEEN, table=SAMPLED):
    """Return the mean score with changing dynamics, in one reading of the experiment."""
    return scores(reading, "optimal", name, step, table=table).mean()


def drift_lead(name, reading=SEEN, table=SAMPLED):
    """Return the interval of one of our variants less MAML after one step, with changing dynamics."""
    return shift_interval(*(scores(reading, "optimal", n, table=table) for n in (name, "maml")))


def climbs(reading, *names):
    """Return by how much the curves still rise in one reading of the experiment."""
    found = stored_seeds(SHIPPED, reading, "optimal")
    earned = EARNED[reading_of(reading).env]
    return [late_rise(found[name], earned) for name in names]


def cloned_by_the_mean(reading):
    """Return Meta-BC's score by the mean action with sigma fixed, of the search's one seed."""
    found = seeds_of(SHIPPED, f"search-{reading}-optimal-meta-bc-fixed-sigma")
    return run_scores(found, 1, table=BY_MEAN).mean()


def narrowly_trained(name, reading, table=SAMPLED):
    """Return scores (seed, drift) after a training on narrow drifts, and the drifts of the test."""
    found = stored_seeds(SHIPPED, reading_of(reading).narrow, "optimal")[name]
    return task_scores(found, 1, table=table), unseen_drifts(reading)


def beyond(name, reading, table=SAMPLED, sign=0):
    """Return each seed's score on drifts beyond those of its training, on both sides or on one."""
    tested, drifts = narrowly_trained(name, reading, table)
    return tested[:, (sign * drifts if sign else abs(drifts)) > NARROW_DRIFT].mean(1)


def within(name, reading):
    """Return the mean score on the drifts that a narrow training did meet."""
    tested, drifts = narrowly_trained(name, reading)
    return tested[:, abs(drifts) <= NARROW_DRIFT].mean()


def beyond_lead(name, reading, table=SAMPLED):
    """Return the interval of one of our variants less MAML on those drifts."""
    return shift_interval(*(beyond(n, reading, table) for n in (name, "maml")))


def after_narrow_drifts():
    """Return what 07 says of trainings on narrow drifts with the heading in the state."""
    assert all(
        beyond_lead(name, SEEN_LITERAL).low < 0 < beyond_lead(name, SEEN_LITERAL).high
        for name in OURS
    )
    assert all(lead_after_cut(n, SEEN, narrow=True).high > 0 for n in OURS)
    return [
        NARROW_DRIFT,
        np.floor(10 * min(within(n, r) for n in (*OURS, "maml") for r in DRIFTS[:2])) / 10,
        *[beyond(name, SEEN).mean() for name in ("maml", *OURS)],
        *[-beyond_lead(name, SEEN, table).high for table in (SAMPLED, BY_MEAN) for name in OURS],
        *[beyond(name, SEEN, sign=1).mean() for name in (*OURS, "maml")],
        ROBOT_DRIFT,
        *[beyond(name, SEEN, sign=-1).mean() for name in (*OURS, "maml")],
        *[beyond(name, SEEN_LITERAL).mean() for name in (*OURS, "maml")],
    ]


def after_narrow_drifts_hidden():
    """Return what 07 says of trainings on narrow drifts without the heading."""
    narrow = {reading.runs: reading.narrow for reading in READINGS}
    hidden, printed = narrow[HIDDEN], narrow[HIDDEN_LITERAL]
    assert beyond_lead("emrld", HIDDEN).low < 0 < beyond_lead("emrld", HIDDEN).high
    assert (
        beyond_lead("emrld-ws", HIDDEN_LITERAL).low
        < 0
        < beyond_lead("emrld-ws", HIDDEN_LITERAL).high
    )
    behind = [-beyond_lead("emrld-ws", HIDDEN, table).high for table in (SAMPLED, BY_MEAN)]
    assert behind == pytest.approx([4.0, 4.0], abs=0.05)  # said once, for both ways to act
    (ended,) = {iterations(name, "optimal", *OURS, "maml") for name in (hidden, printed)}
    assert ended == iterations(HIDDEN, "optimal", *OURS, "maml")
    return [
        *[beyond(name, HIDDEN).mean() for name in ("maml",)],
        NARROW_DRIFT,
        *[beyond(name, HIDDEN).mean() for name in OURS],
        behind[0],
        *[beyond(name, HIDDEN_LITERAL).mean() for name in ("emrld", "maml")],
        *[beyond_lead("emrld", HIDDEN_LITERAL, table).low for table in (SAMPLED, BY_MEAN)],
        beyond("emrld-ws", HIDDEN_LITERAL).mean(),
        ended,
        *climbs(hidden, "maml"),
        *climbs(printed, "maml"),
        *[max(beyond(name, reading).mean() for reading in DRIFTS) for name in ("meta-bc", "gmps")],
        NARROW_DRIFT,
    ]


def overshooting():
    """Return what 07 says of the warm start's step, and of the trainings in which it is too long."""
    raised, ends = {}, {}
    for reading in READINGS:
        for name in (reading.runs, reading.narrow):
            for run in stored_seeds(SHIPPED, name, "optimal")["emrld-ws"]:
                before, after = cloning_before_and_after_warm_start(load_run(run))
                raised[run] = int((after > before).sum())
                ends[run] = training_scores([run])[0]
    too_long = [run for run, tasks in raised.items() if tasks]
    assert all("-narrow-headless-" in run.name for run in too_long)
    rest = [run for run in ends if "-narrow-headless-" in run.name and run not in too_long]
    assert (len(too_long), len(rest)) == (5, 5)
    unpaid, *others = sorted(rest, key=ends.get)
    assert updates_without_step(unpaid) > 0.9 * iterations(HIDDEN, "optimal", "emrld-ws")
    return [
        *min_and_max([raised[run] for run in too_long]),
        max(ends[run] for run in too_long),
        ends[others[0]],
        ends[unpaid],
    ]


def shorter_step(name):
    """Return the settings of EMRLD-WS's runs with a shorter step, and scores beyond narrow drifts."""
    found = stored_seeds(SHIPPED, reading_of(name).narrow + SHORTER_STEP, "optimal")["emrld-ws"]
    wide = abs(unseen_drifts(name)) > NARROW_DRIFT
    return load_config(found[0]), task_scores(found, 1)[:, wide].mean(1)


def shorter_steps():
    """Return what 07 says of EMRLD-WS with a shorter step, where Table 1's overshoots."""
    raised, ends = {}, {}
    for reading in READINGS[2:]:
        for length in ("", SHORTER_STEP):
            found = stored_seeds(SHIPPED, reading.narrow + length, "optimal")["emrld-ws"]
            for seed, run in enumerate(found):
                before, after = cloning_before_and_after_warm_start(load_run(run))
                raised[length, reading, seed] = int((after > before).sum())
                ends[length, reading, seed] = training_scores([run])[0]
    usual = [key for key in ends if not key[0]]
    shorter = {key: (SHORTER_STEP, *key[1:]) for key in usual}
    still = [key for key in shorter.values() if raised[key]]
    unpaid = min(usual, key=lambda key: (raised[key] > 0, ends[key]))
    hidden = (HIDDEN, HIDDEN_LITERAL)
    tested = {name: shorter_step(name)[1] for name in hidden}
    assert len(still) == 4
    return [
        min(ends[shorter[key]] for key in usual if raised[key]),
        ends[shorter[unpaid]],
        np.mean([ends[shorter[key]] for key in usual]),
        np.mean([ends[key] for key in usual]),
        shift_interval(*([ends[key] for key in keys] for keys in (shorter.values(), usual))).low,
        *min_and_max([raised[key] for key in still]),
        *min_and_max([ends[key] for key in still]),
        NARROW_DRIFT,
        *[tested[name].mean() for name in hidden],
        *[beyond("emrld-ws", name).mean() for name in hidden],
        -shift_interval(tested[HIDDEN], beyond("maml", HIDDEN)).high,
        -shift_interval(tested[HIDDEN_LITERAL], beyond("emrld", HIDDEN_LITERAL)).high,
    ]


def largest_steering(data, sign):
    """Return the largest steering of the demonstrations of drifts on one side."""
    drifts = data.tasks[:, 0]
    return float(data.actions[sign * drifts > 0][..., 1].abs().max())


def steering():
    """Return what 07 says of the steering that the demonstrations of changing dynamics ask for."""
    printed = load_demonstrations("optimal", SEEN_LITERAL)
    shown = load_demonstrations("optimal", SEEN)
    tested = unseen_demonstrations(SEEN, "optimal", UNSEEN_TASKS)
    below, above = (
        max(largest_steering(data, -1) for data in (shown, tested)),
        largest_steering(shown, 1),
    )
    drifts = shown.tasks[:, 0]
    wild = shown.actions[..., 1].abs().amax((1, 2)) > 2.0
    first = float(drifts[wild].min())
    assert torch.equal(wild, drifts > first - 0.01)  # all from there on, and no other
    narrow = load_demonstrations(f"data/demonstrations/{SEEN}-narrow.npz", SEEN)
    steered = max(largest_steering(narrow, sign) for sign in (-1, 1))
    assert steered == pytest.approx(0.9, abs=0.05)  # so nothing of it could be cut
    return [
        below,
        above,
        largest_steering(tested, 1),
        first,
        1,  # the end of the box
        max(largest_steering(printed, sign) for sign in (-1, 1)),
    ]


def after_cut(name, reading, table=CUT, narrow=False, trained=False, sign=0):
    """Return each seed's score on unseen drifts, shown demonstrations whose steering was cut, or not.

    Trained on drifts as wide as the test's, or on narrow ones and tested beyond these; or ``trained`` with
    the steering cut as well. On both sides or on one.
    """
    one, drifts = reading_of(reading), unseen_drifts(reading)
    world = one.narrow if narrow else one.cut if trained else one.runs
    found = stored_seeds(SHIPPED, world, "optimal")[name]
    chosen = (abs(drifts) > NARROW_DRIFT if narrow else abs(drifts) >= 0) & (sign * drifts >= 0)
    return task_scores(found, 1, table=table)[:, chosen].mean(1)


def lead_after_cut(name, reading, narrow=False, trained=False, sign=0):
    """Return the interval of one of our variants, the steering cut, less MAML, which reads none."""
    rival = after_cut("maml", reading, SAMPLED, narrow, sign=sign)
    return shift_interval(after_cut(name, reading, CUT, narrow, trained, sign), rival)


def steering_cut():
    """Return what 07 says of the policies shown demonstrations with the steering cut in the test."""
    for reading, narrow in ((SEEN, True), (HIDDEN, True)):
        leads = [lead_after_cut(name, reading, narrow) for name in OURS]
        assert all(lead.low < 0 < lead.high for lead in leads)
    assert lead_after_cut("emrld", SEEN).low < 0 < lead_after_cut("emrld", SEEN).high
    both = (SAMPLED, CUT)
    return [
        *[after_cut("emrld", SEEN, table, narrow=True).mean() for table in both],
        NARROW_DRIFT,
        *[after_cut("emrld-ws", SEEN, table, narrow=True).mean() for table in both],
        after_cut("maml", SEEN, SAMPLED, narrow=True).mean(),
        *[-lead_after_cut(name, SEEN, narrow=True).low for name in OURS],
        *[after_cut("emrld", SEEN, table).mean() for table in both],
        after_cut("emrld-ws", SEEN).mean(),
        *[after_cut(name, HIDDEN, table).mean() for table in both for name in OURS],
        lead_after_cut("emrld-ws", HIDDEN).low,
        *[after_cut(name, HIDDEN, narrow=True).mean() for name in OURS],
        after_cut("maml", HIDDEN, SAMPLED, narrow=True).mean(),
    ]


def trained_on_cut():
    """Return what 07 says of trainings without the heading on demonstrations with the steering cut."""
    seeds = {name: after_cut(name, HIDDEN, trained=True) for name in OURS}
    sides = [after_cut("emrld", HIDDEN, trained=True, sign=sign) for sign in (-1, 1)]
    worse = np.sort(np.minimum(*sides))
    found = stored_seeds(SHIPPED, reading_of(HIDDEN).cut, "optimal")
    never, worst = (found[name][int(seeds[name].argmin())] for name in OURS)
    assert best_and_last(never)[0] < 5
    before, after = cloning_before_and_after_warm_start(load_run(worst))
    leads = {name: lead_after_cut(name, HIDDEN, trained=True) for name in OURS}
    negative = [lead_after_cut(name, HIDDEN, trained=True, sign=-1) for name in OURS]
    assert all(lead.low < 0 < lead.high for lead in (*leads.values(), *negative))
    return [
        worse[2],
        *min_and_max(seeds["emrld"]),
        seeds["emrld-ws"].min(),
        int((after > before).sum()),
        seeds["emrld-ws"].max(),
        *[seeds[name].mean() for name in OURS],
        drift("maml", 1, HIDDEN),
        *leads["emrld-ws"][1:],
    ]


def solved_on_cut():
    """Return what 07 says of trainings with the heading on demonstrations with the steering cut."""
    seeds = {name: after_cut(name, SEEN, trained=True) for name in OURS}
    leads = {name: lead_after_cut(name, SEEN, trained=True) for name in OURS}
    assert leads["emrld"].low < 0 < leads["emrld"].high
    assert 0 < leads["emrld-ws"].low < 0.05
    for each in seeds.values():
        assert each.mean() == pytest.approx(EARNED[SEEN], abs=0.1)
    rival = after_cut("maml", SEEN, SAMPLED)
    return [
        *[each.mean() for each in seeds.values()],
        min(each.min() for each in seeds.values()),
        after_cut("emrld", SEEN, SAMPLED).min(),
        rival.mean(),
        np.sort(rival)[1],
    ]


def baselines_on_cut():
    """Return what 07 says of Meta-BC and GMPS, trained on demonstrations with the steering cut."""
    places = (SEEN, HIDDEN)
    return [
        *[after_cut("meta-bc", reading, trained=True).mean() for reading in places],
        *[after_cut("meta-bc", reading, SAMPLED).mean() for reading in places],
        *[after_cut("gmps", reading, SAMPLED, trained=True).mean() for reading in places],
        *[after_cut("gmps", reading, SAMPLED).mean() for reading in places],
    ]


def limits_of_the_cut():
    """Return what 07 says of where no action was cut."""
    asked = load_demonstrations("optimal", "half_cheetah").actions.abs().max()
    return [1, float(asked)]  # the end of the box, and what lies beyond


def readings():
    """Return what 07 says of the experiment without the heading, and with the drift as printed."""
    printed = stored_seeds(SHIPPED, SEEN_LITERAL, "optimal")
    hidden = {name: scores(HIDDEN_LITERAL, "optimal", name) for name in (*OURS, "maml")}
    assert all(hidden[name].min() > hidden["maml"].max() for name in OURS)
    return [
        *[drift(name, 1, HIDDEN) for name in ("emrld-ws", "maml")],
        *drift_lead("emrld-ws", HIDDEN)[1:],
        drift("emrld", 1, HIDDEN),
        *(-drift_lead("emrld", HIDDEN).low, drift_lead("emrld", HIDDEN).high),
        *[drift(name, 0, HIDDEN) for name in (*OURS, "maml")],
        drift("meta-bc", 1, HIDDEN),
        cloned_by_the_mean(HIDDEN),
        drift("gmps", 1, HIDDEN),
        *[drift(name, 1, SEEN_LITERAL) for name in (*OURS, "maml")],
        task_scores(printed["maml"], 1).min(1).max(),
        *[tested.mean() for tested in hidden.values()],
        *[drift_lead(name, HIDDEN_LITERAL).low for name in OURS],
        *[drift(name, 1, SEEN_LITERAL) for name in ("meta-bc", "gmps")],
        *[drift(name, 1, HIDDEN_LITERAL) for name in ("meta-bc", "gmps")],
        *[max(searched(f"{reading}-optimal-meta-bc", "*")) for reading in PRINTED],
        *[searched(f"{reading}-optimal-meta-bc", "clip0.5")[0] for reading in (SEEN, HIDDEN)],
        *[
            training_scores(
                stored_seeds(SHIPPED, reading, "optimal")["meta-bc"], window=SEARCH_END
            )[0]
            for reading in (SEEN, HIDDEN)
        ],
        max(best_and_last(run)[0] for run in printed["meta-bc"]),
    ]


def trained_to(reading, name, end):
    """Return each seed's return on its training tasks after some iterations."""
    return training_scores(stored_seeds(SHIPPED, reading, "optimal")[name], end)


def hidden_budget():
    """Return what 07 says of the iterations that the trainings without the heading take."""
    first, last = 150, iterations(HIDDEN, "optimal", *OURS, "maml")
    assert {iterations(HIDDEN_LITERAL, "optimal", name) for name in (*OURS, "maml")} == {last}
    three = (*OURS, "maml")
    lead = {
        (reading, end): shift_interval(*(trained_to(reading, n, end) for n in ("emrld-ws", "maml")))
        for reading in (HIDDEN, HIDDEN_LITERAL)
        for end in (first, last)
    }
    assert lead[HIDDEN_LITERAL, last].estimate > lead[HIDDEN_LITERAL, first].estimate
    for reading in (HIDDEN, HIDDEN_LITERAL):
        early, late = (trained_to(reading, "maml", end).mean() for end in (first, last))
        assert late > 2 * early
    return [
        *[trained_to(HIDDEN, name, first).mean() for name in three],
        first,
        *[trained_to(HIDDEN, name, last).mean() for name in three],
        last,
        *[trained_to(HIDDEN_LITERAL, n, end).mean() for end in (first, last) for n in three],
        *[lead[HIDDEN, end].estimate for end in (first, last)],
        *[trained_to(reading, "maml", 50).mean() for reading in (HIDDEN, HIDDEN_LITERAL)],
        50,
        last,
        *[climbs(reading, "maml")[0] for reading in (HIDDEN, HIDDEN_LITERAL)],
        *min_and_max(climbs(HIDDEN, *OURS) + climbs(HIDDEN_LITERAL, *OURS)),
    ]


def hidden_by_side():
    """Return what 07 says of the negative and of the positive drifts without the heading."""

    def on_side(name, reading, sign, least=0.0):
        found = stored_seeds(SHIPPED, reading, "optimal")[name]
        return task_scores(found, 1)[:, sign * unseen_drifts(reading) > least].mean(1)

    def lead(name, reading, sign):
        return shift_interval(*(on_side(n, reading, sign) for n in (name, "maml")))

    assert all(lead(name, HIDDEN, 1).low < 0 < lead(name, HIDDEN, 1).high for name in OURS)
    far = [on_side(n, HIDDEN, 1, 0.5).mean() / on_side(n, HIDDEN, -1).mean() for n in OURS]
    assert max(far) < 0.5  # most of it is lost
    return [
        *[on_side(name, HIDDEN, -1).mean() for name in (*OURS, "maml")],
        *[lead(name, HIDDEN, -1).low for name in OURS],
        *[on_side(name, HIDDEN, 1).mean() for name in (*OURS, "maml")],
        0.5,  # a place on the axis of Figure 14
        min(lead(name, HIDDEN_LITERAL, sign).low for name in OURS for sign in (-1, 1)),
    ]


def readings_by_the_mean():
    """Return what 07 says of the four readings where the policies act by their mean action."""
    cloned = [(SEEN, SEEN_LITERAL), (HIDDEN, HIDDEN_LITERAL)]
    return [
        *[drift(name, step, HIDDEN, BY_MEAN) for step in (1, 0) for name in OURS],
        *[drift("maml", step, HIDDEN, BY_MEAN) for step in (1, 0)],
        scores(HIDDEN, "optimal", "maml", table=BY_MEAN).max(),
        *[end for name in OURS for end in drift_lead(name, HIDDEN, BY_MEAN)[1:]],
        *[drift_lead(n, r, BY_MEAN).low for r in PRINTED[::-1] for n in OURS],
        drift_lead("emrld", SEEN, BY_MEAN).high,
        *[drift("meta-bc", 1, reading, BY_MEAN) for reading in cloned[0]],
        *map(cloned_by_the_mean, cloned[0]),
        *[drift("meta-bc", 1, reading, BY_MEAN) for reading in cloned[1]],
        max(map(cloned_by_the_mean, cloned[1])),
    ]


def rise(env, quality, name):
    """Return by how much the mean over seeds still rises, as a share of its level."""
    return late_rise(stored_seeds(SHIPPED, env, quality)[name], EARNED[env])


def rises(names, worlds, qualities=tuple(STEPS_SHOWN)):
    """Return the rises of several algorithms, sorted."""
    return sorted(
        rise(env, quality, name) for env in worlds for quality in qualities for name in names
    )


def drift_rises():
    return [rise("two_wheeled_drift", "optimal", name) for name in (*OURS, "meta-bc")]


def level(env, quality, name):
    """Return the mean training return of the last fifth."""
    seeds = stored_seeds(SHIPPED, env, quality)[name]
    window = load_config(seeds[0]).iterations // 5
    return training_scores(seeds, window=window).mean()


def demonstrated(env):
    """Return what the optimal demonstrator earned, before any cut, by its own file."""
    return float(
        re.search(r"mean sparse return ([\d.]+)", load_demonstrations("optimal", env).maker)[1]
    )


def iterations(env, quality, *names):
    """Return the iterations of some algorithms' runs in a world, by default ours: all have as many."""
    seeds = [seed for name in names or OURS for seed in stored_seeds(SHIPPED, env, quality)[name]]
    (count,) = {load_config(seed).iterations for seed in seeds}
    return count


def goals():
    """Return the number of goals in the plentiful data, and in the others of the same worlds."""
    (plenty,) = {
        len(load(ROOT / load_config(SHIPPED / f"{env}-meta-bc-plentiful-seed0").demos).tasks)
        for env in PLENTIFUL
    }
    return [plenty, *[len(load_demonstrations("optimal", env).tasks) for env in PLENTIFUL]]


def starved():
    """Return the Fisher samples and CG iterations that starve a trust region, and the runs' length."""
    configs = [load_config(seed) for seed in seeds_of(SHIPPED, STARVED)]
    ((samples, products, length),) = {
        (config.trust_region.fisher_samples, config.trust_region.cg_iterations, config.iterations)
        for config in configs
    }
    return samples, products, length


def largest_moves(env, name):
    """Return the largest KL of a single update of each seed with optimal data, nats."""
    seeds = stored_seeds(SHIPPED, env, "optimal")[name]
    return [max(row.kl for row in load_curve(seed / "curve.csv")) for seed in seeds]


def least_share_after_one_step():
    """Return the least share of its last training return that one step on unseen Point2D goals gives."""
    pairs = [("emrld", "optimal"), ("emrld", "suboptimal"), ("emrld-ws", "optimal")]
    seeds = [
        seed for name, quality in pairs for seed in stored_seeds(SHIPPED, "point2d", quality)[name]
    ]
    return min(
        run_scores([seed], 1)[0] / load_curve(seed / "curve.csv")[-1].return_after for seed in seeds
    )


def gap_of(pair):
    """Return the interval of the late return of a pair's changed runs, less its control's."""
    return shift_interval(*pair.scores(SHIPPED))


def unseen_gap(pair, table=SAMPLED):
    """Return the interval of the score on unseen tasks of a pair's changed runs, less its control's."""
    return shift_interval(*pair.tested(SHIPPED, table))


class Copy(NamedTuple):
    """How well policies copy the demonstrations: cloning loss, and cosine of the mean actions."""

    loss: float
    cosine: float


def copied(run):
    """Return how a run's policies copy after adaptation by cloning alone, as notebook 08 measures it."""
    demos, stored = load_demonstrations("optimal", "point2d"), load_run(run)
    losses, cosines = [], []
    for states, actions, mask in zip(demos.states, demos.actions, demos.mask.bool(), strict=True):
        seen, taken = states[mask], actions[mask]  # (step, dim)
        theta = {name: value.requires_grad_() for name, value in detach(stored.meta_params).items()}
        gradients = torch.autograd.grad(copying_loss(theta, seen, taken), list(theta.values()))
        adapted = {
            name: value.detach() - stored.config.adapt_lr * gradient
            for (name, value), gradient in zip(theta.items(), gradients, strict=True)
        }
        losses.append(float(copying_loss(adapted, seen, taken)))
        mean = distribution(adapted, seen).mean
        products, lengths = (mean * taken).sum(-1), mean.norm(dim=-1) * taken.norm(dim=-1)
        cosines += (products / lengths).tolist()
    return Copy(np.mean(losses), np.mean(cosines))


def copies_and_returns(pair):
    """Return how well either side of a pair copies, and what either returns on unseen tasks."""
    copies = [np.mean([copied(run).loss for run in seeds]) for seeds in pair.runs(SHIPPED)]
    return [*copies, *(tested.mean() for tested in pair.tested(SHIPPED))]


def copying_loss(theta, states, actions):
    """Return minus the log-density of one demonstration, mean over steps and dimensions."""
    mean, log_sigma = distribution(theta, states)
    return -torch.distributions.Normal(mean, log_sigma.exp()).log_prob(actions).mean()


def without_when_tested(quality):
    """Return the interval of what is left on unseen goals without RL in a panel of Fig. 8."""
    panel = ablation_runs(SHIPPED, quality)
    return shift_interval(*(run_scores(panel[part], 1) for part in ("w_rl = 0", "EMRLD")))


def lost_at_most(gap):
    """Return the largest loss that the interval of a difference leaves possible."""
    return max(0.0, -gap.low)


def left(quality, part):
    """Return the late return of each seed in a panel of Fig. 8."""
    return training_scores(ablation_runs(SHIPPED, quality)[part], ABLATION_END)


def without(quality, part):
    """Return the interval of what is left in a panel of Fig. 8, less the whole algorithm's."""
    return shift_interval(left(quality, part), left(quality, "EMRLD"))


def weights(name, varied):
    """Return the runs of a panel of Fig. 7 by the weight."""
    return sensitivity_runs(SHIPPED, name, varied)


def halfway(varied, value, name="emrld"):
    """Return the first iteration at which an algorithm's mean return over seeds is above HALFWAY."""
    curves = [
        load_curve(run / "curve.csv")[: SENSITIVITY_END[name]]
        for run in weights(name, varied)[value]
    ]
    means_by_iteration = [
        np.mean([row.return_after for row in rows]) for rows in zip(*curves, strict=True)
    ]
    return next(iteration for iteration, mean in enumerate(means_by_iteration) if mean > HALFWAY)


def largest_difference(name, varied):
    """Return the largest difference from a weight of 1 that the intervals of a panel leave possible."""
    at_one = late_seeds(name, varied, MOST)
    gaps = [shift_interval(late_seeds(name, varied, value), at_one) for value in WEIGHTS[:-1]]
    return max(max(-gap.low, gap.high) for gap in gaps)


def min_and_max(values):
    ordered = sorted(values)
    return ordered[0], ordered[-1]


def late_seeds(name, varied, value):
    """Return the late return of each seed of an algorithm with one value of a weight."""
    return training_scores(weights(name, varied)[value], SENSITIVITY_END[name])


def late_by_weight(name, varied, value):
    """Return the mean late return of an algorithm with one value of a weight."""
    return late_seeds(name, varied, value).mean()


def span(name, varied):
    """Return the largest less the smallest mean late return of a panel of Fig. 7."""
    late_means = [late_by_weight(name, varied, value) for value in WEIGHTS]
    return max(late_means) - min(late_means)


def switch(label):
    """Return the mean score of a switch's runs on unseen goals."""
    return run_scores(switch_runs(SHIPPED)[label], 1).mean()


def switch_spread(label):
    """Return how far the switch's seeds lie apart on unseen goals."""
    return np.ptp(run_scores(switch_runs(SHIPPED)[label], 1))


def waits_of(seeds):
    """Return the fewest and the most iterations of some runs to the target, which all must reach."""
    return min_and_max(iterations_to(run, TARGET) for run in seeds)


def switch_gaps():
    """Return by how much each switch changes the return on unseen goals, by what it changes."""
    control, *others = (run_scores(seeds, 1) for seeds in switch_runs(SHIPPED).values())
    names = list(switch_runs(SHIPPED))[1:]
    return {n: shift_interval(o, control) for n, o in zip(names, others, strict=True)}


def switch_rises():
    """Return by how much the curve of each switch still rises, the control's left out."""
    return [
        late_rise(seeds, EARNED["point2d"]) for seeds in list(switch_runs(SHIPPED).values())[1:]
    ]


def small_switch_losses():
    """Return the losses that are shown, and too small to matter."""
    small = [gap for gap in switch_gaps().values() if gap.high < 0 and gap.low > -WORTH]
    return [-gap.estimate for gap in small]


def largest_switch_loss():
    """Return the largest loss that remains possible for a switch that is not told apart."""
    return max(lost_at_most(gap) for gap in switch_gaps().values() if gap.high >= 0)


def switch_seeds(label):
    """Return the score of each seed of a switch on unseen goals, sorted."""
    return sorted(run_scores(switch_runs(SHIPPED)[label], 1))


def searched(what, *settings, at_best=False):
    """Return the late training return of the search's runs, or the best mean of ten iterations."""
    found = []
    for setting in settings:
        for run in sorted(SHIPPED.glob(f"search-{what}-{setting}-seed0")):
            returns = [row.return_after for row in load_curve(run / "curve.csv")]
            smooth = np.convolve(returns, np.ones(WINDOW) / WINDOW, "valid")
            found.append(smooth.max() if at_best else np.mean(returns[-SEARCH_END:]))
    return found


def own_and_searched(env, quality, name):
    """Return EMRLD's late return at iteration 80 by seed, and the best that its search has by then."""
    own = training_scores(stored_seeds(SHIPPED, env, quality)[name], 80, SEARCH_END)
    return own, max(searched(f"{env}-{quality}-{name}", "alpha0.1", "kl0.005", "fixed-sigma"))


def gained_by_a_search():
    """Return what 07 says of the search that EMRLD did not get."""
    rows = [own_and_searched(e, q, n) for e in PLENTIFUL for q in STEPS_SHOWN for n in OURS]
    *others, most = sorted(best - own[0] for own, best in rows)
    late, best = own_and_searched("two_wheeled", "optimal", "emrld")
    assert best - late[0] == most
    return [max(others), late[0], best, sorted(late)[-3]]


def gmps_on_point2d(what):
    """Return the runs of one training of GMPS on Point2D beside the comparison's."""
    return seeds_of(SHIPPED, f"point2d-{what}")


def gmps_in_bounds():
    """Return what 07 says of GMPS with a first-order gradient, and at a fifth of its rate."""
    own, first = gmps_on_point2d("suboptimal-gmps"), gmps_on_point2d("suboptimal-gmps-first-order")
    slow = [gmps_on_point2d(f"{q}-gmps-rate0.002-long") for q in reversed(STEPS_SHOWN)]
    return [
        *nats_of(first),
        *nats_of(own),
        *stayed_in_bounds(slow[0] + seeds_of(SHIPPED, "search-point2d-suboptimal-gmps-table1")),
        *stayed_in_bounds(slow[1]),
        *min_and_max(stayed_in_bounds(gmps_on_point2d("optimal-gmps"))),
        *(nats_of(slow[0])[0], *nats_of(slow[1])),
        *nats_of(seeds_of(SHIPPED, "search-point2d-suboptimal-gmps-clip0.5")),
        nats_of(seeds_of(SHIPPED, "search-point2d-suboptimal-gmps-table1"))[0],
        *nats_of(gmps_on_point2d("gmps-paths")),
        *[run_scores(seeds_of(SHIPPED, f"{env}-gmps-paths"), 1).mean() for env in PLENTIFUL],
        *means("optimal", "gmps", places=GOALS),
        *[training_scores(runs, window=SEARCH_END).mean() for runs in (first, own)],
    ]


def robot(name, stage, varied="drift", value=ROBOT_DRIFT, score="mean_return", reading=SEEN):
    """Return the score of each seed on the simulated robot in one case of its study."""
    names = [run.name for run in stored_seeds(SHIPPED, reading, "optimal")[name]]
    sweep = sweep_of(load_study(), names, varied, stage, score)
    return sweep.scores[:, np.abs(sweep.values - value).argmin()]


def controller(value):
    """Return the score of the controller that aims at the goal, under one drift; None: the worst."""
    name = controller_name(make("two_wheeled_drift"))
    sweep = sweep_of(load_study(), [name], "drift", BEFORE)
    chosen = slice(None) if value is None else np.abs(sweep.values - value).argmin()
    return sweep.scores[0, chosen].min()


def on_robot():
    """Return what 09 says of the paper's drift."""
    before, after = ({n: robot(n, stage) for n in ALGORITHMS} for stage in (BEFORE, AFTER))
    leads = [shift_interval(after[name], after["maml"]) for name in OURS]
    assert all(0 < gap.low < 0.1 for gap in leads)  # a hair ahead
    return [
        *[number for n in OURS for number in (before[n].mean(), after[n].mean())],
        *[after[n].min() for n in OURS],
        EARNED["two_wheeled_drift"],
        *(before["maml"].mean(), after["maml"].mean()),
        *(min(gap.low for gap in leads), max(gap.high for gap in leads)),
        *(after["meta-bc"].mean(), after["gmps"].mean()),
        robot("emrld-ws", TRIAL).mean(),
        *[robot("emrld", AFTER, score=score).mean() for score in ("reached", "truly")],
        robot("maml", AFTER, score="truly").mean(),
    ]


def blind(name, stage=AFTER, score="mean_return"):
    """Return each seed's score on the robot under the paper's drift, of policies without the heading."""
    return robot(name, stage, score=score, reading=HIDDEN)


def on_robot_without_heading():
    """Return what 09 says of the policies that do not see their heading."""
    names = ("emrld-ws", "emrld", "maml")
    other_side = {n: robot(n, AFTER, value=-ROBOT_DRIFT, reading=HIDDEN) for n in names}
    leads = [shift_interval(other_side[name], other_side["maml"]) for name in OURS]
    assert all(gap.low < 0 < gap.high for gap in leads)
    return [
        *[blind(name).mean() for name in names],
        *[shift_interval(blind(name), blind("maml")).low for name in names[:2]],
        *[blind(name, score="reached").mean() for name in names],
        *(blind("maml", BEFORE).mean(), blind("maml", TRIAL).mean()),
        *[(blind(n) - blind(n, BEFORE)).mean() for n in ("emrld", "emrld-ws")],
        (blind("emrld-ws", TRIAL) - blind("emrld-ws", BEFORE)).mean(),
        *[blind(name).mean() for name in ("meta-bc", "gmps")],
        -ROBOT_DRIFT,
        *[other_side[name].mean() for name in names],
        iterations(HIDDEN, "optimal", *names),
        150,  # iterations, the budget that 07 compares
    ]


def robot_sweep():
    """Return what 09 says of drifts, delays, the gyroscope and ice."""
    three = ("emrld", "emrld-ws", "maml")
    cost = {
        n: robot(n, AFTER, "delay", 0.0).mean() - robot(n, AFTER, "delay", 0.5).mean()
        for n in three
    }
    return [
        min(robot("emrld-ws", AFTER, value=value).mean() for value in DRIVEN_DRIFTS),
        *(robot("emrld", AFTER, value=0.4).mean(), 0.4),
        *(robot("emrld", AFTER, value=0.8).mean(), 0.8),
        *(robot("maml", AFTER, value=-0.8).mean(), -0.8),
        *(cost["emrld-ws"], cost["emrld"], cost["maml"]),
        *[robot(n, AFTER, "delay", 1.0).mean() for n in three],
        *[robot(n, AFTER, "delay", 1.5).mean() for n in three],
        0.4,
        *[robot(n, AFTER, "odometry_turn", 0.4).mean() for n in three],
        0.02,
        robot("emrld-ws", AFTER, "friction", 0.02).mean(),
    ]


def each(env, quality, name, goal=None):
    """Return the scores of the seeds, sorted."""
    return sorted(scores(env, quality, name, goal=goal))


def without_cloning():
    """Return what is left without cloning, and what with it, for either quality of the data."""
    return [left(q, part).mean() for q in STEPS_SHOWN for part in ("w_bc = 0", "EMRLD")]


GOALS = PLACES[:2]
TWO_WHEELED, TWO_WHEELED_WARM = WITHOUT_RL[2:4]
CLONED = [run for pair in CLONING_ALONE for run in pair.runs(SHIPPED)[0]]
MISLEADING, FIRST_TWENTY, SUMMED, FIXED_SIGMA, AS_PRINTED = WITHOUT_RL[4:]
LEFT_OPEN = (TWO_WHEELED, TWO_WHEELED_WARM, FIRST_TWENTY)  # where a loss that matters is possible


CLAIMS = {
    "07#ahead-optimal": lambda: [
        *(*means("optimal", *OURS, places=GOALS[:1]), best("optimal", GOALS[0])),
        *(*means("optimal", *OURS, places=GOALS[1:]), best("optimal", GOALS[1])),
        smallest_lead("optimal", GOALS),
        *(at(BOTH_WAYS, "optimal", "emrld").mean(), best("optimal", BOTH_WAYS)),
        lead("optimal", BOTH_WAYS, "emrld", 1).low,
        at(BOTH_WAYS, "optimal", "emrld-ws").mean(),
        *lead("optimal", BOTH_WAYS, "emrld-ws", 1)[1:],
        run_scores(unclipped(), 1).mean(),
        *at_the_first_budget(),
    ],
    "07#directions": lambda: [
        *means("optimal", *OURS, places=[FORWARD, BACKWARD]),
        *(FORWARD.earned, BACKWARD.earned),
        *means("optimal", "gmps", places=[FORWARD, BACKWARD, BOTH_WAYS]),
        *cloned_both_ways(),
        min(lead("optimal", FORWARD, name, 1).low for name in OURS),
        *means("optimal", "maml", places=[FORWARD, BACKWARD]),
    ],
    "07#wrong-way-unpunished": lambda: [
        np.mean([np.maximum(at(way, "optimal", name), 0) for way in (FORWARD, BACKWARD)])
        for name in ("gmps", "meta-bc", "emrld")
    ],
    "07#correct-side": lambda: [
        *correct_side("emrld", FORWARD, BACKWARD),
        *means("optimal", "emrld", places=[FORWARD, BACKWARD]),
        *correct_side("gmps", FORWARD, BACKWARD),
        *means("optimal", "gmps", places=[FORWARD, BACKWARD]),
        load_config(paid_correctly("maml")[0]).iterations,
        *correct_side("maml", BACKWARD, FORWARD),
        *[correct_side(name, BOTH_WAYS)[0] for name in ("emrld", "maml", "gmps")],
        np.mean([np.maximum(at(way, "optimal", "meta-bc"), 0) for way in (FORWARD, BACKWARD)]),
        *ahead_of_one_way(),
    ],
    "07#warm-start-or-not": lambda: [
        end
        for place in (*GOALS, BOTH_WAYS)
        for end in (-warm_start_gain(place).low, warm_start_gain(place).high)
    ],
    "07#search-emrld": gained_by_a_search,
    "07#gmps-in-bounds": gmps_in_bounds,
    "07#warm-start-begins": lambda: [
        *[quicker("optimal", env).estimate for env in PLENTIFUL],
        *[quicker("suboptimal", env).estimate for env in PLENTIFUL],
        *[quicker(quality, "half_cheetah").estimate for quality in STEPS_SHOWN],
    ],
    "07#monotone": lambda: [
        *(mean_falls(*OURS), mean_falls("meta-bc")),
        *[*falls(*OURS)[1:2], *falls(*OURS, quality="suboptimal")[1:2]],
        *falls("meta-bc"),
        *means("optimal", "gmps", places=GOALS),
        scores("point2d", "optimal", "maml").mean(),
        *peaks_and_ends("two_wheeled", "maml"),
        scores("two_wheeled", "optimal", "maml").mean(),
        *means("optimal", "meta-bc", places=GOALS),
    ],
    "07#by-the-mean": lambda: [
        *by_mean("optimal", "meta-bc"),
        *(EARNED[env] for env in PLENTIFUL),
        *by_mean("optimal", "emrld", "emrld-ws"),
        *behind_by_the_mean("emrld-ws", "two_wheeled"),
        *by_mean("suboptimal", "meta-bc", "emrld"),
        max(by_mean("optimal", "maml", "gmps") + by_mean("suboptimal", "gmps")),
        *[by_mean_on(BOTH_WAYS, q, name) for q in STEPS_SHOWN for name in (*OURS, "meta-bc")],
        *[by_mean_on(w, "optimal", n) for w in (FORWARD, BACKWARD) for n in (*OURS, "meta-bc")],
    ],
    "07#updates-above-one-nat": lambda: [
        *above_one_nat("gmps", "point2d", "suboptimal"),
        *above_one_nat("gmps", "point2d", "optimal"),
        *above_one_nat("gmps", "two_wheeled", "optimal"),
        sorted(above_one_nat("gmps", env, q)[0] for env in TITLES for q in STEPS_SHOWN)[-4],
        *above_one_nat("meta-bc", "half_cheetah", "optimal"),
        np.ceil(10 * max(largest_moves("half_cheetah", "meta-bc"))) / 10,  # at most
        *above_one_nat("meta-bc", "half_cheetah", "suboptimal"),
        above_one_nat("meta-bc", "two_wheeled", "optimal")[0],
        *nats_of([SHIPPED / "search-two_wheeled-optimal-meta-bc-table1-seed0"]),
        *max(above_one_nat("gmps", reading.runs, "optimal") for reading in READINGS),
        *max(above_one_nat("meta-bc", reading.runs, "optimal") for reading in READINGS),
        *most_without_a_step("two_wheeled", "emrld"),
    ],
    "07#meta-bc-clipped": without_clipping,
    "07#ahead-suboptimal": lambda: [
        *means("suboptimal", *OURS),
        smallest_lead("suboptimal", PLACES),
    ],
    "07#restricted-by-the-data": lambda: [
        *better_data()[:2],
        min(gap.low for gap in restricted("meta-bc")[:2]),
        better_data()[2],
        *(-restricted("gmps")[1].low, restricted("gmps")[1].high),
        *better_for("meta-bc")[:2],
        *[iterations("half_cheetah", quality, "meta-bc") for quality in STEPS_SHOWN],
        *(restricted("gmps")[3].estimate, -restricted("gmps")[2].estimate),
    ],
    "07#the-data-alone": lambda: [
        *[end for place in PLACES[:2] for end in min_and_max(data_alone("meta-bc", place))],
        max(data_alone("gmps", PLACES[0])),
        *min_and_max(data_alone("gmps", PLACES[1])),
        *min_and_max(data_alone("gmps", BACKWARD)),
        *min_and_max([-gap for gap in data_alone("gmps", FORWARD)]),
        *better_for("emrld"),
        better_for("emrld-ws").estimate,
        *(-better_for("emrld-ws").low, better_for("emrld-ws").high),
    ],
    "07#pooled-means": lambda: [
        *[shares(quality, name).mean() for quality in STEPS_SHOWN for name in OURS],
        *[max(shares(q, name).mean() for name in BASELINES) for q in STEPS_SHOWN],
        *[
            (scores(env, "optimal", "emrld").mean() - scores(env, "suboptimal", "emrld").mean())
            / EARNED[env]
            for env in TITLES
        ],
        EARNED["half_cheetah"],
        *(summed(unclipped_shares()) for summed in (interquartile_mean, np.mean)),
    ],
    "07#drift-claims": lambda: [
        *[drift(name, 1) for name in ("emrld", "emrld-ws", "maml")],
        drift("maml", 0),
        demonstrated("two_wheeled_drift"),
        *[scores(SEEN, "optimal", name).min() for name in ("emrld", "maml", "emrld-ws")],
        *drift_lead("emrld-ws")[1:],
        drift_lead("emrld").high,
        *[drift(name, 1) for name in ("meta-bc", "gmps")],
        cloned_by_the_mean(SEEN),
    ],
    "07#narrow-drifts": lambda: [*after_narrow_drifts(), *after_narrow_drifts_hidden()],
    "07#overshoot": overshooting,
    "07#overshoot-shorter": shorter_steps,
    "07#steering": steering,
    "07#by-steering": lambda: [
        *steering_cut(),
        *solved_on_cut(),
        *trained_on_cut(),
        *baselines_on_cut(),
        *limits_of_the_cut(),
    ],
    "07#reading-claims": readings,
    "07#hidden-budget": hidden_budget,
    "07#hidden-by-side": hidden_by_side,
    "07#blind-by-the-mean": readings_by_the_mean,
    "07#flattened": lambda: [
        max(rises((*OURS, "meta-bc"), PLENTIFUL) + drift_rises()),
        level("point2d", "optimal", "maml"),
        max(
            rise("point2d", "suboptimal", "gmps"),
            rise("half_cheetah", "optimal", "gmps"),
            rise("two_wheeled_drift", "optimal", "gmps"),
        ),
        *[-rise("two_wheeled", "optimal", name) for name in ("maml", "gmps")],
        *[-rise(env, "suboptimal", "gmps") for env in ("two_wheeled", "half_cheetah")],
        -rise("point2d", "optimal", "gmps"),
        *min_and_max(rises(OURS, ["half_cheetah"])),
        *{iterations("half_cheetah", quality) for quality in STEPS_SHOWN},
        *[rise("half_cheetah", quality, "meta-bc") for quality in STEPS_SHOWN],
        *[-fall for fall in climbs(SEEN_LITERAL, "meta-bc", "gmps")],
        iterations(HIDDEN, "optimal", *OURS, "maml"),
        *[climbs(reading, "emrld")[0] for reading in (HIDDEN, HIDDEN_LITERAL)],
        *[climbs(reading, "emrld-ws")[0] for reading in (HIDDEN, HIDDEN_LITERAL)],
        *[climbs(reading, "maml")[0] for reading in (HIDDEN, HIDDEN_LITERAL)],
        *climbs(HIDDEN_LITERAL, "meta-bc"),
    ],
    "08#ablation-verdicts": lambda: [
        *without_cloning(),
        *[left(q, "w_rl = 0").mean() for q in STEPS_SHOWN],
        *[lost_at_most(without(q, "w_rl = 0")) for q in STEPS_SHOWN],
        *[lost_at_most(without_when_tested(q)) for q in STEPS_SHOWN],
        late_rise(ablation_runs(SHIPPED, "optimal")["w_rl = 0"], EARNED["point2d"]),
    ],
    "08#without-rl-elsewhere": lambda: [
        *[gap_of(pair).estimate for pair in WITHOUT_RL],
        max(lost_at_most(gap_of(pair)) for pair in WITHOUT_RL if pair not in LEFT_OPEN),
        *[lost_at_most(gap_of(pair)) for pair in LEFT_OPEN],
        gap_of(WITHOUT_RL[1]).high,
        *[training_scores(seeds).mean() for seeds in MISLEADING.runs(SHIPPED)],
        -unseen_gap(TWO_WHEELED_WARM).estimate,
        *(-unseen_gap(TWO_WHEELED_WARM).high, -unseen_gap(TWO_WHEELED_WARM).low),
        max(lost_at_most(unseen_gap(pair)) for pair in (WITHOUT_RL[0], FIXED_SIGMA, AS_PRINTED)),
        *[lost_at_most(unseen_gap(pair)) for pair in (TWO_WHEELED, SUMMED, FIRST_TWENTY)],
        *[scores.mean() for scores in reversed(MISLEADING.tested(SHIPPED))],
    ],
    "08#without-rl-again": lambda: [
        *[scores.mean() for scores in WITHOUT_RL_AGAIN.tested(SHIPPED)],
        *unseen_gap(WITHOUT_RL_AGAIN),
        *gap_of(WITHOUT_RL_AGAIN),
        5,  # a loss that matters
    ],
    "08#cloning-alone": lambda: [
        *copies_and_returns(CLONING_ALONE[1]),
        *copies_and_returns(CLONING_ALONE[0]),
        min(copied(run).cosine for pair in CLONING_ALONE for run in pair.runs(SHIPPED)[0]),
        max(copied(run).cosine for pair in CLONING_ALONE for run in pair.runs(SHIPPED)[1]),
        ABLATION_END,
        min(-unseen_gap(pair).high for pair in CLONING_ALONE),
        min(-unseen_gap(pair, BY_MEAN).high for pair in CLONING_ALONE),
        iterations("point2d", "optimal", "meta-bc"),
        *min_and_max([failed for run in CLONED if (failed := updates_without_step(run))]),
        ABLATION_END,
        max(run_scores(CLONED, 1, table=BY_MEAN)),
        training_scores(
            stored_seeds(SHIPPED, "point2d", "optimal")["meta-bc"], ABLATION_END
        ).mean(),
        ABLATION_END,
        scores("point2d", "optimal", "meta-bc").mean(),
        iterations("point2d", "optimal", "meta-bc"),
        by_mean("optimal", "meta-bc")[0],
        CLONING_ALONE[1].tested(SHIPPED, BY_MEAN)[1].mean(),
    ],
    "08#double-use": lambda: [
        *[side.mean() for side in DOUBLE_USE[0].tested(SHIPPED)],
        *[pair.tested(SHIPPED)[0].mean() for pair in DOUBLE_USE[1:3]],
        min(-unseen_gap(pair).high for pair in DOUBLE_USE[:3]),
        lost_at_most(unseen_gap(DOUBLE_USE[3])),
        *(70, *sorted(iterations_to(run, 70) for run in DOUBLE_USE[3].runs(SHIPPED)[0])),
        sum(updates_without_step(run) for run in DOUBLE_USE[2].runs(SHIPPED)[0]),
        sum(load_config(run).iterations for run in DOUBLE_USE[2].runs(SHIPPED)[0]),
        *[side.mean() for side in DOUBLE_USE[2].tested(SHIPPED, BY_MEAN)],
        late_rise(DOUBLE_USE[2].runs(SHIPPED)[0], EARNED["point2d"], ABLATION_END),
    ],
    "08#sensitivity-verdicts": lambda: [
        *(span("emrld", "w_rl"), largest_difference("emrld", "w_rl"), span("emrld-ws", "w_rl")),
        *(
            late_by_weight("emrld-ws", "w_bc", LEAST),
            MOST,
            late_by_weight("emrld-ws", "w_bc", MOST),
        ),
        *[min(late_seeds("emrld-ws", "w_bc", value)) for value in (LEAST, MOST)],
        min(late_by_weight("emrld-ws", "w_bc", value) for value in WEIGHTS[1:4]),
        *(MOST, *[largest_difference("emrld-ws", varied) for varied in ("w_rl", "w_bc")]),
        *(
            SENSITIVITY_END["emrld"],
            *[late_by_weight("emrld", "w_bc", value) for value in WEIGHTS[:4]],
        ),
        *(*WEIGHTS[:4], late_by_weight("emrld", "w_bc", MOST), MOST),
        *(HALFWAY, halfway("w_bc", LEAST), LEAST, halfway("w_bc", MOST), MOST),
        *[halfway("w_bc", value, "emrld-ws") for value in (LEAST, MOST)],
        *min_and_max(halfway("w_rl", value) for value in WEIGHTS),
    ],
    "08#switch-verdicts": lambda: [
        *(switch(CONTROL), switch_spread(CONTROL)),
        *map(switch, COSTLY),
        *(-switch_gaps()["sigma fixed at 1"].high, -switch_gaps()["sigma fixed at 1"].low),
        *min_and_max(small_switch_losses()),
        largest_switch_loss(),
        *min_and_max([rise for rise in switch_rises() if FLAT < rise < 0.1]),
        max(switch_rises()),
        *(
            TARGET,
            *waits_of(switch_runs(SHIPPED)[CONTROL]),
            waits_of(switch_runs(SHIPPED)["sigma fixed at 1"])[1],
        ),
        *[switch_seeds("advantages not normalised")[seed] for seed in (2, 0, 1)],
        *switch_seeds("released start of the network"),
    ],
    "09#robot-at-the-papers-drift": on_robot,
    "09#robot-without-heading-numbers": on_robot_without_heading,
    "09#robot-sweep-verdicts": robot_sweep,
    "09#controller-against-policies": lambda: [
        controller(None),
        min(robot("emrld-ws", AFTER, value=value).mean() for value in DRIVEN_DRIFTS),
        *(robot("emrld-ws", AFTER).mean(), controller(ROBOT_DRIFT)),
        *(0.8, robot("emrld", AFTER, value=0.8).mean()),
    ],
    "README#The paper's main claim holds where policies are sampled": lambda: [
        *(iterations("half_cheetah", "optimal"), at_the_first_budget()[0]),
        max(falls(*OURS)),
        max(falls(*OURS, quality="suboptimal")),
    ],
    "README#With good demonstrations it hangs on how a tested policy acts": lambda: [
        *by_mean("optimal", "meta-bc", "emrld"),
        *by_mean("suboptimal", "meta-bc", "emrld"),
        *[
            by_mean_on(w, "optimal", n)
            for w in (BOTH_WAYS, FORWARD, BACKWARD)
            for n in ("emrld", "meta-bc")
        ],
    ],
    "README#HalfCheetah's mean hides its two directions": lambda: [
        *means("optimal", "emrld", places=[FORWARD, BACKWARD]),
        *means("optimal", "gmps", places=[FORWARD, BACKWARD]),
        *means("optimal", "meta-bc", places=[FORWARD, BACKWARD]),
        *broken_down()[1:3],
    ],
    "README#RL in the adaptation is not what makes it work, here": lambda: [
        *[left("optimal", part).mean() for part in ("w_rl = 0", "EMRLD")],
        *[lost_at_most(without(q, "w_rl = 0")) for q in STEPS_SHOWN],
        *(lost_at_most(gap_of(FIXED_SIGMA)), lost_at_most(gap_of(TWO_WHEELED))),
        *[-unseen_gap(TWO_WHEELED_WARM)[end] for end in (0, 2, 1)],
        *unseen_gap(WITHOUT_RL_AGAIN),
        left("optimal", "w_bc = 0").mean(),
        *[training_scores(seeds).mean() for seeds in reversed(AS_PRINTED.runs(SHIPPED))],
        *[side.mean() for pair in CLONING_ALONE for side in pair.tested(SHIPPED)],
        *(scores("point2d", "optimal", "meta-bc").mean(), by_mean("optimal", "meta-bc")[0]),
        *[load_config(pair.runs(SHIPPED)[0][0]).meta_w_bc for pair in DOUBLE_USE[1:3]],
        *[pair.tested(SHIPPED)[0].mean() for pair in DOUBLE_USE[1:3]],
        load_config(DOUBLE_USE[3].runs(SHIPPED)[0][0]).meta_w_bc,
        lost_at_most(unseen_gap(DOUBLE_USE[3])),
    ],
    "README#Changing dynamics: two sentences of the paper decide": lambda: [
        *(drift("maml", 1), drift("emrld", 1), drift("maml", 0), drift("emrld-ws", 1)),
        *[drift(name, 1, HIDDEN) for name in ("emrld-ws", "maml")],
        drift_lead("emrld-ws", HIDDEN).low,
        drift("emrld", 1, HIDDEN),
        iterations(HIDDEN, "optimal", *OURS, "maml"),
        *[drift(name, 1, HIDDEN_LITERAL) for name in (*OURS, "maml")],
        min(drift_lead(name, HIDDEN_LITERAL).low for name in OURS),
        largest_steering(unseen_demonstrations(SEEN, "optimal", UNSEEN_TASKS), 1),
        *(1, 1),  # the end of the box
        *[after_cut(n, r, trained=True).mean() for r in (SEEN, HIDDEN) for n in OURS],
        lead_after_cut("emrld-ws", HIDDEN).low,
        NARROW_DRIFT,
        *[after_cut(name, SEEN, narrow=True).mean() for name in OURS],
        *[beyond(name, SEEN).mean() for name in ("maml", *OURS)],
    ],
    "README#On a robot that training never saw one step is enough": lambda: [
        ROBOT_DRIFT,
        *(robot("emrld-ws", stage).mean() for stage in (BEFORE, TRIAL, AFTER)),
        robot("emrld-ws", AFTER, score="truly").mean(),
        *[blind(name).mean() for name in ("emrld-ws", "emrld", "maml")],
        controller(ROBOT_DRIFT),
        *(robot(n, AFTER, "delay", 1.0).mean() for n in ("emrld-ws", "maml")),
    ],
    "README#The second-order meta-gradient, the network's start, normalised advantages, and the mean "
    "in the cloning loss matter": lambda: [
        *map(switch, COSTLY[:4]),
        switch(CONTROL),
        100,  # iterations
        switch("sigma fixed at 1"),
        np.ceil(
            max(
                lost_at_most(gap) for label, gap in switch_gaps().items() if label not in COSTLY[:5]
            )
        ),
        largest_switch_loss(),
    ],
    "README#The baselines got a search, and Meta-BC gains most": lambda: [
        SEARCH_END,
        *searched("point2d-optimal-meta-bc", "table1", "fixed-sigma"),
        *searched("two_wheeled-optimal-meta-bc", "table1", "fixed-sigma"),
        *searched("point2d-suboptimal-meta-bc", "table1", "fixed-sigma"),
        *above_one_nat("gmps", "point2d", "suboptimal"),
        *above_one_nat("gmps", "two_wheeled", "optimal"),
        *nats_of(unclipped()),
        *[TrustRegion().for_actions(dim).max_kl for dim in (2, 6)],
        max(largest_moves("point2d", "meta-bc")),
        *nats_of(gmps_on_point2d("suboptimal-gmps-first-order")),
        *[run_scores(seeds_of(SHIPPED, f"{env}-gmps-paths"), 1).mean() for env in PLENTIFUL],
        *means("optimal", "gmps", places=GOALS),
        max(searched("point2d-*-gmps", "*") + searched("two_wheeled-*-gmps", "*")),
        *[run_scores(unclipped(), 1).mean(), at(BOTH_WAYS, "optimal", "meta-bc").mean()],
        max(0.0, *searched("half_cheetah-*-gmps", "*"), *searched("half_cheetah-*-maml", "*")),
        *goals(),
        *[run_scores(seeds_of(SHIPPED, f"{env}-meta-bc-plentiful"), 1).mean() for env in PLENTIFUL],
        *[scores(env, "optimal", "meta-bc").mean() for env in PLENTIFUL],
        goals()[1],
        training_scores(seeds_of(SHIPPED, "point2d-meta-bc-paths")).mean(),
        run_scores(seeds_of(SHIPPED, "point2d-meta-bc-paths"), 1).mean(),
    ],
    "README#MAML does not fail everywhere": lambda: [
        level("point2d", "optimal", "maml"),
        load_config(stored_seeds(SHIPPED, "point2d", "optimal")["maml"][0]).iterations,
        *searched("two_wheeled-optimal-maml", "no-momentum", "table1"),
        *peaks_and_ends("two_wheeled", "maml"),
        max(searched("two_wheeled-*-maml", "unscaled", at_best=True)),
        scores("half_cheetah", "optimal", "maml").mean(),
        *[correct_side(name, BOTH_WAYS)[0] for name in ("maml", "emrld")],
        correct_lead().low,
    ],
    "README#Noise, not quality, decides whether TwoWheeled data can be copied": lambda: [],
    "README#A run is a draw, and none is lost": lambda: [
        TARGET,
        *(sum(wait is not None for wait in waits("emrld-ws")), len(waits("emrld-ws"))),
        *(median_and_latest(draws("emrld-ws"))[0], min(waits("emrld-ws"))),
        median_and_latest(draws("emrld-ws"))[1],
    ],
    "ledger#log-density": lambda: [
        *(TARGET, *waits_of(switch_runs(SHIPPED)["log-density of the joint action"])),
        *waits_of(switch_runs(SHIPPED)[CONTROL]),
    ],
    "ledger#fisher-product": lambda: [
        *(TrustRegion.fisher_samples, TrustRegion.damping, TrustRegion.cg_iterations),
        *starved(),
        *min_and_max(training_scores(seeds_of(SHIPPED, STARVED))),
        *min_and_max(
            training_scores(seeds_of(SHIPPED, "two_wheeled-suboptimal-emrld"), starved()[2])
        ),
    ],
    "ledger#claim-emrld-learns": lambda: [
        UNSEEN_TASKS,
        *[
            number
            for place in (*PLACES, BOTH_WAYS)
            for number in (*means("optimal", *OURS, places=[place]), best("optimal", place))
        ],
        0.9,  # the level, 90 %
        smallest_lead("optimal", (*GOALS, FORWARD)),
        lead("optimal", BOTH_WAYS, "emrld", 1).low,
        *lead("optimal", BOTH_WAYS, "emrld-ws", 1)[1:],
        iterations("half_cheetah", "optimal"),
        at_the_first_budget()[0],
        *at_the_first_budget()[-3:],
        *by_mean("optimal", "meta-bc"),
        by_mean_on(BOTH_WAYS, "optimal", "meta-bc"),
        *by_mean("optimal", "emrld"),
        by_mean_on(BOTH_WAYS, "optimal", "emrld"),
    ],
    "ledger#claim-warm-start": lambda: [
        30,
        *[end for env in PLENTIFUL for end in quicker("suboptimal", env)],
        *[quicker("optimal", env).estimate for env in PLENTIFUL],
        *[quicker(quality, "half_cheetah").estimate for quality in STEPS_SHOWN],
    ],
    "ledger#claim-monotone": lambda: [
        mean_falls(*OURS),
        mean_falls(*OURS, worlds=DRIFTS, qualities=["optimal"]),
        mean_falls("meta-bc"),
        mean_falls("meta-bc", worlds=DRIFTS, qualities=["optimal"]),
        max(falls(*OURS)),
        sum(len(stored_seeds(SHIPPED, env, "optimal")[name]) for env in TITLES for name in OURS),
        max(falls(*OURS, quality="suboptimal")),
        max(falls(*OURS, worlds=DRIFTS)),
    ],
    "ledger#claim-suboptimal": lambda: [
        *[
            number
            for place in PLACES
            for number in (*means("suboptimal", *OURS, places=[place]), best("suboptimal", place))
        ],
        0.9,  # the level, 90 %
        *[np.floor(smallest_lead("suboptimal", (*PLACES, BOTH_WAYS), step)) for step in (1, 3)],
    ],
    "ledger#claim-one-step": lambda: [
        np.floor(10 * least_share_after_one_step()) / 10,
        UNSEEN_TASKS,
        *min_and_max(each("two_wheeled", "optimal", "emrld")),
        *min_and_max(each("two_wheeled", "optimal", "emrld-ws")),
        *[
            end
            for place in (FORWARD, BACKWARD)
            for name in OURS
            for end in min_and_max(at(place, "optimal", name))
        ],
    ],
    "ledger#claim-maml-fails": lambda: [
        load_config(seeds_of(SHIPPED, "point2d-optimal-maml")[0]).iterations,
        *min_and_max(training_scores(seeds_of(SHIPPED, "point2d-optimal-maml"))),
        load_config(seeds_of(SHIPPED, "point2d-optimal-maml-xavier")[0]).iterations,
        *min_and_max(training_scores(seeds_of(SHIPPED, "point2d-optimal-maml-xavier"))),
        *peaks_and_ends("two_wheeled", "maml"),
        scores("point2d", "optimal", "maml").mean(),
        *min_and_max(each("two_wheeled", "optimal", "maml")),
        *means("optimal", "maml", places=[FORWARD, BACKWARD]),
        *correct_side("maml", FORWARD, BACKWARD),
        load_config(paid_correctly("maml")[0]).iterations,
    ],
    "ledger#claim-gmps-fails": lambda: [
        *means("optimal", "gmps"),
        *above_one_nat("gmps", "two_wheeled", "optimal"),
        *above_one_nat("gmps", "point2d", "optimal"),
        *above_one_nat("gmps", "half_cheetah", "optimal"),
        *above_one_nat("gmps", "point2d", "suboptimal"),
        *nats_of(gmps_on_point2d("suboptimal-gmps-first-order")),
        *nats_of(gmps_on_point2d("suboptimal-gmps-rate0.002-long")),
        *[end for env in PLENTIFUL for end in nats_of(seeds_of(SHIPPED, f"{env}-gmps-paths"))],
        *[run_scores(seeds_of(SHIPPED, f"{env}-gmps-paths"), 1).mean() for env in PLENTIFUL],
    ],
    "ledger#claim-meta-bc-fails": lambda: [
        *means("optimal", "meta-bc")[:2],
        max(largest_moves("point2d", "meta-bc")),
        *falls("meta-bc", worlds=["two_wheeled"]),
        *nats_of(unclipped()),
        TrustRegion().for_actions(6).max_kl,
        *goals(),
        *[run_scores(seeds_of(SHIPPED, f"{env}-meta-bc-plentiful"), 1).mean() for env in PLENTIFUL],
        *by_mean("optimal", "meta-bc"),
        1,  # sigma
        *cloned_both_ways(),
        *broken_down(),
        run_scores(unclipped(), 1).mean(),
        at(BOTH_WAYS, "optimal", "meta-bc").mean(),
    ],
    "ledger#claim-bad-data-limits-cloning": lambda: [
        *better_data(),
        *(restricted("gmps")[1].estimate, *restricted("gmps")[1][1:]),
        better_for("meta-bc").estimate,
        *(restricted("gmps")[3].estimate, -restricted("gmps")[2].estimate),
        *[end for place in PLACES[:2] for end in min_and_max(data_alone("meta-bc", place))],
    ],
    "ledger#claim-run-time": lambda: [
        *min_and_max(minutes(*PLENTIFUL)),
        *min_and_max(iterations_of(*PLENTIFUL)),
        *min_and_max(minutes("half_cheetah")),
        *sorted(set(iterations_of("half_cheetah"))),
    ],
    "ledger#claim-drift": lambda: [
        UNSEEN_TASKS,
        *[drift(name, 1) for name in (*OURS, "maml")],
        drift("maml", 0),
        *[drift(name, 1) for name in ("meta-bc", "gmps")],
        *drift_lead("emrld-ws")[1:],
        drift_lead("emrld").high,
        *[drift(name, 1, HIDDEN) for name in (*OURS, "maml")],
        *drift_lead("emrld-ws", HIDDEN)[1:],
        *drift_lead("emrld", HIDDEN)[1:],
        *[drift(name, 1, SEEN_LITERAL) for name in (*OURS, "maml")],
        *[drift(name, 1, HIDDEN_LITERAL) for name in (*OURS, "maml")],
        min(drift_lead(name, HIDDEN_LITERAL).low for name in OURS),
        *[drift(name, 1, reading) for name in ("meta-bc", "gmps") for reading in PRINTED],
        *map(cloned_by_the_mean, (SEEN, SEEN_LITERAL)),
        NARROW_DRIFT,
        *[beyond(n, SEEN).mean() for n in (*OURS, "maml")],
        largest_steering(unseen_demonstrations(SEEN, "optimal", UNSEEN_TASKS), 1),
        *(1, 1),  # the end of the box
        *[after_cut(n, SEEN, narrow=True).mean() for n in OURS],
        *[beyond(n, r).mean() for r in DRIFTS[1:] for n in (*OURS, "maml")],
        shorter_step(HIDDEN_LITERAL)[0].adapt_lr,
        shorter_step(HIDDEN_LITERAL)[1].mean(),
        *[after_cut(n, SEEN, trained=True).mean() for n in OURS],
        after_cut("meta-bc", SEEN, trained=True).mean(),
        after_cut("gmps", SEEN, SAMPLED, trained=True).mean(),
        *[after_cut(n, HIDDEN, trained=True).mean() for n in OURS],
        *[after_cut(n, HIDDEN).mean() for n in OURS],
        lead_after_cut("emrld-ws", HIDDEN).low,
        *[
            end
            for reading in (SEEN, HIDDEN, HIDDEN_LITERAL)
            for end in searched(f"{reading}-optimal-maml", "no-momentum")
        ],
        *(SEARCH_END, iterations(SEEN, "optimal")),
    ],
    "ledger#claim-robot-one-step": lambda: [
        *(ROBOT_DRIFT, ROBOT_TRIALS),
        *[number for n in OURS for number in (robot(n, BEFORE).mean(), robot(n, AFTER).mean())],
        robot("emrld", AFTER, score="truly").mean(),
        *[robot(n, AFTER).mean() for n in ("meta-bc", "gmps", "maml")],
        *[number for n in OURS for number in (blind(n, BEFORE).mean(), blind(n).mean())],
        *[blind(n, score="reached").mean() for n in OURS],
    ],
    "ledger#claim-robot-maml": lambda: [
        *(blind("maml").mean(), blind("maml", score="reached").mean()),
        *[shift_interval(blind(n), blind("maml")).low for n in OURS],
        *(robot("maml", stage).mean() for stage in (BEFORE, AFTER)),
    ],
    "ledger#claim-robot-meta-policy": lambda: [
        *min_and_max(robot("emrld", BEFORE)),
        *min_and_max(robot("emrld-ws", BEFORE)),
    ],
    "ledger#claim-robot-far": lambda: [
        *[robot(n, AFTER, value=0.8).mean() for n in (*OURS, "maml")],
        *[robot(n, AFTER, "delay", 1.0).mean() for n in (*OURS, "maml")],
        controller(None),
    ],
    "ledger#claim-sensitivity": lambda: [
        *(WINDOW, SENSITIVITY_END["emrld"], *[late_by_weight("emrld", "w_bc", v) for v in WEIGHTS]),
        *(LEAST, MOST, span("emrld", "w_rl"), 1, largest_difference("emrld", "w_rl")),
        SENSITIVITY_END["emrld-ws"],
        *[span("emrld-ws", varied) for varied in ("w_rl", "w_bc")],
        *[largest_difference("emrld-ws", varied) for varied in ("w_rl", "w_bc")],
        *(HALFWAY, halfway("w_bc", MOST), MOST, halfway("w_bc", LEAST), LEAST),
        *min_and_max(halfway("w_rl", value) for value in WEIGHTS),
        *(LEAST, MOST),
    ],
    "ledger#claim-ablation-cloning": lambda: [
        ABLATION_END - WINDOW + 1,
        ABLATION_END,
        *without_cloning(),
    ],
    "ledger#claim-ablation-rl": lambda: [
        *[left(q, part).mean() for q in STEPS_SHOWN for part in ("w_rl = 0", "EMRLD")],
        *[lost_at_most(without(q, "w_rl = 0")) for q in STEPS_SHOWN],
        lost_at_most(gap_of(TWO_WHEELED)),
        *[-unseen_gap(TWO_WHEELED_WARM)[end] for end in (0, 2, 1)],
        *unseen_gap(WITHOUT_RL_AGAIN),
        *[training_scores(seeds).mean() for seeds in reversed(AS_PRINTED.runs(SHIPPED))],
    ],
    "ledger#claim-double-use": lambda: [
        ABLATION_END,
        *[side.mean() for side in DOUBLE_USE[0].tested(SHIPPED)],
        *[pair.tested(SHIPPED)[0].mean() for pair in DOUBLE_USE[1:3]],
        *[load_config(pair.runs(SHIPPED)[0][0]).meta_w_bc for pair in DOUBLE_USE[1:]],
        lost_at_most(unseen_gap(DOUBLE_USE[3])),
    ],
    "ledger#switches": lambda: [
        *(UNSEEN_TASKS, 100),
        *map(switch, switch_runs(SHIPPED)),
    ],
}


def draws(algorithm, env="point2d", lot="own", options=""):
    """Return the stored draws of a training under one lot, on one thread."""
    kind = (env, algorithm, options, lot, 1)
    return [
        draw
        for draw in load_draws()
        if (draw.env, draw.algorithm, draw.options, draw.lot, draw.threads) == kind
    ]


def waits(algorithm, **kind):
    """Return how many iterations each draw took to its target, None where it was not reached."""
    return [draw.reached for draw in draws(algorithm, **kind)]


def said():
    """Return every text with claims by its key."""
    measured = [measured_paragraphs(number) for number in ("07", "08", "09")]
    return {key: text for part in (*measured, findings(), ledger()) for key, text in part.items()}


@pytest.mark.parametrize("key", sorted(CLAIMS))
def test_the_prose_says_what_the_runs_say(key):
    stated, computed = numbers(said()[key]), CLAIMS[key]()
    shown = f"{[number for number, _ in stated]} stated, {[round(float(c), 3) for c in computed]} computed"
    assert len(stated) == len(computed), shown
    for (number, half_a_unit), value in zip(stated, computed, strict=True):
        assert abs(number - value) <= half_a_unit + 1e-9, shown


@pytest.mark.parametrize("env", EARNED)
def test_demonstrators_earned_what_their_files_say(env):
    assert EARNED[env] == demonstrated(env)


def test_every_finding_is_covered():
    texts = [key for key in said() if not key.startswith("ledger")]
    covered = {key for key in CLAIMS if not key.startswith("ledger")} | {NOT_STORED}
    assert set(texts) == covered


def test_numbers_are_found_as_they_are_written():
    text = "Point2D (Fig. 3, notebook 05): `x 9`, $w_1$ earns 74.5 and −9.0, or 3 % of 150 steps."
    assert numbers(text) == [(74.5, 0.05), (-9.0, 0.05), (0.03, 0.005), (150.0, 0.5)]
