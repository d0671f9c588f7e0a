# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
#   kernelspec:
#     display_name: Python 3 (ipykernel)
#     language: python
#     name: python3
# ---

# %% [markdown]
# # 07 · Results: the paper's figures, and how far to trust them
#
# Five algorithms, three environments, good and bad demonstrations, and a few seeds of each. The paper draws the curves and says
# what they show. In this notebook you build the interval that judges such sentences, measure how often it is wrong, and then let it judge
# the paper's claims one by one, on runs that are stored beside this notebook.
#
# **You will be able to**
#
# - measure how often a rule calls one of two equal algorithms better, and build a rule whose error is known,
# - say how many seeds a gap of a given size needs,
# - find what a mean over tasks hides,
# - read whether a curve has ended its rise, and whether a training has broken down.
#
# **You need** notebooks 05 (MAML, Meta-BC, GMPS) and 06 (EMRLD). **Time** The core, sections 1 to 6, is planned for 94 minutes, of which the
# machine computes less than one; sections 7 to 13 are further reading, planned for 63. **Paper** Section 4 (experiments), Figs. 3 to 6, of
# Rengarajan et al., NeurIPS 2022.

# %%
import math
import tempfile
from itertools import combinations
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import torch
from IPython.display import display

from emrld_lite import losses, policy
from emrld_lite.adapt import adapt
from emrld_lite.algorithms import ALGORITHMS
from emrld_lite.classroom import checks as check
from emrld_lite.classroom import few_seeds
from emrld_lite.classroom.clock import Clock
from emrld_lite.classroom.made_up_curves import curves_to_read, trainings
from emrld_lite.classroom.predict import Guesses
from emrld_lite.classroom.sketches.deals import rank_deals
from emrld_lite.classroom.widgets import drift as drift_widget
from emrld_lite.classroom.widgets import seeds as seeds_widget
from emrld_lite.demonstrations import load_demonstrations
from emrld_lite.demonstrators.recipes import unseen_demonstrations
from emrld_lite.envs import make
from emrld_lite.experiments import (
    drift_figures,
    elsewhere,
    machine,
    paper_figures,
    plotting,
    results,
    runs,
)
from emrld_lite.experiments.evaluation import (
    BY_MEAN,
    CUT,
    SAMPLED,
    cloning_before_and_after_warm_start,
    evaluate_run,
    testing_demonstrations,
)
from emrld_lite.experiments.intervals import (
    Interval,
    interquartile_mean,
    median_coverage,
    shift_interval,
    verdict,
    worst_to_best,
)
from emrld_lite.experiments.results import (
    BOTH_WAYS,
    EARNED,
    FLAT,
    PLACES,
    STEPS_SHOWN,
    TITLES,
    largest_fall,
    run_scores,
    seeds_of,
    stored_seeds,
    task_scores,
    training_scores,
)
from emrld_lite.experiments.studies import CUT_READINGS, NARROW_DRIFT, READINGS, SHORTER_STEP
from emrld_lite.learners.base import TaskData
from emrld_lite.policy import without_noise
from emrld_lite.rollout import collect, episode_returns
from emrld_lite.storage import read_json
from emrld_lite.trpo import TrustRegion

# %%
plotting.use_style()
torch.set_num_threads(1)  # leaves the other cores to you
guess = Guesses()
clock = Clock(
    {
        "how sure can a few runs make us": 48,
        "good demonstrations": 18,
        "bad demonstrations": 6,
        "changing dynamics": 11,
        "has the curve ended its rise": 8,
        "the paper's claims": 3,
    },
    further={
        "more about good demonstrations": 12,
        "the later steps": 8,
        "all environments at once": 7,
        "one run again": 10,
        "why gmps breaks down": 8,
        "drifts never met": 10,
        "what the demonstrator asks for": 8,
    },
)
OURS, BASELINES = ("emrld", "emrld-ws"), ("maml", "meta-bc", "gmps")
WORLDS = (*TITLES, "two_wheeled_drift")

# %% [markdown]
# ## 1 · How sure can a few runs make us?
#
# A *run* is one training from one seed. Its policy is then tested on *test tasks*: it adapts to each of them, and we measure its mean
# return. So an experiment is a table of returns $x_{s,i}$, of seed $s$ on test task $i$. The runs lie in
# `data/runs/`, each with the command that made it: five seeds per algorithm and environment. EMRLD and EMRLD-WS have Table 1's values; the baselines have what a small search chose for them on the training tasks (notebook 05). On Point2D and TwoWheeled the test tasks are twenty random goals that no training used. HalfCheetah
# has only two tasks, forward and backward, and as in the paper they serve for training *and* test; there, nothing is unseen.

# %% tags=["scores"]
clock.at("how sure can a few runs make us")
stored = stored_seeds(runs.SHIPPED, "two_wheeled", "optimal")
returns = {name: task_scores(stored[name], step=1) for name in ("emrld", "meta-bc")}
figure, axes = plt.subplots(figsize=(7.4, 3.2))
ticks = {}
for place, (name, table) in enumerate(returns.items()):  # table: (seed, task)
    look = {key: plotting.LOOKS[name][key] for key in ("color", "marker")}
    for seed, row in enumerate(table):
        where = (len(table) + 0.8) * place + seed
        ticks[where] = f"{plotting.label(name)}\nseed 0" if seed == 0 else str(seed)
        spread = np.linspace(-0.3, 0.3, len(row))
        axes.plot(where + spread, row, linestyle="none", markersize=4, **look)
        axes.plot([where - 0.35, where + 0.35], [row.mean()] * 2, color="black")
axes.set_xticks(list(ticks), list(ticks.values()))
axes.set_ylabel("return on a test task")
plt.show()

# %% [markdown]
# *Figure 1. TwoWheeled, optimal demonstrations: the return on each of twenty unseen goals (a dot) after one adaptation step,
# and their mean (a line), seed by seed. The dots of one seed belong together: they share one policy.*
#
# The paper plots average returns, so a run's **score** is its mean over the test tasks: the lines. As many seeds, as many scores.
#
# **How different could the scores' mean have been,** had we drawn other seeds? The *bootstrap* answers
# by drawing from what we have: make a new experiment by drawing runs *with replacement* from the table, compute its mean, and repeat this a few thousand
# times. A tempting shortcut: the table holds a number for every seed and every task, twenty times as many, so draw single numbers.
#
# **Predict first.** Will the means of single numbers spread more than those of whole runs, or less?

# %%
guess.ask("apart", "drawn apart, the means spread", ["more", "as much", "less"])

# %% tags=["goals-are-not-runs", "reveal"]
table, random = returns["meta-bc"], np.random.default_rng(0)
whole = [random.choice(table, len(table)).mean() for _ in range(4000)]
single = [random.choice(table.ravel(), table.size).mean() for _ in range(4000)]
figure, axes = plt.subplots(figsize=(6.4, 2.6))
bins = np.linspace(min(whole + single), max(whole + single), 61)
axes.hist(whole, bins, color="#CC79A7", label="whole runs drawn", alpha=0.8)
axes.hist(single, bins, color="#333333", histtype="step", hatch="//", label="single returns drawn")
axes.set(xlabel="mean return of a resample", ylabel="resamples")
axes.legend()
plt.show()
widths = [np.ptp(np.quantile(draws, [0.025, 0.975])) for draws in (whole, single)]
guess.reveal(
    "apart", "the middle 95 % are {1:.1f} wide, and {0:.1f} over whole runs".format(*widths)
)

# %% [markdown] tags=["reveal"]
# *Figure 2. Means of 4,000 resamples of the same table (Meta-BC on TwoWheeled). The towers: few runs make only few different resamples.*
#
# Twenty returns of one seed are not twenty experiments. If the training from this seed went badly, all twenty are low. Whoever draws them apart acts as if there
# were twenty times as many trainings, and as a rule the interval comes out too narrow. So from here on only *runs* count, with one score each.

# %% [markdown]
# **What the range from worst to best says.** No resample of whole runs can leave the range from the worst run to the best. It is worth printing, under its true name.
# It misses the median of all runs that could have been drawn only if all $n$ runs happen to fall on the same side of that median, which has probability $2 \cdot 2^{-n}$. So it covers
# the median with probability $1 - 2^{1-n}$.

# %% tags=["median-coverage"]
random = np.random.default_rng(0)
for number in (3, 5):
    draws = random.exponential(size=(4000, number))  # their median is log 2
    inside = (draws.min(1) < math.log(2)) & (draws.max(1) > math.log(2))
    assert abs(inside.mean() - median_coverage(number)) < 0.02
    print(
        f"{number} runs: worst to best covers the median in {median_coverage(number):.0%} of all "
        f"experiments (in {inside.mean():.0%} of 4,000 simulated ones)"
    )

# %% [markdown]
# Below, a score stands with its range, `mean [worst, best]`, and means just that.
#
# ### Which of two algorithms is better?
#
# It is tempting to bootstrap the *difference*: draw runs of both, subtract the means, and say "ahead" when the middle 90 % of
# these differences lie above zero. This sounds like an error of 5 %: among pairs of equally good algorithms one in twenty would be called "ahead", and one in twenty "behind".
# Here is this rule. A *rule* takes the scores of two sides, two arrays of shape (runs,), and returns an interval with the fields `estimate`, `low` and `high`.


# %% tags=["bootstrap-given"]
def bootstrap_rule(one, other):
    """Return the middle 90 % of bootstrapped differences of two means, as an interval."""
    random = np.random.default_rng(0)
    left, right = (random.choice(side, (1000, len(side))).mean(1) for side in (one, other))
    low, high = np.quantile(left - right, [0.05, 0.95])
    return Interval(one.mean() - other.mean(), low, high)


example = bootstrap_rule(np.array([74.0, 71.5, 75.2]), np.array([70.1, 73.8, 69.0]))
print(f"estimate {example.estimate:.2f}, from {example.low:.2f} to {example.high:.2f}")

# %% [markdown]
# ### Exercise 1 · How often is "ahead" false?
#
# *Difficulty 2 of 3, planned for 8 minutes.* Find out what such a promise is worth. Two algorithms that are equally good make a *null pair*: their scores come from one
# distribution. Draw `pairs` null pairs with the generator `random`, with `runs` scores on each side (the distribution does not matter much; take the normal one), and return the share of
# them that `rule` calls "ahead".
#
# <details><summary>Hint 1: what must be new for each pair?</summary>
# Both sides. An experiment that is repeated gets other seeds for both algorithms.
# </details>
#
# <details><summary>Hint 2: what counts</summary>
# "Ahead" means that the whole interval lies above zero, not only its estimate. A false "behind" is the other error; do not count it.
# </details>


# %% tags=["exercise-false-ahead"]
def false_ahead_rate(rule, runs, pairs, random):
    """Return the share of null pairs of ``runs`` scores each that the rule calls ahead."""
    ### BEGIN SOLUTION
    false = 0
    for _ in range(pairs):
        one, other = random.normal(size=(2, runs))
        false += rule(one, other).low > 0
    return false / pairs
    ### END SOLUTION


# %%
rate_right = check.false_ahead_rate(false_ahead_rate)
rate = false_ahead_rate if rate_right else few_seeds.false_ahead_rate  # until yours is right

# %% [markdown]
# **Predict first.** The bootstrap of a difference promises 5 %. How often does it say "ahead" about a null pair with three seeds on each side?

# %%
guess.ask("bootstrap", "false ahead, three seeds each (%)")

# %% tags=["false-ahead", "tolerance:abs=1.5", "reveal"]
shares = {
    number: rate(bootstrap_rule, number, 3000, np.random.default_rng(number))
    for number in (3, 5, 10)
}
told = [f"{100 * float(share):.1f} % with {number} seeds" for number, share in shares.items()]
assert shares[3] > 0.1 and shares[3] > shares[10] > 0.05
guess.reveal("bootstrap", ", ".join(told))

# %% [markdown] tags=["reveal"]
# The bootstrap breaks its promise: it calls more than one null pair in ten "ahead", and as many "behind". So few runs show too
# little of how runs vary, and drawing from them again cannot add what they lack. With more seeds the promise gets better.

# %% [markdown]
# ### A rule whose error can be counted
#
# There is another way. Look only at the *ranks*. Three runs of one side and three of the other have the ranks 1 to 6, from the lowest score to the highest. In a null pair nothing
# tells the sides apart, so every way to deal the six ranks to the two sides is equally likely, whatever the distribution of the scores.
#
# **Predict first.** How many such deals are there, and in how many does *every* run of the first side beat *every* run of the second?

# %%
guess.ask("deals", "deals in all, and deals in which all of the first side's runs win")

# %% tags=["three-against-three", "reveal"]
figure = rank_deals()
plt.show()
guess.reveal("deals", "20 in all, 1 of them: 5 %")

# %% [markdown] tags=["reveal"]
# *Figure 3. The twenty deals of six ranks, a column each; below, how many of the nine pairs of runs (one of each side) the first side loses. Only in the framed deal
# does it lose none.*
#
# So the rule "ahead, if every run of the first beats every run of the second" calls a null pair "ahead" with probability exactly 5 %. That is the rank-sum test of Wilcoxon, Mann and Whitney.
# With more runs it need not be so strict: the first side may lose some pairs, as long as so few lost pairs are rare.

# %% [markdown]
# **The same rule as an interval.** Take all differences between a run of the first side and a run of the second: a lost pair is a negative difference. The *median* of these differences estimates by how much the first side
# is better (Hodges and Lehmann, 1963). Let the interval reach from the $k$-th smallest difference to the $k$-th largest. It lies above zero if fewer than $k$ pairs are lost. So take the largest $k$ for which, among all equally likely deals,
# *fewer than $k$ lost pairs* have a share of at most the error that you allow. Then "ahead" is false with at most this error, "behind" likewise, and the
# true difference is in the interval in all other cases.
#
# ### Exercise 2 · The rank interval
#
# *Difficulty 3 of 3, planned for 15 minutes.* Write it, for any numbers of runs. From section 2 on, your interval judges the paper.
#
# <details><summary>Hint 1: the deals</summary>
# <code>itertools.combinations(range(n), m)</code> yields all ways to choose m of n ranks; the other side has the rest. For one deal, count the pairs of ranks, one of each side, of which the first side's is the lower one.
# </details>
#
# <details><summary>Hint 2: k</summary>
# You have a list of lost pairs, an entry per deal. Which share of the deals has fewer than 1, fewer than 2, ... lost pairs? Go on while the share is at most the error.
# </details>
#
# <details><summary>Hint 3: try it on the figure</summary>
# Three against three and an error of 5 % must give k = 1: the interval is the whole range of the nine differences. Three against three at 10 %: by the numbers below Figure 3, k = 2.
# </details>


