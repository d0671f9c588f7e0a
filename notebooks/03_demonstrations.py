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
# # 03 · Demonstrations: good ones, bad ones, and what copying makes of them
#
# One demonstration per task: that is all EMRLD gets. Where do the demonstrations come from? From an **expert** that was told
# what the learner never is: the goal, and how far away it is. In this notebook you train one in less than half a minute, spoil its
# trajectories on purpose, and let policies *copy* good and bad ones, to see how far copying goes and what stops it.
#
# **You will be able to**
#
# - train a goal-conditioned expert on a dense reward by TRPO (trust-region policy optimisation, a policy-gradient step of limited length; notebook 05 takes it apart),
# - say what each kind of sub-optimal data takes away,
# - tell apart what the data, the cut and the copy's own noise do to a copy,
# - design a data set whose copy fails, and predict how.
#
# **You need** notebooks 01 (behaviour cloning) and 02 (the environments). **Time** planned: 90 minutes with the exercises, of which the machine computes
# one to two, and 5 minutes of further reading. **Paper** Section 4.1 and Appendix C of Rengarajan et al., NeurIPS 2022.

# %%
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import torch
from IPython.display import display

from emrld_lite import policy
from emrld_lite.classroom import checks as check
from emrld_lite.classroom import designs
from emrld_lite.classroom.clock import Clock
from emrld_lite.classroom.predict import Guesses
from emrld_lite.classroom.sketches.corridor import corridor
from emrld_lite.classroom.widgets.cloning import (
    cloning_picture,
    cloning_sliders,
    copies_by_noise_and_cut,
)
from emrld_lite.demonstrations import load_demonstrations
from emrld_lite.demonstrators import recipes
from emrld_lite.demonstrators.cloning import clone
from emrld_lite.demonstrators.expert import ExpertConfig, GoalConditioned, train_expert
from emrld_lite.envs import make
from emrld_lite.experiments import plotting
from emrld_lite.policy import without_noise
from emrld_lite.rollout import collect, episode_returns

# %%
plotting.use_style()
torch.set_num_threads(1)  # leaves the other cores to you
FAMILIES = ("point2d", "two_wheeled", "half_cheetah", "two_wheeled_drift")
guess = Guesses()
clock = Clock(
    {
        "an expert": 15,
        "good data and bad data": 15,
        "copying alone": 15,
        "what the copy was shown": 25,
        "a data set of your own": 20,
    },
    further={"where paper and code differ": 5},
)

# %% [markdown]
# ## 1 · An expert
#
# The paper trains one expert for *all* tasks of an environment: a policy whose input is the state $s$ with the task's numbers $g_i$ appended, $\pi(a \mid s, g_i)$. In Point2D and TwoWheeled, $g_i$ is the goal's $x$ and $y$. The expert's reward is **dense**; for the
# goal-reaching environments it is minus the distance to the goal. (The paper does not name the reward; its released code uses a dense one.) The expert has two hidden layers of 128 units and a learned value network:
# `emrld_lite.demonstrators.expert` shares rollouts, advantages and the TRPO step with the meta-learner.
#
# ### Exercise 1 · Tell it the goal
#
# *Difficulty 1 of 3, planned for 4 minutes.* Append the task's numbers to every state, so that every episode of task $i$ sees the numbers of task $i$. Afterwards your function tells a trained expert where to go.
#
# <details><summary>Hint 1: what is missing from the tasks?</summary>
# The states have an axis for the episodes, the tasks have none. <code>tasks[:, None]</code> is (task, 1, n).
# </details>
#
# <details><summary>Hint 2: how do the shapes come to match?</summary>
# <code>.expand(...)</code> repeats the axis of length 1 without copying; then join along the last axis.
# </details>


# %% tags=["exercise-goal"]
def with_task(states, tasks):
    """Return (task, episode, state + n) from (task, episode, state) and (task, n)."""
    ### BEGIN SOLUTION
    context = tasks[:, None].expand(*states.shape[:2], tasks.shape[-1])
    return torch.cat([states, context], dim=-1)
    ### END SOLUTION


# %%
told_by_you = check.with_task(with_task)
clock.at("an expert")

# %% [markdown]
# From now on your function is what the expert sees. `way_of` plays an expert by its **mean action**, without noise, and returns where it goes; `told` are the goals that it is told. (Until your function is right, the package's `GoalConditioned` stands in for it.)


# %%
def package_way(params, told):
    """Return where an expert goes, (task, time, 2), by the package's functions."""
    draws = torch.Generator().manual_seed(0)
    rollout = collect(GoalConditioned(point), told, without_noise(params), 1, draws)
    over = rollout.mask[:, 0, :, None] == 0  # an episode ends at its goal
    return rollout.states[:, 0, :, :2].masked_fill(over, torch.nan)


@torch.no_grad()
def your_way(params, told):
    """Return where an expert goes that sees what your function shows it, (task, time, 2)."""
    states, visited = point.reset(told, 1), []
    for time in range(point.horizon):
        visited.append(states[:, 0])
        seen = torch.as_tensor(with_task(states, told), dtype=torch.float32)
        states = point.step(told, states, policy.mean(params, seen), time).states
    return torch.stack(visited, dim=1)


# %% tags=["tolerance:abs=0.001"]
point = make("point2d")
goals = point.training_tasks()
stored = recipes.load_or_train_expert("point2d", "optimal")
way_of = your_way if told_by_you else package_way
theirs = package_way(stored, goals)
gap = (way_of(stored, goals)[:, : theirs.shape[1]] - theirs).abs().nan_to_num().max()
assert gap < 1e-3
print(f"largest gap between this way and the package's: {gap:.4f} length units")

# %% [markdown]
# **Predict first.** You train an expert: 128 episodes per TRPO iteration, each of 100 steps at most. After how many iterations does the point reach a random goal more often than not?

