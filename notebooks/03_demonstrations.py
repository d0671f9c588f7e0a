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
# One recorded path per task: that is all EMRLD gets. Where do the paths come from? From an **expert** who was told
# what the learner never is: the goal, and how far away it is. This notebook trains one in half a minute, records it, spoils the
# recordings on purpose, and lets a policy *copy* one good and one bad trajectory, to see how far copying goes.
#
# **You will be able to**
#
# - train a goal-conditioned expert by TRPO on a dense reward,
# - say what each kind of sub-optimal data takes away,
# - measure what behaviour cloning alone makes of one good and one bad trajectory, and explain a surprise.
#
# **You need** notebooks 01 (behaviour cloning) and 02 (the environments). **Time** about 50 minutes, of which the machine computes
# one to two. **Paper** Section 4.1 and Appendix C of Rengarajan et al., NeurIPS 2022.

# %%
import matplotlib.pyplot as plt
import numpy as np
import torch

from emrld_lite.classroom import checks as check
from emrld_lite.classroom.clock import Clock
from emrld_lite.demonstrations import load_demonstrations
from emrld_lite.demonstrators import recipes
from emrld_lite.demonstrators.cloning import clone
from emrld_lite.demonstrators.expert import ExpertConfig, GoalConditioned, train_expert
from emrld_lite.envs import ENVIRONMENTS, make
from emrld_lite.experiments import plotting
from emrld_lite.rollout import collect, episode_returns

plotting.use_style()
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
# **Predict first.** 192 episodes per iteration, each of 100 steps at most. After how many iterations does the point reach a random goal more often than not?

# %% tags=["live-expert"]
history = list(train_expert(ExpertConfig(env="point2d", iterations=40)))
expert = history[-1].params
figure, axes = plt.subplots(figsize=(6.2, 3))
axes.plot([100 * iterate.success for iterate in history], color="#333333")
axes.set(xlabel="TRPO iteration", ylabel="goals reached (%)", ylim=(-3, 103))
losses = axes.twinx()
losses.plot([it.dense_return for it in history], color="#999999", linestyle="--")
losses.set_ylabel("dense return (dashed)")
losses.grid(False)
plt.show()

# %% tags=["expert-is-good", "statistical", "tolerance:abs=8"]
unseen = point.sample_tasks(20, np.random.default_rng(5))
shown = recipes.demonstrate(expert, "point2d", unseen, "optimal", seed=0)
reached = (shown.lengths() < 60).double().mean()
assert history[-1].success > 0.9
assert reached > 0.9
print(f"iteration 40: {100 * history[-1].success:.1f} % of the random goals reached,")
print(f"              {100 * reached:.1f} % of 20 new ones in fewer than 60 steps")

# %% [markdown]
# *Figure 1. Training the Point2D expert: share of episodes that reach their goal (solid) and mean dense return (dashed), as measured on the machine that ran this notebook.*
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
for column, name in zip(panels.T, ENVIRONMENTS, strict=True):
    for axes, quality in zip(column, ("optimal", "suboptimal"), strict=True):
        plotting.all_demonstrations(load_demonstrations(quality, name), axes)
        axes.set_title(f"{name}\n{quality}", fontsize=10)
plt.show()

# %% [markdown]
# *Figure 2. The paper's Figure 2 for every environment: one demonstration a training task. Discs and lines: where a reward is paid. Dots: where a recording ends. For the cheetah, the position of
# its torso over time, five recordings a direction.*
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


for name in ENVIRONMENTS:
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
# **Behaviour cloning** maximises the likelihood of the demonstration, $\min_\theta -\frac{1}{T} \sum_t \log \pi_\theta(a_t \mid s_t)$: one policy for each task and its one trajectory, 400 steps of Adam.
#
# **Predict first.** How much of the demonstrator's return does a copy of one *good* trajectory earn? A copy of one *bad* one? In every environment?

# %% tags=["cloning-numbers"]
clock.at("copying alone")
rollouts, shares = {}, {}
for name in ENVIRONMENTS:
    paid = float(replay(load_demonstrations("optimal", name)).mean())
    for quality in ("optimal", "suboptimal"):
        data = load_demonstrations(quality, name)
        episodes = 4 if name == "half_cheetah" else 20
        draws = torch.Generator().manual_seed(0)
        rollout = collect(make(name), data.tasks, clone(data), episodes, draws)
        rollouts[name, quality] = rollout
        shares[name, quality] = 100 * float(episode_returns(rollout).mean()) / paid