# %% tags=["exercise-rank-interval"]
def rank_interval(one, other, error):
    """Return (estimate, low, high) of by how much ``one`` exceeds ``other``, (run,) each."""
    ### BEGIN SOLUTION
    ranks = range(len(one) + len(other))
    lost = []
    for mine in combinations(ranks, len(one)):
        theirs = [rank for rank in ranks if rank not in mine]
        lost.append(sum(a < b for a in mine for b in theirs))
    rare = [k for k in range(1, len(one) * len(other)) if np.mean(np.less(lost, k)) <= error]
    k = max(rare)
    differences = np.sort(np.subtract.outer(one, other), axis=None)
    return np.median(differences), differences[k - 1], differences[-k]
    ### END SOLUTION


# %%
interval_right = check.rank_interval(rank_interval)
judge = few_seeds.as_rule(rank_interval if interval_right else few_seeds.rank_interval)

# %% [markdown]
# <details><summary>When it is right: why this is more than a test</summary>
#
# Shift the second side's scores by any number $d$. If $d$ is the true difference, the shifted sides are a null pair. The rule then calls one of them better with at most twice the error, and it does so
# exactly where $d$ lies outside the interval. So the interval holds the true difference with a probability of at least one minus twice the error: 90 % here.
#
# **What this assumes.** That the two sides differ by a shift and by nothing else. Where one side varies much more from seed to seed, "ahead" can be false in one of ten experiments with three seeds; and where one has rare bad runs, both can have the same mean and still be told apart. Then the verdict says which usually wins, not whose mean is higher.
#
# </details>
#
# From here on `judge` is your interval, with an error of 5 % for either verdict. Does it keep its promise? Your first function measures your second:

# %% tags=["ranks-keep-the-promise", "tolerance:abs=1.5"]
for number in (3, 4, 5):
    share = rate(judge, number, 2000, np.random.default_rng(number))
    assert share < 0.07  # 5 % but for the luck of 2,000 pairs
    print(f"{number} seeds each: false ahead in {100 * float(share):.1f} % of 2,000 null pairs")

# %% [markdown]
# To count deals one by one takes too long for more than about eight seeds. The package's `shift_interval` counts them faster, and gives the same numbers:

# %% tags=["same-interval"]
random = np.random.default_rng(1)
for number in (3, 5, 6):
    sides = random.normal(70, 4, size=(2, number))
    ours, package = judge(*sides), shift_interval(*sides)
    assert check.agree(tuple(ours), tuple(package))
    print(f"{number} seeds each: yours {ours:.2f}, the package's {package:.2f}")

# %% [markdown]
# <details><summary>Bonus, for the fast: how many seeds does the bootstrap need?</summary>
#
# With how many seeds does the bootstrap keep within 6 %? Ask `rate(bootstrap_rule, ...)`. By our measurement (12,000 pairs; the cell above drew fewer) its error falls slowly: about 12.5 % with 3 seeds, 9 % with 5, 7 % with 10, and still 6 % with 20.
# Hardly a paper of the field has twenty seeds.
#
# </details>
#
# ### How many seeds does a gap need?
#
# An error of 5 % says how rarely the rule sees a difference that is *not* there. How often does it miss one that *is* there? This depends on the *gap* between the two algorithms, on the *spread* of their scores
# over seeds (a standard deviation), and on the number of seeds. Whoever plans an experiment asks it the other way round.
#
# ### Exercise 3 · Seeds needed
#
# *Difficulty 2 of 3, planned for 12 minutes.* Find the smallest number of seeds, from 3 to 20 on each side, with which `rule` says "ahead" in at least the share `chance` of all experiments. Simulate 400 experiments for each number: normal scores with the
# standard deviation `spread` on both sides, the first side better by `gap` on average, all drawn with `random`. If not even 20 seeds are enough, return `None`.
#
# <details><summary>Hint 1: you have nearly written it</summary>
# Exercise 1 without its null: one side gets the gap added, and a loop over numbers of seeds stands around it.
# </details>
#
# <details><summary>Hint 2: when to stop</summary>
# Return the first number whose share is large enough; only when the loop has come to its end is the answer None.
# </details>


# %% tags=["exercise-seeds-needed"]
def seeds_needed(rule, gap, spread, chance, random):
    """Return the least number of seeds of each side that shows the gap often enough, or None."""
    ### BEGIN SOLUTION
    for number in range(3, 21):
        ahead = 0
        for _ in range(400):
            one = random.normal(gap, spread, number)
            other = random.normal(0, spread, number)
            ahead += rule(one, other).low > 0
        if ahead / 400 >= chance:
            return number
    return None
    ### END SOLUTION


# %%
plan_right = check.seeds_needed(seeds_needed)
plan = seeds_needed if plan_right else few_seeds.seeds_needed  # until yours is right

# %% [markdown]
# **Predict first.** Two algorithms differ by 3 points of return, and from seed to seed either of them varies by 3 points (one standard deviation). How many seeds of each make it likely (four times in five) that the
# better one is called "ahead"?

# %%
guess.ask("needed", "seeds on each side", ["3", "5", "8", "more than 10"])

# %% tags=["seeds-for-a-gap", "tolerance:whole=3", "reveal"]
needed = {}
for ratio in (3.0, 2.0, 1.0, 0.5):
    found = plan(shift_interval, 3.0 * ratio, 3.0, 0.8, np.random.default_rng(0))
    needed[ratio] = None if found is None else int(found)
    print(f"gap {3.0 * ratio:4.1f}, spread 3.0: {needed[ratio] or 'more than 20'}")
assert needed[1.0] > 10 and needed[3.0] < needed[2.0] < needed[1.0]
guess.reveal("needed", f"{needed[1.0]}")

# %% [markdown]
# The sliders show the same for all three verdicts, and beside it single experiments, one after another. Look for two things: an experiment with the verdict
# "ahead" whose estimate is far *above* the true gap, and what happens to the verdicts at a gap of zero.

# %% tags=["widget-seeds", "nbval-ignore-output"]
seeds_widget.seeds_sliders()

# %% tags=["reveal"]
display(seeds_widget.seeds_picture(gap=3.0, spread=3.0, seeds=5, draw=1))

# %% [markdown] tags=["reveal"]
# *Figure 4. Left: how often each verdict falls for a gap as large as the spread, by the number of seeds (framed: five). Right: one of the experiments with five seeds; its scores, and below them the interval of their difference.*
#
# With three or five seeds a gap as large as the spread is missed more often than seen. So "not distinguishable" is no proof of equality. And an experiment that does say "ahead" has drawn a difference that was large by luck: this one
# estimates more than the true 3. At a gap of zero either verdict falls in at most one experiment of twenty, whatever the number of seeds.

# %% [markdown]
# **Two rules for reading.** Where an interval holds zero we write "not distinguishable" and print it all the same: its ends say which gains and which losses the runs exclude. And each verdict is false with at most 5 % *if* the two
# sides are equal; among twenty such pairs we must expect one false "ahead". So trust a gap for its size, and for its return in other environments, more than for a single "ahead".

# %% [markdown]
# ## 2 · Good demonstrations (Figs. 3 and 5)
#
# Now the paper's main experiment. EMRLD and EMRLD-WS are the paper's algorithms, MAML, Meta-BC and GMPS its baselines.
#
# **What differs from the paper**, here and in the next two sections. EMRLD's sigma is learned, where the paper fixes it; both losses are means over steps and over the action's dimensions, where it prints sums; TRPO's step carries momentum, and the network starts in its own way (notebook 08 takes each of these back, one by one). The experts and so the demonstrations are ours, their noise and cuts as the
# paper describes them. Each baseline has the setting that a search chose. Not known are the paper's numbers of iterations, its rate for later adaptation steps, and how its policies act in the tests. The table at the end of section 6 has the rest.
#
# **Predict first.** Which algorithm do you expect in third place on the test tasks, after the two variants of EMRLD?

# %%
clock.at("good demonstrations")
guess.ask("third", "third place, on Point2D and on TwoWheeled", ["MAML", "Meta-BC", "GMPS"])

# %% tags=["figure-3", "reveal"]
figure = paper_figures.results(runs.SHIPPED, "optimal")
plt.show()

# %% [markdown] tags=["reveal"]
# *Figure 5 (the paper's Fig. 3). Optimal demonstrations. Top: mean return on the training tasks after adaptation; HalfCheetah's is the mean over both directions. Bottom: mean return on the test tasks after 0 to 3
# adaptation steps, HalfCheetah's two directions apart. Lines are means over the seeds; bands reach from the lowest seed to the highest. Grey line: the demonstrations' own return. Look at how much of the return comes with the first step.*

# %% [markdown]
# The paper: "our algorithms out perform the others by obtaining the highest average return". Your interval puts a number on it: each
# variant against the *best* baseline of its row, which is chosen after looking and so given every advantage.


# %% tags=["judge-the-best"]
def against_the_best(quality, step):
    """Print and return the difference of each variant to the best baseline, a row per place."""
    gaps = {}
    for place in (*PLACES, BOTH_WAYS):
        seeds = stored_seeds(runs.SHIPPED, place.env, quality)
        table = {name: run_scores(seeds[name], step, place.goal) for name in ALGORITHMS}
        best = max(BASELINES, key=lambda name: table[name].mean())
        for name in OURS:
            gap = gaps[place.title, name] = judge(table[name], table[best])
            scores = f"{worst_to_best(table[name]):6.1f}"
            print(f"{place.title:21}{plotting.label(name):9}{scores}", end="")
            print(f"   less {plotting.label(best):7}{gap:+7.1f}   {verdict(gap)}")
    return gaps


# %% tags=["ahead-optimal", "reveal"]
optimal = against_the_best("optimal", step=1)
means = {
    env: [
        run_scores(seeds, 1).mean() for seeds in stored_seeds(runs.SHIPPED, env, "optimal").values()
    ]
    for env in ("point2d", "two_wheeled")
}
thirds = {env: plotting.label(list(ALGORITHMS)[np.argsort(row)[-3]]) for env, row in means.items()}
guess.reveal("third", ", ".join(f"{TITLES[env]}: {name}" for env, name in thirds.items()))

# %% [markdown] tags=["reveal"]
# **Measured.** On the two goal-reaching environments the claim holds by far: EMRLD and EMRLD-WS reach 79.1 and 79.2 on Point2D, where the best baseline has 49.8, and 77.5 and 77.5 on
# TwoWheeled, where it has 33.1; the smallest gap, at the lower end of its interval, is 27.1. On HalfCheetah the paper's own number, the mean over both directions, says the same for EMRLD: 197.4 against 168.5, ahead by at least 10.6. EMRLD-WS's 196.5 cannot be told from Meta-BC's: its lead may be anything from -0.4 to 61.2. The baseline is the reason: without the clipped gradient that it has here Meta-BC had 119.2, and both were ahead (shown below, with its updates). And the budget speaks, too. After 150 iterations both curves still rose by 10 % and 9 % of their level, so the two were trained on to 250, by the rule that gave Meta-BC its 700, and with them those on sub-optimal data, which were ahead already; at 150 their late training returns, 167.9 and 172.1, could not be told from the 169.2 that Meta-BC has at its end, on a curve that is flat.
#
# The rows of HalfCheetah's two directions say something else than its mean. How would one notice, without being told?

# %% [markdown]
# ### Exercise 4 · What does a mean over tasks hide?
#
# *Difficulty 2 of 3, planned for 10 minutes.* Write a detector: one number per table (seed, task) that is large where *all seeds fail on the same tasks* and succeed on the others, and small where the table only has
# good and bad seeds, or noise. Every table may have the same mean over all its entries. There are many right answers; the check tries yours on made-up tables. Then you let it loose on all stored runs.
#
# <details><summary>Hint 1: what do the seeds of a table share?</summary>
# The tasks. Noise is drawn anew for each seed, so a mean over the seeds makes it smaller; what belongs to a task stays.
# </details>
#
# <details><summary>Hint 2: and a bad seed?</summary>
# It lowers all tasks by the same amount. Does that change how far the tasks lie apart?
# </details>


# %% tags=["exercise-hidden"]
def hidden_by_mean(table):
    """Return a number, large where the tasks of a table (seed, task) differ for every seed."""
    ### BEGIN SOLUTION
    return table.mean(0).std()
    ### END SOLUTION


# %%
detector_right = check.hidden_by_mean(hidden_by_mean)
hidden = hidden_by_mean if detector_right else few_seeds.hidden_by_mean  # until yours is right

# %% [markdown]
# **Predict first.** The four environments with five algorithms each make twenty tables (optimal data, one step). In which environment does your detector find most?

# %%
guess.ask("hidden", "most is hidden in", [*TITLES.values(), "changing dynamics"])

# %% tags=["what-the-means-hide", "reveal"]
found = []
for env in WORLDS:
    for name, seeds in stored_seeds(runs.SHIPPED, env, "optimal").items():
        table = task_scores(seeds, step=1)
        found.append((float(hidden(table)), TITLES.get(env, "changing dynamics"), name, table))
found.sort(key=lambda entry: -entry[0])
print(f"{'':29}{'detector':>9}{'mean':>8}{'worst task':>12}{'best task':>11}")
for number, title, name, table in found[:8]:
    tasks = table.mean(0)
    print(f"{title:19}{plotting.label(name):10}{number:9.1f}{table.mean():8.1f}", end="")
    print(f"{tasks.min():12.1f}{tasks.max():11.1f}")
guess.reveal("hidden", f"{found[0][1]}, by {plotting.label(found[0][2])}")

# %% [markdown] tags=["reveal"]
# The mean of a line says little where its worst and its best task lie so far apart. A large number is a reason to look, not yet a verdict: tasks may also differ in what they pay. HalfCheetah has two tasks, so here they are, one by one, before the adaptation and after one step:

# %% tags=["directions", "reveal"]
seeds = stored_seeds(runs.SHIPPED, "half_cheetah", "optimal")
ways = PLACES[2:]  # forward, backward
print(f"{'':16}{'forward':>30}{'backward':>20}")
print(f"{'demonstrations':28}" + "".join(f"{place.earned:>18.1f}" for place in ways))
for name in ALGORITHMS:
    for step in (0, 1):
        scores = [run_scores(seeds[name], step, place.goal) for place in ways]
        ends = "".join(f"{worst_to_best(table):7.1f}".rjust(26) for table in scores)
        print(f"{plotting.label(name):9} {step} steps {ends}")

