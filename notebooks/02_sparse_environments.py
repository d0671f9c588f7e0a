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
# # 02 · Sparse environments: where there is nothing to learn from
#
# Put a point on a plane, hide a goal two units away, and pay it only once it is next to the goal. Let it try 2,400 times. You
# can count on your fingers how often it is paid. This notebook builds the paper's environments, shows how empty their rewards
# are, and what is left of a policy gradient where there is no reward: exactly nothing, or, with one innocent constant,
# something worse.
#
# **You will be able to**
#
# - write Point2D Navigation and the wheeled robot from their formulas,
# - say when it would pay to loiter next to a goal, and when not,
# - measure how often an untrained policy is rewarded, with an interval,
# - say what the policy gradient is on tasks without a reward, and prove it,
# - explain why a constant reward of $10^{-5}$ is not harmless.
#
# **You need** notebook 01 (policy gradient, advantages). **Time** about 70 minutes, of which the machine computes one. **Paper**
# Section 4.1 and Appendix B (Environments) of Rengarajan et al., NeurIPS 2022.

# %%
import math

import gymnasium
import matplotlib.pyplot as plt
import numpy as np
import torch

from emrld_lite import losses, policy
from emrld_lite.advantage import Score
from emrld_lite.classroom import checks as check
from emrld_lite.classroom.clock import Clock
from emrld_lite.classroom.widgets import sparsity
from emrld_lite.demonstrations import load_demonstrations
from emrld_lite.demonstrators.expert import ExpertConfig, train_expert
from emrld_lite.envs import GYMNASIUM_IDS, make
from emrld_lite.experiments import plotting
from emrld_lite.experiments.intervals import wilson_interval
from emrld_lite.rollout import collect

plotting.use_style()
FAMILIES = ("point2d", "two_wheeled", "half_cheetah", "two_wheeled_drift")
torch.set_num_threads(1)  # leaves the other cores to you
clock = Clock(
    {
        "a point and a goal": 15,
        "the others": 20,
        "how rarely it pays": 15,
        "what the gradient is then": 15,
        "dense and sparse, live": 5,
    }
)

# %% [markdown]
# ## 1 · A point and a goal
#
# **Point2D Navigation.** The state is a position $(x, y)$, the action a displacement $(dx, dy)$ of length at most 0.1:
#
# $$x_{t+1} = x_t + dx_t, \qquad y_{t+1} = y_t + dy_t, \qquad dx_t^2 + dy_t^2 \le 0.1^2 .$$
#
# (The paper prints $y_{t+1} = x_t + dy_t$, a slip of the pen.) With $d$ the distance from $(x_{t+1}, y_{t+1})$ to the goal $(x_g, y_g)$, the reward is
#
# $$R_t = \begin{cases} 100 - t - 1 & d \le 0.02 \quad \text{(and the episode ends)} \\ 1 - d & 0.02 < d \le 0.2 \\ 0 & \text{otherwise.} \end{cases}$$
#
# An episode starts at the origin and lasts 100 steps at most, $t = 0, \dots, 99$. The first line pays out the steps that are left, so that arriving early pays. The goals of the
# twelve training tasks lie on a semicircle of radius 2.
#
# ### Exercise 1 · Write it
#
# *Difficulty 2 of 3, 10 minutes.* One step for one point.
#
# <details><summary>Hint 1: a move that is too long</summary>
# Keep its direction: multiply it by 0.1 over its length. A shorter move stays as it is.
# </details>
#
# <details><summary>Hint 2: which distance, which case first?</summary>
# The distance after the step. Both conditions hold very close to the goal; the smaller disc wins.
# </details>


# %% tags=["exercise-point"]
def point_step(position, move, goal, time):
    """Return (new position (2,), reward, done) from three tensors (2,) and the time index t."""
    ### BEGIN SOLUTION
    length = float(move.norm())
    moved = position + move * (0.1 / length if length > 0.1 else 1.0)
    distance = float((moved - goal).norm())
    if distance <= 0.02:
        return moved, 100.0 - time - 1, True
    return moved, (1.0 - distance if distance <= 0.2 else 0.0), False
    ### END SOLUTION


