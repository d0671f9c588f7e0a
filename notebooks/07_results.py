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
# what they show. Here you draw the same figures from runs that are stored beside this notebook, and ask of every sentence:
# does it hold here, **and how sure can so few runs make us**? The main claim holds. Several of the others hold only in part, and
# two of the baselines turn out to have diverged in training, so that their curves do not show what the paper takes them to show.
#
# **You will be able to**
#
# - say what the range from the worst seed to the best covers, and how often,
# - measure how often a rule calls one of two equal algorithms better, and use a rule whose error is known,
# - read Figs. 3 to 6 claim by claim, and look behind a mean over tasks,
# - tell whether a curve has flattened, and repeat a stored run digit for digit.
#
# **You need** notebooks 05 (MAML, Meta-BC, GMPS) and 06 (EMRLD). **Time** about 75 minutes, of which the machine computes
# three. **Paper** Section 4 (experiments), Figs. 3 to 6, of Rengarajan et al., NeurIPS 2022.

# %%
import math
import platform
import tempfile
from importlib import metadata
from itertools import combinations
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import torch

from emrld_lite.algorithms import ALGORITHMS
from emrld_lite.classroom import checks as check
from emrld_lite.classroom.clock import Clock
from emrld_lite.demonstrators.recipes import unseen_demonstrations
from emrld_lite.envs import make
from emrld_lite.experiments import elsewhere, paper_figures, plotting, results, runs
from emrld_lite.experiments.evaluation import evaluate_run
from emrld_lite.experiments.intervals import (
    AHEAD,
    BEHIND,
    EVEN,
    Interval,
    median_coverage,
    rank_of_ends,
    shift_interval,
    verdict,
    worst_to_best,
)
from emrld_lite.experiments.intervals import interquartile_mean as package_mean
from emrld_lite.experiments.results import (
    BOTH_WAYS,
    EARNED,
    FLAT,
    NOTHING,
    PLACES,
    STEPS_SHOWN,
    TITLES,
    largest_fall,
    run_scores,
    stored_seeds,
    training_scores,
)
from emrld_lite.rollout import episode_returns
from emrld_lite.storage import read_json
from emrld_lite.trpo import TrustRegion

plotting.use_style()
torch.set_num_threads(1)  # leaves the other cores to you
clock = Clock(
    {
        "how sure can a few runs make us": 30,
        "good demonstrations": 15,
        "bad demonstrations": 10,
        "changing dynamics": 5,
        "are the runs long enough, and are they real": 15,
    }
)
OURS, BASELINES = ("emrld", "emrld-ws"), ("maml", "meta-bc", "gmps")

# %% [markdown]
# ## 1 · How sure can a few runs make us?
#
# A *run* is one training from one seed. Its policy is then tested on twenty *test tasks*: it adapts to each of them, and we measure its mean
# return. So an experiment is a table of returns $x_{s,i}$, of seed $s$ on test task $i$. The runs lie in
# `data/runs/`, each with the command that made it. On Point2D and TwoWheeled the test tasks are random goals that no training used. HalfCheetah
# has only two tasks, forward and backward, and as in the paper they serve for training *and* test; there, nothing is unseen.

# %% tags=["scores"]
clock.at("how sure can a few runs make us")
stored = stored_seeds(runs.SHIPPED, "two_wheeled", "optimal")
returns = {name: results.task_scores(stored[name], step=1) for name in ("emrld", "meta-bc")}
figure, axes = plt.subplots(figsize=(6.4, 3.2))
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
# and their mean (a line), seed by seed.*
#
# The paper plots average returns, so a run's **score** is its mean over the test tasks: the lines. Three seeds, three scores.
#
# **One number for many runs.** One lost run can move a mean far, and a median throws most of the data away. Agarwal et al. (2021) suggest
# the **interquartile mean** (IQM): sort all $n$ scores, leave out the lowest and the highest $\lfloor n/4 \rfloor$, average the
# rest. Of three scores it leaves out none. Section 3 shows what it leaves out when several environments are pooled, and why that matters.
#
# ### Exercise 1 · The interquartile mean
#
# *Difficulty 1 of 3, 5 minutes.* `scores` is an array of any shape.
#
# <details><summary>Hint 1: sorting a table</summary>
# <code>np.sort(scores, axis=None)</code> flattens, and sorts a copy.
# </details>
#
# <details><summary>Hint 2: the slice</summary>
# With <code>cut = n // 4</code>, keep <code>ordered[cut : n - cut]</code>.
# </details>


# %% tags=["exercise-iqm"]
def interquartile_mean(scores):
    """Return the mean of the middle half of the scores."""
    ### BEGIN SOLUTION
    ordered = np.sort(scores, axis=None)
    cut = len(ordered) // 4
    return ordered[cut : len(ordered) - cut].mean()
    ### END SOLUTION


# %%
if check.interquartile_mean(interquartile_mean):
    for table in returns.values():
        for scores in (table, table.mean(1)):
            assert np.isclose(interquartile_mean(scores), package_mean(scores))
    print("Your numbers equal those of emrld_lite.experiments.intervals.interquartile_mean.")

# %% [markdown]
# **How different could that number have been,** had we drawn other seeds? The *bootstrap* answers
# by drawing from what we have: make a new experiment by drawing runs *with replacement* from the table, compute its mean, and repeat this a few thousand
# times.
#
# **Predict first.** A tempting shortcut: Meta-BC's table in Figure 1 holds a number for every seed and task, so draw single numbers. Will the means spread
# more or less than those of whole runs? Which spread would one more seed respect?