# %% [markdown] tags=["reveal"]
# **Measured.** EMRLD and EMRLD-WS run both ways with every seed, 98.4 and 105.7 forward, 296.4 and 287.3 backward; the demonstrations have 138.0 and 329.9. **GMPS runs
# backward whichever way it is asked**: -174.0 forward and 150.8 backward, and its adaptation step changes next to nothing. Its mean, -11.6, looks like a policy that
# stands still, and is none. Meta-BC runs backward as fast as EMRLD, at 296.5 or more with every seed, and forward slowly, at 15.3 to 51.8: there both variants are ahead, by at least 28.9. MAML never moves, -1.1 and -1.0, for a reason that lies in the reward's formula: the further reading finds it.
#
# A policy that runs at full speed whatever it is asked has about the same mean over both directions as one that does not move. So a mean near zero says neither that a policy has "failed to learn" nor why. "Starving" is the wrong word
# for a policy that sees a reward, or a punishment, in every episode.

# %% [markdown]
# **Which of our two?** The paper shows both variants and does not say which is better. Do we know?

# %% tags=["warm-start-or-not", "reveal"]
for place in (*PLACES, BOTH_WAYS):
    seeds = stored_seeds(runs.SHIPPED, place.env, "optimal")
    plain, warm = (run_scores(seeds[name], 1, place.goal) for name in OURS)
    gap = judge(warm, plain)
    print(f"{place.title:21}EMRLD-WS less EMRLD: {gap:+6.1f}   {verdict(gap)}")

# %% [markdown] tags=["reveal"]
# **Measured.** We do not: nowhere can the two be distinguished. What the runs exclude is a difference of more than the intervals: on Point2D the warm start may cost up to 0.6 or gain up to 0.5, on TwoWheeled
# it may cost 4.5 or gain 9.2, on the mean of HalfCheetah cost 30.0 or gain 34.6. These are finished trainings, not one switch: on Point2D EMRLD-WS had half as many iterations as EMRLD, on TwoWheeled a third, on HalfCheetah as many.

# %% [markdown]
# The paper also says that the improvement is "**nearly monotone**", that "**Meta-BC** fails and has unstable training", and that "**MAML and GMPS** fail to learn due to sparsity". For the first two we measure
# the largest fall of the ten-iteration mean below its best so far, as a share of its best: of the mean over seeds, which is the curve that the paper draws, and of the worst seed.

# %% tags=["monotone", "reveal"]
print(f"{'':23}{'EMRLD':>10}{'EMRLD-WS':>10}{'Meta-BC':>10}   largest fall: mean, worst seed")
for env, title in TITLES.items():
    for quality in STEPS_SHOWN:
        seeds = stored_seeds(runs.SHIPPED, env, quality)
        print(f"{title:12}{quality:11}", end="")
        for name in (*OURS, "meta-bc"):
            worst = max(largest_fall([run]) for run in seeds[name])
            print(f"{largest_fall(seeds[name]):>5.0%}{worst:>5.0%}", end="")
        print()

# %% [markdown] tags=["reveal"]
# **Measured.** *Nearly monotone* **holds** for the curve that the paper draws: in three environments, with good and bad data, the mean over seeds of either variant never falls by more than 2.5 % of its best, Meta-BC's by up to 23 %. Single seeds of ours fall by more on TwoWheeled, with optimal data at most by 13.7 %, with sub-optimal data by 18.9 %; with optimal data Meta-BC's worst seeds fall by 7 %, 30 % and 29 %. *Fails* holds
# for GMPS on Point2D, with 1.5 after one step; on TwoWheeled it has 10.7, little less than MAML. MAML has 10.8 on Point2D. On TwoWheeled it finds goals and loses them again: over ten iterations it returns at best 26.6 to 57.4 on the training tasks, by seed, and 2.4 to 28.8 at the end; 12.7 are left on the test tasks. Meta-BC learns a part, 49.8
# and 33.1, with the fixed sigma of the paper. We write *differs* for MAML and for Meta-BC.

# %% [markdown]
# **Is it the right score?** The paper keeps sigma fixed, and samples actions "during training" (appendix C); how a policy acts in its *tests* it does not say. All returns above are of policies that are sampled, as in training. But the noise is not the same: sigma is learned in EMRLD, where it may shrink, and fixed at 1 in Meta-BC on Point2D and, with optimal data, on TwoWheeled, where each action
# is half noise. So here are the same policies again, adapted on the same trajectories, acting by their **mean action** (the table `by_mean.csv` of each run).
#
# **Predict first.** Sampled, Meta-BC has about 50 on Point2D and 33 on TwoWheeled with optimal data. What does it have by its mean action? And with sub-optimal data?

# %%
guess.ask("mean", "Meta-BC by its mean action: optimal data, sub-optimal data")

# %% tags=["by-the-mean", "reveal"]
cloned = {}
for quality in STEPS_SHOWN:
    for place in (*PLACES, BOTH_WAYS):
        by_mean = {}
        for name, seeds in stored_seeds(runs.SHIPPED, place.env, quality).items():
            sampled = run_scores(seeds, 1, place.goal)
            by_mean[name] = run_scores(seeds, 1, place.goal, BY_MEAN)
            print(f"{place.title:21}{quality:11}{plotting.label(name):9}", end="")
            print(f" sampled {worst_to_best(sampled):6.1f}".ljust(42), end="")
            print(f" by the mean {worst_to_best(by_mean[name]):6.1f}")
        for name in OURS:
            gap = judge(by_mean[name], by_mean["meta-bc"])
            print(f"{'':32}{plotting.label(name):9} less Meta-BC by the mean: {gap:+6.1f}", end="")
            print(f"   {verdict(gap)}")
        cloned[quality, place] = by_mean["meta-bc"].mean()
told = {q: " and ".join(f"{cloned[q, place]:.1f}" for place in PLACES[:2]) for q in STEPS_SHOWN}
guess.reveal("mean", f"{told['optimal']}; {told['suboptimal']}")

# %% [markdown] tags=["reveal"]
# **Measured.** With optimal data **Meta-BC solves both environments by its mean action**: 79.4 on Point2D and 83.9 on TwoWheeled, where the demonstrations have 80.9 and 84.0, EMRLD 80.3 and 77.7, and EMRLD-WS 80.6 and 81.8; on TwoWheeled EMRLD-WS is even behind it, by anything from 0.4 to 8.8. With sub-optimal data it fails either way, with 11.3 and 5.1, where EMRLD has 77.8 and 76.7. MAML and GMPS
# stay at 12.3 or below by this score, too. On HalfCheetah sigma is learned on both sides, and the score changes little: in the mean over directions EMRLD, EMRLD-WS and Meta-BC have 230.9, 229.1 and 170.7 with optimal data, and 195.6, 211.9 and 102.2 with sub-optimal. Forward the three have 124.4, 126.3 and 39.7 with optimal data, backward 337.4, 331.8 and 301.7; by this score both variants are ahead forward and in the mean, with either data, and backward EMRLD-WS is.
#
# So on Point2D and TwoWheeled the claim about good demonstrations hangs on a sentence that the paper lacks. If they act by their mean, whoever has *clean, whole* demonstrations needs no reward: cloning in both steps cannot be told from EMRLD. If they are sampled, EMRLD is ahead; but its sigma is smaller. Here both act with the *same* sigma, at the test alone: the policies were trained with their own.


# %% tags=["same-sigma", "tolerance:abs=3", "reveal"]
def with_sigma(run, sigmas):
    """Return a run's mean return on unseen goals after one step, by the sigma that it acts with."""
    shown, world = testing_demonstrations(run), run.config.environment()
    still = without_noise(evaluate_run(run, shown, steps=1).policies[1])
    found = []
    for sigma in sigmas:
        acts = {**still, "log_sigma": torch.full_like(still["log_sigma"], math.log(sigma))}
        rollout = collect(world, shown.tasks, acts, 20, torch.Generator().manual_seed(0))
        found.append(float(episode_returns(rollout).mean()))
    return found


same = {}
for env in ("point2d", "two_wheeled"):
    stored = stored_seeds(runs.SHIPPED, env, "optimal")
    for name in ("emrld", "meta-bc"):
        tables = [with_sigma(runs.load_run(run), (1.0, 0.3)) for run in stored[name]]
        same[env, name] = np.array(tables).T  # (sigma, seed)
    for sigma, one, other in zip((1.0, 0.3), same[env, "emrld"], same[env, "meta-bc"], strict=True):
        gap = judge(one, other)
        print(f"{TITLES[env]:11}both with sigma {sigma}: EMRLD {one.mean():5.1f}", end="")
        print(f"   Meta-BC {other.mean():5.1f}   difference {gap:+6.1f}   {verdict(gap)}")
assert same["point2d", "emrld"].mean() > same["point2d", "meta-bc"].mean()

# %% [markdown] tags=["reveal"]
# On Point2D about half of the lead is left with sigma 1 and a third with 0.3; trained with sigma fixed, EMRLD-WS keeps 73.6 there (notebook 08, the first switch of section 5), so there RL does teach a policy to live with its noise. On TwoWheeled nothing is left that could be distinguished: there most of the sampled lead is the smaller noise. With bad demonstrations EMRLD is ahead of cloning by either score; with good ones, on these two environments, it depends on the score.

# %% [markdown]
# Now *look* at the policies. Fig. 5 sends the adapted TwoWheeled policies to twenty random goals.

# %% tags=["figure-5", "reveal"]
figure = paper_figures.trajectories(runs.SHIPPED)
plt.show()

# %% [markdown] tags=["reveal"]
# *Figure 6 (the paper's Fig. 5). One episode for each of twenty unseen goals (stars; the discs pay a reward), and how many reach it. Trajectories that do are coloured, the others grey and dotted. Top: after one
# adaptation step on optimal data. Bottom: after three steps on sub-optimal data. Seed 0 of each algorithm. Look at whether a policy's trajectories go to different places at all.*
#
# EMRLD's trajectories make a fan. A baseline whose trajectories are all alike, whatever the goal, has not adapted: that is what your detector saw as tasks that differ.

# %% [markdown]
# ## 3 · Bad demonstrations (Fig. 4)
#
# Now the demonstrations are noisy and stop before any reward; TwoWheeled's lack their beginning as well (notebook 03).
#
# **Predict first.** Which algorithm loses most return against good demonstrations, on Point2D and TwoWheeled?

# %%
clock.at("bad demonstrations")
guess.ask("suffers", "most is lost by", ["EMRLD", "EMRLD-WS", "Meta-BC", "GMPS"])

# %% tags=["figure-4", "reveal"]
figure = paper_figures.results(runs.SHIPPED, "suboptimal")
plt.show()

# %% [markdown] tags=["reveal"]
# *Figure 7 (the paper's Fig. 4). As Figure 5, with sub-optimal demonstrations; the grey line is still the optimal ones' return. MAML reads no demonstrations, so its runs are the same. Look at how far both variants of EMRLD are above what was demonstrated, which contains no reward.*

# %% [markdown]
# The paper shows sub-optimal data after three adaptation steps, but its text gives no rate for the later ones. We begin with one step, about which there is nothing to choose (section 8 chooses).

# %% tags=["ahead-suboptimal", "reveal"]
print("after one step")
suboptimal = against_the_best("suboptimal", step=1)
print("\nafter three steps, the later ones at a tenth of the rate")
third = against_the_best("suboptimal", step=3)

# %% [markdown] tags=["reveal"]
# **Measured.** After one step the claim holds in every row, for both variants: 76.9 and 75.8 on Point2D, 69.8 and 77.1 on TwoWheeled, 63.0 and 93.2 forward, 262.0 and 271.4 backward, ahead by at least 17.7. After three steps it holds as well. No demonstration contains a reward, and
# the adapted policies find it: what was missing in the data came from RL. (In which of its two places, notebook 08 asks.)

# %% [markdown]
# **Do better demonstrations help the baselines?** The paper says that Meta-BC and GMPS fail because they "are restricted by the optimality of the data". If that is so, we would expect more from better data, though both could
# fail for other reasons with either.

# %% tags=["restricted-by-the-data", "reveal"]
lost = {}
for place in (*PLACES, BOTH_WAYS):
    for name in ("emrld", "emrld-ws", "meta-bc", "gmps"):
        good, bad = (
            run_scores(stored_seeds(runs.SHIPPED, place.env, quality)[name], 1, place.goal)
            for quality in STEPS_SHOWN
        )
        lost[place.title, name] = gap = judge(good, bad)
        print(f"{place.title:21}{plotting.label(name):9}optimal less sub-optimal: ", end="")
        print(f"{gap:+7.1f}   {verdict(gap)}")
goals = [place.title for place in PLACES[:2]]
most = {title: max(lost, key=lambda key: (key[0] == title, lost[key].estimate)) for title in goals}
guess.reveal("suffers", ", ".join(f"{t}: {plotting.label(name)}" for t, (_, name) in most.items()))

# %% [markdown] tags=["reveal"]
# **Measured.** For Meta-BC the expectation holds on the goal-reaching environments: better data gain 38.6 on Point2D and 27.4 on TwoWheeled, at least 15.9. GMPS hardly gains: 1.1 on Point2D, and on TwoWheeled
# between a loss of 6.8 and a gain of 4.6. On HalfCheetah Meta-BC gains, too, 70.3 in the mean over directions, at least 58.3 (after 700 iterations and 300; both curves are flat). GMPS runs backward faster from better data, by 62.9, and the wrong way faster when it should go forward, by
# 75.0.
#
# But not the data alone differ in these pairs: Meta-BC and GMPS have with either data the settings that a search chose with them, and Meta-BC 700 iterations with the optimal, 300 with the other. The search itself has every setting with both data, after equally many iterations, one seed each:

# %% tags=["the-data-alone", "reveal"]
searched = ("table1", "alpha0.1", "rate0.002", "fixed-sigma", "clip0.5")
print(f"{'optimal less sub-optimal':33}" + "".join(f"{setting:>13}" for setting in searched))
for name in ("meta-bc", "gmps"):
    for place in PLACES:
        print(f"{place.title:22}{plotting.label(name):11}", end="")
        for setting in searched:
            good, bad = (
                run_scores(
                    [runs.SHIPPED / f"search-{place.env}-{quality}-{name}-{setting}-seed0"],
                    step=1,
                    goal=place.goal,
                )
                for quality in STEPS_SHOWN
            )
            print(f"{good[0] - bad[0]:+13.1f}", end="")
        print()

# %% [markdown] tags=["reveal"]
# **Measured.** With equal settings better data gain Meta-BC 2.5 to 25.4 on Point2D and 6.8 to 25.4 on TwoWheeled, GMPS up to 5.6 on Point2D and on TwoWheeled anything from -5.3 to 3.7. On HalfCheetah GMPS runs backward faster from better data with each setting, by 42.6 to 135.0, and the wrong way faster by 49.2 to 166.2. So on the goal-reaching environments Meta-BC's gain, and on HalfCheetah GMPS's speed, are the data's doing. Meta-BC's difference on HalfCheetah changes its sign with the setting.
#
# **Measured.** EMRLD gains from better data on HalfCheetah as well: 33.9 in the mean over directions, anything from 13.3 to 57.9, after as many iterations; both curves still climb. For EMRLD-WS the 14.0 cannot be told from nothing: a loss of 13.4 is possible, and a gain of 43.5.