# %%
guess.ask("half", "more than half of the goals reached from iteration")

# %% tags=["live-expert", "reveal"]
history = list(train_expert(ExpertConfig(env="point2d", iterations=30, tasks=32)))
expert = history[-1].params
figure, panels = plt.subplots(1, 2, figsize=(8.4, 2.8))
panels[0].plot([100 * iterate.success for iterate in history], color="#333333")
panels[0].set(xlabel="TRPO iteration", ylabel="goals reached (%)", ylim=(-3, 103))
panels[1].plot([iterate.dense_return for iterate in history], color="#333333")
panels[1].set(xlabel="TRPO iteration", ylabel="mean dense return\n(length units times steps)")
plt.show()

# %% [markdown]
# *Figure 1. Training the Point2D expert, as measured on the machine that ran this notebook: the share of episodes that reach their goal (left) stays near zero and then rises within a few iterations, while the mean dense return (right) rises from the beginning.*

# %% tags=["expert-is-good", "reveal", "statistical", "tolerance:abs=20", "tolerance:whole=8"]
half = next(iterate.iteration for iterate in history if iterate.success > 0.5)
unseen = point.sample_tasks(20, np.random.default_rng(5))
apart = (way_of(expert, unseen) - unseen[:, None]).norm(dim=-1).nan_to_num(9.0)  # (task, time)
reached = (apart[:, :60] <= 0.02).any(1).double().mean()  # what Point2D calls reached
assert history[-1].success > 0.85
assert reached > 0.75
guess.reveal("half", f"from iteration {half} on")
print(f"iteration 30: {100 * history[-1].success:.1f} % of the random goals reached,")
print(f"              {100 * reached:.1f} % of 20 new ones in fewer than 60 steps")

# %% [markdown]
# **Predict first.** The experts of the repository were trained the same way, on 80 (Point2D) to 250 (HalfCheetah) iterations; `python -m emrld_lite demos` remakes them, bit for bit on the same machine. Every goal that Point2D's expert was ever told lies on the
# *upper* semicircle. Now tell it goals on the *lower* one, by your function. Where does it go?

# %%
guess.ask(
    "below",
    "told a goal below the start, the expert goes",
    ["to the goal", "towards it but not there", "up, to goals that it knows"],
)

# %% tags=["told-a-lie", "reveal", "tolerance:0.05"]
figure, panels = plt.subplots(1, 2, figsize=(8.4, 3.6), sharey=True)
ends = {}
for axes, side, told in zip(panels, ("upper", "lower"), (goals, -goals), strict=True):
    way = way_of(stored, told)
    axes.plot(way[..., 0].T, way[..., 1].T, color="#0072B2", linewidth=1)
    axes.plot(told[:, 0], told[:, 1], "*", color="black", markersize=8)
    axes.set(title=f"told goals on the {side} semicircle", xlabel="x (length units)")
    axes.set(aspect="equal", xlim=(-2.7, 2.7), ylim=(-2.7, 2.7))
    ends[side] = (way - told[:, None]).norm(dim=-1).nan_to_num(9.0).min(1).values
panels[0].set_ylabel("y (length units)")
plt.show()
assert ends["upper"].max() < 0.05 and 0.1 < ends["lower"].mean() < 1.0
nearest = (
    f"within {ends['lower'].mean():.2f} of them on average, at worst {ends['lower'].max():.2f}"
)
guess.reveal("below", nearest)
print(f"             (of the goals that it knows: within {ends['upper'].mean():.2f})")

# %% [markdown] tags=["reveal"]
# *Figure 2. Ways of the stored Point2D expert when it is told goals (stars) from its training range (left), and goals outside of it (right): it has learned what the two numbers mean, but well only where it was trained.*
#
# The goal is one input among others, and a network is good where its data were. Keep that in mind: the copies below have data in far fewer places.

# %% [markdown]
# ## 2 · Good data and bad data
#
# **Optimal data**: one trajectory of the expert for each training task, by its mean action. **Sub-optimal data** come from an expert whose training was stopped early, with noise on its actions, and with a part cut off:
#
# | environment | stopped at | action noise | cut |
# |---|---|---|---|
# | Point2D | 50 % of goals reached | 0.1 | the end: 0.2 before the disc that pays |
# | TwoWheeled | 50 % | 0.1 | the **beginning**: the first 8 steps; and the end, 0.1 before the disc |
# | TwoWheeled, drift | 70 % | 0.1 | the same |
# | HalfCheetah | 90 % | 0.3 | the end: 0.5 m before the reward begins |
#
# The action noise is a standard deviation, in units of the action range. (The paper says what is cut, not how much. The numbers are ours.)

# %% tags=["figure-2"]
clock.at("good data and bad data")
figure, panels = plt.subplots(2, 4, figsize=(13, 5.6))
for column, name in zip(panels.T, FAMILIES, strict=True):
    for axes, quality in zip(column, ("optimal", "suboptimal"), strict=True):
        plotting.all_demonstrations(load_demonstrations(quality, name), axes)
        axes.set_title(f"{name}\n{quality}", fontsize=10)
plt.show()

# %% [markdown]
# *Figure 3. The paper's Figure 2 for every environment, one demonstration per training task: the optimal data (top) end at their goals, the sub-optimal data (bottom) end before any reward. Discs and lines: where a reward is paid. Dots: where a demonstration ends. For the cheetah, the position of
# its torso over time, five demonstrations per direction.*
#
# ### Exercise 2 · Cut it short
#
# *Difficulty 2 of 3, planned for 6 minutes.* Given each step's distance to the region that pays, how many steps from the start on may be kept so that *every* one of them is farther away than a margin?
#
# <details><summary>Hint 1: one trajectory comes close, and leaves again</summary>
# Everything after the first close step is cut, also what is far again.
# </details>
#
# <details><summary>Hint 2: without a loop</summary>
# Write 1 for a far step and 0 for a close one. What does the product of all numbers up to each step tell you?
# </details>