# %% tags=["goals-are-not-runs"]
table, random = returns["meta-bc"], np.random.default_rng(0)
whole = [random.choice(table, len(table)).mean() for _ in range(4000)]
single = [random.choice(table.ravel(), table.size).mean() for _ in range(4000)]
figure, axes = plt.subplots(figsize=(6.4, 2.8))
bins = np.linspace(15, 45, 61)
axes.hist(whole, bins, color="#CC79A7", label="whole runs drawn", alpha=0.8)
axes.hist(single, bins, color="#333333", histtype="step", hatch="//", label="single returns drawn")
axes.set(xlabel="mean return of a resample", ylabel="resamples")
axes.legend()
plt.show()
widths = [np.ptp(np.quantile(draws, [0.025, 0.975])) for draws in (whole, single)]
assert widths[0] > 1.2 * widths[1]
print(f"the middle 95 % are {widths[0]:.0f} wide over runs, {widths[1]:.0f} over single returns")

# %% [markdown]
# *Figure 2. Means of 4,000 resamples of the same table (Meta-BC on TwoWheeled). The towers: few runs make only few different resamples.*
#
# The twenty returns of a seed are not twenty experiments: they share one policy. Whoever draws them apart claims to
# know more than they do. So from here on only *runs* count, with one score each.
#
# **What the range from worst to best says.** No resample of whole runs can leave the range between the worst run and the best, and with three runs the
# middle 95 % of the resamples *is* that range. It is worth printing, under its true name. It misses the median of all runs that could have been drawn only
# if all $n$ runs happen to fall on the same side of that median, which has probability $2 \cdot 2^{-n}$. So it covers the median with probability $1 - 2^{1-n}$.

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
# So three runs give 75 %, and five give 94 %. Below, a score stands with its range, `mean [worst, best]`, and means just that.
#
# **Which of two algorithms is better?** It is tempting to bootstrap the *difference*: draw runs of both, subtract the means, and say "ahead" when the middle 90 % of
# these differences lie above zero. That sounds like an error of 5 % on either side. Is it?
#
# There is another rule, whose error we can count. Suppose both algorithms are equally good: their seeds' scores come from one distribution, a *null pair*. Sort
# the six scores. Then each way to deal the six ranks to two groups of three is equally likely. In how many does the first group take the three highest?

# %% tags=["three-against-three"]
for number in (3, 5):
    ranks = set(range(2 * number))
    splits = [(split, ranks - set(split)) for split in combinations(ranks, number)]
    # pairs of runs, one of each side, of which the second wins
    lost = np.array([sum(a < b for a in mine for b in theirs) for mine, theirs in splits])
    k = rank_of_ends(number, number)
    assert (lost < k).mean() <= 0.05 < (lost < k + 1).mean()
    print(
        f"{number} seeds each: the first side loses fewer than {k} of {number**2} pairs of runs "
        f"in {(lost < k).sum()} of {len(splits)} splits, {(lost < k).mean():.1%}"
    )

# %% [markdown]
# In one of twenty. So this rule calls a null pair "ahead" with probability exactly 5 %, whatever the distribution: *every* seed of the first beats *every* seed of the
# second. It is the rank-sum test of Wilcoxon, Mann and Whitney. (With three seeds it cannot reach less than 5 %; a t-test can, for whoever grants it that scores are
# normal.) With five seeds each it forgives: of the 25 pairs of runs, the first may lose four.
#
# **The same rule as an interval.** Take all differences between a run of the first and a run of the second. Their median estimates by how much the first is better
# (Hodges and Lehmann, 1963). With $k = 1$ for three against three, and $k = 5$ for five against five, the interval from the $k$-th smallest to the $k$-th largest difference covers the true shift with
# probability at least 90 %. "Ahead" says that it lies above zero, "behind" below, and where it holds zero we write "not distinguishable" and print it all the same: it
# says which gains and which losses the runs exclude. This is `shift_interval` of the package, and every verdict in this notebook and the next comes from it.
#
# ### Exercise 2 · How often is "ahead" false?
#
# *Difficulty 2 of 3, 10 minutes.* Measure it for both rules. A *rule* takes the scores of two sides, two arrays of shape (runs,), and returns an interval with the fields
# `estimate`, `low` and `high`. Draw `pairs` null pairs: `runs` scores for each side, all from the standard normal distribution of the generator `random`. Return the share of pairs that the rule calls
# "ahead". The bootstrap of a difference is given.
#
# <details><summary>Hint 1: a null pair</summary>
# <code>one, other = random.normal(size=(2, runs))</code>: both sides from one distribution, new for each pair.
# </details>
#
# <details><summary>Hint 2: what counts</summary>
# <code>rule(one, other).low &gt; 0</code> is the false "ahead". A false "behind" is the other error; do not count it.
# </details>
#
# <details><summary>Hint 3: the frame</summary>
# A counter, a loop over <code>range(pairs)</code>, and one division at the end.
# </details>


# %% tags=["bootstrap-given"]
def bootstrap_rule(one, other):
    """Return the middle 90 % of bootstrapped differences of two means, as an interval."""
    random = np.random.default_rng(0)
    left, right = (random.choice(side, (1000, len(side))).mean(1) for side in (one, other))
    low, high = np.quantile(left - right, [0.05, 0.95])
    return Interval(one.mean() - other.mean(), low, high)


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


# %% tags=["false-ahead"]
if check.false_ahead_rate(false_ahead_rate):
    print(f'{"false "}"ahead" among 3,000 null pairs{"3 seeds each":>16}{"5 seeds each":>16}')
    shares = {}
    for name, rule in (("bootstrap of a difference", bootstrap_rule), ("ranks", shift_interval)):
        random = np.random.default_rng(0)
        shares[name] = [false_ahead_rate(rule, number, 3000, random) for number in (3, 5)]
        print(f"{name:37}" + "".join(f"{share:>16.1%}" for share in shares[name]))
    assert shares["bootstrap of a difference"][0] > 0.11  # both promise 5 %
    assert max(shares["ranks"]) < 0.06