# %% tags=["point-equals-package"]
clock.at("a point and a goal")
point = make("point2d")
if check.point_step(point_step):
    random = torch.Generator().manual_seed(0)
    goal = point.training_tasks()[4]
    for _ in range(300):
        start = goal + 0.3 * torch.randn(2, generator=random)
        action = torch.randn(2, generator=random).clamp(-1, 1)  # a policy acts in units of 0.1
        ours = point_step(start, 0.1 * action, goal, 7)
        theirs = point.step(goal[None], start[None, None], action[None, None], 7)
        assert torch.allclose(ours[0], theirs.states[0, 0], atol=1e-6)
        assert abs(ours[1] - float(theirs.rewards)) < 1e-5 and ours[2] == bool(theirs.terminated)
    print("Your Point2D equals emrld_lite.envs.Point2D on 300 random steps.")

# %% [markdown]
# **The landscape of its reward.** **Predict first:** which share of the half disc of radius 2 pays anything at all, for one goal?

# %% tags=["reward-landscape"]
figure, panels = plt.subplots(1, 3, figsize=(11.5, 3.5))
wheeled = make("two_wheeled")
plotting.reward_landscape(point, point.training_tasks()[4], panels[0])
plotting.reward_landscape(wheeled, wheeled.training_tasks()[8], panels[1])
panels[0].set_title("Point2D, one task")
panels[1].set_title("TwoWheeled, one task")
away = np.linspace(0, 1, 500)
panels[2].plot(away, np.where(away <= 0.02, 99, np.where(away <= 0.2, 1 - away, 0)))
panels[2].set(yscale="symlog", xlabel="distance to the goal", ylabel="reward at t = 0")
panels[2].set_title("Point2D, along a line")
plt.show()
x, y = np.meshgrid(np.linspace(-2, 2, 1601), np.linspace(0, 2, 801))
inside = np.hypot(x, y) <= 2
goal_x, goal_y = point.training_tasks()[4].tolist()
share = (inside & (np.hypot(x - goal_x, y - goal_y) <= 0.2)).sum() / inside.sum()
assert 0.009 < share < 0.0101
print(f"the disc that pays covers {share:.2%} of the half disc of radius 2")

# %% [markdown]
# *Figure 1. Reward of standing at each place, for one goal: white pays nothing, orange one minus the distance, brown the remaining steps. The cross is the start. Right: a
# cut through Point2D's reward (logarithmic above 1).*
#
# A plain, and one small peak that takes about one hundredth of the half disc: the goal lies on the rim, so only about half of its disc is inside. No slope anywhere outside of the disc leads in.
#
# ### Exercise 2 · Finish or loiter?
#
# *Difficulty 2 of 3, 10 minutes.* The point stands just outside of the inner disc, at $d = 0.02$, and could finish with its next step, the one with the time index $t$. Or it could stay where it is and collect $1 - 0.02$ in each of the
# steps $t, \dots, 99$. By how much is loitering better, with later rewards discounted by $\gamma$ per step from $t$ on?
#
# **Predict first.** Does it ever pay to loiter, when returns are not discounted ($\gamma = 1$)? And with $\gamma = 0.95$?
#
# <details><summary>Hint 1: how many steps are there to loiter?</summary>
# t, t + 1, ... 99: that is 100 - t of them. The first is not discounted.
# </details>
#
# <details><summary>Hint 2: a sum of powers</summary>
# <code>sum(discount**k for k in range(100 - time))</code> works for every discount, 1 included.
# </details>


# %% tags=["exercise-loitering"]
def loitering_gain(time, discount):
    """Return what loitering from step ``time`` to 99 earns more than finishing in step ``time``."""
    ### BEGIN SOLUTION
    waited = sum(0.98 * discount**k for k in range(100 - time))
    finished = 100 - time - 1
    return waited - finished
    ### END SOLUTION