# %% tags=["exercise-cut"]
def steps_before_reward(distance, margin):
    """Return how many first steps all stay farther than margin, (task,), from (task, time)."""
    ### BEGIN SOLUTION
    return (distance > margin).long().cumprod(-1).sum(-1)
    ### END SOLUTION


# %%
cut_by_you = check.steps_before_reward(steps_before_reward)

# %% [markdown]
# Your function now spoils data. `expert_data` returns trajectories of the optimal expert with noise of your choice, their first steps left out and their end cut off by `steps_before_reward`. (Until your function is right, the package's recipe cuts.) Both leave the same numbers of steps.


# %%
def cut_short(data, margin, skipped=0):
    """Return data without their first steps, ended by your function ``margin`` before the reward."""
    distance = make(data.environment).distance_to_reward(data.tasks, data.states[:, 0])
    kept = torch.as_tensor(steps_before_reward(distance, margin))  # (task,)
    far = torch.arange(distance.shape[1]) < kept[:, None]  # (task, time)
    mask = data.mask * far[:, None]  # (task, 1, time)
    cut = {"states": data.states * mask[..., None], "actions": data.actions * mask[..., None]}
    cut["mask"] = mask
    return replace(data, **{part: values[:, :, skipped:] for part, values in cut.items()})


def expert_data(name, tasks, noise=0.0, margin=None, skipped=0):
    """Return the optimal expert's trajectories with noise; cut unless ``margin`` is None."""
    if cut_by_you and margin is not None:
        return cut_short(expert_data(name, tasks, noise), margin, skipped)
    params = recipes.load_or_train_expert(name, "optimal")
    recipe = recipes.Recipe(action_noise=noise, short_of_reward=margin, skipped_steps=skipped)
    return recipes.demonstrate(params, name, tasks, "optimal", 0, recipe)


# %%
wheeled = make("two_wheeled")
tasks = wheeled.training_tasks()[::2]  # every other task, to save time
yours = expert_data("two_wheeled", tasks, noise=0.1, margin=0.1, skipped=8)
recipe = recipes.Recipe(action_noise=0.1, short_of_reward=0.1, skipped_steps=8)
wheeled_expert = recipes.load_or_train_expert("two_wheeled", "optimal")
theirs = recipes.demonstrate(wheeled_expert, "two_wheeled", tasks, "optimal", 0, recipe)
assert check.agree(yours.lengths(), theirs.lengths())
print(f"steps kept per task:     {yours.lengths().tolist()}")
print(f"by the package's recipe: {theirs.lengths().tolist()}")

# %% [markdown]
# **What each cut takes away.** `replay` plays the stored *actions* from the start, with no policy at all, and returns the sum of the rewards.


# %%
def replay(data):
    """Return the sparse return of playing each demonstration's actions from the start, (task,)."""
    environment = make(data.environment)
    states, total = environment.reset(data.tasks, 1), torch.zeros(len(data.tasks))
    alive = torch.ones(len(data.tasks))
    for time in range(int(data.lengths().max())):
        moved = environment.step(data.tasks, states, data.actions[:, :, time], time)
        playing = alive * (time < data.lengths())
        total += moved.rewards[:, 0] * playing
        alive = alive * ~moved.terminated[:, 0]
        states = moved.states
    return total


# %% [markdown]
# **Predict first.** Cut Point2D's optimal trajectories with a margin of 0: every state that is kept lies outside of the disc that pays, whose reward is $1 - d$ at a distance $d$ of at most 0.2 from the goal. Replay their actions. What is the return?

# %%
guess.ask(
    "margin", "return, cut at a margin of 0", ["0", "between 0.8 and 1", "about 10", "about 80"]
)

# %% tags=["margins", "reveal", "tolerance:abs=0.3"]
for margin in (0.2, 0.1, 0.0):
    returns = replay(expert_data("point2d", goals, margin=margin))
    print(f"margin {margin:.1f}: return {returns.min():.1f} to {returns.max():.1f}")
assert 0.8 <= returns.min() <= returns.max() < 1.0
guess.reveal("margin", f"{returns.mean():.1f}")

# %% [markdown] tags=["reveal"]
# A state that lies outside of the disc, and less than a step (0.1) away from it, has an action that leads into it; the disc pays it once, between 0.8 and 1. With a margin of a step or more the replayed actions are paid nothing. This is why the recipes keep a margin.

# %% tags=["replay", "tolerance:0.1"]
for name in FAMILIES:
    good, bad = (
        replay(load_demonstrations(quality, name)) for quality in ("optimal", "suboptimal")
    )
    assert (good > 60).all() and (bad == 0).all()
    print(f"{name:18} optimal {good.min():5.1f} to {good.max():5.1f}", end="")
    print(f"   sub-optimal {bad.min():.1f} to {bad.max():.1f}")

# %% [markdown]
# Replayed, the optimal data reach every goal, and no sub-optimal trajectory has any return. Point2D's and the cheetah's sub-optimal data stop before anything is paid: they show the *direction*, and not the *goal*. TwoWheeled's lack the first steps as well, in which the robot turns towards its goal.
# "This truncation eliminates the possibility of direct imitation being successful", says the paper. Is that so?
#
# ## 3 · Copying alone
#
# **Behaviour cloning** maximises the likelihood of the demonstration, $\min_\theta -\frac{1}{T} \sum_t \log \pi_\theta(a_t \mid s_t)$, over its $T$ steps $(s_t, a_t)$: one policy $\pi_\theta$ per task and its one trajectory, 400 steps of Adam
# with the rate 0.003. The copy is a Gaussian policy, so it acts with noise of its own, of standard deviation $\sigma$. Its $\log \sigma$ starts at 0 and falls by at most about 0.003 per step of Adam, so $\sigma$ is still about $e^{-1.2} = 0.3$ at the end, however exact the data are.
# Whatever a copy loses may be the fault of the data, or of this noise. We therefore run each copy twice: acting as it is, **sampled**, and by its **mean action** alone. One network more or less hits a small goal by luck, so we fit three per demonstration, from three starts, and take the mean.