# %% [markdown]
# Both rules promise 5 %. The bootstrap breaks its promise: with three seeds it calls about one null pair in eight "ahead", and as many "behind". Three runs show too
# little of how runs vary, and drawing from them again cannot add what they lack. The ranks keep their promise.
#
# **Many verdicts.** Each verdict below is false with at most 5 % *if* the two sides are equal. Among twenty null pairs we must expect one false "ahead". So trust a gap for its
# size, and for its return in other environments, more than for a single "ahead".
#
# ## 2 · Good demonstrations (Figs. 3 and 5)
#
# **Predict first.** The paper's Fig. 3 has training curves (top) and adaptation to test tasks (bottom) for three environments.
# Which algorithm do you expect in second place, after the two variants of EMRLD?

# %% tags=["figure-3"]
clock.at("good demonstrations")
figure = paper_figures.results(runs.SHIPPED, "optimal")
plt.show()

# %% [markdown]
# *Figure 3 (the paper's Fig. 3). Optimal demonstrations. Top: mean return on the training tasks after adaptation; HalfCheetah's is the mean over both directions. Bottom: mean return on the test tasks after 0 to 3
# adaptation steps, HalfCheetah's two directions apart. Lines are means over the seeds; bands reach from the lowest seed to the highest. Grey line: the demonstrations' own return. Later steps use a tenth of the first one's rate (section 3).*
#
# The paper: "our algorithms out perform the others by obtaining the highest average return". We put a number on it: each
# variant against the *best* baseline of its row, which is chosen after looking and so given every advantage.


# %% tags=["ahead-optimal"]
def against_the_best(quality, step):
    """Print and return the difference of each variant to the best baseline, a row per place."""
    gaps = {}
    for place in (*PLACES, BOTH_WAYS):
        seeds = stored_seeds(runs.SHIPPED, place.env, quality)
        table = {name: run_scores(seeds[name], step, place.goal) for name in ALGORITHMS}
        best = max(BASELINES, key=lambda name: table[name].mean())
        for name in OURS:
            gap = gaps[place.title, name] = shift_interval(table[name], table[best])
            print(
                f"{place.title:21}{plotting.label(name):9}{worst_to_best(table[name]):6.1f}", end=""
            )
            print(f"   less {plotting.label(best):7}{gap:+7.1f}   {verdict(gap)}")
    return gaps


optimal = against_the_best("optimal", step=1)
not_ahead = {title for (title, _), gap in optimal.items() if verdict(gap) != AHEAD}
assert not_ahead == {"HalfCheetah backward"}

# %% [markdown]
# **Measured.** On the two goal-reaching environments the claim holds by far: EMRLD and EMRLD-WS reach 74.5 and 75.6 on Point2D, where the best baseline has 21.0, and 77.0 and 75.1 on
# TwoWheeled, where it has 28.9; the smallest gap, at the lower end of its interval, is 36.2. On HalfCheetah the paper's own number, the mean over both directions, says the same: 177.0 and 177.1 against 65.1.
#
# But look at the last rows of Figure 3 and of the table: *backward*, the variants are not distinguishable from the best baseline. A mean over two tasks can hide what
# each of them says, so here they are apart, before the adaptation and after one step.

# %% tags=["directions"]
seeds = stored_seeds(runs.SHIPPED, "half_cheetah", "optimal")
ways = PLACES[2:]  # forward, backward
print(f"{'':16}{'forward':>30}{'backward':>20}")
print(f"{'demonstrations':28}" + "".join(f"{place.earned:>18.1f}" for place in ways))
turned = {}
for name in ALGORITHMS:
    for step in (0, 1):
        scores = [run_scores(seeds[name], step, place.goal) for place in ways]
        turned[name, step] = [table.mean() for table in scores]
        ends = "".join(f"{worst_to_best(table):7.1f}".rjust(26) for table in scores)
        print(f"{plotting.label(name):9} {step} steps {ends}")
assert min(turned["emrld", 1]) > 90 and min(turned["emrld-ws", 1]) > 90
assert turned["gmps", 0][0] < -200 < 200 < turned["gmps", 0][1]

# %% [markdown]
# **Measured.** Both directions of EMRLD and EMRLD-WS are positive after one step, 100.8 and 112.9 forward, 253.3 and 241.4 backward; the demonstrations have 138.0 and 329.9. **GMPS runs
# backward whichever way it is asked**: -263.1 forward and 245.1 backward, and its adaptation step changes next to nothing. Its mean, -9.0, looks like a policy that
# stands still, and is none. Meta-BC runs backward as well as anyone, 260.6, and forward it still runs backward, -130.3. Only MAML stands still, with -4.1 and 1.7.
#
# So "starving" is the wrong word for GMPS here: it sees a reward in every episode. It cloned the two demonstrations into one policy, and one of them won.
#
# **What if the wrong way were not punished?** The paper says two things. Its appendix B has a formula that pays beyond two metres *either* way, so that the wrong way costs; the
# released code does this, and so do we. Its Section 4.1 says that a reward comes "only after it has moved a certain number of units along the x-axis in the correct direction". With the policies above, a
# wrong way that costs nothing would lift the means a good deal. (The package has the switch, `paid_side="correct"`; policies *trained* with it are not among these runs.)

# %% tags=["wrong-way-unpunished"]
unpunished = {}
for name in ALGORITHMS:
    tables = [run_scores(seeds[name], 1, place.goal) for place in ways]
    unpunished[name] = np.mean([np.maximum(table, 0.0) for table in tables])
    both = np.mean(tables)
    print(
        f"{plotting.label(name):9} mean {both:6.1f}   wrong way unpunished {unpunished[name]:6.1f}"
    )
assert min(unpunished[name] for name in OURS) > max(unpunished[name] for name in BASELINES)