# %% [markdown]
# ## 4 · Changing dynamics (Fig. 6, in simulation)
#
# Here the goal is the same for all tasks, (2, 1), and what differs is a drift that turns the robot: its heading $\theta$ grows by $\omega_g$ per second on top of what the
# policy asks for. The paper trains on nine drifts, and finds that "the EMRLD variants clearly outperform the others".
#
# **What differs from the paper.** It does not name its nine drifts; ours are spread evenly up to 0.8 radians per second (section 12 has narrow ones). Two things can be read in two ways, so we ran both readings of each, with five seeds:
#
# - *How the drift acts.* A step lasts $dT = 0.5$ s, so a rate turns the robot by $\omega_g\, dT$. The paper prints $\theta + \omega_g + \omega\, dT$: the same number turns it twice as far. (There our drifts reach 0.7 radians per step; from 0.75 on no steering could hold against them. The drift of the paper's robot, -0.65, takes 0.65 of these 0.75 as printed, and 0.325 as a rate.)
# - *What a policy sees.* Position and heading, as the robot has them, or position alone, as the paper's text says ($S \in \mathbb R^2$). The released code shows the heading in its TwoWheeled world; it has no drift, so which state the paper's runs had here we do not know.
#
# Meta-BC and GMPS run with the settings that a search in this environment, with the drift a rate, chose on the training tasks; only GMPS without the heading takes what was chosen with it, since no setting returns more than 0.5 there. MAML has Table 1's values; without the momentum, which held it down on TwoWheeled, it is no better here (one seed in the search).
#
# First a rate, with the heading seen. **Predict first.** Does a policy that *sees* its heading need to adapt at all? What share of MAML's return after one step is there before it?

# %%
clock.at("changing dynamics")
guess.ask("adapt", "MAML before the step, as a share of its return after it (%)")

# %% tags=["figure-6", "reveal"]
figure = drift_figures.drift(runs.SHIPPED)
plt.show()

# %% [markdown] tags=["reveal"]
# *Figure 8 (the simulated part of the paper's Fig. 6). Top left: training. Top right: twenty unseen drifts, by adaptation steps; the grey line is the demonstrations' return. Bottom: three episodes of
# each algorithm (seed 0, one step) in the unseen task nearest the drift that the paper set on its robot. Look at the returns at step 0: they need no adaptation.*

# %% tags=["drift-claims", "reveal"]
seeds = stored_seeds(runs.SHIPPED, "two_wheeled_drift", "optimal")
drifts = {name: run_scores(seeds[name], 1) for name in ALGORITHMS}
before = {name: run_scores(seeds[name], 0) for name in ALGORITHMS}
for name, table in drifts.items():
    print(f"{plotting.label(name):9} before {worst_to_best(before[name]):5.1f}", end="")
    print(f"   one step {worst_to_best(table):5.1f}")
for name in OURS:
    gap = judge(drifts[name], drifts["maml"])
    print(f"{plotting.label(name):9} less MAML: {gap:+5.1f}   {verdict(gap)}")
guess.reveal("adapt", f"{before['maml'].mean() / drifts['maml'].mean():.0%}")

# %% [markdown] tags=["reveal"]
# **Measured.** With the heading in the state **the claim does not reproduce.** After one step EMRLD reaches 70.4, EMRLD-WS 74.4 and MAML 71.0. MAML's *unadapted* policy has 70.1 and the demonstrations 74.4, so little is left to gain. One of EMRLD's five seeds, with 55.3, had learned all drifts and lost those at one end again; one of MAML's, with 57.8, never had them all. EMRLD-WS has them
# with every seed, 74.4 at least. So EMRLD-WS counts as ahead, by anything from 0.0 to 16.6, while EMRLD's difference cannot be distinguished, and a lead of more than 0.4 is excluded. Meta-BC and GMPS do fail when they are sampled, with 32.3 and 5.6; by its mean action and with sigma fixed Meta-BC has 74.4 (one seed, of the search).
#
# **Why does MAML do so well?** In the other environments the tasks have different goals, and no observation tells which one is meant. Here the
# goal is always the same, and the policy sees its position and heading: if the robot drifts left, it steers right. *One* policy then solves all nine tasks, and plain RL
# finds it once luck has found the reward, which a disc of radius 0.5 allows.

# %% [markdown]
# **Now hide the heading.** A policy that sees its position alone cannot look where it is turned to. It can still hold a path, since on *one* path the place tells the heading; but which turn belongs to a place depends on the drift, and it would seem that only the adaptation can tell that. **Predict first.** What is left of MAML after one step, as a share of EMRLD-WS?

# %%
guess.ask("headless", "MAML as a share of EMRLD-WS, heading hidden (%)")

# %% tags=["drift-readings", "reveal"]
figure = drift_figures.readings(runs.SHIPPED)
plt.show()

# %% [markdown] tags=["reveal"]
# *Figure 9. Return on twenty unseen drifts by adaptation steps: left the drift as a rate, right as the paper prints it, five seeds each; above with the heading in the state, below without. The grey lines are the demonstrations' returns.*

# %% tags=["reading-claims", "reveal"]
after = {}
for reading in READINGS:
    seeds = stored_seeds(runs.SHIPPED, reading.runs, "optimal")
    print(f"{reading.title}, {len(seeds['maml'])} seeds")
    for name, folders in seeds.items():
        after[reading, name] = run_scores(folders, 1)
        line = f"  {plotting.label(name):9} before {worst_to_best(run_scores(folders, 0)):5.1f}"
        print(f"{line:38} one step {worst_to_best(after[reading, name]):5.1f}")
    for name in OURS:
        gap = judge(after[reading, name], after[reading, "maml"])
        print(f"  {plotting.label(name):9} less MAML: {gap:+5.1f}   {verdict(gap)}")
blind = {name: after[READINGS[2], name].mean() for name in ("emrld-ws", "maml")}
guess.reveal("headless", f"{blind['maml'] / blind['emrld-ws']:.0%}")

# %% [markdown] tags=["reveal"]
# **Measured.** With the heading hidden and the drift a rate **the claim holds for EMRLD-WS, by little**: after one step it has 53.3 where MAML has 44.4, and is ahead by 0.5 to 19.6. EMRLD's 45.1 cannot be distinguished from MAML's: a loss of 9.8 is possible, and a gain of 15.9. The variants do adapt, from 12.9 and 10.2 before the step. MAML does not: it has 45.6 before it. So even a policy that sees its position alone can steer against a good part of the drifts, perhaps because where the robot stands tells how far it was turned. Meta-BC is left with 4.0 (with sigma fixed and by its mean action with 0.0) and GMPS with 0.0.
# **With the drift as printed it holds for both variants, in both states.** With the heading EMRLD and EMRLD-WS have 74.3 and 74.4 and MAML 69.1, whose worst drift earns at most 45.1. Without it **the paper's picture is there in full**: 55.7, 57.2 and 10.0, every seed of either variant is ahead of every seed of MAML, and the variants lead by at least 36.8 and 39.8. These are the paper's formula and the state of the paper's text. Sampled, Meta-BC and GMPS fail there as well, with 25.5 and 1.4 with the heading and 6.1 and 0.4 without it. (On the training tasks no other setting of Meta-BC ends above 32.7, with a clipped gradient, or 11.8 without the heading; search, one seed. With a rate clipping takes Meta-BC to 26.4 and 11.4, from 35.5 and 5.0 with the same seed. Halfway through the training its five seeds had up to 52.0 over ten iterations, and lost it again.)

# %% [markdown]
# **How long must one train to see this?** With the heading seen all three are flat after 150 iterations. With the heading hidden they are not, so EMRLD, EMRLD-WS and MAML ran 500 there, as long as the released code. **Predict first.** MAML's return on its training tasks after 150 iterations: which share is it of what MAML has after 500?

# %%
guess.ask("budget", "MAML after 150 of 500 iterations, as a share of its end (%)")

# %% tags=["hidden-budget", "reveal"]
BUDGETS = (50, 150, 300, 500)
reached = {}
for reading in READINGS[2:]:
    print(f"{reading.title}: mean training return after {', '.join(map(str, BUDGETS))} iterations")
    found = stored_seeds(runs.SHIPPED, reading.runs, "optimal")
    for name in (*OURS, "maml"):
        for end in BUDGETS:
            reached[reading, name, end] = training_scores(found[name], end)
        line = "".join(f"{reached[reading, name, end].mean():7.1f}" for end in BUDGETS)
        print(f"  {plotting.label(name):9}{line}")
    for end in (150, 500):
        for name in OURS:
            gap = judge(reached[reading, name, end], reached[reading, "maml", end])
            print(f"  {plotting.label(name):9}less MAML after {end}: {gap:+5.1f}   {verdict(gap)}")
ends = [reached[READINGS[2], "maml", end].mean() for end in (150, 500)]
guess.reveal("budget", f"{ends[0] / ends[1]:.0%}")

# %% [markdown] tags=["reveal"]
# **Measured.** With a rate EMRLD, EMRLD-WS and MAML have 31.8, 41.4 and 19.7 after 150 iterations and 45.6, 52.7 and 44.8 after 500; as printed they have 28.1, 33.5 and 1.6, and 57.1, 58.8 and 11.9. So with a rate most of the variants' lead was one of speed: EMRLD-WS's shrinks from 24.8 to 5.7. As printed it is not, and it grows. MAML, which has 3.3 and 0.9 after 50 iterations, has not come to its end after 500 either: its curves still climb, by 7.5 % and 27.5 %, while the variants rise by 0.8 % to 9.0 %.
#
# **Does a mean over drifts say enough?** The drift of the paper's robot is negative. So here are the two sides apart:

# %% tags=["hidden-by-side", "reveal"]
for reading in READINGS[2:]:
    drifts = unseen_demonstrations(reading.env, "optimal", 20).tasks[:, 0].numpy()
    found = stored_seeds(runs.SHIPPED, reading.runs, "optimal")
    for side, chosen in (("negative", drifts < 0), ("positive", drifts > 0)):
        print(f"{reading.title}, {chosen.sum()} {side} drifts, one step")
        by_seed = {name: task_scores(found[name], 1)[:, chosen].mean(1) for name in (*OURS, "maml")}
        for name, each in by_seed.items():
            print(f"  {plotting.label(name):9}{worst_to_best(each):5.1f}", end="")
            gap = judge(each, by_seed["maml"])
            print("" if name == "maml" else f"   less MAML: {gap:+5.1f}   {verdict(gap)}")

# %% [markdown] tags=["reveal"]
# **Measured.** With a rate it hides two cases. On the negative drifts EMRLD has 64.7, EMRLD-WS 68.0 and MAML 49.5, and **both variants are ahead**, by at least 5.3 and 12.1; on the positive ones they have 32.0, 43.6 and 40.9, and nobody is. (Figure 14 shows where: beyond 0.5 the variants lose most of it. We split by sign after we had seen the runs. Section 13 finds a reason in our demonstrations: at positive drifts they ask for a steering that no robot does.) As printed both variants lead on either side, by at least 22.8.
#
# But what a policy reaches without the heading falls short of what the demonstrations earn. Is it the adaptation that fails, or the policy's own noise? Each drawn action turns the robot a little, a policy without the heading does not see it, and the turns add up. So here are the same policies, before the step and after it, acting by their mean:

# %% tags=["blind-by-the-mean", "reveal"]
by_mean = {}
for reading in READINGS:
    print(reading.title + ", by the mean action")
    for name, folders in stored_seeds(runs.SHIPPED, reading.runs, "optimal").items():
        before, one_step = (run_scores(folders, step, table=BY_MEAN) for step in (0, 1))
        by_mean[reading, name] = one_step
        line = f"  {plotting.label(name):9} before {worst_to_best(before):5.1f}"
        print(f"{line:38} one step {worst_to_best(one_step):5.1f}")
    for name in OURS:
        gap = judge(by_mean[reading, name], by_mean[reading, "maml"])
        print(f"  {plotting.label(name):9} less MAML: {gap:+5.1f}   {verdict(gap)}")

# %% [markdown] tags=["reveal"]
# **Measured.** So the step does what it should, and the noise hides a part of what it gains. With the heading hidden and the drift a rate EMRLD has 52.4 by the mean action and EMRLD-WS 60.9, from 16.6 and 10.2 before the step; MAML's step gains next to nothing, 53.1 from 51.6, and its best seed has 62.5. By this score neither variant can be told from MAML there: EMRLD's lead may be anything from -16.0 to 20.8, that of EMRLD-WS from -2.8 to 19.9. As printed both are ahead, by at least 46.2 and 46.5 without the heading, and by 0.2 and 0.3 with it, where little is left to gain. In the fourth reading, the heading seen and the drift a rate, a lead of EMRLD of more than 0.4 is excluded. And where the heading is seen, Meta-BC needs no RL by this score: 45.6 and 38.4 with its sigma learned, but 74.4 and 74.5 with sigma fixed (search, one seed). Without the heading it has 3.3 and 3.6, and 1.5 at most with sigma fixed.
#
# **The verdict, then, depends on two sentences of the paper.** With the heading in the state and a drift that is a rate there is nothing to adapt to, and MAML is as good as EMRLD. Take away the heading, and MAML, trained long enough, still finds one policy that copes with a good part of the drifts; EMRLD-WS is ahead of it by little, and both variants are on the side of the paper's own drift; five more trainings of each, with better demonstrations, confirm neither (section 13). Let the drift act as printed, and both are; without the heading by far. All this with training drifts as wide as the test's. With narrow ones, and shown demonstrations whose steering a robot can do, neither variant can be told from MAML where the drift is a rate; without the heading and with the drift as printed EMRLD is ahead (sections 12 and 13).

# %% [markdown]
# **Turn the drift yourself.** The same stored policies (seed 0), the drift a rate, each value of the slider shown by one demonstration. Which algorithms does the adaptation step change, and at which drifts? Then hide the heading.

# %% tags=["widget-drift", "nbval-ignore-output"]
driven = {seen: drift_widget.drive(runs.SHIPPED, seen) for seen in (True, False)}
drift_widget.drift_sliders(driven)

# %% tags=["reveal", "nbval-ignore-output"]
display(drift_widget.drift_picture(driven[True], -0.6))
display(drift_widget.drift_picture(driven[False], -0.6))

# %% [markdown] tags=["reveal"]
# *Figure 10. Four episodes at a drift of -0.6 radians per second, with the heading seen (first row) and hidden (second), before the adaptation step (grey, dashed) and after it (coloured); markers stand where an episode ends, titles give the mean return of twenty. Look at who is at the goal before the step:
# a policy that is has no use for an adaptation.*