# %%
figure, axes = plt.subplots(figsize=(7.4, 3))
looks = {"optimal": (-0.2, "#0072B2", ""), "suboptimal": (0.2, "#E69F00", "//")}
for quality, (shift, colour, hatch) in looks.items():
    heights = [shares[name, quality] for name in ENVIRONMENTS]
    places = np.arange(len(heights)) + shift
    axes.bar(places, heights, 0.38, color=colour, hatch=hatch, label=f"copy of {quality} data")
axes.axhline(100, color="black", linewidth=0.8, linestyle=(0, (1, 2)))
axes.set_xticks(range(len(ENVIRONMENTS)), ENVIRONMENTS)
axes.set(ylabel="return of the copy\n(% of the optimal data's)", ylim=(0, 135))
axes.legend(loc="upper right", ncols=2)
plt.show()

# %% [markdown]
# *Figure 3. Mean sparse return of policies cloned from one trajectory each, in per cent of what the optimal demonstrations earn (dotted line), over all training tasks.*

# %% tags=["cloning-claims", "statistical", "tolerance:abs=8", "tolerance:whole=4"]
assert all(shares[name, "optimal"] < 80 for name in ENVIRONMENTS)
assert shares["point2d", "suboptimal"] < 0.4 * shares["point2d", "optimal"]
assert shares["half_cheetah", "suboptimal"] < shares["half_cheetah", "optimal"]
assert shares["two_wheeled", "suboptimal"] > shares["two_wheeled", "optimal"]
per_task = {
    q: episode_returns(rollouts["two_wheeled", q]).mean(1) for q in ("optimal", "suboptimal")
}
better = int((per_task["suboptimal"] > per_task["optimal"]).sum())
assert better > 12  # of 24
print("return of the copy, in % of the optimal data's")
for name in ENVIRONMENTS:
    good, bad = shares[name, "optimal"], shares[name, "suboptimal"]
    print(f"{name:18} optimal data {good:5.1f}   sub-optimal data {bad:5.1f}")
print(f"TwoWheeled: the copy of bad data is the better one on {better} of 24 tasks")

# %% [markdown]
# The left group is what the paper describes: the copy of a path that stops short stops short. The cheetah's copy loses less, since a gait repeats itself: who can copy two metres of running can run on.
#
# And TwoWheeled? We expected the copy of the bad data to fail, and looked for our mistake. There is none: on most tasks the robot *without* the first eight steps does **better**. Look at one of them:

# %%
task = 12
figure, panels = plt.subplots(1, 2, figsize=(8.6, 3.6), sharey=True)
for axes, quality in zip(panels, ("optimal", "suboptimal"), strict=True):
    data = load_demonstrations(quality, "two_wheeled")
    plotting.all_demonstrations(data.take(slice(task, task + 1)), axes)
    plotting.trajectories(rollouts["two_wheeled", quality], axes, task=task, episodes=20)
    earned = float(episode_returns(rollouts["two_wheeled", quality])[task].mean())
    axes.set_title(f"{quality} data; the copy earns {earned:.0f}")
plt.show()

# %% [markdown]
# *Figure 4. One task of TwoWheeled: its demonstration (black, a dot at its end) and twenty episodes of the policy cloned from it (blue).*
#
# The good demonstration is too clean. One sharp turn, then straight on: it never shows what to do when the heading is a little off, and the copy, which acts with some noise, is soon off. The bad demonstration is
# noisy, and *corrects itself all the time*: it shows which heading is right and how to come back to it, from anywhere. If that is the reason, then noise must help a **good** demonstrator, too. An experiment: the optimal expert, nothing
# cut off, with more and more noise on its actions.

# %% tags=["noise-helps", "statistical", "tolerance:abs=8"]
expert = recipes.load_or_train_expert("two_wheeled", "optimal")
wheeled = make("two_wheeled")
tasks = wheeled.training_tasks()
noises = (0.0, 0.05, 0.1, 0.3)
earned = {noise: [] for noise in noises}
for noise in noises:
    noisy = recipes.Recipe(action_noise=noise)
    for seed in range(3):
        data = recipes.demonstrate(expert, "two_wheeled", tasks, "optimal", seed, noisy)
        draws = torch.Generator().manual_seed(seed)
        rollout = collect(wheeled, tasks, clone(data, seed=seed), 20, draws)
        earned[noise].append(float(episode_returns(rollout).mean()))
