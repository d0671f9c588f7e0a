"""Every number that the prose says of the stored runs is computed from them again.

Covered are the README's findings, the ledger's rows named in CLAIMS, and in notebooks 07 and 08 each
paragraph that begins with "**Measured.**" and the table of the paper's claims. A number that is added,
taken away or changed fails here until its computation says the same.
"""

import re
import tomllib
from pathlib import Path

import jupytext
import numpy as np
import pytest

from emrld_lite.demonstrations import load, load_demonstrations
from emrld_lite.experiments.evaluation import UNSEEN_TASKS
from emrld_lite.experiments.intervals import bootstrap_interval
from emrld_lite.experiments.lottery import TARGET, load_draws, median_and_latest
from emrld_lite.experiments.results import (
    EARNED,
    FLAT,
    STEPS_SHOWN,
    TITLES,
    largest_fall,
    late_rise,
    run_scores,
    seeds_of,
    stored_seeds,
    training_scores,
)
from emrld_lite.experiments.runs import SHIPPED, load_config, load_curve
from emrld_lite.experiments.studies import (
    AS_STORED,
    CONTROL,
    SENSITIVITY_END,
    STUDY_END,
    WEIGHTS,
    sensitivity_runs,
    switch_runs,
)
from emrld_lite.trpo import TrustRegion

ROOT = Path(__file__).resolve().parent.parent
NUMBER = re.compile(r"(?<![-\w.,/])([+-]?\d+(?:\.\d+)?)( ?%)?(?![\w/])")
PLACES = r"(?:Figs?\.|Figures?|Section|Table|notebooks?) \d+(?:(?:,| to| and) \d+)*"
NOT_A_RESULT = re.compile(rf"`[^`]*`|\$[^$]*\$|\[[^]]*\]\([^)]*\)|{PLACES}")


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
                found[f"{number}#{tag}"] = paragraph
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
ELSEWHERE = (
    ("point2d", "optimal", "emrld-ws"),
    ("point2d", "suboptimal", "emrld-ws"),
    ("two_wheeled", "suboptimal", "emrld"),
    ("two_wheeled", "suboptimal", "emrld-ws"),
    ("half_cheetah", "suboptimal", "emrld", 250),
)
NOT_STORED = (
    "README#Later adaptation steps need a smaller rate"  # evaluate --later-rate 1 prints it
)
OURS, BASELINES = ("emrld", "emrld-ws"), ("maml", "meta-bc", "gmps")
THEN = AS_STORED["trust_region"]
STARVED = "starved-two_wheeled-suboptimal-emrld"
LEAST, MOST = WEIGHTS[0], WEIGHTS[-1]
HALFWAY = 35  # of a return of about 70, by which the panels of Fig. 7 are compared
WINDOW = 10  # iterations over which a late return is a mean


def scores(env, quality, name, step=None):
    """Return the score of each seed on unseen tasks, by default after the steps the paper shows."""
    seeds = stored_seeds(SHIPPED, env, quality)[name]
    return run_scores(seeds, STEPS_SHOWN[quality] if step is None else step)


def means(quality, *names):
    """Return each algorithm's mean score in each world, world by world."""
    return [scores(env, quality, name).mean() for env in TITLES for name in names]


def best(quality):
    """Return the best baseline's mean score in each world."""
    return [max(scores(env, quality, name).mean() for name in BASELINES) for env in TITLES]


def smallest_gap(quality):
    """Return the least lower end of the intervals of our variants less the best baseline."""
    lows = []
    for env in TITLES:
        table = {name: scores(env, quality, name) for name in BASELINES}
        baseline = max(table.values(), key=np.mean)
        lows += [bootstrap_interval([scores(env, quality, name)], [baseline]).low for name in OURS]
    return min(lows)


def falls(*names, quality="optimal", worlds=tuple(TITLES)):
    """Return the largest fall of the ten-iteration mean in each world, worst seed of the algorithms."""
    found = []
    for env in worlds:
        seeds = stored_seeds(SHIPPED, env, quality)
        found.append(max(largest_fall(run) for name in names for run in seeds[name]))
    return found


