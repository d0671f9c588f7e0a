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
# One demonstration per task: that is all EMRLD gets. Where do the demonstrations come from? From an **expert** who was told
# what the learner never is: the goal, and how far away it is. This notebook trains one in less than half a minute, records it, spoils the
# recordings on purpose, and lets a policy *copy* one good and one bad trajectory, to see how far copying goes.
#
# **You will be able to**
#
# - train a goal-conditioned expert on a dense reward (by TRPO, a policy-gradient step of limited length; notebook 05 takes it apart),
# - say what each kind of sub-optimal data takes away,
# - measure what behaviour cloning alone makes of a trajectory, and tell apart what the data, the cut and the copy's own noise do to it.
#
# **You need** notebooks 01 (behaviour cloning) and 02 (the environments). **Time** about 50 minutes, of which the machine computes
# one. **Paper** Section 4.1 and Appendix C of Rengarajan et al., NeurIPS 2022.

# %%
import matplotlib.pyplot as plt
import numpy as np
import torch

from emrld_lite import policy
from emrld_lite.classroom import checks as check
from emrld_lite.classroom.clock import Clock
from emrld_lite.demonstrations import load_demonstrations
from emrld_lite.demonstrators import recipes
from emrld_lite.demonstrators.cloning import clone
from emrld_lite.demonstrators.expert import ExpertConfig, GoalConditioned, train_expert
from emrld_lite.envs import make
from emrld_lite.experiments import plotting
from emrld_lite.rollout import collect, episode_returns

plotting.use_style()
FAMILIES = ("point2d", "two_wheeled", "half_cheetah", "two_wheeled_drift")
torch.set_num_threads(1)  # leaves the other cores to you
clock = Clock(
    {
        "an expert": 15,
        "good data and bad data": 15,
        "copying alone": 20,
    }
)

# %% [markdown]
# ## 1 · An expert
#
# The paper trains one expert for *all* tasks of an environment: a policy whose input is the state with the task's numbers appended, $\pi(a \mid s, g_i)$. Its reward is **dense**; for the
# goal-reaching environments, minus the distance to the goal. (The paper does not name the reward; its released code uses a dense one.) Two hidden layers of 128 units, a learned value network,
# and TRPO: `emrld_lite.demonstrators.expert` shares rollouts, advantages and the TRPO step with the meta-learner.
#
# ### Exercise 1 · Tell it the goal
#
# *Difficulty 1 of 3, 5 minutes.* Append the task to every state.
#
# <details><summary>Hint 1: the shapes do not match</summary>
# <code>tasks[:, None]</code> is (task, 1, n); <code>.expand(...)</code> repeats it along the episodes without copying.
# </details>
#
# <details><summary>Hint 2: which function joins?</summary>
# <code>torch.cat([first, second], dim=-1)</code>
# </details>


# %% tags=["exercise-goal"]
def with_task(states, tasks):
    """Return (task, episode, state + n) from (task, episode, state) and (task, n)."""
    ### BEGIN SOLUTION
    context = tasks[:, None].expand(*states.shape[:2], tasks.shape[-1])
    return torch.cat([states, context], dim=-1)
    ### END SOLUTION


# %%
clock.at("an expert")
point = make("point2d")
if check.with_task(with_task):
    tasks = point.training_tasks()
    theirs = GoalConditioned(point).reset(tasks, 4)
    assert torch.equal(with_task(point.reset(tasks, 4), tasks), theirs)
    print("Your states equal those of emrld_lite.demonstrators.expert.GoalConditioned.")

# %% [markdown]
# **Predict first.** 128 episodes per iteration, each of 100 steps at most. After how many iterations does the point reach a random goal more often than not?

# %% tags=["live-expert"]
history = list(train_expert(ExpertConfig(env="point2d", iterations=30, tasks=32)))
expert = history[-1].params
figure, panels = plt.subplots(1, 2, figsize=(8.4, 2.8))
panels[0].plot([100 * iterate.success for iterate in history], color="#333333")
panels[0].set(xlabel="TRPO iteration", ylabel="goals reached (%)", ylim=(-3, 103))
panels[1].plot([iterate.dense_return for iterate in history], color="#333333")
panels[1].set(xlabel="TRPO iteration", ylabel="mean dense return")
plt.show()