# %% tags=["cloning-numbers"]
def returns_of_copy(data, seed=0):
    """Return the copy's mean sparse returns {"sampled", "mean action"}, and its parameters."""
    copied, environment = clone(data, seed=seed), make(data.environment)
    ways = {"sampled": (copied, 10), "mean action": (without_noise(copied), 1)}
    returns = {}
    for way, (params, episodes) in ways.items():
        draws = torch.Generator().manual_seed(seed)
        rollout = collect(environment, data.tasks, params, episodes, draws)
        returns[way] = float(episode_returns(rollout).mean())
    return returns, copied


clock.at("copying alone")

# %% [markdown]
# **Predict first.** Copies of the *optimal* data, sampled: what is their return, in per cent of the demonstrations' own? And does the copy of TwoWheeled's *sub-optimal* data, which lack the beginning and the end, have any return to speak of?

# %%
guess.ask("good copy", "return of the optimal data's sampled copies, %")
guess.ask(
    "bad copy",
    "the copy of TwoWheeled's sub-optimal data has",
    ["no return", "a few per cent", "half or more"],
)

# %% tags=["reveal"]
shares, sigmas = {}, []
for name in FAMILIES:
    for quality in ("optimal", "suboptimal"):
        data = load_demonstrations(quality, name).map(lambda values: values[::2])
        paid = float(replay(load_demonstrations("optimal", name))[::2].mean())
        copies = [returns_of_copy(data, seed) for seed in range(3)]
        sigmas += [float(copied["log_sigma"].exp().median()) for _, copied in copies]
        shares[name, quality] = {
            way: 100 * np.mean([returns[way] for returns, _ in copies]) / paid
            for way in ("sampled", "mean action")
        }
assert all(0.2 < sigma < 0.5 for sigma in sigmas)
print(f"sigma of the copies, median over tasks: {min(sigmas):.2f} to {max(sigmas):.2f}")

# %% tags=["reveal"]
figure, panels = plt.subplots(1, 2, figsize=(11, 3), sharey=True)
looks = {"optimal": (-0.2, "#0072B2", ""), "suboptimal": (0.2, "#E69F00", "//")}
for axes, way in zip(panels, ("sampled", "mean action"), strict=True):
    for quality, (shift, colour, hatch) in looks.items():
        heights = [shares[name, quality][way] for name in FAMILIES]
        places = np.arange(len(heights)) + shift
        axes.bar(places, heights, 0.38, color=colour, hatch=hatch, label=f"copy of {quality} data")
    axes.axhline(100, color="black", linewidth=0.8, linestyle=(0, (1, 2)))
    axes.set_xticks(range(len(FAMILIES)), FAMILIES, fontsize=8)
    axes.set(title=way, ylim=(0, 135))
panels[0].set_ylabel("return of the copy\n(% of the optimal data's)")
panels[1].legend(loc="upper right", ncols=2)
plt.show()

# %% [markdown] tags=["reveal"]
# *Figure 4. Mean sparse return of policies cloned from one trajectory each (three copies per trajectory), in per cent of the optimal demonstrations' (dotted line), over every other training task. Sampled (left), every copy of optimal data falls short, and TwoWheeled's sub-optimal data make the better copy; by the mean action (right) TwoWheeled's optimal data make the better one.*

# %% tags=["cloning-claims", "reveal", "statistical", "tolerance:abs=25", "tolerance:rel=0.2"]
print("return of the copy, in % of the optimal data's   sampled   mean action")
for (name, quality), share in shares.items():
    print(f"{name:18} {quality:28} {share['sampled']:9.1f} {share['mean action']:13.1f}")
sampled = [shares[name, "optimal"]["sampled"] for name in FAMILIES]
assert max(sampled) < 85
good, bad = shares["point2d", "optimal"], shares["point2d", "suboptimal"]
assert all(bad[way] < 0.7 * good[way] for way in good)
wheeled_shares = {quality: shares["two_wheeled", quality] for quality in looks}
assert wheeled_shares["optimal"]["mean action"] > 1.2 * wheeled_shares["optimal"]["sampled"]
assert wheeled_shares["optimal"]["mean action"] > wheeled_shares["suboptimal"]["mean action"]
assert wheeled_shares["suboptimal"]["sampled"] > 30
guess.reveal("good copy", f"{min(sampled):.1f} to {max(sampled):.1f} %, by environment")
guess.reveal("bad copy", f"{wheeled_shares['suboptimal']['sampled']:.1f} % of the optimal data's")

# %% [markdown] tags=["reveal"]
# - **Sampled**, no copy of optimal data has 85 % of its demonstrator's return. **By its mean action** the copy of TwoWheeled's optimal data gets back most of what it lacks: there the loss was the copy's own noise, not a failure of cloning.
# - **Point2D's sub-optimal data** make a bad copy either way. It does not stop where the demonstration stopped: it runs on, through the goal and past it (notebook 01, Figure 6). Nobody showed it where to stay.
# - **TwoWheeled's sub-optimal data**, which cannot be imitated according to the paper, make a copy with more than half of the optimal demonstrations' return. Why?

# %% [markdown]
# ## 4 · What the copy was shown
#
# Sub-optimal data differ from optimal ones in several ways at once. We take them apart, in TwoWheeled: trajectories of the *optimal* expert, **clean** or **noisy** (noise of 0.1 on its actions), and **whole** or **cut** (without their first eight steps and their end).
#
# **Predict first.** Four data sets, four copies. Which copy has the smallest return?