def restricted(name):
    """Return the intervals of optimal less sub-optimal data after one step, world by world."""
    pairs = [[scores(env, quality, name, step=1) for quality in STEPS_SHOWN] for env in TITLES]
    return [bootstrap_interval([good], [bad]) for good, bad in pairs]


def share(quality, name):
    """Return the share of the demonstrator's return, an interquartile mean over the worlds' runs."""
    strata = [scores(env, quality, name) / EARNED[env] for env in TITLES]
    return bootstrap_interval(strata).estimate


def drift(name, step):
    seeds = stored_seeds(SHIPPED, "two_wheeled_drift", "optimal")[name]
    return run_scores(seeds, step).mean()


def rise(env, quality, name):
    """Return the steepest seed's rise over the last twenty iterations, as a share."""
    return max(late_rise(run) for run in stored_seeds(SHIPPED, env, quality)[name]) / EARNED[env]


def rise_at_250():
    """Return what the rise of HalfCheetah's steepest sub-optimal run was at iteration 250."""
    rises = []
    for name in OURS:
        seeds = stored_seeds(SHIPPED, "half_cheetah", "suboptimal")[name]
        ends = [training_scores(seeds, end, window=20) for end in (250, 230)]
        rises += list(ends[0] - ends[1])
    return max(rises) / EARNED["half_cheetah"]


def demonstrated(env):
    """Return what the optimal demonstrator earned, before any cut, by its own file."""
    return float(
        re.search(r"mean sparse return ([\d.]+)", load_demonstrations("optimal", env).maker)[1]
    )


def iterations(env, quality):
    """Return the iterations of our runs in a world, of which all have as many."""
    seeds = [seed for name in OURS for seed in stored_seeds(SHIPPED, env, quality)[name]]
    (count,) = {load_config(seed).iterations for seed in seeds}
    return count