# %% [markdown]
# ## 5 · Has the curve ended its rise, and did the training hold?
#
# A comparison of half-trained policies says who is quicker, not who is better. We call a curve *climbing* if the mean of its last
# fifth exceeds that of the fifth before by more than 5 % of the algorithm's *own* level, the mean of the last fifth; *falling* if it sinks by more than that; and *flat* otherwise (the exercise has none that falls). (A level below a twentieth of the demonstrations' return counts as this twentieth: the ups and
# downs of next to nothing are luck.)
#
# And a flat curve may belong to a training that broke. The Kullback-Leibler divergence (KL, in nats) between the adapted policies before an update and after it says how far the update moved them. TRPO takes no step beyond a bound; Adam, with which Meta-BC and GMPS
# make their updates, has none. We say that a training *broke down* if an update moved the adapted policies by more than one nat: an action of the old policy is then, on average over its logarithm, e times less likely under the new one, as if all means had moved by 1.4 sigma, where TRPO's bound allows 0.2. (A stored curve notes an update in words from ten nats on.)
#
# ### Exercise 5 · Read four curves
#
# *Difficulty 1 of 3, planned for 4 minutes.* These four trainings are made up. Write down, for each, `"flat"` or `"climbing"`, and `"in bounds"` or `"broke down"`.

# %%
clock.at("has the curve ended its rise")
figure = curves_to_read()
plt.show()

# %% [markdown]
# *Figure 11. Four made-up trainings. Top: mean return; the dotted lines mark off the last two fifths. Bottom: KL of each update, on a logarithmic axis, with TRPO's bound (dashed). Read the axes before you read the curves.*
#
# <details><summary>Hint: A and B</summary>
# Write down four numbers: the mean of the fourth fifth and of the last, for each of the two. A steep line may be a small share.
# </details>


# %% tags=["exercise-read"]
def read_curves():
    """Return {training: ("flat" or "climbing", "in bounds" or "broke down")}."""
    ### BEGIN SOLUTION
    return {
        "A": ("flat", "in bounds"),
        "B": ("climbing", "in bounds"),
        "C": ("flat", "broke down"),
        "D": ("climbing", "broke down"),
    }
    ### END SOLUTION


# %%
read_right = check.read_curves(read_curves)

# %% tags=["curves-read", "reveal"]
for name, training in trainings().items():
    print(
        f"{name}: rises by {training.rise:5.1%} of its level, largest KL {training.kl.max():8.2f}"
    )

# %% [markdown] tags=["reveal"]
# A looks steep, because its panel begins at 72. B looks flat, because its panel reaches to 80, and it has grown by a third. C is flat, and its return alone looks like that of a training that has come to its end; but several of its updates moved
# the policies by thousands of nats. D does both: it climbs, and it broke down. So this workbook keeps the KL of every update, and a figure should start its axis at zero or say that it does not.

# %% [markdown]
# Now the stored runs, by the same two rules. **Predict first.** Which algorithms have updates of more than one nat?

# %%
guess.ask("broke", "more than one nat: the algorithms")


# %% tags=["flattened", "reveal"]
def rises(seeds, earned):
    """Return by how much the mean over seeds still rises, and the seeds one by one, as text."""
    both = results.late_rise(seeds, earned)
    each = [results.late_rise([run], earned) for run in seeds]
    ends = f"({min(each):.0%} to {max(each):.0%})"
    return f"{both:>7.1%}{'*' if both > FLAT else ' '} {ends:<16}"


print("rise of the mean over seeds, as a share of its level (and of the seeds one by one)")
print(f"{'':43}{'optimal':<25}sub-optimal")
for env, title in TITLES.items():
    for name in ALGORITHMS:
        stored = [stored_seeds(runs.SHIPPED, env, quality)[name] for quality in STEPS_SHOWN]
        line = "".join(rises(seeds, EARNED[env]) for seeds in stored)
        print(f"{title:33}{plotting.label(name):9}{line}")
for reading in READINGS:
    for name, seeds in stored_seeds(runs.SHIPPED, reading.runs, "optimal").items():
        print(f"{reading.title:33}{plotting.label(name):9}{rises(seeds, EARNED[reading.env])}")
print(f"* climbing: more than {FLAT:.0%}")

# %% [markdown] tags=["reveal"]
# **Measured.** **Flat** are EMRLD, EMRLD-WS and Meta-BC on Point2D, on TwoWheeled and with changing dynamics: at most 4.2 %; MAML everywhere but on TwoWheeled, on Point2D at a level of 10.5; and GMPS with sub-optimal data on Point2D, with optimal data on HalfCheetah and with changing dynamics, at most 4.6 %. **Falling** are MAML and GMPS on TwoWheeled with optimal data, by 11.4 % and 13.4 %, and GMPS with sub-optimal data there, by 7.5 %, and on HalfCheetah, by 7.1 %, and with optimal data on Point2D, by 5.7 % of little. **Still climbing** are
# EMRLD and EMRLD-WS on HalfCheetah, by 8.3 % to 11.0 % after 250 iterations. Meta-BC is flat there, at 0.9 % with optimal data and 3.3 % with sub-optimal. So there the comparison is one at a budget, for EMRLD and EMRLD-WS.
#
# The mean over seeds can hide opposite cases. MAML "falls" on TwoWheeled because one seed loses much of its level while another gains, and is "flat" on Point2D because four seeds fall a little and one climbs. EMRLD's late seed on Point2D with optimal data still climbs as well.
#
# **Measured.** With changing dynamics these are the words for a rate and the heading seen. As printed EMRLD, EMRLD-WS and MAML are flat there, too, and Meta-BC and GMPS fall, by 27.1 % and 52.2 % of little. Without the heading EMRLD is flat after 500 iterations, at 3.1 % and 4.7 %; EMRLD-WS is with a rate, at 0.8 %, and climbs by 9.0 % as printed; MAML climbs by 7.5 % and 27.5 %, and Meta-BC as printed by 10.1 % of very little.

# %% tags=["divergence", "reveal"]
figure, panels = plt.subplots(2, 3, figsize=(10.5, 6.4), sharey=True)
for row, quality in zip(panels, STEPS_SHOWN, strict=True):
    for axes, (env, title) in zip(row, TITLES.items(), strict=True):
        stored = stored_seeds(runs.SHIPPED, env, quality)
        bound = TrustRegion().for_actions(make(env).action_dim).max_kl
        curves = {
            name: [runs.load_curve(run / "curve.csv") for run in stored[name]]
            for name in ("meta-bc", "gmps")
        }
        plotting.divergence(curves, bound, axes)
        raw = f"search-{env}-{quality}-meta-bc-table1-seed0"
        if env == "half_cheetah":  # as many iterations as clipped
            raw = f"{env}-{quality}-meta-bc-unclipped-seed0"
        moved = [update.kl for update in runs.load_curve(runs.SHIPPED / raw / "curve.csv")]
        axes.plot(moved, ":", color="black", linewidth=1, label="Meta-BC, Table 1")
        axes.get_legend().remove()
        axes.set_title(f"{title}, {quality} data (bound {bound:.2f})", fontsize=10)
    for axes in row[1:]:
        axes.set_ylabel("")
figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
plt.show()

# %% [markdown] tags=["reveal"]
# *Figure 12. How far each update of Meta-BC and GMPS moves the adapted policies, on a logarithmic axis, every seed; above with optimal data, below with sub-optimal; triangles lie above the picture. The black line is the bound that TRPO keeps for EMRLD and EMRLD-WS. Dotted: Meta-BC at Table 1's values, before the search (one seed): sigma is learned, and no gradient clipped.*

# %% tags=["updates-above-one-nat", "reveal"]
studied = {f"{TITLES[env]}, {quality}": (env, quality) for env in TITLES for quality in STEPS_SHOWN}
studied |= {reading.title: (reading.runs, "optimal") for reading in READINGS}
above = []
for title, (env, quality) in studied.items():
    for name, seeds in stored_seeds(runs.SHIPPED, env, quality).items():
        curves = [runs.load_curve(run / "curve.csv") for run in seeds]
        moved = np.array([row.kl for curve in curves for row in curve])
        if number := int((moved > 1).sum()):
            above.append(plotting.label(name))
            print(f"{title:33}{plotting.label(name):9}{number:5}", end="")
            print(f" of {len(moved):5} updates above one nat, the largest {moved.max():.1e}")
guess.reveal("broke", ", ".join(dict.fromkeys(above)) or "none")

# %% [markdown] tags=["reveal"]
# **Measured.** Only GMPS and Meta-BC have such updates. GMPS's are 517 of 750 on Point2D with sub-optimal data, 216 of 2500 there with optimal data, and 165 of 750 on TwoWheeled with optimal data; the other three have 32 at most. Meta-BC's are 405 of 3500 on HalfCheetah with optimal data, though none exceeds 2.3 nats, 3 of 1500 with sub-optimal, and 9 on TwoWheeled; at Table 1's values, with sigma learned, they were 118 of 300 there (the search's one seed). With changing dynamics GMPS has up to 182 of 750 and Meta-BC up to 48 of 1500. TRPO has a
# fault of its own: it may find no step at all. One seed of EMRLD on TwoWheeled found none in 89 of its 300 iterations, and its final policy is that of the middle of its training; the same seed loses what it has with a second adaptation step (Figure 5).
#
# So some of these trainings *broke down*, which is more than the paper's "little data"; though by this rule Meta-BC's five on HalfCheetah with optimal data did, too, and learned all the same. Is the divergence then the *reason* of the failure? On the goal-reaching environments not for Meta-BC: with sigma fixed its training on Point2D stays in bounds with every seed, and sampled it still earns far less than EMRLD. Its sigma of 1 keeps that return down: by its mean action it has all (section 2), and twenty times as many goals, with noise in their paths, bring much less (notebook 05). Nor for GMPS, as far as these runs show: kept in bounds it earns little more. Section 11 looks for what breaks it.
#
# **On HalfCheetah it costs a good deal.** There the comparison's Meta-BC has a *clipped* gradient, the usual cure: where it is longer than 0.5, it is shortened to that before Adam sees it. The search had not asked for this at first. Here is what Meta-BC did without it, at Table 1's values, all else alike, five seeds. **Predict first.** What does it return then, with optimal data?

# %%
guess.ask("clipped", "Meta-BC not clipped, optimal data: mean over both directions")

# %% tags=["meta-bc-clipped", "reveal"]
for quality in STEPS_SHOWN:
    ours = stored_seeds(runs.SHIPPED, "half_cheetah", quality)
    for title, name in {"clipped": "meta-bc", "not clipped": "meta-bc-unclipped"}.items():
        seeds = seeds_of(runs.SHIPPED, f"half_cheetah-{quality}-{name}")
        moved = [row.kl for run in seeds for row in runs.load_curve(run / "curve.csv")]
        print(
            f"{quality:11}{title:12}{sum(kl > 1 for kl in moved):4} of {len(moved)} updates", end=""
        )
        print(f" above one nat, the largest {max(moved):.1f}")
        for place in (*ways, BOTH_WAYS):
            tested = run_scores(seeds, 1, place.goal)
            print(f"    {place.title:21} {worst_to_best(tested):6.1f}")
            for variant in OURS if title == "not clipped" else ():
                gap = judge(run_scores(ours[variant], 1, place.goal), tested)
                print(f"{'':26}{plotting.label(variant):9} less this: {gap:+6.1f}   {verdict(gap)}")
    if quality == "optimal":
        guess.reveal("clipped", f"{tested.mean():.1f}")

# %% [markdown] tags=["reveal"]
# **Measured.** Without clipping 638 of 3500 updates exceed one nat with optimal data, the largest 306 nats, and 111 of 1500 with sub-optimal. In the mean over directions Meta-BC has 119.2 and 88.2, where clipped it has 168.5 and 99.3. One seed of five had learned as much as the others, 179.5 on average over its best ten iterations; around iteration 653 of 700 it lost all of it, and at the end it stands still. One of the others runs the wrong way when it should run forward, -58.9.
#
# Against this baseline both variants were ahead in the mean over directions, by at least 14.6. A cure of one line takes one of these two verdicts away: "the baselines had their chance" is a claim as well, and this one was false for a while. (For GMPS clipping is no cure, see section 11, and on the goal-reaching environments it is the best setting in no row of the search.)

# %% [markdown]
# ## 6 · The paper's claims
#
# Here are the paper's sentences. **Before you unfold the answers**, go through them and write "holds", "differs" or "not reproduced" beside each, with the number that you would give as a reason.
#
# | | Section 4 and the appendices, in the paper's words |
# |---:|---|
# | 1 | "obtaining the highest average return" (optimal data) |
# | 2 | "quickly adapt to testing tasks with just one adaptation step and one trajectory" |
# | 3 | "nearly-monotone improvement" |
# | 4 | "Meta-BC fails and has unstable training performance" |
# | 5 | "MAML and GMPS fail to learn due to sparsity" |
# | 6 | "EMRLD outperforms all the baselines" (sub-optimal data) |
# | 7 | "restricted by the optimality of the data" |
# | 8 | "the EMRLD variants clearly outperform the others" (changing dynamics) |
# | 9 | EMRLD or EMRLD-WS? (not claimed) |

# %%
clock.at("the paper's claims")

# %% [markdown] tags=["reveal"]
# | | here | where |
# |---:|---|---|
# | 1 | **holds** for EMRLD in three environments of three if the tested policies are sampled, for EMRLD-WS in two; by their mean action Meta-BC cannot be told from EMRLD on the goal-reaching two and is ahead of EMRLD-WS on TwoWheeled, nor can it be told with an equal sigma there. On HalfCheetah EMRLD is ahead in the mean over directions, and both are forward; backward Meta-BC does as well, and EMRLD-WS's lead in the mean is not shown (by the mean action it is) | sections 2 and 5 |
# | 2 | **holds** | section 2 |
# | 3 | **holds** in three environments for the mean over seeds, which the paper draws; on TwoWheeled single seeds fall by more than a tenth of their best | section 2 |
# | 4 | **differs**: with sigma fixed, as in the paper, it is steady on Point2D; sampled it earns less than two thirds of what EMRLD does, by its mean action as much, as far as these seeds can tell. On HalfCheetah it is unstable as printed, and one seed of five loses all; with a clipped gradient it is steady, runs backward as well as EMRLD and forward a little | sections 2 and 5 |
# | 5 | **differs**: MAML learns a little on Point2D, on TwoWheeled it finds goals and loses them, and on HalfCheetah it stands still with the reward of appendix B's formula but not with Section 4.1's; GMPS fails on Point2D and has no more than MAML on TwoWheeled, but its training breaks down as well, and on HalfCheetah it runs backward for both tasks, with rewards in sight | sections 2 and 7 |
# | 6 | **holds** in three environments of three after one step and, with a smaller rate, after three; without it on the goal-reaching two, EMRLD on TwoWheeled at the edge | sections 3 and 8 |
# | 7 | **differs**: seen for Meta-BC on the goal-reaching two with every setting that was tried, on HalfCheetah with its own; for GMPS not | section 3 |
# | 8 | **holds** with the drift as printed, for both variants, when they are sampled (by its mean action Meta-BC with sigma fixed does as well where the heading is seen, one seed), and by far without the heading, though MAML still climbs there; **differs** with a rate: without the heading EMRLD-WS is ahead by little, and either variant on negative drifts, neither of which more trainings confirm; with it MAML does as well as EMRLD, and EMRLD-WS is ahead by a hair. With narrow training drifts EMRLD is ahead where the heading is hidden and the drift as printed, and else nobody clearly, once our demonstrations' error is cut | sections 4, 12 and 13 |
# | 9 | not distinguishable | section 2 |
#
# The appendices' three sentences, about $w_{\mathrm{rl}}$ and $w_{\mathrm{bc}}$, are notebook 08's.