# %%
clock.at("what the copy was shown")
guess.ask(
    "four copies",
    "the worst copy is that of the data that are",
    ["whole, clean", "whole, noisy", "cut, clean", "cut, noisy"],
)

# %% tags=["clean-or-noisy", "reveal", "statistical", "tolerance:abs=20", "tolerance:rel=0.1"]
cuts = {"whole": {}, "cut": {"margin": 0.1, "skipped": 8}}
noises = {"clean": 0.0, "noisy": 0.1}
square, copies = {}, {}
for cut, removed in cuts.items():
    for kind, noise in noises.items():
        data = expert_data("two_wheeled", tasks, noise, **removed)
        square[cut, kind], copied = returns_of_copy(data)
        copies[cut, kind] = data, copied
        both = ", ".join(f"{way} {value:.1f}" for way, value in square[cut, kind].items())
        print(f"{cut}, {kind}: return of the copy, {both}")
assert square["whole", "clean"]["mean action"] > 1.2 * square["whole", "clean"]["sampled"]
assert square["whole", "noisy"]["sampled"] > 1.2 * square["whole", "clean"]["sampled"]
assert max(square["cut", "clean"].values()) < 20 < 30 < min(square["cut", "noisy"].values())
worst = min(square, key=lambda which: square[which]["sampled"])
guess.reveal("four copies", ", ".join(worst))

# %% [markdown] tags=["reveal"]
# | | clean data | noisy data |
# |---|---|---|
# | whole | by the mean action most of the demonstrations' return; the copy's own noise costs half of that or more | the copy's own noise costs little |
# | cut | **nearly nothing**, with and without the copy's noise | about half of the whole demonstrations' return |
#
# (One copy per trajectory here, and one draw of the noise: differences of ten between copies are luck.)
#
# So the paper is right about *clean* data: without the first steps imitation fails. Noise on the demonstrator's actions, which the paper adds as well, brings it back. Why should *worse* actions teach better?

# %% [markdown]
# ### Exercise 3 · Read a figure
#
# *Difficulty 2 of 3, planned for 7 minutes. Pen and paper.* We ask the copies themselves. Put each of the four copies on the middle of its own demonstration, with the heading off by an error (positive: turned to the left), and see how its mean turn rate changes, compared with no error.
# Figure 5 shows the four answers, in an order drawn at random. Before you read on, answer in writing:
#
# 1. What does a line look like that corrects an error? And one that does not notice it?
# 2. Which line belongs to the copy of the cut, clean data, and which two to the copies of noisy data? Say why.
# 3. One line is left over. What in its data does it owe its shape to?
#
# <details><summary>Hint 1: signs</summary>
# The heading is too far to the left. Which sign has a turn to the right?
# </details>
#
# <details><summary>Hint 2: what did each copy see?</summary>
# A copy can only know how to turn back from headings that its data contain. Which headings does an expert show that drives straight to the goal, once it has turned towards it? Which one does an expert show whose actions are noisy?
# </details>