# %% [markdown]
# **Measured.** With negative returns counted as zero GMPS would have 122.6 and Meta-BC 130.3, where EMRLD has 177.0. The order stays, and "fails" becomes "solves one
# of two tasks".
#
# **Which of our two?** The paper shows both variants and does not say which is better. Do we know?

# %% tags=["warm-start-or-not"]
for place in (*PLACES, BOTH_WAYS):
    seeds = stored_seeds(runs.SHIPPED, place.env, "optimal")
    plain, warm = (run_scores(seeds[name], 1, place.goal) for name in OURS)
    gap = shift_interval(warm, plain)
    print(f"{place.title:21}EMRLD-WS less EMRLD: {gap:+6.1f}   {verdict(gap)}")
    assert verdict(gap) == EVEN

# %% [markdown]
# **Measured.** We do not: nowhere can the two be distinguished. What the runs exclude is a difference of more than the intervals: on Point2D the warm start may cost up to 7.6 or gain up to 6.6, on TwoWheeled
# it may cost 8.8 or gain 3.5, on the mean of HalfCheetah cost 16.2 or gain 20.5.
#
# Is the warm start at least quicker? Here is the mean return over the first thirty training iterations.

# %% tags=["warm-start-begins"]
lead = {}
for env, title in TITLES.items():
    seeds = stored_seeds(runs.SHIPPED, env, "optimal")
    plain, warm = (training_scores(seeds[name], end=30, window=30) for name in OURS)
    lead[env] = shift_interval(warm, plain)
    print(f"{title:12}EMRLD-WS less EMRLD: {lead[env]:+6.1f}   {verdict(lead[env])}")
assert [verdict(gap) for gap in lead.values()] == [EVEN, EVEN, BEHIND]

# %% [markdown]
# Not as a rule. On the two goal-reaching environments its lead cannot be distinguished from nothing; on HalfCheetah the warm start begins *behind*.
#
# The other sentences about Fig. 3, one by one:
#
# - "**Quickly adapt** to testing tasks with just one adaptation step and one trajectory": the bottom row says yes. Nearly
#   all is gained at the first step, on Point2D and TwoWheeled for goals that no training used.
# - "**Nearly-monotone** improvement": we measure the largest fall of the ten-iteration mean below its best so far,
#   as a share of its best.
# - "**Meta-BC** fails and has unstable training", "**MAML and GMPS** fail to learn due to sparsity".

# %% tags=["monotone"]
print(f"{'':12}{'EMRLD':>10}{'EMRLD-WS':>10}{'Meta-BC':>10}   largest fall, worst seed")
for env, title in TITLES.items():
    seeds = stored_seeds(runs.SHIPPED, env, "optimal")
    falls = [max(largest_fall(run) for run in seeds[name]) for name in (*OURS, "meta-bc")]
    assert max(falls[:2]) < 0.15 < falls[2]
    print(f"{title:12}" + "".join(f"{fall:>10.0%}" for fall in falls))

# %% [markdown]
# **Measured.** *Nearly monotone* holds: no seed of EMRLD or EMRLD-WS ever falls by more than 3.4 % of its best, while Meta-BC falls
# by 47 % to 111 %. *Fails* holds for GMPS on the goal-reaching environments, with 1.5 and 14.8 after one step, and for MAML on Point2D, with 4.9. On TwoWheeled
# two seeds of MAML learn something, 29.3 and 29.5, and the third does not, 0.5. We write *differs* for MAML, and for Meta-BC, which on HalfCheetah solves one of two tasks.
#
# **Which goals does MAML reach?** On TwoWheeled the twenty test goals are not spread evenly.

# %% tags=["maml-goes-left"]
goals = unseen_demonstrations("two_wheeled", "optimal", 20).tasks.numpy()
left = np.degrees(np.arctan2(goals[:, 1], goals[:, 0])) > 120
table = results.task_scores(stored_seeds(runs.SHIPPED, "two_wheeled", "optimal")["maml"], step=1)
print(f"{left.sum()} of {len(goals)} test goals lie left of 120 degrees. MAML's mean return:")
for seed, row in enumerate(table):
    print(f"seed {seed}: {row[left].mean():5.1f} on those, {row[~left].mean():5.1f} on the others")
assert sorted(table[:, left].mean(1))[-2] > 50 and table[:, ~left].mean(1).max() < 15

# %% [markdown]
# Two seeds of MAML have learned to go left, whichever goal is asked for, and eight of the twenty goals happen to lie there. With evenly drawn goals their
# mean would be lower.
#
# **Why do Meta-BC and GMPS fail?** The paper names sparse rewards and little data. Before we agree, look at the training itself. TRPO, which makes the meta-update of the other three, measures how far an
# update moves the adapted policies, in the Kullback-Leibler divergence (KL, in nats), and takes no step beyond a bound. Meta-BC and GMPS use Adam, as the paper says, with a rate of 0.01, and
# **nothing bounds Adam's step**. With a learned sigma, cloning can moreover raise the density of the demonstrated actions without end.

# %% tags=["divergence"]
figure, panels = plt.subplots(1, 3, figsize=(10.5, 3.1), sharey=True)
for axes, (env, title) in zip(panels, TITLES.items(), strict=True):
    stored = stored_seeds(runs.SHIPPED, env, "optimal")
    bound = TrustRegion().for_actions(make(env).action_dim).max_kl
    curves = {
        name: [runs.load_curve(run / "curve.csv") for run in stored[name]]
        for name in ("meta-bc", "gmps")
    }
    plotting.divergence(curves, bound, axes)
    axes.set_title(f"{title} (TRPO's bound: {bound:.2f})")
    axes.label_outer()
plt.show()