# %% [markdown]
# ## Where paper and code differ
#
# | point | paper | released code | this workbook |
# |---|---|---|---|
# | iterations | not given | 700, or 500 | 100 to 500 for EMRLD and EMRLD-WS, 150 to 500 for MAML; section 5 lists who still climbs |
# | which episodes count | $M$ trajectories | the first 20 to finish out of 30 | exactly 20, none dropped |
# | how a policy acts in the tests | not said ("during training" sampled) | not compared | sampled, and by its mean action (section 2) |
# | bands in the figures | standard deviation over seeds in training, over test tasks in the tests | – | from the lowest seed to the highest |
# | HalfCheetah's reward, the wrong way | none (Section 4.1), or negative (appendix B) | negative | negative; a switch |
# | rate of the later adaptation steps | not given | not compared | a tenth of the first, chosen when the test tasks had been seen (section 8) |
# | Meta-BC's and GMPS's budget | not given | 700, or 500 | Meta-BC 300 iterations, 700 where its curve still rose; GMPS 150, and 500 there. What a search over alpha, the meta learning rate, sigma and clipping chose, for MAML also the KL bound, momentum and scaled advantages; on HalfCheetah the search's run is seed 0 for GMPS and MAML |
#
# ## What was shown
#
# - A verdict is worth what its rule is worth: a bootstrap of three runs calls more than one null pair in ten "ahead"; your rank interval keeps its promise, at the price of missing what few seeds cannot show.
# - A gap as large as the spread needs more than ten seeds of each side. "Not distinguishable" is no proof of equality.
# - Which score is right is a question of its own: the noise of a policy may be all that a baseline lacks.
# - A mean over tasks can hide the result. What all seeds of a task share, it shows when one looks.
# - A curve is read on its own level, and with the KL of its updates beside it.
# - Which of the paper's sentences these runs carry stands in section 6.
#
# **Next** [notebook 08](08_ablations.ipynb): which part of EMRLD makes the difference, and what turns out to be an accident of the code.

# %% [markdown]
# ## 7 · More about good demonstrations (further reading)
#
# **What if the wrong way were not punished?** The paper says two things about HalfCheetah. Its appendix B has a formula that pays beyond two metres *either* way, so that the wrong way costs; the
# released code does this, and so do we. Its Section 4.1 says that a reward comes "only after it has moved a certain number of units along the x-axis in the correct direction". With the policies above, a
# wrong way that costs nothing would lift the mean of GMPS a good deal:

# %% tags=["wrong-way-unpunished"]
clock.at("more about good demonstrations")
seeds = stored_seeds(runs.SHIPPED, "half_cheetah", "optimal")
for name in ALGORITHMS:
    tables = [run_scores(seeds[name], 1, place.goal) for place in ways]
    unpunished = np.mean([np.maximum(table, 0.0) for table in tables])
    both = np.mean(tables)
    print(f"{plotting.label(name):9} mean {both:6.1f}   wrong way unpunished {unpunished:6.1f}")

# %% [markdown]
# **Measured.** With negative returns counted as zero GMPS would have 75.4 and Meta-BC 168.5, where EMRLD has 197.4. EMRLD stays first and Meta-BC second; GMPS passes MAML.
#
# To count is not to train. GMPS is punished for the wrong way in every episode; does it need that, or does it suffer from it? So it was trained again with the reward of Section 4.1 (`paid_side="correct"`: the wrong way earns nothing, and costs nothing), and EMRLD and MAML beside it, three seeds each. (Meta-BC reads no reward: its training is the same.) **Predict first.** MAML stands still where the wrong way is punished. What does it do where it is not?

# %%
guess.ask("paid", "MAML, paid in the correct direction only: forward, backward")

# %% tags=["correct-side", "reveal"]
correctly = {}
for name in ("emrld", "gmps", "maml"):
    again = seeds_of(runs.SHIPPED, f"half_cheetah-correct-side-optimal-{name}")
    correctly[name] = again
    for paid, trained in (("either way", seeds[name]), ("the correct way", again)):
        ends = [worst_to_best(run_scores(trained, 1, place.goal)) for place in ways]
        print(
            f"{plotting.label(name):9}paid {paid:16}"
            + "forward {:5.1f}   backward {:5.1f}".format(*ends)
        )
guess.reveal("paid", "{:.1f}, {:.1f}".format(*ends))  # MAML's, the last of the loop
print("training, mean of ten iterations up to the 250th and up to the last")
for name in ("emrld", "maml"):
    early, late = (worst_to_best(training_scores(correctly[name], end)) for end in (250, None))
    print(f"{plotting.label(name):9}{early:5.1f}   {late:5.1f}")
gap = judge(*(run_scores(correctly[name], 1, BOTH_WAYS.goal) for name in ("emrld", "maml")))
print(f"both directions, EMRLD less MAML {gap:+5.1f}   {verdict(gap)}")

# %% [markdown] tags=["reveal"]
# **Measured.** EMRLD does without the punishment: after one step it has 82.6 forward and 284.2 backward, where it has 98.4 and 296.4 with it. GMPS does not learn to run forward without it either: 0.5 forward and 150.4 backward, after -174.0 and 150.8. So the punishment is not what keeps it from running forward; it only makes its mean look like that of a policy that stands still. And **MAML learns**: after 500 iterations it runs backward at 304.7, as well as EMRLD, but whichever way it is asked, with 0.0 forward. A run backward that is paid as much in one task as it costs in the other has nothing to gain from; unpunished, it has. So that MAML stands still on HalfCheetah is in good part the doing of the reward's formula, which sets the two tasks against each other, and not of sparsity alone.
#
# **Measured.** The mean over both directions is then 183.4 for EMRLD, 152.4 for MAML and 75.4 for GMPS (three seeds each), and 168.5 for Meta-BC with negative returns counted as zero (five). **EMRLD is ahead of MAML by this reading, too,** by at least 14.6, though MAML trained for twice as many iterations: after EMRLD's 250 its training stood at 116.4. MAML's curves still rise, by 8.0 % of the demonstrators' return in their last fifth. But who runs one way only has the mean of one direction and nothing: to reach EMRLD's it would have to run backward at 366.7, faster than the demonstrator, who has 329.9.
#
# **Was EMRLD searched as well?** The baselines have the settings that a search chose for them, EMRLD and EMRLD-WS have Table 1's throughout. Here is what such a search would have gained them on the goal-reaching environments: seed 0, the mean training return of iterations 61 to 80, with ten times the $\alpha$, half of TRPO's bound (its smaller step), and sigma fixed.

# %% tags=["search-emrld"]
changes = {"10 alpha": "alpha0.1", "half the bound": "kl0.005", "sigma fixed": "fixed-sigma"}
print(f"{'':34}{'Table 1, its five seeds':27}" + "".join(f"{title:>16}" for title in changes))
for env, title in (("point2d", "Point2D"), ("two_wheeled", "TwoWheeled")):
    for quality in STEPS_SHOWN:
        for name in OURS:
            seeds = stored_seeds(runs.SHIPPED, env, quality)[name]
            own = training_scores(seeds, end=80, window=20)  # (seed,)
            found = [f"search-{env}-{quality}-{name}-{change}-seed0" for change in changes.values()]
            tried = training_scores([runs.SHIPPED / run for run in found], window=20)
            print(f"{title:12}{quality:12}{plotting.label(name):10}", end="")
            print("".join(f"{score:5.0f}" for score in own) + "  ", end="")
            print("".join(f"{score:16.1f}" for score in tried))

# %% [markdown]
# **Measured.** Little. In seven rows of eight no setting ends above Table 1's values with the same seed by more than 1.3. In the eighth, EMRLD on TwoWheeled with optimal data, that seed is a late one: it has 23.9 by then, and 76.2 with half of the bound, where three of its other seeds have 74.4 and more without it. So the comparison does not hang on a search that EMRLD did not get (HalfCheetah was not tried).
#
# **Is the warm start at least quicker?** The paper's abstract calls it "particularly efficient for sub-optimal demonstration data". Here is the mean return over the first thirty training iterations.

# %% tags=["warm-start-begins"]
for quality in STEPS_SHOWN:
    for env, title in TITLES.items():
        seeds = stored_seeds(runs.SHIPPED, env, quality)
        plain, warm = (training_scores(seeds[name], end=30, window=30) for name in OURS)
        gap = judge(warm, plain)
        print(f"{quality:11}{title:12}EMRLD-WS less EMRLD: {gap:+6.1f}   {verdict(gap)}")

# %% [markdown]
# **Measured.** On Point2D and TwoWheeled it is: by 17.8 and 15.7 with optimal data, of which the second is not distinguishable from nothing, and by 8.0 and 11.5 with sub-optimal data. On HalfCheetah it is, too, by 18.6 and 9.8. So it is quicker, and with bad data not more so than with good.
#
# **Which goals does MAML reach?** On TwoWheeled the twenty test goals are not spread evenly. Where a policy goes one way, whichever goal is asked for, its mean depends on how many goals happen to lie there; with goals drawn evenly it would be another.

# %% tags=["maml-goes-left"]
goals = unseen_demonstrations("two_wheeled", "optimal", 20).tasks.numpy()
left = np.degrees(np.arctan2(goals[:, 1], goals[:, 0])) > 120
table = task_scores(stored_seeds(runs.SHIPPED, "two_wheeled", "optimal")["maml"], step=1)
print(f"{left.sum()} of {len(goals)} test goals lie left of 120 degrees. MAML's mean return:")
for seed, row in enumerate(table):
    print(f"seed {seed}: {row[left].mean():5.1f} on those, {row[~left].mean():5.1f} on the others")

# %% [markdown]
# ## 8 · The later steps need a smaller rate (further reading)
#
# The meta-policy was trained for one step, and makes it a long one. All stored three-step numbers use a tenth of $\alpha$ for the later steps, and that tenth was picked
# with the *test* tasks in sight. So here is the choice again, for EMRLD on TwoWheeled, on the *training* tasks, where it belongs; and then the test tasks with that choice, the stored one, and the paper's own $\alpha$.
#
# **Predict first.** At the paper's own $\alpha$ for all steps, is EMRLD's return after three steps higher than after one?

# %%
clock.at("the later steps")
guess.ask("later", "after three full steps the return is", ["higher", "about as high", "lower"])

# %%
seeds = stored_seeds(runs.SHIPPED, "two_wheeled", "suboptimal")


def returns_at(rate, data=None):
    """Return EMRLD's returns after 0 to 3 steps, a mean over seeds, on data or the training tasks."""
    curves = []
    for run in map(runs.load_run, seeds["emrld"]):
        curve = evaluate_run(run, data or run.load_demonstrations(), later_rate=rate)
        curves.append([float(episode_returns(rollout).mean()) for rollout in curve.rollouts])
    return np.mean(curves, axis=0)


def show(table):
    """Print the returns after each step, a line per rate."""
    for rate, means in table.items():
        print(f"  later steps at {rate:.2f} of alpha" + "".join(f"{mean:8.1f}" for mean in means))


# %% tags=["later-rates", "statistical", "tolerance:0.15", "tolerance:abs=8", "reveal"]
training = {rate: returns_at(rate) for rate in (1.0, 0.3, 0.1, 0.03)}
print("EMRLD, mean return after 0, 1, 2 and 3 steps, training tasks")
show(training)
assert training[1.0][3] < training[1.0][1]
one, three = training[1.0][1], training[1.0][3]
guess.reveal("later", f"lower: {three:.1f} after three full steps, {one:.1f} after one")

# %% tags=["later-rates-test", "statistical", "tolerance:0.15", "tolerance:abs=8", "reveal"]
chosen = max((0.3, 0.1, 0.03), key=lambda rate: training[rate][3])
test = {0.1: np.mean([results.returns_by_step(run) for run in seeds["emrld"]], axis=0)}  # stored
if chosen != 0.1:
    test[chosen] = returns_at(chosen, unseen_demonstrations("two_wheeled", "suboptimal", 20))
print("EMRLD, mean return after 0, 1, 2 and 3 steps, test tasks")
show(test)

# %% [markdown] tags=["reveal"]
# And if nobody chooses a rate? Here are both variants at the paper's own for all three steps, on test tasks, beside the best that any baseline has in its stored tests after any number of steps.

# %% tags=["later-full-steps", "statistical", "tolerance:0.15", "tolerance:abs=8", "reveal"]
for env in ("point2d", "two_wheeled"):
    stored, full = stored_seeds(runs.SHIPPED, env, "suboptimal"), {}
    for name in OURS:
        curves = []
        for run in map(runs.load_run, stored[name]):
            curve = evaluate_run(run, testing_demonstrations(run), later_rate=1.0)
            curves.append([float(episode_returns(rollout).mean()) for rollout in curve.rollouts])
        full[name] = np.array(curves)  # (seed, step)
        line = "".join(f"{mean:8.1f}" for mean in full[name].mean(0))
        print(
            f"{TITLES[env]:11}{plotting.label(name):9}{line}   worst seed {full[name][:, 3].min():.1f}"
        )
    best = max(run_scores(stored[name], step).mean() for name in BASELINES for step in range(4))
    assert min(full[name][:, 3].mean() for name in OURS) > best
    print(f"{TITLES[env]:11}best baseline, any step: {best:.1f}")
    for name in OURS:
        gaps = [judge(full[name][:, 3], run_scores(stored[rival], 3)) for rival in BASELINES]
        least = min(gaps, key=lambda gap: gap.low)
        print(f"{TITLES[env]:11}{plotting.label(name):9}less any baseline: at least {least:+.1f}")