# %% tags=["loitering"]
if check.loitering_gain(loitering_gain):
    figure, axes = plt.subplots(figsize=(6.2, 3))
    for discount, line in ((1.0, "-"), (0.95, "--")):
        gains = np.array([loitering_gain(time, discount) for time in range(100)])
        axes.plot(gains, line, color="#333333", label=f"discount {discount:g}")
        pays = np.flatnonzero(gains > 1e-9)
        assert pays[0] == {1.0: 51, 0.95: 94}[discount] and pays[-1] == 99
        print(f"discount {discount:.2f}: loitering pays from step {pays[0]} on; ", end="")
        print(f"at t = 0 it loses {-gains[0]:.2f}, at t = 99 it wins {gains[99]:.2f}")
    axes.axhline(0, color="black", linewidth=0.8)
    axes.set(yscale="symlog", xlabel="step t", ylabel="loitering less finishing")
    axes.set_yticks([-100, -10, -1, 0, 1], ["-100", "-10", "-1", "0", "1"])
    axes.legend()
    plt.show()

# %% [markdown]
# *Figure 2. What loitering at the edge of the inner disc earns more than finishing, by the time index of the step; linear between -1 and 1, logarithmic beyond.*
#
# Early the jackpot is far ahead. Late it shrinks to nothing, and loitering wins: in the second half of the episode if returns are plain sums, in the last six steps with the paper's discount. A learner that gets to its goal only
# at the end of an episode is told to stay outside. An optimal demonstrator arrives after some twenty steps, so nothing here depends on it.
#
# ## 2 · The others
#
# **TwoWheeled Locomotion.** A robot with a heading $\theta$, a linear velocity $v \in [0, 0.22]$ and an angular velocity $\omega \in [-2.84, 2.84]$, in steps of $dT = 0.5$ seconds:
#
# $$x_{t+1} = x_t + v_t \cos(\theta_t)\, dT, \qquad y_{t+1} = y_t + v_t \sin(\theta_t)\, dT, \qquad \theta_{t+1} = \theta_t + \omega_t\, dT .$$
#
# It must *turn* before it can drive to the side. Rewards as for the point, with a disc of 0.5 and a box $|x - x_g|, |y - y_g| \le 0.2$ that pays the remaining
# steps; 24 training goals. Leaving the arena $|x|, |y| \le 2.5$ ends the episode.
#
# ### Exercise 3 · Drive
#
# *Difficulty 1 of 3, 5 minutes.* All robots at once: `state` is (robot, 3).
#
# <details><summary>Hint 1: taking the state apart</summary>
# <code>x, y, heading = state.unbind(-1)</code>, and <code>torch.stack([...], dim=-1)</code> puts it together again.
# </details>
#
# <details><summary>Hint 2: which heading drives?</summary>
# The one before the turn.
# </details>


# %% tags=["exercise-wheeled"]
def wheeled_step(state, v, omega, dt):
    """Return the next (x, y, heading), (robot, 3), from (robot, 3), (robot,), (robot,), seconds."""
    ### BEGIN SOLUTION
    x, y, heading = state.unbind(-1)
    ahead = v * dt
    place = [x + ahead * torch.cos(heading), y + ahead * torch.sin(heading)]
    return torch.stack([*place, heading + omega * dt], dim=-1)
    ### END SOLUTION


# %%
clock.at("the others")
if check.wheeled_step(wheeled_step):
    random = torch.Generator().manual_seed(1)
    states = torch.randn(1, 50, 3, generator=random)
    actions = torch.rand(1, 50, 2, generator=random) * 2 - 1
    v, omega = 0.22 * (actions[0, :, 0] + 1) / 2, 2.84 * actions[0, :, 1]
    theirs = wheeled.step(wheeled.training_tasks()[:1], states, actions, 0)
    assert torch.allclose(wheeled_step(states[0], v, omega, 0.5), theirs.states[0], atol=1e-5)
    print("Your robot equals emrld_lite.envs.TwoWheeled.")