# %% [markdown]
# *Figure 4. How far each update of Meta-BC and GMPS moves the adapted policies, on a logarithmic axis, every seed, optimal data; triangles lie above the picture. The black line is the bound that TRPO keeps for EMRLD, EMRLD-WS and MAML.*

# %% tags=["updates-above-one-nat"]
for name in ALGORITHMS:
    moved = []
    for env in TITLES:
        for quality in STEPS_SHOWN if name != "maml" else ("optimal",):
            for run in stored_seeds(runs.SHIPPED, env, quality)[name]:
                moved += [row.kl for row in runs.load_curve(run / "curve.csv")]
    moved = np.array(moved)
    print(f"{plotting.label(name):9}{(moved > 1).sum():5} of {len(moved):5} updates above one nat")
    assert (moved > 1).any() == (name in ("meta-bc", "gmps"))

# %% [markdown]
# **Measured.** A single update of GMPS moved the adapted policies by more than one nat 717 times in 3120, and one of Meta-BC 765 times in 7800; the other three never did. Some of
# GMPS's updates reach a KL of a one with thirty-two zeros.
#
# So these trainings *broke down*, which is more than "little data": the returns of GMPS and Meta-BC in this notebook are those of a diverging optimiser. That is what the printed settings do here. What
# they would reach with a bounded step, a fixed sigma or a smaller $\alpha$ these runs do not say; notebook 05 tried four meta learning rates, on one seed and optimal data.
#
# Is the divergence then the *reason* of the failure? Not for Meta-BC, as far as one seed tells: with the averaged log-density of today's defaults its training on Point2D stays in bounds, and so it does on TwoWheeled at a fifth of the rate, and neither
# returns more than the diverging runs (README has the numbers, `data/next/runs` the runs). Little data remains a reason; for GMPS the question is open.
#
# Now *look* at the policies. Fig. 5 sends the adapted TwoWheeled policies to twenty random goals.

# %% tags=["figure-5"]
figure = paper_figures.trajectories(runs.SHIPPED)
plt.show()

# %% [markdown]
# *Figure 5 (the paper's Fig. 5). One episode for each of twenty unseen goals (stars; the discs pay a reward), and how many reach it. Trajectories that do are coloured, the others grey and dotted. Top: after one
# adaptation step on optimal data. Bottom: after three steps on sub-optimal data. Seed 0 of each algorithm.*
#
# EMRLD's trajectories make a fan, and most of them end at their star; a few miss it and leave the picture. MAML goes left, whichever goal is asked for: its
# adaptation sees no reward on the other side. Meta-BC sets off in the right direction and drives past, having
# learned without reward that there is anything to stop for; with sub-optimal data it hardly turns. GMPS follows one compromise between all
# demonstrations.
#
# ## 3 · Bad demonstrations (Fig. 4)
#
# Now the demonstrations are noisy and stop before any reward; TwoWheeled's lack their beginning as well (notebook 03).
# **Predict first:** which algorithm suffers most?

# %% tags=["figure-4"]
clock.at("bad demonstrations")
figure = paper_figures.results(runs.SHIPPED, "suboptimal")
plt.show()

# %% [markdown]
# *Figure 6 (the paper's Fig. 4). As Figure 3, with sub-optimal demonstrations; the grey line is still the optimal ones' return. MAML reads no demonstrations, so its runs are the same.*
#
# The paper shows sub-optimal data after three adaptation steps, but its text gives no rate for the later ones. We begin with one step, about which there is nothing to choose.

# %% tags=["ahead-suboptimal"]
print("after one step")
suboptimal = against_the_best("suboptimal", step=1)
assert all(verdict(gap) == AHEAD for gap in suboptimal.values())
print("\nafter three steps, the later ones at a tenth of the rate")
third = against_the_best("suboptimal", step=3)
not_ahead = {where for where, gap in third.items() if verdict(gap) != AHEAD}
assert not_ahead == {("HalfCheetah backward", "emrld")}

# %% [markdown]
# **Measured.** After one step the claim holds in every row, for both variants: 76.1 and 74.0 on Point2D, 64.2 and 71.8 on TwoWheeled, 74.0 and 89.1 forward, 246.4 and 244.0 backward. After three steps EMRLD
# is not distinguishable from Meta-BC backward, 218.6 against 176.1, and all other rows hold. No demonstration contains a reward, and
# the adapted policies find it: what was missing in the data came from the meta-update's RL.
#
# **The later steps need a smaller rate.** The meta-policy was trained for one step, and makes it a long one. All stored three-step numbers use a tenth of $\alpha$ for the later steps, and that tenth was picked
# with the *test* tasks in sight. So here is the choice again, for EMRLD on TwoWheeled, on the *training* tasks, where it belongs; and then the test tasks with that choice, the stored one, and the paper's own $\alpha$.

# %% tags=["later-rates", "statistical", "tolerance:0.15", "tolerance:abs=8"]
seeds = stored_seeds(runs.SHIPPED, "two_wheeled", "suboptimal")


def returns_at(rate, data=None):
    """Return EMRLD's returns after 0 to 3 steps, a mean over seeds, on data or the training tasks."""
    curves = []
    for run in map(runs.load_run, seeds["emrld"]):
        curve = evaluate_run(run, data or run.load_demonstrations(), later_rate=rate)
        curves.append([float(episode_returns(rollout).mean()) for rollout in curve.rollouts])
    return np.mean(curves, axis=0)


def told(table):
    """Print the returns after each step, a line per rate."""
    for rate, means in table.items():
        print(f"  later steps at {rate:.2f} of alpha" + "".join(f"{mean:8.1f}" for mean in means))


training = {rate: returns_at(rate) for rate in (1.0, 0.3, 0.1, 0.03)}
print("EMRLD, mean return after 0, 1, 2 and 3 steps, training tasks")
told(training)
chosen = max(training, key=lambda rate: training[rate][3])
assert training[1.0][3] < training[1.0][1] - 20 and chosen == 0.03