# %% tags=["expert-is-good", "statistical", "tolerance:abs=20", "tolerance:whole=8"]
unseen = point.sample_tasks(20, np.random.default_rng(5))
shown = recipes.demonstrate(expert, "point2d", unseen, "optimal", seed=0)
reached = (shown.lengths() < 60).double().mean()
half = next(iterate.iteration for iterate in history if iterate.success > 0.5)
assert history[-1].success > 0.85
assert reached > 0.75
print(f"more often than not from iteration {half} on")
print(f"iteration 30: {100 * history[-1].success:.1f} % of the random goals reached,")
print(f"              {100 * reached:.1f} % of 20 new ones in fewer than 60 steps")

# %% [markdown]
# *Figure 1. Training the Point2D expert: share of episodes that reach their goal (left) and mean dense return (right), as measured on the machine that ran this notebook.*
#
# The experts of the repository were trained the same way, on 80 (Point2D) to 250 (HalfCheetah) iterations; `python -m emrld_lite demos` remakes them, bit for bit on the same machine.
#
# ## 2 · Good data and bad data
#
# **Optimal data**: one trajectory of the expert for each training task, its mean action, no noise. **Sub-optimal data** come from an expert whose training was stopped early, with noise on its actions, and with a part cut off:
#
# | environment | stopped at | action noise | cut |
# |---|---|---|---|
# | Point2D | 50 % of goals reached | 0.1 | the end: 0.2 before the disc that pays |
# | TwoWheeled | 50 % | 0.1 | the **beginning**: the first 8 steps; and the end, 0.1 before the disc |
# | TwoWheeled, drift | 70 % | 0.1 | the same |
# | HalfCheetah | 90 % | 0.3 | the end: 0.5 m before the reward begins |
#
# (The paper says what is cut, not how much. The numbers are ours.)

# %% tags=["figure-2"]
clock.at("good data and bad data")
figure, panels = plt.subplots(2, 4, figsize=(13, 5.6))
for column, name in zip(panels.T, FAMILIES, strict=True):
    for axes, quality in zip(column, ("optimal", "suboptimal"), strict=True):
        plotting.all_demonstrations(load_demonstrations(quality, name), axes)
        axes.set_title(f"{name}\n{quality}", fontsize=10)
plt.show()

# %% [markdown]
# *Figure 2. The paper's Figure 2 for every environment: one demonstration per training task. Discs and lines: where a reward is paid. Dots: where a demonstration ends. For the cheetah, the position of
# its torso over time, five demonstrations per direction.*
#
# ### Exercise 2 · Cut it short
#
# *Difficulty 2 of 3, 5 minutes.* Given each step's distance to the region that pays, how many steps from the start on may be kept so that *none* of them is closer than a margin?
#
# <details><summary>Hint 1: one trajectory comes close, and leaves again</summary>
# Everything after the first close step is cut, also what is far again.
# </details>
#
# <details><summary>Hint 2: without a loop</summary>
# <code>cumprod</code> of zeros and ones stays 1 until the first 0.
# </details>


# %% tags=["exercise-cut"]
def steps_before_reward(distance, margin):
    """Return how many first steps all stay farther than margin, (task,), from (task, time)."""
    ### BEGIN SOLUTION
    return (distance > margin).long().cumprod(-1).sum(-1)
    ### END SOLUTION


# %%
if check.steps_before_reward(steps_before_reward):
    data = load_demonstrations("suboptimal", "point2d")
    distance = point.distance_to_reward(data.tasks, data.states[:, 0])
    kept = steps_before_reward(distance, 0.2)
    assert (kept >= data.lengths()).all()
    steps = torch.arange(distance.shape[1])
    closest = distance[steps < data.lengths()[:, None]].min()
    print(f"the closest stored sub-optimal step is {closest:.3f} away from the reward")

# %% [markdown]
# **What each cut takes away.** Replay the stored *actions* from the start, with no policy at all. Optimal data reach every goal. Sub-optimal data earn, by themselves, nothing.


# %% tags=["replay", "tolerance:0.1"]
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


for name in FAMILIES:
    good, bad = (
        replay(load_demonstrations(quality, name)) for quality in ("optimal", "suboptimal")
    )
    assert (good > 60).all() and (bad == 0).all()
    print(f"{name:18} optimal {good.min():5.1f} to {good.max():5.1f}", end="")
    print(f"   sub-optimal {bad.min():.1f} to {bad.max():.1f}")