# %% [markdown]
# **Changing dynamics.** The same robot, slower ($v \le 0.15$, $|\omega| \le 1.5$), one goal at $(2, 1)$ for all tasks, and a *residual angular velocity* $\omega_g$ that makes task $i$ what it is: a
# drift the robot does not see. The paper prints $\theta + \omega_g + \omega\, dT$; since $\omega_g$ is a velocity, we use $\theta + (\omega + \omega_g)\, dT$ (the environment `two_wheeled_literal_drift` has the printed one).
#
# **HalfCheetah Forward-Backward.** A planar body with six joints, simulated by MuJoCo; the task is a direction $d_g = \pm 1$. With control cost $c_t = 0.05\, \|a_t\|^2$ and $dT = 0.05$ seconds
#
# $$R_t = d_g\, \frac{x_{t+1} - x_t}{dT} - c_t \quad \text{if } |x_{t+1} - x_0| > 2, \qquad \text{otherwise } 0 .$$
#
# All four are ordinary Gymnasium environments, too, and draw themselves:

# %% tags=["gymnasium"]
pictures = {}
for name in FAMILIES:
    environment = gymnasium.make(GYMNASIUM_IDS[name], render_mode="rgb_array")
    environment.reset(seed=3)
    environment.action_space.seed(3)
    for _ in range(40):
        environment.step(environment.action_space.sample())
    pictures[name] = environment.render()
figure, panels = plt.subplots(1, 4, figsize=(12, 3.3))
for axes, (name, picture) in zip(panels, pictures.items(), strict=True):
    axes.imshow(picture)
    axes.set_axis_off()
    axes.set_title(name)
plt.show()

# %% [markdown]
# *Figure 3. The four environments after 40 random actions. The cheetah is MuJoCo's own picture where there is a GL library, a drawing of the same body where there is none.*
#
# A gait is a sequence of poses. These are the demonstrations of the two directions, at the same six moments:

# %% tags=["cheetah-strip"]
data = load_demonstrations("optimal", "half_cheetah")
cheetah = make("half_cheetah")
figure, rows = plt.subplots(2, 6, figsize=(12, 4.4))
tilts = {}
for panels, task in zip(rows, (0, 5), strict=True):
    for axes, step in zip(panels, range(30, 54, 4), strict=True):
        cheetah.draw(axes, data.tasks[task], data.states[task, 0, : step + 1])
        axes.set(title=f"{0.05 * step:.2f} s", xlabel="x (m)", ylim=(-0.2, 1.6))
        axes.set_yticks([])
        axes.set_aspect("equal")
    tilts[float(data.tasks[task])] = float(data.states[task, 0, :, 1].abs().max().rad2deg())
plt.show()
assert tilts[1.0] > 60 and tilts[-1.0] < 45
for direction, tilt in tilts.items():
    print(f"direction {direction:+.0f}: its body tilts by up to {tilt:.0f} degrees")

# %% [markdown]
# *Figure 4. Six moments of the optimal demonstrations, forward (top) and backward (bottom); the orange region is where the reward begins.*
#
# Backward it runs level. Forward it tips over its front leg until it nearly stands on its nose, falls back and goes on: fast, and not pretty. "Optimal" means here what it means in the paper, trained to the end, and no more.
#
# And the drift: nine tasks, the very same actions, nine ways.

# %%
drift = make("two_wheeled_drift")
tasks = drift.training_tasks()
states, ways = drift.reset(tasks, 1), []
for time in range(28):
    ways.append(states[:, 0])
    straight = torch.tensor([1.0, 0.0]).expand(9, 1, 2)  # full speed, no turn
    states = drift.step(tasks, states, straight, time).states
figure, axes = plt.subplots(figsize=(4.6, 3.4))
for task, way in enumerate(torch.stack(ways, dim=1)):
    label = f"{float(tasks[task]):+.1f} rad/s" if task % 4 == 0 else None
    axes.plot(way[:, 0], way[:, 1], color=plt.cm.viridis(task / 8), label=label)
axes.plot(2, 1, marker="*", color="black", markersize=10, linestyle="none")
axes.set(xlabel="x (length units)", ylabel="y (length units)", aspect="equal")
axes.legend(loc="lower right", bbox_to_anchor=(1.45, 0))
plt.show()