# %% tags=["later-rates-test", "statistical", "tolerance:0.15", "tolerance:abs=8"]
unseen = unseen_demonstrations("two_wheeled", "suboptimal", 20)
test = {rate: returns_at(rate, unseen) for rate in (1.0, chosen)}
test[0.1] = np.mean([results.returns_by_step(run) for run in seeds["emrld"]], axis=0)  # stored
print("EMRLD, mean return after 0, 1, 2 and 3 steps, test tasks")
told(dict(sorted(test.items(), reverse=True)))
maml = run_scores(seeds["maml"], 3).mean()
print(f"MAML, after three steps: {maml:.1f}")
assert test[1.0][3] < maml < test[0.1][3]

# %% [markdown]
# At the paper's $\alpha$ the later steps *undo* the first, on the training tasks as on the test tasks: after three of them EMRLD is below MAML. The training tasks would have chosen a thirtieth, at which nothing is lost; a tenth
# costs a little there. On the test tasks, where the first step leaves something to gain, both rates gain. So the conclusion does not hang on the tenth, but it does hang on *some* smaller rate, and Fig. 4
# as the paper draws it cannot be had with one $\alpha$ for all steps. HalfCheetah's EMRLD loses with later steps even at a tenth (Figures 3 and 6).
#
# **Do better demonstrations help the baselines?** The paper says that Meta-BC and GMPS fail because they "are restricted by the optimality of the data". If that is so, we would expect more from better data, though both could
# fail for other reasons with either.

# %% tags=["restricted-by-the-data"]
for place in (*PLACES, BOTH_WAYS):
    for name in ("meta-bc", "gmps"):
        good, bad = (
            run_scores(stored_seeds(runs.SHIPPED, place.env, quality)[name], 1, place.goal)
            for quality in STEPS_SHOWN
        )
        gap = shift_interval(good, bad)
        print(
            f"{place.title:21}{plotting.label(name):8} optimal less sub-optimal: {gap:+7.1f}",
            end="",
        )
        print(f"   {verdict(gap)}")

# %% [markdown]
# **Measured.** For Meta-BC the expectation holds on the goal-reaching environments: better data gain 13.2 on Point2D and 21.5 on TwoWheeled, at least 6.3. GMPS hardly gains: 1.2 on Point2D, and on TwoWheeled
# between a loss of 1.1 and a gain of 15.3. HalfCheetah's mean cannot tell, and its directions say why: from better data both learn to run backward faster, by 87.0 and 98.4, and run the wrong way faster when they should go forward, by
# 99.8 and 108.1. The first of these two is not distinguishable from nothing.
#
# **All environments at once.** Returns of different environments cannot be averaged, but shares can. We divide each run's score, on HalfCheetah the mean over both directions, by the mean return of the *optimal* demonstrations, also where the data are
# sub-optimal, and pool the runs.

# %% tags=["pooled"]
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
axes.set_ylim(top=1.02)
plt.show()

# %% [markdown]
# *Figure 7. Each run of the three environments, as a share of the optimal demonstrations' mean return, and the plain mean over all runs (bar). Filled: optimal data, one step. Open: sub-optimal data, three steps, the later ones at a tenth of the rate.*

# %% tags=["pooled-means"]
print(f"{'':11}{'plain mean':>22}{'interquartile mean':>24}")
print(f"{'':11}" + f"{'optimal':>11}{'sub-opt.':>11}" * 2)
for name in ALGORITHMS:
    tables = [pooled[quality, name] for quality in STEPS_SHOWN]
    means = [table.mean() for table in tables] + [package_mean(table) for table in tables]
    print(f"{plotting.label(name):11}" + "".join(f"{mean:>11.0%}" for mean in means))
better, worse = (pooled[quality, "emrld"] for quality in STEPS_SHOWN)
assert better.mean() > worse.mean() and package_mean(better) < package_mean(worse)

# %% [markdown]
# **Measured.** In the plain mean EMRLD and EMRLD-WS reach 86 % and 86 % of the optimal demonstrations' return with optimal data, 84 % and 84 % with sub-optimal data. The best baseline stays at 29 % and 16 %: the paper's main claim in
# one picture, and it stands. Now compare the interquartile mean: 87 % and 91 % for EMRLD, as if bad data were *better* than good. They are not. The IQM leaves out the lowest quarter, and there lie EMRLD's two worst HalfCheetah runs, 46 % and 61 %,
# which are exactly what bad data did. A robust mean is robust against the outlier that is an accident, and also against the outlier that is the result. We use the plain mean, and show every run.
#
# ## 4 · Changing dynamics (Fig. 6, in simulation)
#
# Here the goal is the same for all tasks, (2, 1), and what differs is a drift that turns the robot: its heading $\theta$ grows by $\omega_g$ per second on top of what the
# policy asks for. The paper trains on nine drifts, and finds that "the EMRLD variants clearly outperform the others". **Predict first:** does a policy that *sees* its
# heading need to adapt at all?

# %% tags=["figure-6"]
clock.at("changing dynamics")
figure = paper_figures.drift(runs.SHIPPED)
plt.show()

# %% [markdown]
# *Figure 8 (the simulated part of the paper's Fig. 6). Top left: training. Top right: twenty unseen drifts, by adaptation steps; the grey line is the demonstrations' return. Bottom: three episodes of
# each algorithm (seed 0, one step) in the unseen task nearest the drift that the paper set on its robot.*

# %% tags=["drift-claims"]
seeds = stored_seeds(runs.SHIPPED, "two_wheeled_drift", "optimal")
drifts = {name: run_scores(seeds[name], 1) for name in ALGORITHMS}
for name, table in drifts.items():
    before = worst_to_best(run_scores(seeds[name], 0))
    print(f"{plotting.label(name):9} before {before:5.1f}   one step {worst_to_best(table):5.1f}")