# %% tags=["corrections"]
errors = torch.linspace(-0.6, 0.6, 13)  # rad
letters = dict(zip(copies, np.random.default_rng(9).permutation(list("ABCD")), strict=True))
styles = {"A": ("-", "o"), "B": ("--", "s"), "C": ("-.", "^"), "D": (":", "D")}
figure, axes = plt.subplots(figsize=(6.2, 3.2))
slopes = {}
for which, letter in sorted(letters.items(), key=lambda pair: pair[1]):
    data, copied = copies[which]
    middle = data.states[range(len(tasks)), :, data.lengths() // 2]  # (task, 1, 3)
    placed = middle.repeat(1, len(errors), 1)  # (task, error, 3)
    placed[..., 2] += errors
    turn = policy.mean(copied, placed)[..., 1]  # (task, error), units of 2.84 rad/s
    change = (turn - turn[:, len(errors) // 2, None]).mean(0)  # against no error, over tasks
    slopes[which] = float((change * errors).sum() / errors.square().sum())
    line, marker = styles[letter]
    axes.plot(errors, change, line, marker=marker, markersize=4, label=letter)
axes.set(xlabel="error of the heading (rad)")
axes.set_ylabel("change of the turn rate\n(share of the fastest)")
axes.legend()
plt.show()

# %% [markdown]
# *Figure 5. How the four copies react to a heading that is off: change of the mean turn rate against the error, mean over twelve tasks. Two lines are steep, one is flat, one lies between them.*

# %%
guess.ask("flat", "cut, clean data", ["A", "B", "C", "D"])
guess.ask("steep", "the two of noisy data")

# %% tags=["corrections-named", "reveal", "tolerance:abs=0.15"]
noisy = sorted(str(letters[cut, "noisy"]) for cut in cuts)
guess.reveal("flat", str(letters["cut", "clean"]))
guess.reveal("steep", " and ".join(noisy))
for (cut, kind), slope in slopes.items():
    print(f"{letters[cut, kind]}: {cut}, {kind}, turns by {slope:+.2f} of its fastest per rad")
assert abs(slopes["cut", "clean"]) < 0.15 and slopes["whole", "clean"] < -0.2
assert max(slopes["cut", "noisy"], slopes["whole", "noisy"]) < slopes["whole", "clean"] - 0.2

# %% [markdown] tags=["reveal"]
# 1. A falling line corrects: too far to the left, it turns to the right. A flat line does not notice.
# 2. The flat line is that of the cut, clean data: they drive straight on and show a single heading, so the copy has nothing to learn a reaction from. The two steep lines are those of the noisy data: their demonstrator *corrects itself all the time*, so the data show many headings, and the way back from each.
# 3. The whole, clean data contain the first turn, from the heading at the start to that of the goal. The copy corrects a little, by what it saw there.
#
# Laskey et al. (2017) turned this into a method (DART): add noise to the demonstrator on purpose. For us it is a warning: "sub-optimal" says how well the demonstrator does, not how well it teaches.

# %% tags=["corridor", "reveal"]
corridor()
plt.show()

# %% [markdown] tags=["reveal"]
# *Figure 6. A sketch of the states that demonstrations cover (shaded; dashed: the demonstration; blue: its copy). Clean data cover a line: the copy's small errors lead out of it, to where there are no data. Noisy data cover a corridor, and every step away from its middle is followed by the way back.*

# %% [markdown]
# ### Exercise 4 · How far from the data?
#
# *Difficulty 2 of 3, planned for 5 minutes.* We measure whether a copy leaves its data: for each state that it visits, the distance to the nearest state of its demonstration. Your function draws the next figure, and judges your own data set in section 5.
#
# <details><summary>Hint 1: all pairs at once</summary>
# <code>torch.cdist</code> gives the distances of all pairs of two sets of points; or let an axis of length 1 broadcast.
# </details>
#
# <details><summary>Hint 2: of which axis?</summary>
# One number per state is left. Over what does "nearest" choose?
# </details>


# %% tags=["exercise-nearest"]
def nearest_distance(states, data):
    """Return each state's distance to the nearest data point, (n,), from (n, d) and (m, d)."""
    ### BEGIN SOLUTION
    return torch.cdist(states, data).min(dim=1).values
    ### END SOLUTION


# %%
measured_by_you = check.nearest_distance(nearest_distance)

# %% [markdown]
# **Predict first.** A copy of *whole, clean* data starts on its demonstration. Does it stay there for 16 steps when it acts by its mean action? When it is sampled, with $\sigma$ = 0.3?

# %%
guess.ask(
    "leaves",
    "the copy of whole, clean data leaves them",
    ["either way", "sampled only", "not at all"],
)


# %%
def distance_curve(data, params, steps=16):
    """Return the mean distance of a copy to its data at each of its first steps, in the plane."""
    rollout = collect(wheeled, data.tasks, params, 10, torch.Generator().manual_seed(0))
    gaps = []
    for task, length in enumerate(data.lengths().tolist()):
        known = data.states[task, 0, :length, :2]
        places = rollout.states[task, :, :steps, :2].reshape(-1, 2)  # (episode and time, 2)
        gap = torch.as_tensor(nearest_distance(places, known)).reshape(10, steps)
        gaps.append(gap.masked_fill(rollout.mask[task, :, :steps] == 0, torch.nan))
    return torch.stack(gaps).nanmean((0, 1))  # (time,)


# %% tags=["leaving-the-data", "reveal", "tolerance:abs=0.1"]
colours = {"clean": "#0072B2", "noisy": "#E69F00"}
away = {}
if measured_by_you:
    figure, panels = plt.subplots(1, 2, figsize=(9, 3))
    for (cut, kind), (data, copied) in copies.items():
        for way, params in (("sampled", copied), ("mean action", without_noise(copied))):
            away[cut, kind, way] = curve = distance_curve(data, params)
            line = "-" if way == "sampled" else ":"
            marker = "o" if kind == "clean" else "s"
            look = {"color": colours[kind], "marker": marker, "markersize": 3}
            panels[list(cuts).index(cut)].plot(curve, line, label=f"{kind}, {way}", **look)
    for panel, cut in zip(panels, cuts, strict=True):
        panel.set(title=f"{cut} data", xlabel="step")
    panels[0].set_ylabel("distance to the data\n(length units)")
    panels[0].legend(fontsize=8)
    plt.show()

# %% [markdown] tags=["reveal"]
# *Figure 7. Mean distance, in the plane, between the copies and their own demonstrations over the first 16 steps, twelve tasks and ten episodes each, sampled (solid) and by the mean action (dotted). Whole data (left): only the sampled copy of clean data drifts away. Cut data (right): the copy of clean data drives away, that of noisy data comes closer.*

# %% tags=["leaving-the-data-numbers", "reveal", "tolerance:abs=0.1"]
if measured_by_you:
    first, last = ({key: float(curve[at]) for key, curve in away.items()} for at in (0, -1))
    for (cut, kind, way), start in first.items():
        end = last[cut, kind, way]
        print(f"{cut}, {kind}, {way}: {start:.2f} away at first, {end:.2f} after 16 steps")
    assert last["whole", "clean", "sampled"] > 2 * last["whole", "clean", "mean action"]
    assert last["whole", "clean", "sampled"] > 1.5 * last["whole", "noisy", "sampled"]
    assert last["cut", "clean", "mean action"] > 1.2 * first["cut", "clean", "mean action"]
    assert last["cut", "noisy", "mean action"] < 0.7 * first["cut", "noisy", "mean action"]
    pair = [f"{way} {last['whole', 'clean', way]:.2f}" for way in ("mean action", "sampled")]
    guess.reveal(
        "leaves", f"distance after 16 steps: {', '.join(pair)}; a step is 0.11 long at most"
    )

# %% [markdown] tags=["reveal"]
# Left, both copies start on their data. The copy of the clean data stays there as long as it acts by its mean; with its own noise it drifts away step by step, because small errors lead to states without data, where nobody showed the way back. This is
# what **compounding errors** means, and it takes errors to begin with. The copy of the noisy data makes the same errors and undoes them. Right, both start where nobody showed them anything, eight steps from their data: the copy of the clean data drives away from them, that of the noisy data comes closer.
#
# Notebook 04 makes a part of this precise: cloning controls the distance to the demonstrator in the *demonstrator's* states; in the copy's own it may be larger by a factor of up to $1/(1-\gamma)$, here 20.

# %% [markdown]
# **Move it yourself.** One TwoWheeled demonstration of the optimal expert per goal, its end cut off; choose the noise on its actions and how many first steps are cut. Left, the demonstration (dots) and ten sampled episodes of its copy; right, the mean return for every choice, over four goals. All hundred copies are fitted beforehand, in some seconds.
#
# Try this: from the upper left corner, move only the cut until the copy fails. How few steps does it take? Then leave the cut where it is and move only the noise.

# %% tags=["widget-cloning", "nbval-ignore-output"]
ready = copies_by_noise_and_cut()
cloning_sliders(ready)

# %% tags=["widget-picture", "reveal"]
for noise in (0.0, 0.1):
    display(cloning_picture(ready, noise, 4))

# %% [markdown] tags=["reveal"]
# *Figure 8. The lesson of the sliders. Noise and cut as in the titles: without the first four steps, the copy of a clean demonstration (top) does not know where to turn and scatters; a noise of 0.1 on the demonstrator's actions (bottom) makes a copy that finds to the demonstration and along it.*

# %% tags=["widget-numbers", "reveal", "statistical", "tolerance:abs=25"]
returns = ready.returns()  # (noise, cut)
print(
    f"mean return of the copies, clean: whole {returns[0, 0]:.1f}, cut by 2 steps {returns[0, 2]:.1f}"
)
print(
    f"noise 0.1:                        whole {returns[2, 0]:.1f}, cut by 2 steps {returns[2, 2]:.1f}"
)
assert returns[0, 2:].max() < 20 and returns[2].min() > 40

# %% [markdown] tags=["reveal"]
# Two steps are enough: a wheeled robot turns by up to 1.42 rad in one, so its first two steps hold the whole turn towards the goal. Where the noise is large, the table is uneven: one trajectory per goal is little, and by chance it shows a correction or does not.

# %% [markdown]
# ## 5 · A data set of your own
#
# So far copies failed because they came to states without data. There is a second way to fail.
#
# ### Exercise 5 · Perfect demonstrations, a useless copy
#
# *Difficulty 3 of 3, planned for 15 minutes.* Design demonstrations in Point2D that all **reach their goal**, and whose copy fails all the same. You decide where the demonstrator walks: `walk(place, place, ...)` returns the actions, (time, 2), of a walk from the start $(0, 0)$ through the places you name,
# straight and in steps of at most 0.1; `walk(goal)` is the honest demonstration. Return a list of one to four walks, and your prediction of how the copy fails:
#
# - `"stays behind"`: it never comes as far from the start as the disc that pays, 1.8 length units,
# - `"runs past"`: it comes as far as that, and is paid less than a fifth of the demonstrations' return.
#
# A walk has at most 100 steps, so it is at most 10 length units long; the goal is 2 away. Your design must work for any goal, so write places with `goal`: `0.5 * goal` is half-way. The check plays your walks, copies them, and looks whether the copy fails as you said.
# Its copy has no network, so that every computer gives the same verdict: at every place it takes the *average of the actions that were demonstrated around there*. This is what the likelihood asks of a copy that can bend as it likes. The cell after the check fits a network, too.
#
# <details><summary>Hint 1: what does a copy not know?</summary>
# A policy sees where it is, and not how it got there. What does it do at a place where the demonstrator did first one thing, and later another?
# </details>
#
# <details><summary>Hint 2: one visit is one vote</summary>
# The average counts every visit. If the demonstrator comes through a place more often on a detour than on the way to the goal, the detour wins. How can you make it come by often enough?
# </details>
#
# <details><summary>Hint 3: after the goal</summary>
# For the other way to fail: an episode ends at the goal, so there are no data behind it, unless the demonstrator misses the goal first and turns back. What does the copy make of a sharp turn?
# </details>


# %% tags=["exercise-design"]
def misleading(goal, walk):
    """Return a list of walks that reach the goal (2,), and how their copy fails, in two words."""
    ### BEGIN SOLUTION
    out_and_back = [0.5 * goal, 0.0 * goal]
    return [walk(*out_and_back, *out_and_back, *out_and_back, goal)], "stays behind"
    ### END SOLUTION


# %%
misled = check.misleading(misleading)
clock.at("a data set of your own")

# %% [markdown]
# Your data set, copied by a network as in section 3, and judged by your own `nearest_distance`. Until your design is right, the honest walk stands here.

# %% tags=["statistical", "tolerance:abs=5"]
goal = point.sample_tasks(1, np.random.default_rng(3))[0]
walks, said = misleading(goal, designs.walk) if misled else ([designs.walk(goal)], "arrives")
walks = [torch.as_tensor(actions, dtype=torch.float32) for actions in walks]
data = designs.as_demonstrations(goal, walks)
paid = [designs.play(goal, actions).total for actions in walks]
network = without_noise(clone(data))
draws = torch.Generator().manual_seed(0)
rollout = collect(point, data.tasks, network, 1, draws)
way = rollout.states[0, 0, : int(rollout.mask.sum())]
averaged = designs.averaging_copy(data, 0.1)
print(f"demonstrations: return {min(paid):.1f} at least")
print(f"network's copy: return {episode_returns(rollout).item():.1f}, by its mean action")
print(f"averaging copy: return {averaged.total:.1f}; you said that it {said}")

# %%
ways = {
    "network's copy": (way, "#0072B2", "-"),
    "averaging copy": (averaged.states, "#D55E00", ":"),
}
paths = data.states[0], data.mask[0].sum(-1).long()
shown = [path[:length] for path, length in zip(*paths, strict=True)]
figure, (plane, panel) = plt.subplots(1, 2, figsize=(10, 3.4))
point.draw_tasks(plane, data.tasks)
for path in shown:
    plotting.demonstration(path, plane, linewidth=1.0)
    panel.plot((path - goal).norm(dim=-1), color="#333333", linestyle="--", linewidth=1.0)
for name, (places, colour, line) in ways.items():
    look = {"color": colour, "linestyle": line, "linewidth": 2.5, "label": name}
    plane.plot(places[:, 0], places[:, 1], **look)
    panel.plot((places - goal).norm(dim=-1), **look)
panel.axhspan(0, 0.2, color="#E69F00", alpha=0.3, linewidth=0)
panel.set(xlabel="step", ylabel="distance to the goal\n(length units)", ylim=(0, 4))
panel.legend(loc="upper right")
plt.show()

# %% tags=["tolerance:abs=0.1"]
if measured_by_you:
    known = data.states[0][data.mask[0].bool()]
    apart = torch.as_tensor(nearest_distance(way, known)).double().mean()
    print(f"mean distance of the network's copy to its nearest demonstrated state: {apart:.2f}")

# %% [markdown]
# *Figure 9. Your data set (dashed) and two copies of it: the network of section 3 by its mean action (blue), and the averaging copy of the check (dotted). Left, the plane; right, the distance to the goal over time, with the part that pays shaded. Compare where the demonstrations end with where the copies are when they do.*
#
# <details><summary>After your design: why it fails, and what is different from section 4</summary>
#
# The data set of the complete notebook walks half-way to the goal and back, three times, and then to the goal. At half-way, where it turns, its action points back three times and onwards once: the average points back. Before half-way, it comes by four times outwards and three times inwards: the
# average creeps outwards, at a seventh of a step. So the copy creeps towards half-way, stops short of it, and stays there. Its network's copy does the same, and hardly leaves its data.
#
# A loop through the start, walked twice before the demonstrator leaves for the goal, does it too: at the place where it leaves, two votes say "round" and one says "to the goal". And a demonstrator that first goes past the goal and then turns sharply back makes a copy that misses the turn and runs past.
#
# In section 4 a copy failed because it left its data: the cure is more states, such as those that noise shows. Here a copy fails *on* its data, and more of the same data cure nothing: the demonstrator remembers where it has been, and a policy $\pi(a \mid s)$ does not. Nor can a Gaussian say "either this or that": it says the average.
# The network may still behave differently from the averaging copy where the data are sparse; what it does there is its own invention.
# </details>
#
# ### Bonus · Votes on a line
#
# *Difficulty 3 of 3, for the fast. Pen and paper.* A demonstrator walks back and forth along a line, in steps of equal length between fixed places, from the start at place 0 to the goal at place $n$, where it stops for the first time. Its action is $+1$ or $-1$. Show that
#
# 1. at a place $0 < j < n$ where it never turns, the average action is $1 / (2 k + 1)$ with a whole number $k$, so that it always points to the goal,
# 2. at a place $0 < j < n$ where it turns back $k$ times and passes onwards once, and which it never comes to otherwise, the average is $(1 - k) / (1 + k)$.
#
# How often must a demonstrator turn back at the same place, for the copy to be caught there? Try it with `walk`.
#
# <details><summary>Hint: count the crossings</summary>
# It begins on one side of the gap between $j$ and $j + 1$ and ends on the other. How many more crossings are there one way than the other?
# </details>
#
# <details><summary>Solution</summary>
#
# 1. Between $j$ and $j + 1$ it crosses onwards once more than it crosses back, since it begins before the gap and ends behind it: $k + 1$ times onwards, $k$ times back. Every crossing onwards is an action $+1$ at $j$. It walks straight through $j$, so every crossing back, which arrives at $j$, is followed by an
# action $-1$ at $j$. The average is $(k + 1 - k) / (2 k + 1) = 1 / (2 k + 1) > 0$.
# 2. At the turning place there are $k$ actions $-1$, one action $+1$, and no others: $(1 - k) / (1 + k)$.
#
# With $k = 1$ the average is 0: the copy stands still there if it comes to exactly that place, and what it does next to it depends on how widely it averages. From $k = 2$ on the average points back, and the copy is caught. With a width of a step, though, the neighbours' votes count as well: the averaging copy of the check needs three.
# </details>
#
# ## Where paper and code differ (further reading)
#
# | point | paper | released code | this workbook |
# |---|---|---|---|
# | the expert's reward | not said | dense | dense: minus the distance; for the cheetah its sparse reward, paid everywhere |
# | how good "partially trained" is | not said | not compared | a success rate, in the table above |
# | action noise | "induced" | not compared | 0.1, for the cheetah 0.3 of the action range |
# | how much is cut | not said | not compared | in the table above |
# | cloning loss | a sum over the data | a mean | a mean; `--bc-reduction sum` |
#
# ## What was shown

# %% [markdown] tags=["reveal"]
# - A goal-conditioned expert learns Point2D in less than half a minute; it was told the goal and paid at every step. Told a goal that it never trained on, it goes towards it, and not all the way.
# - Optimal demonstrations, replayed, reach every goal; sub-optimal ones have no return by themselves, each for a reason of its own.
# - A copy acts with noise of its own. By its mean action, a copy of TwoWheeled's whole clean trajectory has most of the demonstrator's return; sampled, about half.
# - Cutting the beginning ruins the copy of clean data. Noise in the demonstrations shows corrections, and brings imitation back.
# - A copy also fails on its own data, where the demonstrator's actions contradict each other: it averages them.

# %% [markdown]
# What cloning alone lacks is feedback from the environment. EMRLD adds the cloning gradient to a policy gradient, so that rewards speak as well; its variant EMRLD-WS first takes one step of cloning and then collects the episodes that it learns from.
#
# **Next** notebook 04 asks what a theorem can say about demonstrations; notebook 06 uses them.
#
# **References** Schulman et al. (2015), *Trust region policy optimization*; Ross, Gordon and Bagnell (2011), *A reduction of imitation learning*; Laskey et al. (2017), *DART: noise injection for robust imitation learning*; Duan et al. (2016), *Benchmarking deep RL*; Rengarajan et al. (2022), the paper.