# %% [markdown]
# *Figure 5. Driving straight ahead under nine residual angular velocities; the star is the goal that all nine tasks share.*
#
# ## 3 · How rarely it pays
#
# An untrained Gaussian policy ($\sigma = 1$) acts in every training task. An episode counts if a single one of its steps is paid. A rate that is seen $k$ times in $n$ episodes is uncertain; we
# give **Wilson's interval**, which stays sensible for small $k$.
#
# **Predict first:** in which of the four environments is a random policy rewarded most often? In which least?

# %% tags=["how-rarely", "tolerance:rel=0.2", "tolerance:abs=0.05"]
clock.at("how rarely it pays")
rates, intervals = {}, {}
for name in FAMILIES:
    environment = make(name)
    tasks = environment.training_tasks()
    untrained = policy.initialise(environment.state_dim, environment.action_dim, seed=0)
    each = 40 if name == "half_cheetah" else 2400 // len(tasks)
    rollout = collect(environment, tasks, untrained, each, torch.Generator().manual_seed(0))
    paid, count = int((rollout.rewards != 0).any(-1).sum()), rollout.mask.shape[:2].numel()
    rates[name], intervals[name] = paid / count, wilson_interval(paid, count)
    low, high = (100 * end for end in intervals[name])
    print(f"{name:18}{100 * rates[name]:6.2f} % of {count} episodes [{low:.2f}, {high:.2f}]")
assert intervals["point2d"][1] < 0.01
assert intervals["two_wheeled"][1] < 0.05 and intervals["two_wheeled_drift"][1] < 0.05
assert rates["half_cheetah"] == max(rates.values())

# %%
figure, axes = plt.subplots(figsize=(7, 2.6))
for place, name in enumerate(rates):
    low, high = intervals[name]
    axes.plot([100 * low, 100 * high], [place, place], color="black", linewidth=2)
    axes.plot(100 * rates[name], place, marker="o", color="#D55E00", linestyle="none")
axes.set_yticks(range(len(rates)), rates)
axes.set(xscale="log", xlabel="episodes with any reward (%)", ylim=(3.5, -0.5))
plt.show()

# %% [markdown]
# *Figure 6. How often an untrained policy sees any reward: rate (dot) and 95 % interval (line), over all training tasks, logarithmic scale.*
#
# The cheetah is the least sparse: a random wriggle sometimes carries it two metres, often enough the wrong way, where it is paid *negatively* for going on. For the point the rate is
# around one in a thousand: its steps point in random directions and cancel. The wheeled robot keeps its heading from step to step, gets farther, and has a larger disc to meet.
#
# ### Exercise 4 · How long must one wait?
#
# *Difficulty 1 of 3, 5 minutes.* With probability `rate` an episode is rewarded. How many episodes must be collected so that *at least one* is rewarded with probability `confidence`?
#
# <details><summary>Hint 1: the other way round</summary>
# The chance that n episodes in a row see nothing is (1 − rate)<sup>n</sup>.
# </details>
#
# <details><summary>Hint 2: solving for n</summary>
# Take logarithms (<code>math.log</code>); both are negative. Round up with <code>math.ceil</code>.
# </details>


# %% tags=["exercise-waiting"]
def episodes_needed(rate, confidence):
    """Return the smallest whole number of episodes."""
    ### BEGIN SOLUTION
    return math.ceil(math.log(1 - confidence) / math.log(1 - rate))
    ### END SOLUTION


# %% tags=["waiting", "tolerance:rel=0.6"]
if check.episodes_needed(episodes_needed):
    batch = 20  # episodes per task and iteration, Table 1
    for name in ("point2d", "two_wheeled"):
        needed = episodes_needed(rates[name], 0.95)
        assert needed > {"point2d": 40, "two_wheeled": 5}[name] * batch
        print(f"{name:12} {needed / batch:5.1f} batches of {batch} episodes")