def goals():
    """Return the number of goals in the plentiful data, and in the others of the same worlds."""
    (plenty,) = {
        len(load(ROOT / load_config(SHIPPED / f"{env}-plentiful-meta-bc-seed0").demos).tasks)
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


def largest_kl(name):
    """Return the least over two worlds of the largest KL of a single update of seed 0, nats."""
    seeds = [stored_seeds(SHIPPED, env, "optimal")[name][0] for env in PLENTIFUL]
    return min(max(row.kl for row in load_curve(seed / "curve.csv")) for seed in seeds)


def least_share_after_one_step():
    """Return the least share of its last training return that one step on unseen Point2D goals gives."""
    pairs = [("emrld", "optimal"), ("emrld", "suboptimal"), ("emrld-ws", "optimal")]
    seeds = [
        seed for name, quality in pairs for seed in stored_seeds(SHIPPED, "point2d", quality)[name]
    ]
    return min(
        run_scores([seed], 1)[0] / load_curve(seed / "curve.csv")[-1].return_after for seed in seeds
    )


def late(name, end=None):
    """Return the mean return of a study's runs over the last ten iterations."""
    return training_scores(seeds_of(SHIPPED, name), end).mean()


def without_rl(env, quality, name, end=STUDY_END):
    """Return the interval of the late return without RL in the adaptation, less the control's."""
    stem = f"ablation-{env}-{quality}-{name}-w_rl0.0"
    sides = (seeds_of(SHIPPED, stem), seeds_of(SHIPPED, f"{env}-{quality}-{name}"))
    without, control = (training_scores(seeds, end) for seeds in sides)
    return bootstrap_interval([without], [control])


def weights(name, varied):
    """Return the runs of a panel of Fig. 7 by the weight."""
    return sensitivity_runs(SHIPPED, name, varied)


def halfway(varied, value):
    """Return the first iteration at which EMRLD's mean return over seeds is above HALFWAY."""
    curves = [
        load_curve(run / "curve.csv")[:SENSITIVITY_END] for run in weights("emrld", varied)[value]
    ]
    means_by_iteration = [
        np.mean([row.return_after for row in rows]) for rows in zip(*curves, strict=True)
    ]
    return next(iteration for iteration, mean in enumerate(means_by_iteration) if mean > HALFWAY)


def min_and_max(values):
    ordered = sorted(values)
    return ordered[0], ordered[-1]


def span(name, varied):
    """Return the largest less the smallest mean late return of a panel of Fig. 7."""
    panel = sensitivity_runs(SHIPPED, name, varied)
    late_means = [training_scores(seeds, SENSITIVITY_END).mean() for seeds in panel.values()]
    return max(late_means) - min(late_means)


def switch(label):
    """Return the mean score of a switch's runs on unseen goals."""
    return run_scores(switch_runs(SHIPPED)[label], 1).mean()


def each(env, quality, name):
    """Return the scores of the seeds, sorted."""
    return sorted(scores(env, quality, name))


def claim_ablation():
    return [
        late("ablation-optimal-w_bc0.0"),
        late("point2d-optimal-emrld"),
        late("point2d-optimal-maml"),
        late("point2d-suboptimal-emrld", STUDY_END),
        late("ablation-optimal-w_rl0.0"),
        late("ablation-suboptimal-w_rl0.0"),
    ]


CLAIMS = {
    "07#ahead-optimal": lambda: [
        *means("optimal", *OURS),
        *best("optimal"),
        smallest_gap("optimal"),
    ],
    "07#monotone": lambda: [
        max(falls(*OURS)),
        min(falls("meta-bc")),
        max(falls("meta-bc")),
        *means("optimal", "gmps"),
        scores("point2d", "optimal", "maml").mean(),
        scores("half_cheetah", "optimal", "maml").mean(),
        *each("two_wheeled", "optimal", "maml")[1:],
        each("two_wheeled", "optimal", "maml")[0],
        each("half_cheetah", "optimal", "meta-bc")[0],
        each("half_cheetah", "optimal", "meta-bc")[-1],
    ],
    "07#ahead-suboptimal": lambda: [
        *means("suboptimal", *OURS),
        *best("suboptimal"),
        smallest_gap("suboptimal"),
    ],
    "07#restricted-by-the-data": lambda: [
        restricted("meta-bc")[0].estimate,
        restricted("meta-bc")[1].estimate,
        restricted("meta-bc")[2].low,
        restricted("meta-bc")[2].high,
        max(abs(gap.estimate) for gap in restricted("gmps")),
    ],
    "07#pooled": lambda: [
        *[share(quality, name) for quality in STEPS_SHOWN for name in OURS],
        *[max(share(quality, name) for name in BASELINES) for quality in STEPS_SHOWN],
    ],
    "07#drift-claims": lambda: [
        *[drift(name, 1) for name in ("emrld", "emrld-ws", "maml")],
        drift("maml", 0),
        demonstrated("two_wheeled_drift"),
        *[drift(name, 1) for name in ("meta-bc", "gmps")],
    ],
    "07#flattened": lambda: [
        FLAT,
        max(rise(env, q, name) for env in TITLES for q in STEPS_SHOWN for name in (*OURS, "maml")),
        iterations("half_cheetah", "optimal"),
        rise_at_250(),
        iterations("half_cheetah", "suboptimal"),
        rise("two_wheeled", "optimal", "meta-bc"),
        rise("two_wheeled", "optimal", "gmps"),
    ],
    "08#ablation-verdicts": claim_ablation,
    "08#without-rl-elsewhere": lambda: [without_rl(*where).estimate for where in ELSEWHERE],
    "08#sensitivity-verdicts": lambda: [
        *[span(name, varied) for name in OURS for varied in ("w_rl", "w_bc")],
        MOST,
        *[np.ptp(training_scores(weights(name, "w_bc")[MOST], SENSITIVITY_END)) for name in OURS],
        *(MOST, HALFWAY, halfway("w_bc", MOST), LEAST, halfway("w_bc", LEAST)),
        *min_and_max(halfway("w_rl", value) for value in WEIGHTS),
    ],
    "08#switch-verdicts": lambda: [
        switch(CONTROL),
        switch("first-order meta-gradient"),
        switch("cloning loss summed"),
    ],
    "README#The paper's main claim holds": lambda: [
        max(falls(*OURS)),
        max(falls(*OURS, quality="suboptimal")),
    ],
    "README#RL in the adaptation is not what makes it work": lambda: [
        late("ablation-optimal-w_rl0.0"),
        late("point2d-optimal-emrld"),
        late("ablation-optimal-w_bc0.0"),
    ],
    "README#Changing dynamics: not reproduced": lambda: [
        drift("maml", 1),
        drift("emrld", 1),
        drift("maml", 0),
    ],
    "README#The second-order meta-gradient and the mean in the cloning loss matter": lambda: [
        switch("first-order meta-gradient"),
        switch("cloning loss summed"),
        switch(CONTROL),
    ],
    "README#The baselines had their chance": lambda: [
        *goals(),
        *[run_scores([SHIPPED / f"{env}-plentiful-meta-bc-seed0"], 1)[0] for env in PLENTIFUL],
    ],
    "README#MAML does not fail everywhere": lambda: [
        each("two_wheeled", "optimal", "maml")[1],
        scores("half_cheetah", "optimal", "maml").mean(),
    ],
    "README#Meta-BC half works on HalfCheetah": lambda: [
        end
        for quality in STEPS_SHOWN
        for name in ("meta-bc", "emrld")
        for end in each("half_cheetah", quality, name)[::2]
    ],
    "README#Noise, not quality, decides whether TwoWheeled data can be copied": lambda: [],
    "README#A run is a draw, and none is lost": lambda: [
        TARGET,
        *(sum(wait is not None for wait in waits("emrld-ws")), len(waits("emrld-ws"))),
        *(median_and_latest(draws("emrld-ws"))[0], min(waits("emrld-ws"))),
        median_and_latest(draws("emrld-ws"))[1],
    ],
    "README#A starved trust region costs a seed": lambda: [
        *sorted(training_scores(seeds_of(SHIPPED, STARVED))),
        late("two_wheeled-suboptimal-emrld", STUDY_END),
    ],
    "ledger#fisher-product": lambda: [
        *(TrustRegion.fisher_samples, TrustRegion.damping),
        *(THEN.fisher_samples, THEN.damping),
        *starved(),
        *sorted(training_scores(seeds_of(SHIPPED, STARVED))),
        late("two_wheeled-suboptimal-emrld", STUDY_END),
    ],
    "ledger#claim-emrld-learns": lambda: [
        *(UNSEEN_TASKS, *means("optimal", *OURS)[:2], best("optimal")[0]),
        *(*means("optimal", *OURS)[2:4], best("optimal")[1]),
        *(*means("optimal", *OURS)[4:], best("optimal")[2]),
        np.floor(smallest_gap("optimal")),
    ],
    "ledger#claim-monotone": lambda: [
        max(falls(*OURS)),
        sum(len(stored_seeds(SHIPPED, env, "optimal")[name]) for env in TITLES for name in OURS),
        max(falls(*OURS, quality="suboptimal")),
        *falls(*OURS, worlds=["two_wheeled_drift"]),
        min(falls("meta-bc")),
        max(falls("meta-bc")),
    ],
    "ledger#claim-suboptimal": lambda: [
        *(*means("suboptimal", *OURS)[:2], best("suboptimal")[0]),
        *(*means("suboptimal", *OURS)[2:4], best("suboptimal")[1]),
        *(*means("suboptimal", *OURS)[4:], best("suboptimal")[2]),
        np.floor(smallest_gap("suboptimal")),
    ],
    "ledger#claim-one-step": lambda: [
        np.floor(10 * least_share_after_one_step()) / 10,
        UNSEEN_TASKS,
        *each("two_wheeled", "optimal", "emrld")[::2],
        *each("two_wheeled", "optimal", "emrld-ws")[::2],
        *each("half_cheetah", "optimal", "emrld")[::2],
        *each("half_cheetah", "optimal", "emrld-ws")[::2],
    ],
    "ledger#claim-maml-fails": lambda: [
        load_config(seeds_of(SHIPPED, "point2d-optimal-maml-xavier")[0]).iterations,
        *sorted(training_scores(seeds_of(SHIPPED, "point2d-optimal-maml")))[::2],
        *sorted(training_scores(seeds_of(SHIPPED, "point2d-optimal-maml-xavier")))[::2],
        scores("point2d", "optimal", "maml").mean(),
        *each("two_wheeled", "optimal", "maml")[::2],
        scores("half_cheetah", "optimal", "maml").mean(),
    ],
    "ledger#claim-gmps-fails": lambda: means("optimal", "gmps"),
    "ledger#claim-meta-bc-fails": lambda: [
        *means("optimal", "meta-bc")[:2],
        min(falls("meta-bc")[:2]),
        min(1.0, largest_kl("meta-bc")),  # more than a nat
        TrustRegion().for_actions(2).max_kl,
        *goals(),
        *each("half_cheetah", "optimal", "meta-bc")[::2],
    ],
    "ledger#claim-bad-data-limits-cloning": lambda: [
        *[gap.estimate for gap in restricted("meta-bc")[:2]],
        restricted("meta-bc")[2].low,
        restricted("meta-bc")[2].high,
        max(abs(gap.estimate) for gap in restricted("gmps")),
    ],
    "ledger#claim-drift": lambda: [
        UNSEEN_TASKS,
        *[drift(name, 1) for name in (*OURS, "maml")],
        drift("maml", 0),
        *[drift(name, 1) for name in ("meta-bc", "gmps")],
    ],
    "ledger#claim-sensitivity": lambda: [
        *(SENSITIVITY_END - WINDOW + 1, SENSITIVITY_END),
        *[span(name, varied) for name in OURS for varied in ("w_rl", "w_bc")],
        *(HALFWAY, halfway("w_bc", MOST), MOST, halfway("w_bc", LEAST), LEAST),
    ],
    "ledger#claim-ablation-cloning": lambda: [
        STUDY_END - WINDOW + 1,
        STUDY_END,
        *claim_ablation()[:4],
    ],
    "ledger#claim-ablation-rl": lambda: [
        late("ablation-optimal-w_rl0.0"),
        late("point2d-optimal-emrld"),
        late("ablation-suboptimal-w_rl0.0"),
        late("point2d-suboptimal-emrld", STUDY_END),
    ],
    "ledger#switches": lambda: [UNSEEN_TASKS, *map(switch, switch_runs(SHIPPED))],
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
    return measured_paragraphs("07") | measured_paragraphs("08") | findings() | ledger()


@pytest.mark.parametrize("key", sorted(CLAIMS))
def test_the_prose_says_what_the_runs_say(key):
    stated, computed = numbers(said()[key]), CLAIMS[key]()
    shown = f"{[number for number, _ in stated]} stated, {[round(float(c), 3) for c in computed]} computed"
    assert len(stated) == len(computed), shown
    for (number, half_a_unit), value in zip(stated, computed, strict=True):
        assert abs(number - value) <= half_a_unit + 1e-9, shown


@pytest.mark.parametrize("env", TITLES)
def test_demonstrators_earned_what_their_files_say(env):
    assert EARNED[env] == demonstrated(env)


def test_every_finding_is_covered():
    texts = measured_paragraphs("07") | measured_paragraphs("08") | findings()
    covered = {key for key in CLAIMS if not key.startswith("ledger")} | {NOT_STORED}
    assert set(texts) == covered


def test_numbers_are_found_as_they_are_written():
    text = "Point2D (Fig. 3, notebook 05): `x 9`, $w_1$ earns 74.5 and −9.0, or 3 % of 150 steps."
    assert numbers(text) == [(74.5, 0.05), (-9.0, 0.05), (0.03, 0.005), (150.0, 0.5)]