# %% [markdown]
# Point2D's and the cheetah's bad data stop before anything is paid: they know the *direction*, not the *prize*. TwoWheeled's bad data also lack the first steps, in which the robot turns towards its goal.
# "This truncation eliminates the possibility of direct imitation being successful", says the paper. Is that so?
#
# ## 3 · Copying alone
#
# **Behaviour cloning** maximises the likelihood of the demonstration, $\min_\theta -\frac{1}{T} \sum_t \log \pi_\theta(a_t \mid s_t)$, over its $T$ steps $(s_t, a_t)$: one policy for each task and its one trajectory, 400 steps of Adam
# with the rate 0.003. The copy is a Gaussian policy, so it acts with noise of its own, $\sigma$. Its $\log \sigma$ starts at 0 and falls by at most about 0.003 per step of Adam, so $\sigma$ is still about $e^{-1.2} = 0.3$ at the end, however exact the data are.
# Whatever a copy loses may be the fault of the data, or of this noise. We therefore run each copy twice: acting as it is, **sampled**, and by its **mean action** alone. (To save time we take every other task.)
#
# **Predict first.** How much of the demonstrator's return does a copy of one *good* trajectory earn, sampled and by its mean action? A copy of one *bad* one?


# %% tags=["cloning-numbers"]
def without_noise(params):
    """Return the same policies with a sigma so small that they act by their mean."""
    return dict(params, log_sigma=torch.full_like(params["log_sigma"], -12.0))


def returns_of_copy(data, seed=0):
    """Return the copy's mean sparse returns {"sampled", "mean action"}, and its parameters."""
    copied, world = clone(data, seed=seed), make(data.environment)
    ways = {"sampled": (copied, 10), "mean action": (without_noise(copied), 1)}
    earned = {}
    for way, (params, episodes) in ways.items():
        draws = torch.Generator().manual_seed(seed)
        rollout = collect(world, data.tasks, params, episodes, draws)
        earned[way] = float(episode_returns(rollout).mean())
    return earned, copied


clock.at("copying alone")
shares, sigmas = {}, []
for name in FAMILIES:
    for quality in ("optimal", "suboptimal"):
        data = load_demonstrations(quality, name).map(
            lambda values: values[::2]
        )  # every other task
        paid = float(replay(load_demonstrations("optimal", name))[::2].mean())
        earned, copied = returns_of_copy(data)
        sigmas.append(float(copied["log_sigma"].exp().median()))
        shares[name, quality] = {way: 100 * value / paid for way, value in earned.items()}
assert all(0.2 < sigma < 0.5 for sigma in sigmas)
print(f"sigma of the copies, median over tasks: {min(sigmas):.2f} to {max(sigmas):.2f}")

# %%
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

# %% [markdown]
# *Figure 3. Mean sparse return of policies cloned from one trajectory each, in per cent of what the optimal demonstrations earn (dotted line), over every other training task: acting with their own noise (left) and by their mean action (right).*

# %% tags=["cloning-claims", "statistical", "tolerance:abs=25", "tolerance:rel=0.2"]
print("return of the copy, in % of the optimal data's   sampled   mean action")
for (name, quality), share in shares.items():
    print(f"{name:18} {quality:28} {share['sampled']:9.1f} {share['mean action']:13.1f}")
for name in FAMILIES:
    assert shares[name, "optimal"]["sampled"] < 85
for way in ("sampled", "mean action"):
    assert shares["point2d", "suboptimal"][way] < 0.7 * shares["point2d", "optimal"][way]
wheeled_shares = {quality: shares["two_wheeled", quality] for quality in looks}
assert wheeled_shares["optimal"]["mean action"] > 1.2 * wheeled_shares["optimal"]["sampled"]
assert wheeled_shares["optimal"]["mean action"] > wheeled_shares["suboptimal"]["mean action"]
assert wheeled_shares["suboptimal"]["sampled"] > 30

# %% [markdown]
# - **Sampled**, no copy of good data earns 85 % of what its demonstrator earns. **By its mean action** the copy of TwoWheeled's good data gets back most of what it lacks: there the loss was the copy's own noise, not a failure of cloning.
# - **Point2D's bad data** make a bad copy either way. It does not stop where the demonstration stopped: it runs on, through the goal and past it (notebook 01, Figure 4). Nobody showed it where to stay.
# - **TwoWheeled's bad data**, which cannot be imitated according to the paper, make a copy that earns half to two thirds of the demonstrator's return. Why?
#
# The bad data differ from the good in several ways at once. We take them apart: the *optimal* expert, with and without noise of 0.1 on its actions, its trajectories whole, or cut as above (the first eight steps and the end).