# %% [markdown]
# At the rate seen here, a task of Point2D waits for about 3,600 episodes: 180 iterations, in each of which it learns nothing.
#
# **Turn it yourself.** The sliders move the goal along the semicircle and change the radius of the disc that pays. 500 walks of an untrained policy stay the same.

# %% tags=["widget-sparsity", "nbval-ignore-output"]
walks = sparsity.random_walks()
sparsity.sparsity_sliders(walks)

# %%
sparsity.sparsity_picture(walks, angle=60, radius=0.2)

# %% [markdown]
# *Figure 7. The sliders' default as a still picture: 500 untrained walks (grey), those that meet the disc of radius 0.2 (orange).*
#
# ## 4 · What the gradient is then
#
# Notebook 01: the gradient of $\mathcal L^{\mathrm{RL}}$ is minus the mean of $\hat A_t\, \nabla_\theta \log \pi_\theta(a_t \mid s_t)$. In a task in which **no** episode of the batch is rewarded, all returns are 0. So the fitted baseline
# is 0, every advantage $\hat A_t$ is 0, and the gradient is exactly 0. Not small: zero.

# %% tags=["zero-gradient"]
clock.at("what the gradient is then")
tasks = wheeled.training_tasks()
start = policy.per_task(policy.initialise(3, 2, seed=0), len(tasks))


def task_gradients(seed, bonus=0.0, normalised=True, world=wheeled, start=start):
    """Return each task's policy gradient (task, parameter), and whether it saw a reward, (task,)."""
    draws = torch.Generator().manual_seed(seed)
    rollout = collect(world, world.training_tasks(), start, 20, draws)
    seen = (rollout.rewards > 0).any(-1).any(-1)
    rollout = rollout._replace(rewards=rollout.rewards + bonus * rollout.mask)
    rollout = Score(normalise=normalised)(rollout)
    leaves = {name: value.clone().requires_grad_() for name, value in start.items()}
    loss = losses.rl_loss(leaves, rollout).sum()
    parts = torch.autograd.grad(loss, list(leaves.values()))
    return torch.cat([part.flatten(1) for part in parts], dim=1), seen


gradients, seen = task_gradients(seed=0)
assert (gradients[~seen] == 0).all() and (gradients[seen].norm(dim=1) > 0).all()
assert (~seen).sum() > 4
lengths = gradients.norm(dim=1)
print(
    f"{int((~seen).sum())} tasks saw no reward; longest gradient: {float(lengths[~seen].max()):g}"
)
print(f"{int(seen.sum())} tasks saw one; shortest gradient: {float(lengths[seen].min()):.3f}")

# %% [markdown]
# ### And with a reward of $10^{-5}$ everywhere?
#
# The released code pays $10^{-5}$ where the paper pays 0. Who would mind? But advantages are **normalised**: each task's are shifted and scaled to mean 0 and standard deviation 1.
#
# **Predict first:** in a task without any real reward, how long is the gradient now, compared with a task that *was* rewarded?

# %% tags=["constant-reward", "tolerance:0.3"]
tiny, _ = task_gradients(seed=0, bonus=1e-5)
plain, _ = task_gradients(seed=0, bonus=1e-5, normalised=False)
lengths = {
    "reward 0": gradients.norm(dim=1),
    "reward 1e-5, normalised": tiny.norm(dim=1),
    "reward 1e-5, as it is": plain.norm(dim=1),
}
ratio = lengths["reward 1e-5, normalised"][~seen].mean() / lengths["reward 0"][seen].mean()
assert ratio > 0.5
assert lengths["reward 1e-5, as it is"][~seen].max() < 1e-4
for name, values in lengths.items():
    without, rewarded = float(values[~seen].mean()), float(values[seen].mean())
    print(f"{name:23} tasks without a reward {without:.1e}, with one {rewarded:.1e}")
print(f"reward 1e-5, normalised: {float(ratio):.2f} times as long as from a real reward")

# %%
figure, axes = plt.subplots(figsize=(7.4, 3.2))
looks = (("o", "#0072B2"), ("s", "#D55E00"), ("^", "#777777"))
order = seen.int().argsort(stable=True)  # tasks without a reward first
for (name, values), (marker, colour) in zip(lengths.items(), looks, strict=True):
    axes.plot(values[order], marker=marker, color=colour, linestyle="none", label=name)