# %% [markdown] tags=["reveal"]
# At the paper's $\alpha$ the later steps cost EMRLD much, on the training tasks as on the test tasks; EMRLD-WS loses less, and on Point2D nothing. Even so EMRLD-WS stays ahead of every baseline by your interval, on the goal-reaching environments; so does EMRLD on Point2D, and on TwoWheeled its interval ends about at zero. So there the conclusion of section 3 does not hang on the tenth (HalfCheetah was not tried at the full rate): the rate decides how much
# is left after three steps, and whether the later ones help. With optimal data the mean of EMRLD falls with later steps even at a tenth (Figure 5), on HalfCheetah a little, on TwoWheeled by more, through one seed of five that loses all it has; five seeds cannot tell either fall from nothing.

# %% [markdown]
# ## 9 · All environments at once (further reading)
#
# Returns of different environments cannot be averaged, but shares can. We divide each run's score, on HalfCheetah the mean over both directions, by the mean return of the *optimal* demonstrations, also where the data are
# sub-optimal, and pool the runs. Agarwal et al. (2021) recommend the **interquartile mean** (IQM) for such a pool: sort all $n$ scores, leave out the lowest and the highest $\lfloor n/4 \rfloor$, and average the
# rest. One lost run then moves the number less than it moves a mean.
#
# **Predict first.** Bad data cost both variants of EMRLD some points of the pooled share. In which environment do they cost EMRLD most?

# %%
clock.at("all environments at once")
guess.ask("dear", "bad data cost EMRLD most on", [*TITLES.values()])

# %% tags=["pooled", "reveal"]
figure, axes = plt.subplots(figsize=(6.4, 3.2))
pooled = {}
for shift, (quality, step) in zip((-0.2, 0.2), STEPS_SHOWN.items(), strict=True):
    for place, name in enumerate(ALGORITHMS):
        seeds = {env: stored_seeds(runs.SHIPPED, env, quality)[name] for env in TITLES}
        shares = np.concatenate([run_scores(seeds[env], step) / EARNED[env] for env in TITLES])
        pooled[quality, name] = shares
        look = {key: plotting.LOOKS[name][key] for key in ("color", "marker")}
        filled = {} if quality == "optimal" else {"markerfacecolor": "white"}
        plotting.runs_and_mean(shares, place + shift, axes, **look, **filled)
axes.set_xticks(range(5), [plotting.label(name) for name in ALGORITHMS])
axes.set_ylabel("share of the optimal\ndemonstrations' return")
axes.set_ylim(top=1.06)
plt.show()

# %% [markdown] tags=["reveal"]
# *Figure 13. Each run of the three environments, as a share of the optimal demonstrations' mean return, and the plain mean over all runs (bar). Filled: optimal data, one step. Open: sub-optimal data, three steps, the later ones at a tenth of the rate. Look at
# the lowest points of EMRLD and of Meta-BC.*

# %% tags=["pooled-means", "reveal"]
print(f"{'':11}{'plain mean':>22}{'interquartile mean':>24}")
print(f"{'':11}" + f"{'optimal':>11}{'sub-opt.':>11}" * 2)
for name in ALGORITHMS:
    tables = [pooled[quality, name] for quality in STEPS_SHOWN]
    means = [table.mean() for table in tables] + [interquartile_mean(table) for table in tables]
    print(f"{plotting.label(name):11}" + "".join(f"{mean:>11.0%}" for mean in means))
good, bad = (
    {
        env: run_scores(stored_seeds(runs.SHIPPED, env, quality)["emrld"], step).mean()
        / EARNED[env]
        for env in TITLES
    }
    for quality, step in STEPS_SHOWN.items()
)
cost = {title: float(good[env] - bad[env]) for env, title in TITLES.items()}
print("EMRLD loses with bad data: " + ", ".join(f"{t} {lost:.1%}" for t, lost in cost.items()))
guess.reveal("dear", max(cost, key=cost.get))

# %% [markdown] tags=["reveal"]
# **Measured.** In the plain mean EMRLD and EMRLD-WS reach 91 % and 91 % of the optimal demonstrations' return with optimal data, 84 % and 88 % with sub-optimal data. The best baseline stays at 57 % and 21 %: the paper's main claim in
# one picture, and it stands. But one number for three environments does not say where a loss comes from: bad data cost EMRLD 2.8 % of the demonstrations' return on Point2D, 3.1 % on TwoWheeled and 15.7 % on HalfCheetah, where either curve still climbs: three steps on bad data against one on good, as the paper shows them. (Section 3 compares after one step on both. HalfCheetah's share is of 237.0, the demonstrations' return with their last step.) And a robust mean leaves out what one may want to know. With Meta-BC's unclipped runs of HalfCheetah in the pool its interquartile mean with optimal data is 54 %, its plain mean 50 %: the difference is the seed that lost all, which the IQM drops as an accident.
# Where one training in five loses all that it has learned, that *is* the result. We use the plain mean, and show every run.

# %% [markdown]
# ## 10 · One run again, live (further reading)
#
# A stored curve is a promise: the same command makes it again. But a sum depends on the order in which it is added up, and
# every kind of processor has its own. The last digits differ, and after some iterations of thousands of random steps each the curves part: the same seed
# is another draw on another machine. Notebook 06 shows how far draws lie apart. The run in `data/portable` was made with three environment variables that ask for
# the oldest arithmetic, which all x86 processors share (and make it 1.6 times slower, on an AMD EPYC). It says of itself:

# %% tags=["promise"]
clock.at("one run again")
facts = read_json(elsewhere.PORTABLE_RUN / "provenance.json", "provenance")
print(facts["command"])
for name, value in facts["variables"].items():
    print(f"    {name}={value}")
print("made on:", facts["processor"])

# %% [markdown]
# **Predict first.** Eight iterations again, now, on your processor: how many of the eight returns agree in every digit?

# %%
guess.ask("digits", "returns of eight that agree in every digit")

# %% tags=["replay", "nbval-ignore-output", "reveal"]
promised = runs.load_run(elsewhere.PORTABLE_RUN).curve
with tempfile.TemporaryDirectory() as folder:
    live = elsewhere.repeat(elsewhere.PORTABLE_RUN, Path(folder) / "again", iterations=8)
print("iteration     stored   just now")
for one, other in zip(promised, live, strict=False):
    print(f"{one.iteration:9} {one.return_after:10.6f} {other.return_after:10.6f}")
pairs = [(a.return_after, b.return_after) for a, b in zip(promised, live, strict=False)]
assert not machine.repeats_digits(facts) or all(one == other for one, other in pairs)
assert abs(pairs[0][1] / pairs[0][0] - 1) < 0.01
guess.reveal("digits", f"{sum(one == other for one, other in pairs)}, on the machine that ran this")

# %% [markdown] tags=["reveal"]
# On the two models of AMD EPYC that were tried, with the same versions of torch and numpy, all eight agree in every digit. The variables promise as much for every x86 processor, and do not keep it: on an Intel Xeon the return of the first iteration agrees in every digit, but the KL of its update differs by six parts in a million, and
# from the fifth iteration on the curves have parted. What agrees everywhere is the beginning, to a per cent, since all random numbers are the same.

# %% [markdown]
# ## 11 · Why GMPS breaks down (further reading)
#
# GMPS adapts by RL and clones in the meta-update: Adam lowers the cloning loss of the *adapted* policies, and its gradient goes through the adaptation step. That step is short ($\alpha$ times a gradient of few rewards), yet after it twelve different demonstrations should be likely. Here are its trainings on Point2D with sub-optimal data, as they ended, with Adam's memory. They make one more update, and we look at the tasks one by one: how far does it move the adapted policy where the RL step did something, and where no reward was seen?
#
# **Predict first.** Take the mean KL of the tasks with a step, and divide it by that of the tasks without one. What is the ratio, in the median over the five seeds?

# %%
clock.at("why gmps breaks down")
guess.ask("ratio", "KL of tasks with an RL step, as a multiple of that without")


# %%
def one_more_update(run):
    """Return, by task, the length of the RL step and the KL by which one more update moves its result."""
    config, demos = run.config, run.load_demonstrations()
    world, score, rule = config.environment(), config.score(), config.adaptation(demos.quality)
    draws, theta = torch.Generator().manual_seed(0), run.meta_params
    trial = score(collect(world, demos.tasks, theta, 20, draws))
    adapted = adapt(theta, trial, demos, rule)
    after = score(collect(world, demos.tasks, adapted, 20, draws))
    learner = config.learner(theta)
    learner.load(run.learner_state)
    updated, _ = learner.update(theta, TaskData(trial, after, demos), rule, draws)
    policies = [
        policy.distribution(p, after.states) for p in (adapted, adapt(updated, trial, demos, rule))
    ]
    moved = losses.task_mean(policy.kl_divergence(*policies), after.mask)
    step = torch.cat([(adapted[name] - theta[name]).flatten(1) for name in theta], 1)
    return step.norm(dim=1), moved


# %% tags=["gmps-one-more-update", "nbval-ignore-output", "reveal"]
ratios = {}
for title, name in {"second order": "gmps", "first order": "gmps-first-order"}.items():
    for run in map(runs.load_run, seeds_of(runs.SHIPPED, f"point2d-suboptimal-{name}")):
        length, moved = one_more_update(run)
        with_step, without = (float(moved[chosen].mean()) for chosen in (length > 0, length == 0))
        ratios.setdefault(title, []).append(with_step / without)
        weights = float(policy.to_vector(run.meta_params).norm())
        print(f"{title}, seed {run.config.seed}: parameters {weights:4.1f} long, RL steps", end="")
        print(f" {float(length[length > 0].mean()):.3f}", end="")
        print(f"; KL with a step {with_step:9.2g}, without one {without:9.2g}")
medians = {title: float(np.median(found)) for title, found in ratios.items()}
assert medians["second order"] > 10 and medians["first order"] < 5
guess.reveal("ratio", "second order {:.0f}, first order {:.1f}".format(*medians.values()))

# %% [markdown] tags=["reveal"]
# The break is by far largest in the tasks with a step. Their policies fly apart; those of the tasks that share $\theta$ move much less, though by more than a nat with four seeds of five. To make so short a step count, the meta-update has made the policy *sensitive* to it: what a step of a few hundredths turns it into depends so strongly on $\theta$, and on the few rewards of one iteration, that one more update throws it far away.
#
# If that is the cause, it must go away when the gradient does not pass through the step. That is the *first-order* gradient (`second_order=False`), which the last lines show. And is a smaller learning rate a cure, or a gradient that is clipped to a length of 0.5 before Adam sees it? And the paper's reason, little data? The last row has twenty noisy paths per goal in place of one clean one, and 300 iterations. Here are the trainings.

# %% tags=["gmps-in-bounds", "reveal"]
trainings_of_gmps = {
    "as in the comparison": "point2d-suboptimal-gmps",
    "first order": "point2d-suboptimal-gmps-first-order",
    "Table 1": "search-point2d-suboptimal-gmps-table1",
    "Table 1, clipped": "search-point2d-suboptimal-gmps-clip0.5",
    "a fifth of the rate, sub-optimal": "point2d-suboptimal-gmps-rate0.002-long",
    "a fifth of the rate, optimal": "point2d-optimal-gmps-rate0.002-long",
    "as in the comparison, optimal": "point2d-optimal-gmps",
    "twenty noisy paths per goal": "point2d-gmps-paths",
}
for title, name in trainings_of_gmps.items():
    seeds = seeds_of(runs.SHIPPED, name)
    moved = [row.kl for run in seeds for row in runs.load_curve(run / "curve.csv")]
    ends = training_scores(seeds, window=20)
    print(
        f"{title:33}{sum(kl > 1 for kl in moved):4} of {len(moved)} updates above one nat,", end=""
    )
    print(f" returns at the end {ends.min():.1f} to {ends.max():.1f}")

# %% [markdown] tags=["reveal"]
# **Measured.** With the first-order gradient 2 of 450 updates exceed one nat, where 517 of 750 did. A fifth of Adam's rate (one seed, Table 1's $\alpha$) is no cure: it stays in bounds for 166 updates in place of 56 with sub-optimal data, and for 196 in place of 84 to 121 with optimal; then 579 and 406 of 750 exceed it, with optimal data a larger share than at the full rate. Nor is clipping: with it 101 of 150 updates exceed one nat, at Table 1's values without it 88 (one seed each). So single long gradients are not what breaks it. More data keep it whole: with twenty noisy paths per goal 0 of 900 updates exceed one nat, on TwoWheeled as well, and on unseen goals it returns 4.2 and 11.6, where it has 1.5 and 10.7 with one clean path. (Whether their number does it or their noise these runs do not say.) Kept in bounds by the first-order gradient GMPS returns as little as before, 0.5 against 0.5. So the break does not explain why it fails; though a first-order gradient cannot teach $\theta$ to make its RL step useful, so what a bounded second-order GMPS would learn is open.

# %% [markdown]
# ## 12 · Drifts that training did not meet (further reading)
#
# The paper does not name its nine training drifts, and ours reach as far as the test's. Suppose that the paper's were small. Then the drift of its robot, -0.65, would be one that no training met, and the adaptation would have to go beyond what it learned from. Perhaps that is where MAML fails and EMRLD does not?
#
# So the trainings of section 4 were repeated with nine drifts of at most 0.3, all else alike: four readings, five algorithms, five seeds. The test is the same, twenty drifts of which most lie beyond 0.3.
#
# **Predict first.** With the heading in the state and the drift a rate, how much does each of EMRLD and MAML lose on the drifts beyond 0.3, when it was trained on narrow ones?

# %%
clock.at("drifts never met")
guess.ask("narrow", "what is lost beyond 0.3 (return): EMRLD, MAML")

# %% tags=["by-drift", "reveal"]
figure = drift_figures.by_drift(runs.SHIPPED)
plt.show()

# %% [markdown] tags=["reveal"]
# *Figure 14. Return after one adaptation step by the test drift, a column per reading. Above: the policies of section 4, trained on drifts spread over the whole axis. Below: policies trained on drifts in the grey part only. Lines are means over five seeds, bands reach from the lowest seed to the highest. In which columns does a line of the lower row keep its height outside of the grey part?*