# %% tags=["clean-or-noisy", "statistical", "tolerance:abs=20", "tolerance:rel=0.1"]
expert = recipes.load_or_train_expert("two_wheeled", "optimal")
wheeled = make("two_wheeled")
tasks = wheeled.training_tasks()[::2]
cuts = {"whole": {}, "cut": {"skipped_steps": 8, "short_of_reward": 0.1}}
noises = {"clean": 0.0, "noisy": 0.1}
square, copies = {}, {}
for cut, removed in cuts.items():
    for kind, noise in noises.items():
        recipe = recipes.Recipe(action_noise=noise, **removed)
        data = recipes.demonstrate(expert, "two_wheeled", tasks, "optimal", 0, recipe)
        square[cut, kind], copied = returns_of_copy(data)
        copies[cut, kind] = data, copied
        both = ", ".join(f"{way} {value:.1f}" for way, value in square[cut, kind].items())
        print(f"{cut:5}, {kind}: return of the copy, {both}")
assert square["whole", "clean"]["mean action"] > 1.2 * square["whole", "clean"]["sampled"]
assert square["whole", "noisy"]["sampled"] > 1.2 * square["whole", "clean"]["sampled"]
for way in ("sampled", "mean action"):
    assert square["cut", "clean"][way] < 20 < 30 < square["cut", "noisy"][way]

# %% [markdown]
# | | clean data | noisy data |
# |---|---|---|
# | whole | the mean action earns most of what the demonstrator earns; the copy's own noise costs about half of that | the copy's own noise costs little |
# | cut | **nearly nothing**, with and without the copy's noise | half of the demonstrator's return or more |
#
# So the paper is right about *clean* data: without the first steps imitation fails. Noise on the demonstrator's actions, which the paper adds as well, brings it back. Noisy demonstrations *correct themselves all the time*: they show many headings, and the way
# back from each. We can ask the copies themselves. Put each copy on the middle of its demonstration, with the heading off by an error, and see how it turns.