for name in OURS:
    gap = shift_interval(drifts[name], drifts["maml"])
    print(f"{plotting.label(name):9} less MAML: {gap:+5.1f}   {verdict(gap)}")
    assert verdict(gap) == EVEN

# %% [markdown]
# **Measured.** **This claim does not reproduce in the experiment that we ran.** After one step EMRLD reaches 73.4, EMRLD-WS 72.0 and MAML 72.0. Neither difference can be distinguished; a lead over MAML of more than 3.4 is excluded for EMRLD, and of more than 2.9 for EMRLD-WS. MAML's *unadapted*
# policy has 74.2, and the demonstrations 74.4, so nothing is left to gain. Meta-BC and GMPS do fail, with 24.9 and 0.1.
#
# **What differs from the paper.** Our nine drifts are spread evenly up to 0.8 radians per second; the paper does not name its nine. Our drift turns the robot by $\omega_g\, dT$ in a step of length $dT$; its printed formula, $\theta + \omega_g + \omega\, dT$, turns it
# twice as fast. Our policy sees its heading; the paper's text has only the position in the state ($S \in \mathbb R^2$). GMPS has broken down here too: in Figure 8 it drives away from the goal.
#
# **Why does MAML do so well?** In the other environments the tasks have different goals, and no observation tells which one is meant. Here the
# goal is always the same, and the policy sees its position and heading: if the robot drifts left, it steers right. *One* policy then solves all nine tasks, and plain RL
# finds it once luck has found the reward, which a disc of radius 0.5 allows. A policy that does not see its heading might need to adapt; these runs cannot say.
# (The paper's text on the real robot is milder than its figure: MAML "takes a longer sub-optimal route to reach the reward region".)
#
# ## 5 · Are the runs long enough, and are they real?
#
# A comparison of half-trained policies says who is quicker, not who is better. Has a curve **flattened**? We compare the last
# fifth of the iterations with the fifth before, and divide the difference by the algorithm's *own* level at the end: a rise of 2 is little for one that has 75 and a third for one that has 6.
#
# A level near zero makes any rise look huge. So the divisor is at least `floor`, a twentieth of the demonstrations' return: below that an algorithm has as good as nothing, a few lucky
# episodes, and its ups and downs are those of luck.
#
# ### Exercise 3 · The late rise
#
# *Difficulty 1 of 3, 5 minutes.* `returns` is the curve, an array of shape (iterations,). A fifth has `len(returns) // 5` iterations. Return the rise as a share of the level at the end, or of `floor` if that is larger.
#
# <details><summary>Hint 1: slices from the end</summary>
# With <code>window = len(returns) // 5</code>, the last fifth is <code>returns[-window:]</code>, the one before <code>returns[-2 * window : -window]</code>.
# </details>
#
# <details><summary>Hint 2: the divisor</summary>
# <code>max(level, floor)</code>, where the level is the mean of the last fifth.
# </details>


# %% tags=["exercise-late-rise"]
def late_rise(returns, floor):
    """Return by how much the last fifth exceeds the fifth before, as a share of its level."""
    ### BEGIN SOLUTION
    window = len(returns) // 5
    level = returns[-window:].mean()
    return (level - returns[-2 * window : -window].mean()) / max(level, floor)
    ### END SOLUTION


# %%
clock.at("are the runs long enough, and are they real")
if check.late_rise(late_rise):
    seeds = stored_seeds(runs.SHIPPED, "half_cheetah", "optimal")["emrld"]
    curves = [[row.return_after for row in runs.load_curve(run / "curve.csv")] for run in seeds]
    mine = late_rise(np.mean(curves, axis=0), NOTHING * EARNED["half_cheetah"])
    assert np.isclose(mine, results.late_rise(seeds, EARNED["half_cheetah"]))
    print("Your number equals that of emrld_lite.experiments.results.late_rise.")

# %% tags=["flattened"]
print(f"{'rise of the mean over seeds, as a share of its level':53}{'optimal':>10}{'sub-opt.':>10}")
climbing = set()
for env, title in (*TITLES.items(), ("two_wheeled_drift", "changing dynamics")):
    for name in ALGORITHMS:
        cells = []
        for quality in STEPS_SHOWN if env in TITLES else ("optimal",):
            seeds = stored_seeds(runs.SHIPPED, env, quality)[name]
            cells.append(results.late_rise(seeds, EARNED[env]))
            if cells[-1] > FLAT:
                climbing.add((env, name))
        print(f"{title:18}{plotting.label(name):35}" + "".join(f"{cell:>10.1%}" for cell in cells))
assert ("point2d", "maml") in climbing
assert {env for env, name in climbing if name in OURS} == {"half_cheetah"}

# %% [markdown]
# **Measured.** We call a curve flat when this rise is at most 5 %. **Flat** are EMRLD and EMRLD-WS on Point2D, on TwoWheeled and with changing dynamics: at most 3.7 %. **Still climbing** are
# both on HalfCheetah, by 7.6 % to 10.4 % after 250 iterations on optimal data and 400 on sub-optimal; MAML on Point2D, by 18.7 %, to a level of 7.4; Meta-BC with optimal data in all three environments, by 6.8 % to 8.5 %; and GMPS on sub-optimal
# HalfCheetah, by 7.5 %. So on HalfCheetah the comparison is one at a budget, and "MAML fails" on Point2D means: up to here.
#
# ### One run again, live
#
# A stored curve is a promise: the same command makes it again. But a sum depends on the order in which it is added up, and
# every kind of processor has its own. The last digits differ, and after some iterations of thousands of random steps each the curves part: the same seed
# is another draw on another machine. Notebook 06 shows how far draws lie apart. The run in `data/portable` was made with three environment variables that leave
# every x86 processor one and the same order (and make it 1.6 times slower, on an AMD EPYC). It says of itself:

# %% tags=["promise"]
facts = read_json(elsewhere.PORTABLE_RUN / "provenance.json", "provenance")
print(facts["command"])
for name, value in facts["variables"].items():
    print(f"    {name}={value}")
print("made on:", facts["processor"])

# %% [markdown]
# **Predict first.** Eight iterations again, now, on your processor: how many of the eight returns agree in every digit?

# %% tags=["replay", "tolerance:0.01"]
promised = runs.load_run(elsewhere.PORTABLE_RUN).curve
with tempfile.TemporaryDirectory() as folder:
    live = elsewhere.repeat(elsewhere.PORTABLE_RUN, Path(folder) / "again", iterations=8)
print("iteration     stored   just now")
for one, other in zip(promised, live, strict=False):
    print(f"{one.iteration:9} {one.return_after:10.6f} {other.return_after:10.6f}")
farthest = max(
    abs(one.return_after - other.return_after) for one, other in zip(promised, live, strict=False)
)
here = {name: metadata.version(name) for name in ("torch", "numpy")}
same_versions = here == {name: facts["versions"][name] for name in here}
if same_versions and platform.machine().lower() in ("x86_64", "amd64"):
    assert farthest == 0.0
assert abs(live[0].return_after / promised[0].return_after - 1) < 0.01

# %% [markdown]
# On an x86 processor, with the same versions of torch and numpy, all eight agree in every digit. Elsewhere the first iteration agrees to a per
# cent, since all random numbers are the same, and the others drift away from it.
#
# ## The paper's claims, in one table
#
# | Section 4 and the appendices, in the paper's words | here | where |
# |---|---|---|
# | "obtaining the highest average return" (optimal data) | **holds** in three environments of three; on HalfCheetah because of the forward direction, backward the baselines do as well | section 2 |
# | "quickly adapt to testing tasks with just one adaptation step and one trajectory" | **holds** | section 2 |
# | "nearly-monotone improvement" | **holds**: falls of at most 3.4 % | section 2 |
# | "Meta-BC fails and has unstable training performance" | **differs**: unstable everywhere, and on HalfCheetah one of two tasks solved | section 2 |
# | "MAML and GMPS fail to learn due to sparsity" | **differs**: two seeds of MAML learn a little on TwoWheeled; GMPS diverges, and on HalfCheetah it runs backward for both tasks, with rewards in sight | section 2 |
# | "EMRLD outperforms all the baselines" (sub-optimal data) | **holds** after one step in three environments of three; after three steps only at a smaller rate | section 3 |
# | "restricted by the optimality of the data" | **differs**: seen for Meta-BC in two environments of three | section 3 |
# | "the EMRLD variants clearly outperform the others" (changing dynamics) | **not reproduced** in the experiment that we ran: MAML does as well | section 4 |
# | "setting $w_{\mathrm{bc}} = 0$ hampers the performance" | **holds**: next to nothing is left | notebook 08 |
# | "setting $w_{\mathrm{rl}} = 0$ hampers the performance" | **not reproduced**: no loss that can be distinguished; one of more than 3 is excluded on Point2D and TwoWheeled, not on HalfCheetah | notebook 08 |
# | "fairly robust to variations in $w_{\mathrm{rl}}$ and $w_{\mathrm{bc}}$" | **holds** | notebook 08 |
# | EMRLD or EMRLD-WS? (not claimed) | not distinguishable | section 2 |
#
# ## Where paper and code differ
#
# | point | paper | released code | this workbook |
# |---|---|---|---|
# | iterations | not given | 700, or 500 | 150 to 400 for EMRLD, EMRLD-WS and MAML; section 5 lists who still climbs |
# | which episodes count | $M$ trajectories | the first 20 to finish out of 30 | exactly 20, none dropped |
# | bands in the figures | standard deviation over seeds in training, over test tasks in the tests | – | from the lowest seed to the highest |
# | HalfCheetah's reward, the wrong way | none (Section 4.1), or negative (appendix B) | negative | negative; a switch |
# | rate of the later adaptation steps | not given | not compared | a tenth of the first, chosen when the test tasks had been seen (section 3) |
# | Meta-BC's and GMPS's budget | not given | 700, or 500 | 500 and 200 iterations (HalfCheetah 300 and 120); four meta learning rates on one seed |
#
# ## What was shown
#
# - A verdict is worth what its rule is worth: ranks call one null pair in twenty "ahead", a bootstrap of three runs one in eight.
# - EMRLD and EMRLD-WS are ahead of every baseline in three environments, with good and with bad data; which of the two is better, we
#   cannot tell.
# - A mean over tasks can hide the result: on HalfCheetah the baselines solve one of two tasks, and always the same one.
# - Meta-BC and GMPS diverge with the printed settings, so their curves show neither sparse rewards nor little data alone; Meta-BC does no better where it stays in bounds.
# - One claim, about changing dynamics, does not reproduce in the experiment that we ran.
# - A stored run is repeated by its command: digit for digit on the same kind of machine, and on every x86 processor if it was made for that.
#
# **Next** [notebook 08](08_ablations.ipynb): which part of EMRLD makes the difference, and what turns out to be an accident of the code.
#
# **References** Agarwal, Schwarzer, Castro, Courville and Bellemare (2021), *Deep reinforcement learning at the edge of the
# statistical precipice*; Colas, Sigaud and Oudeyer (2018), *How many random seeds?*; Hodges and Lehmann (1963), *Estimates of location based on rank tests*; Mann and Whitney (1947), *On a test
# of whether one of two random variables is stochastically larger than the other*; Rengarajan et al. (2022), the paper.