# %% tags=["narrow-drifts", "reveal"]
lost = {}
for reading in READINGS:
    drifts = unseen_demonstrations(reading.env, "optimal", 20).tasks[:, 0].numpy()
    far = np.abs(drifts) > NARROW_DRIFT
    print(f"{reading.title}: {far.sum()} of {len(drifts)} test drifts are beyond {NARROW_DRIFT}")
    spread, narrow = (
        stored_seeds(runs.SHIPPED, name, "optimal") for name in (reading.runs, reading.narrow)
    )
    beyond = {}
    for name, folders in narrow.items():
        before, after = (task_scores(folders, step) for step in (0, 1))  # (seed, drift)
        steady = task_scores(folders, 1, table=BY_MEAN)
        beyond[name] = after[:, far].mean(1), steady[:, far].mean(1)
        lost[reading, name] = task_scores(spread[name], 1)[:, far].mean() - after[:, far].mean()
        print(
            f"  {plotting.label(name):9}within {before[:, ~far].mean():5.1f} before the step",
            end="",
        )
        print(
            f", {after[:, ~far].mean():5.1f} after;   beyond {before[:, far].mean():5.1f}", end=""
        )
        print(f" before, {worst_to_best(beyond[name][0]):5.1f} after")
    for name in OURS:
        pairs = zip(("sampled", "by the mean"), beyond[name], beyond["maml"], strict=True)
        for way, one, other in pairs:
            gap = judge(one, other)
            print(
                f"  {plotting.label(name):9}less MAML beyond, {way:11} {gap:+5.1f}   {verdict(gap)}"
            )
guess.reveal("narrow", ", ".join(f"{lost[READINGS[0], name]:.1f}" for name in ("emrld", "maml")))

# %% [markdown] tags=["reveal"]
# **Measured.** On drifts within 0.3 and with the heading in the state all three, EMRLD, EMRLD-WS and MAML, have 74.3 or more. Beyond them, and with the drift a rate, MAML keeps 70.9, EMRLD and EMRLD-WS have 50.1 and 47.7, and they are behind by at least 13.1 and 18.8 (by the mean action 9.2 and 11.3). That looks as if the claim turned round. But the mean hides two sides: at positive drifts the three have 30.1, 24.5 and 74.2, at negative ones, where the paper's -0.65 lies, 72.8, 74.3 and 67.1. Section 13 finds the reason in our demonstrations, and without it neither variant can be told from MAML. With the drift as printed their 65.2 and 60.7 cannot be told from MAML's 69.9.
#
# **Measured.** Without the heading and with a rate MAML has 33.3 beyond 0.3, and the variants 22.3 and 14.1; EMRLD cannot be told from MAML, and EMRLD-WS is behind, by 4.0 at least, sampled and by the mean action (not so once the demonstrations are mended). As printed **EMRLD is ahead**, with 38.8 to MAML's 13.1, by at least 18.1 (by the mean action 19.2), and EMRLD-WS's 8.0 cannot be told from MAML's. These trainings took 500 iterations, as long as those on spread drifts; MAML is flat at their end, rising by 0.7 % and 3.5 %. Meta-BC and GMPS return at most 4.2 and 0.5 beyond 0.3, sampled, in any reading.
#
# So narrow drifts in the training do not make MAML fail. Where it sees its heading it has learned to steer by it, and that serves drifts it never met. Where it does not see it, it loses much, and so do the variants; EMRLD is ahead if the drift acts as printed.
#
# **Why does EMRLD-WS do worse than EMRLD here?** Its mean over seeds hides opposite cases. Its warm start is one step of gradient descent on the cloning loss of one demonstration, so it should lower that loss. Does it? No episode is needed to see.

# %% tags=["overshoot", "reveal"]
print("EMRLD-WS: training tasks whose cloning loss the warm start raises, and the return, by seed")
for reading in READINGS:
    for drifts, name in (("spread", reading.runs), ("narrow", reading.narrow)):
        found = stored_seeds(runs.SHIPPED, name, "optimal")["emrld-ws"]
        pairs = [cloning_before_and_after_warm_start(runs.load_run(run)) for run in found]
        raised = [int((after > before).sum()) for before, after in pairs]
        ends = "".join(f"{score:6.1f}" for score in training_scores(found))
        print(f"{reading.title:33}{drifts:8}{raised} of {len(pairs[0][0])}   {ends}")

# %% [markdown] tags=["reveal"]
# **Measured.** Not always. On spread drifts, and with the heading in the state, the warm start of no run raises the loss in any task. Without the heading and after narrow drifts it does in five runs of ten, in 5 to 9 of the nine tasks. There it overshoots: training has made $\sigma$ small and with it the loss steep, and at Table 1's $\alpha$ the step goes over the minimum and up the other side. **These five runs end their training with 37.3 at most.** Of the other five four end with 56.6 or more; the last, with 0.0, hardly ever met a reward.
#
# So the first step is too long there. **Does a shorter one help?** Here are the two readings once more, trained with $\alpha = 0.003$ in place of 0.01. (The paper has one $\alpha$, so the step that follows the warm start is shorter, too.)

# %% tags=["overshoot-shorter", "reveal"]
print(
    "EMRLD-WS, narrow drifts, heading hidden: tasks whose loss is raised, of nine, and the training's"
)
print("return at its end, by seed; then on test drifts beyond 0.3, after one step")
ended = {"0.01": [], "0.003": []}
for reading in READINGS[2:]:
    drifts = unseen_demonstrations(reading.env, "optimal", 20).tasks[:, 0].numpy()
    wide = np.abs(drifts) > NARROW_DRIFT
    others = stored_seeds(runs.SHIPPED, reading.narrow, "optimal")
    for alpha, name in (("0.01", reading.narrow), ("0.003", reading.narrow + SHORTER_STEP)):
        found = stored_seeds(runs.SHIPPED, name, "optimal")["emrld-ws"]
        pairs = [cloning_before_and_after_warm_start(runs.load_run(run)) for run in found]
        raised = [int((after > before).sum()) for before, after in pairs]
        ended[alpha] += list(training_scores(found))
        ends = "".join(f"{score:6.1f}" for score in ended[alpha][-len(found) :])
        tested = task_scores(found, 1)[:, wide].mean(1)
        print(f"{reading.title}, alpha {alpha:6}{raised}{ends}   test {worst_to_best(tested):5.1f}")
        for other in ("emrld", "maml"):
            gap = judge(tested, task_scores(others[other], 1)[:, wide].mean(1))
            print(f"{'':40}less {plotting.label(other):6}{gap:+6.1f}   {verdict(gap)}")
gap = judge(np.array(ended["0.003"]), np.array(ended["0.01"]))
print(f"the training's return at its end, ten runs each, alpha 0.003 less 0.01: {gap:+.1f}")

# %% [markdown] tags=["reveal"]
# **Measured.** It does. **The five runs that overshot end with 58.3 or more,** and the one that hardly met a reward with 50.8; on average the ten end with 60.0 in place of 36.8. (The worst runs of ten, drawn again, would do better anyway. So the verdict is that of all ten against all ten: the shorter step is ahead, by at least 1.2.) So what failed there was mostly the length of the step. But $\sigma$ goes on shrinking, and at the end of the training the shorter step raises the loss, too, in four runs of ten, in 2 to 9 of the nine tasks. These end with 35.1 to 64.2: not every overshoot is a failure. On drifts beyond 0.3 EMRLD-WS has 18.9 with a rate and 21.7 as printed now, where it had 14.1 and 8.0. With a rate it is behind MAML still, by at least 2.5 (shown the demonstrations as they are), as printed behind EMRLD, by at least 3.1. (We chose this $\alpha$ after we had seen the runs and tried no other; EMRLD and MAML kept theirs.)

# %% [markdown]
# ## 13 · What the demonstrator asks for (further reading)
#
# In sections 4 and 12 both variants lose return at positive drifts, and MAML does not. MAML reads no demonstrations. So before one blames the method one looks at the data: which actions do the demonstrations hold?
#
# An action has two numbers, speed and steering, and the robot clips both at 1: who asks for 3 gets 1. The demonstrations hold what the expert asked for. **Predict first.** How large is the largest steering in the demonstration of each end, at -0.8 and at 0.8 radians per second?

# %%
clock.at("what the demonstrator asks for")
guess.ask("steering", "largest steering at -0.8 and at 0.8")

# %% tags=["steering", "reveal"]
figure = drift_figures.steering()
plt.show()
world = READINGS[0].env
shown = unseen_demonstrations(world, "optimal", 20)
largest = {}
for title, data in (("training", load_demonstrations("optimal", world)), ("test", shown)):
    drifts = data.tasks[:, 0].numpy()
    largest[title] = data.actions[:, 0, :, 1].abs().amax(-1).numpy()  # (task,)
    for side, chosen in (("negative", drifts < 0), ("positive", drifts > 0)):
        print(f"{title:9}{side} drifts: at most {largest[title][chosen].max():.1f}")
guess.reveal("steering", "{:.1f} and {:.1f}".format(*largest["training"][[0, -1]]))

# %% [markdown] tags=["reveal"]
# *Figure 15. The steering that the demonstrations ask for, the drift a rate. Left: step by step, at both ends of the drifts and in the middle. Right: the largest of each demonstration, by its drift. In the grey part the robot does no more than at its edge.*

# %% [markdown] tags=["reveal"]
# **Measured.** Against negative drifts the demonstrations ask for at most 1.3, against positive ones for up to 4.2 in the training, and for up to about 5 in the test. **Our expert over-corrects at positive drifts:** from 0.4 on its steering swings from one side to the other near the goal. The robot makes 1 of it and arrives, so the return says nothing of it. But a cloning step is asked to imitate that, and a few such actions, many $\sigma$ away from all others, outweigh the rest of the path. That is an error in our data, and none of the paper's that we know of. (With the drift as printed nothing swings: the largest steering is 2.3, and held.)
#
# So we cut the steering to 1 (`demos --cut`). The path stays the same, since 1 is what the robot did. First in the test alone, with the stored policies; then in the training as well, of everyone who reads demonstrations. (The narrow training drifts need no new training: their demonstrations steer by 0.9 at most.)

# %% tags=["steering-cut", "reveal"]
for reading in CUT_READINGS:
    drifts = unseen_demonstrations(reading.env, "optimal", 20).tasks[:, 0].numpy()
    for trained, name in (("spread", reading.runs), ("narrow", reading.narrow)):
        chosen = np.abs(drifts) > (NARROW_DRIFT if trained == "narrow" else 0.0)
        print(f"{reading.title}, {trained} training drifts, one step on {chosen.sum()} test drifts")
        found = stored_seeds(runs.SHIPPED, name, "optimal")
        maml = task_scores(found["maml"], 1)[:, chosen].mean(1)
        readers = (*OURS, "meta-bc")  # GMPS's step reads no demonstration, its training does
        ways = [(one, "as they are", found, SAMPLED) for one in (*readers, "gmps")]
        ways += [(one, "cut in the test", found, CUT) for one in readers]
        if trained == "spread":
            again = stored_seeds(runs.SHIPPED, reading.cut, "optimal")
            ways += [(one, "cut in both", again, CUT) for one in readers]
            ways += [("gmps", "cut in training", again, SAMPLED)]
        for one, way, seeds, table in ways:
            tested = task_scores(seeds[one], 1, table=table)  # (seed, drift)
            sides = [tested[:, chosen & (sign * drifts > 0)].mean() for sign in (-1, 1)]
            gap = judge(tested[:, chosen].mean(1), maml)
            line = (
                f"  {plotting.label(one):9}{way:16}{worst_to_best(tested[:, chosen].mean(1)):5.1f}"
            )
            print(f"{line}   by side {sides[0]:5.1f} {sides[1]:5.1f}", end="")
            print(f"   less MAML: {gap:+5.1f}   {verdict(gap)}")
        print(f"  MAML{'':21}{worst_to_best(maml):5.1f}")

# %% tags=["by-steering", "reveal"]
figure = drift_figures.by_drift_and_steering(runs.SHIPPED)
plt.show()

# %% [markdown] tags=["reveal"]
# *Figure 16. Return after one adaptation step by the test drift, the drift a rate, a column per state. Above trained on drifts as wide as the test's, below on those in the grey part. Lines with markers: EMRLD and EMRLD-WS shown demonstrations whose steering is cut to 1, in the training and in the test, and MAML, which reads none. Thin lines: the two with the demonstrations as they are. Means over five seeds.*

# %% [markdown] tags=["reveal"]
# **Measured.** Cut in the test alone, by the stored policies. **With the heading seen, what was lost at positive drifts is our demonstrations' doing.** After narrow training drifts EMRLD goes from 50.1 to 72.1 beyond 0.3 and EMRLD-WS from 47.7 to 61.8, and neither can be told from MAML's 70.9 any more (a loss of 4.2 and of 25.6 is possible). After spread ones EMRLD goes from 70.4 to 73.7, its lost seed among them, and still cannot be told from MAML; EMRLD-WS has 74.2. **With the heading hidden it is so in part.** 45.1 and 53.3 become 50.4 and 59.0, and EMRLD-WS is ahead of MAML by at least 2.3; after narrow drifts they have 28.2 and 20.2, and neither can be told from MAML's 33.3.
#
# **Measured.** Cut in the training as well, the heading seen, **EMRLD and EMRLD-WS solve it: 74.4 and 74.5,** as much as the demonstrations earn, and the worst of their ten seeds has 74.4. EMRLD's worst had 55.3 before. MAML has 71.0, but four of its seeds have at least 74.0: nothing is left to be ahead by. EMRLD cannot be told from it, and EMRLD-WS is ahead by a hair, as before.
#
# **Measured.** Cut in both, the heading hidden, three of EMRLD's five seeds have at least 58.8 on either side. But the seeds scatter: EMRLD's from 2.4, which never learned, to 67.2, and EMRLD-WS's from 30.0, whose warm start overshoots in 5 of the nine tasks as it does after narrow drifts, to 66.3. Their means are 46.1 and 51.1, and neither can be told from MAML's 44.4. **So these trainings do not confirm the small lead** that EMRLD-WS has with the drift a rate and the heading hidden: it may be anything from -7.7 to 20.2. Nor do they confirm that the variants lead at negative drifts.
#
# **Measured.** The swings are not what holds Meta-BC and GMPS back, at the settings that the search chose with the data as they are. Trained and shown the cut demonstrations, Meta-BC has 26.5 with the heading and 3.4 without, where it has 32.3 and 4.0 on those as they are; GMPS has 2.7 and 0.0, and 5.6 and 0.0 before. (By the mean action and with sigma fixed Meta-BC is another matter, as was seen above.)
#
# **Measured.** What this does not say. We found the swings because our own method lost, after we had seen the runs. The demonstrations of the other environments ask for more than 1 as well, HalfCheetah's for up to 6.6; nothing was cut there.

# %% [markdown]
# **References** Agarwal, Schwarzer, Castro, Courville and Bellemare (2021), *Deep reinforcement learning at the edge of the
# statistical precipice*; Colas, Sigaud and Oudeyer (2018), *How many random seeds?*; Hodges and Lehmann (1963), *Estimates of location based on rank tests*; Mann and Whitney (1947), *On a test
# of whether one of two random variables is stochastically larger than the other*; Rengarajan et al. (2022), the paper.