axes.axvspan(-0.5, int((~seen).sum()) - 0.5, color="#EEEEEE", zorder=0)
axes.set_yscale("symlog", linthresh=1e-7)
axes.set(
    xlabel="training task (shaded: saw no reward)", ylabel="length of the gradient", ylim=(-2e-8, 3)
)
axes.set_yticks([0, 1e-6, 1e-4, 1e-2, 1], ["0", "1e-6", "1e-4", "0.01", "1"])
axes.legend(loc="center right")
plt.show()

# %% [markdown]
# *Figure 8. Length of each task's policy gradient on TwoWheeled, from the same 20 episodes, with three ways to treat steps that earn nothing. Where a reward was seen, circles lie under squares.*
#
# The baseline cannot fit a constant reward perfectly: the return to come falls from $10^{-5}/(1-\gamma)$ to $10^{-5}$ along the episode, and a cubic in $t$ follows that only nearly. What is left is a millionth of
# nothing; dividing by its standard deviation blows it up to size 1.
#
# **Where does such a gradient point?** What is left depends on the time $t$ (and a little on the state), not on the action, and the expected score is zero (notebook 01). So its expectation is zero: it points nowhere. A single batch does not know that.
# Let us see whether the gradients of two batches agree: ten batches of the same untrained policy on Point2D, once with $10^{-5}$ in tasks that saw no reward, once with the dense reward $-d$.

# %% tags=["cosines", "tolerance:abs=0.03"]
tasks = point.training_tasks()
same = policy.per_task(policy.initialise(2, 2, seed=0), len(tasks))
cosines = {}
for name, reward, bonus in (("reward 1e-5", "sparse", 1e-5), ("dense reward", "dense", 0.0)):
    batches = [
        task_gradients(seed, bonus, world=make("point2d", reward=reward), start=same)
        for seed in range(10)
    ]
    pairs = [(one, other) for i, one in enumerate(batches) for other in batches[:i]]
    found = []
    for (one, seen_one), (other, seen_other) in pairs:
        usable = ~(seen_one | seen_other)  # a dense reward is never above 0
        found.append(torch.cosine_similarity(one, other, dim=1)[usable])
    cosines[name] = torch.cat(found)
    mean, spread = cosines[name].mean(), cosines[name].std()
    print(f"{name:12} mean cosine {mean:.2f}, deviation {spread:.2f}, of {len(pairs)} pairs")
assert abs(cosines["reward 1e-5"].mean()) < 0.1
assert cosines["dense reward"].mean() > 0.9

# %%
figure, axes = plt.subplots(figsize=(6.2, 2.8))
looks = {"reward 1e-5": ("#D55E00", "//"), "dense reward": ("#0072B2", "")}
bins = np.linspace(-1, 1, 41)
for name, (colour, hatch) in looks.items():
    weights = np.full(len(cosines[name]), 100 / len(cosines[name]))
    axes.hist(
        cosines[name], bins, weights=weights, color=colour, hatch=hatch, alpha=0.7, label=name
    )
axes.set(xlabel="cosine between the gradients of two batches", ylabel="pairs (%)")
axes.legend(loc="upper left")
plt.show()

# %% [markdown]
# *Figure 9. How far the policy gradients of two batches of the same task agree: with a constant reward of $10^{-5}$ in tasks without a reward, and with a dense reward.*
#
# With the dense reward all batches say the same. With the constant one they agree as little as random directions: the mean is zero, as derived. The policy takes steps as long as those towards a goal, and takes them at random. In this workbook the reward elsewhere is 0, as the
# paper writes, and advantages whose spread is zero stay zero.
#
# ## 5 · Dense and sparse, live
#
# Is the environment perhaps too hard? The same learner, TRPO with the goal in its input (notebook 03), once with the **dense** reward $-d$, once with the **sparse** one: 16 iterations of 192 episodes each on Point2D.