# %% tags=["corrections", "tolerance:abs=0.15"]
errors = torch.linspace(-0.6, 0.6, 13)  # rad
figure, axes = plt.subplots(figsize=(6.2, 3.2))
looks = {"whole": "-", "cut": "--"}
colours = {"clean": "#0072B2", "noisy": "#E69F00"}
slopes = {}
for (cut, kind), (data, copied) in copies.items():
    middle = data.states[range(len(tasks)), :, data.lengths() // 2]  # (task, 1, 3)
    placed = middle.repeat(1, len(errors), 1)  # (task, error, 3)
    placed[..., 2] += errors
    turn = policy.mean(copied, placed)[..., 1]  # (task, error), units of 2.84 rad/s
    change = (turn - turn[:, len(errors) // 2, None]).mean(0)  # against no error, over tasks
    slopes[cut, kind] = float((change * errors).sum() / errors.square().sum())
    axes.plot(errors, change, looks[cut], color=colours[kind], label=f"{cut}, {kind}")
    print(f"{cut:5}, {kind}: turns by {slopes[cut, kind]:+.2f} of its fastest per rad of error")
axes.set(
    xlabel="error of the heading (rad)", ylabel="change of the turn rate\n(share of the fastest)"
)
axes.legend()
plt.show()
assert abs(slopes["cut", "clean"]) < 0.15 and slopes["whole", "clean"] < -0.2
assert max(slopes["cut", "noisy"], slopes["whole", "noisy"]) < slopes["whole", "clean"] - 0.2

# %% [markdown]
# *Figure 4. How the copies react to a heading that is off: change of the mean turn rate against the error, mean over twelve tasks. A falling line corrects the error.*
#
# The copy of the cut clean data does not react at all: its demonstration drives straight on and shows nothing else. The whole clean demonstration contains its first turn, and the copy corrects a little. Both noisy ones make copies that turn back firmly.
# Laskey et al. (2017) turned this into a method (DART). For us it is a warning: "sub-optimal" says how well the demonstrator does, not how well it teaches.
#
# ### Exercise 3 · How far from the data?
#
# *Difficulty 2 of 3, 5 minutes.* For each state the copy visits: the distance to the nearest state of its demonstration.
#
# <details><summary>Hint 1: all pairs at once</summary>
# <code>torch.cdist(states, data)</code> is (n, m), every distance.
# </details>
#
# <details><summary>Hint 2: which of them?</summary>
# The smallest of each row: <code>.min(dim=1).values</code>
# </details>


# %% tags=["exercise-nearest"]
def nearest_distance(states, data):
    """Return each state's distance to the nearest data point, (n,), from (n, d) and (m, d)."""
    ### BEGIN SOLUTION
    return torch.cdist(states, data).min(dim=1).values
    ### END SOLUTION


# %% tags=["leaving-the-data", "tolerance:abs=0.1"]
if check.nearest_distance(nearest_distance):
    figure, panels = plt.subplots(1, 2, figsize=(9, 3))
    away = {}
    for (cut, kind), (data, copied) in copies.items():
        for way, params in (("sampled", copied), ("mean action", without_noise(copied))):
            draws = torch.Generator().manual_seed(0)
            rollout = collect(wheeled, tasks, params, 10, draws)
            gaps = []
            for task, length in enumerate(data.lengths().tolist()):
                known = data.states[task, 0, :length, :2]
                places = rollout.states[task, :, :16, :2]  # (episode, time, 2)
                gap = nearest_distance(places.flatten(0, 1), known).reshape(10, 16)
                gaps.append(gap.masked_fill(rollout.mask[task, :, :16] == 0, torch.nan))
            curve = torch.stack(gaps).nanmean((0, 1))  # (time,)
            away[cut, kind, way] = float(curve[0]), float(curve[-1])
            line = "-" if way == "sampled" else ":"
            panel = panels[list(cuts).index(cut)]
            panel.plot(curve, line, color=colours[kind], label=f"{kind}, {way}")
    for panel, cut in zip(panels, cuts, strict=True):
        panel.set(title=f"{cut} data", xlabel="step")
    panels[0].set_ylabel("distance to the data\n(length units)")
    panels[0].legend(fontsize=8)
    plt.show()
    assert away["whole", "clean", "sampled"][1] > 2 * away["whole", "clean", "mean action"][1]
    assert away["whole", "clean", "sampled"][1] > 1.5 * away["whole", "noisy", "sampled"][1]
    assert away["cut", "clean", "mean action"][1] > 1.2 * away["cut", "clean", "mean action"][0]
    assert away["cut", "noisy", "mean action"][1] < 0.7 * away["cut", "noisy", "mean action"][0]
    for (cut, kind, way), (first, last) in away.items():
        print(f"{cut:5}, {kind}, {way:11}: {first:.2f} away at first, {last:.2f} after 16 steps")

# %% [markdown]
# *Figure 5. Mean distance, in the plane, between the copies and their own demonstrations over the first 16 steps, twelve tasks and ten episodes each: whole data (left) and cut data (right), sampled (solid) and by the mean action (dotted).*
#
# Left, both copies start on their data. The copy of the clean data stays there as long as it acts by its mean; with its own noise it drifts away step by step, because small errors lead to states without data, where nobody showed the way back. This is
# what **compounding errors** means, and it takes errors to begin with. The copy of the noisy data makes the same errors and undoes them. Right, both start where nobody showed them anything, eight steps from their data: the copy of the clean data drives away from them, that of the noisy data comes closer.
#
# Notebook 04 makes a part of this precise: cloning controls the distance to the demonstrator in the *demonstrator's* states, and that is no bound on anything in the copy's own. What is missing is
# feedback from the environment. EMRLD adds the cloning gradient to a policy gradient, so that rewards speak as well, and its variant EMRLD-WS first takes one step of cloning and then collects the episodes it learns from.
#
# ## Where paper and code differ
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
#
# - A goal-conditioned expert learns Point2D in less than half a minute; it was told the goal and paid at every step.
# - Optimal demonstrations, replayed, reach every goal; sub-optimal ones earn nothing by themselves, each for a reason of its own.
# - A copy acts with noise of its own. By its mean action, a copy of TwoWheeled's whole clean trajectory earns most of what the demonstrator earns; sampled, about half.
# - Cutting ruins the copy of clean data. Noise in the demonstrations shows corrections, and brings imitation back.
#
# **Next** notebook 04 asks what a theorem can say about demonstrations; notebook 06 uses them.
#
# **References** Schulman et al. (2015), *Trust region policy optimization*; Ross, Gordon and Bagnell (2011), *A reduction of imitation learning*; Laskey et al. (2017), *DART: noise injection for robust imitation learning*; Duan et al. (2016), *Benchmarking deep RL*; Rengarajan et al. (2022), the paper.