assert min(earned[0.1]) > 1.3 * max(earned[0.0])
for noise, returns in earned.items():
    each = ", ".join(f"{value:.1f}" for value in returns)
    print(f"noise {noise:.2f}: return of the copy {np.mean(returns):.1f}, by seed {each}")

# %%
figure, axes = plt.subplots(figsize=(5.6, 3))
for place, noise in enumerate(noises):
    axes.plot([place] * 3, earned[noise], marker="o", color="#333333", linestyle="none")
axes.plot([np.mean(earned[noise]) for noise in noises], color="#333333", linewidth=1)
axes.set_xticks(range(len(noises)), noises)
axes.set(xlabel="noise on the expert's actions", ylabel="return of the copy", ylim=(0, 88))
plt.show()

# %% [markdown]
# *Figure 5. TwoWheeled: mean sparse return of copies of optimal demonstrations against the noise on the demonstrator's actions; three seeds and their mean.*
#
# Noise makes the *data* worse and the *copy* better. Laskey et al. (2017) turned this into a method (DART). For us it is a warning: "sub-optimal" says how well the demonstrator does, not how well he teaches.
# The paper's claim that its TwoWheeled data cannot be imitated we could not confirm with data made as it describes.
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


# %% tags=["leaving-the-data", "tolerance:abs=0.05"]
if check.nearest_distance(nearest_distance):
    figure, axes = plt.subplots(figsize=(6.4, 3))
    first, last = {}, {}
    for quality, look in (("optimal", "-"), ("suboptimal", "--")):
        data, rollout = (
            load_demonstrations(quality, "two_wheeled"),
            rollouts["two_wheeled", quality],
        )
        away = []
        for i in range(24):
            known = data.states[i, 0, : int(data.lengths()[i]), :2]
            away.append(
                nearest_distance(rollout.states[i, :, :16, :2].flatten(0, 1), known).reshape(20, 16)
            )
        curve = torch.stack(away).mean((0, 1))  # (time,)
        first[quality], last[quality] = float(curve[0]), float(curve[-1])
        axes.plot(curve, linestyle=look, color="#333333", label=f"copy of {quality} data")
    axes.set(xlabel="step", ylabel="distance to the data (length units)")
    axes.legend()
    plt.show()
    assert last["optimal"] > 0.15 and last["suboptimal"] < 0.5 * first["suboptimal"]
    for quality, away in first.items():
        print(
            f"copy of {quality} data: {away:.2f} away at first, {last[quality]:.2f} after 16 steps"
        )

# %% [markdown]
# *Figure 6. Mean distance, in the plane, between the copy and its own demonstration, over the first 16 steps, all 24 tasks and 20 episodes each.*
#
# The copy of the clean data starts on its data and drifts away, step by step: small errors lead to states without data, where errors are larger, **compounding errors**. The copy of the noisy data starts where
# nobody showed it anything, and comes *towards* its data: it has learnt to correct. Notebook 04 makes this precise: cloning controls the distance to the demonstrator in the *demonstrator's* states, and that is no bound on anything in the copy's own. What is missing is
# feedback from the world. EMRLD takes *one* step of cloning, then looks at rewards.
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
# - A goal-conditioned expert learns Point2D in half a minute; it was told the goal and paid at every step.
# - Optimal demonstrations, replayed, reach every goal; sub-optimal ones earn nothing by themselves, each for a reason of its own.
# - Copying one good trajectory goes part of the way, and the copy leaves its data. Point2D's bad data make a bad copy; TwoWheeled's noisy ones a better copy than the clean ones.
#
# **Next** notebook 04 asks what a theorem can say about demonstrations; notebook 06 uses them.
#
# **References** Schulman et al. (2015), *Trust region policy optimization*; Ross, Gordon and Bagnell (2011), *A reduction of imitation learning*; Laskey et al. (2017), *DART: noise injection for robust imitation learning*; Duan et al. (2016), *Benchmarking deep RL*; Rengarajan et al. (2022), the paper.