# %% tags=["dense-and-sparse"]
clock.at("dense and sparse, live")
success = {}
for reward in ("dense", "sparse"):
    config = ExpertConfig(env="point2d", reward=reward, iterations=16)
    success[reward] = [100 * iterate.success for iterate in train_expert(config)]
figure, axes = plt.subplots(figsize=(6, 3))
axes.plot(success["dense"], marker="o", markevery=4, color="#0072B2", label="dense reward")
axes.plot(
    success["sparse"],
    marker="^",
    markevery=4,
    linestyle=":",
    color="#D55E00",
    label="sparse reward",
)
axes.set(xlabel="TRPO iteration", ylabel="episodes that reach the goal (%)", ylim=(-3, 103))
axes.legend(loc="center right")
plt.show()

# %% tags=["dense-learns", "statistical", "tolerance:abs=20"]
assert success["dense"][-1] > 50
assert success["sparse"][-1] < 15
for reward, share in success.items():
    print(f"{reward:6} reward: {share[-1]:5.1f} % of the goals reached in iteration 16")

# %% [markdown]
# *Figure 10. Share of episodes that reach their goal while a goal-conditioned policy learns from the dense and from the sparse reward, as measured on the machine that ran this notebook.*
#
# The task is easy. It is the *reward* that is hard. (Not hopeless: one policy that is told the goal can pool the lucky episodes of all goals. After 30 iterations the sparse learner reaches between 1 % and 50 % of them, depending on the seed and the processor, and on TwoWheeled, where luck is
# twenty times as frequent, it manages sooner: try `iterations=40` or `env="two_wheeled"`.) A dense reward, though, needs somebody who can measure the distance to the goal at every step; a demonstration needs somebody who has been there once.
#
# ## Where paper and code differ
#
# | point | paper | released code | this workbook |
# |---|---|---|---|
# | Point2D's $y_{t+1}$ | $x_t + dy_t$ | $y_t + dy_t$ | $y_t + dy_t$ |
# | length of a point's step | at most 0.1 | always 0.1 | at most; `step_rule="exact"` |
# | TwoWheeled near the goal | $1 - d$ | $2 - d$ | $1 - d$ |
# | reward elsewhere | 0 | $10^{-5}$ | 0 |
# | steps per episode | 100 | 101 | 100 |
# | the arena | "square box of side 2.5", which shuts the goals out | $\lvert x \rvert, \lvert y \rvert \le 2.5$ | the code's |
# | TwoWheeled's state | $\mathbb R^2$ | $x, y$, heading | $x, y$, heading, not wrapped |
# | drift | $\theta + \omega_g + \omega\, dT$ (units clash) | not released | $\theta + (\omega + \omega_g)\, dT$; as printed: `two_wheeled_literal_drift` |
# | drifts of the nine tasks | not said; $-0.65$ at test time | not released | $-0.8$ to $0.8$, evenly |
# | cheetah's observation | $\mathbb R^{20}$ | joint positions but $x$, velocities, torso | the same |
# | cheetah paid for $\lvert x - x_0 \rvert > 2$ | "in the correct direction" in words, either way in the formula | not compared | either way |
# | how a cheetah starts | not said | not compared | at rest, always the same |
#
# ## What was shown
#
# - The four environments, two of them written by you and equal to the package's.
# - An untrained point is paid in fewer than one episode of a hundred; most tasks of a batch see no reward.
# - Arriving early pays; arriving late does not, and then it would pay to loiter.
# - Where no reward is seen, the policy gradient is exactly zero; a constant $10^{-5}$ with normalised advantages makes it long, and two batches disagree on where it points.
# - With a dense reward the same learner reaches most goals after sixteen iterations, with the sparse one hardly any.
#
# **Next** notebook 03 makes the demonstrations that fill the gap.
#
# **References** Finn, Abbeel and Levine (2017), *MAML*; Gupta et al. (2018), *Meta-reinforcement learning of structured exploration strategies*; Todorov, Erez and Tassa (2012), *MuJoCo*; Wilson (1927); Rengarajan et al. (2022), the paper.
