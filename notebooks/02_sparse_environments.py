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
# Put a point on a plane, hide a goal two units away, and pay the point only once it is next to the goal. How often is an
# untrained policy paid, and what is left of its policy gradient as long as it is not? You write the first of the paper's
# environments yourself, let your version answer, and then measure all four.
#
# **You will be able to**
#
# - write Point2D Navigation from its description and read the landscape of its reward,
# - say when it would pay to loiter next to a goal, and mend a reward for which it does,
# - drive the wheeled robot to any goal, and say what your driver knows that a learner does not,
# - measure how often an untrained policy is rewarded, with an interval, and how long one waits for it,
# - say what the policy gradient is in a task without a reward, and prove it.
#
# **You need** notebook 01 (policy gradient, baseline, advantages). **Time** planned: 85 minutes for sections 1 to 6, of which the machine
# computes one or two; 25 more for the further reading. **Paper** Section 4.1 and Appendix B (Environments) of Rengarajan et al., NeurIPS 2022.

# %%
import math

import gymnasium
import matplotlib.pyplot as plt
import numpy as np
import torch
from matplotlib.colors import BoundaryNorm, ListedColormap

from emrld_lite import losses, policy
from emrld_lite.advantage import Score, discounted_returns, linear_baseline
from emrld_lite.classroom import checks as check
from emrld_lite.classroom.clock import Clock
from emrld_lite.classroom.predict import Guesses
from emrld_lite.classroom.sketches.starvation import reward_chain
from emrld_lite.classroom.widgets import sparsity
from emrld_lite.demonstrations import load_demonstrations
from emrld_lite.demonstrators.expert import ExpertConfig, train_expert
from emrld_lite.envs import GYMNASIUM_IDS, half_cheetah, make, point2d, two_wheeled
from emrld_lite.experiments import plotting
from emrld_lite.experiments.intervals import wilson_interval
from emrld_lite.rollout import collect

# %%
plotting.use_style()
FAMILIES = ("point2d", "two_wheeled", "half_cheetah", "two_wheeled_drift")
torch.set_num_threads(1)  # leaves the other cores to you
guess = Guesses()
clock = Clock(
    {
        "a point and a goal": 20,
        "finish or loiter": 15,
        "the others": 20,
        "how rarely it pays": 15,
        "what the gradient is then": 10,
        "dense and sparse, live": 5,
    },
    further={"a constant tiny reward": 20, "how the cheetah runs": 5},
)

# %% [markdown]
# ## 1 · A point and a goal
#
# **Point2D Navigation.** The state is a position $(x, y)$, the action a displacement $(dx, dy)$ of length at most 0.1:
#
# $$x_{t+1} = x_t + dx_t, \qquad y_{t+1} = y_t + dy_t, \qquad dx_t^2 + dy_t^2 \le 0.1^2 .$$
#
# An episode starts at the origin and lasts 100 steps at most, with the time indices $t = 0, \dots, 99$. The goal $(x_g, y_g)$ is the task, and the
# policy does not see it. The paper's reward, in words:
#
# - A step that ends within 0.02 of the goal has *arrived*. It is paid the number of steps that are left after it (99 where it is the first step, 0 where it is the last), and the episode ends.
# - A step that ends within 0.2 of the goal, but not within 0.02, is paid one minus its distance to the goal.
# - Any other step is paid nothing.
#
# ### Exercise 1 · Write it
#
# *Difficulty 2 of 3, planned for 10 minutes.* One step for one point. A move that is asked for may be too long; then the point goes 0.1 in its direction.
#
# <details><summary>Hint 1: a move that is too long</summary>
# Keep its direction and change its length. A shorter move stays as it is, and a move of length zero is a shorter move, too.
# </details>
#
# <details><summary>Hint 2: which distance, which case first?</summary>
# The distance after the step. Very close to the goal two of the conditions hold; think about which one the words above let win.
# </details>


# %% tags=["exercise-point"]
def point_step(position, move, goal, time):
    """Return (new position (2,), reward, whether it has arrived) from tensors (2,) and the index t."""
    ### BEGIN SOLUTION
    length = float(move.norm())
    moved = position + move * (0.1 / length if length > 0.1 else 1.0)
    distance = float((moved - goal).norm())
    if distance <= 0.02:
        return moved, 100.0 - time - 1, True
    return moved, (1.0 - distance if distance <= 0.2 else 0.0), False
    ### END SOLUTION


# %%
checked = check.point_step(point_step)
clock.at("a point and a goal")
point = make("point2d")
goals = point.training_tasks()  # (task, 2), twelve on a semicircle of radius 2


def package_step(position, move, goal, time):
    """Ask the package's Point2D for one step of one point; its actions count in units of 0.1."""
    moved = point.step(goal[None], position[None, None], 10 * move[None, None], time)
    return moved.states[0, 0], float(moved.rewards), bool(moved.terminated)


step = point_step if checked else package_step  # until yours is right, the package's

# %% [markdown]
# <details><summary>After your answer: the formula as the paper prints it</summary>
#
# With $d$ the distance to the goal after the step,
#
# $$R_t = \begin{cases} 100 - t - 1 & d \le 0.02 \quad \text{(and the episode ends)} \\ 1 - d & 0.02 < d \le 0.2 \\ 0 & \text{otherwise.} \end{cases}$$
#
# For the position the paper prints $y_{t+1} = x_t + dy_t$, a slip of the pen.
#
# </details>
#
# The first kind of step pays out the steps that are left, so that arriving early pays.
#
# **The landscape of the reward.** A policy looks for the goal within the upper half disc of radius 2; its rim holds all goals. *Predict first:* which share of that half disc pays anything at all, for one goal?

# %%
guess.ask("share", "share of the half disc that pays, %")


# %% [markdown]
# Your step paints the answer: the reward of standing still at every place of a grid, at $t = 0$.


# %% tags=["reward-landscape"]
def painted(goal, x, y):
    """Return the reward of standing still at every place of a grid, (len(y), len(x))."""
    places = torch.cartesian_prod(y, x).flip(-1)  # (place, 2)
    rewards = [float(step(place, torch.zeros(2), goal, 0)[1]) for place in places]
    return torch.tensor(rewards).reshape(len(y), len(x))


goal = goals[4]
x, y = torch.arange(-2.2, 2.2, 0.04), torch.arange(-0.2, 2.4, 0.04)
near_x, near_y = (goal[axis] + torch.linspace(-0.25, 0.25, 75) for axis in (0, 1))
landscape, near = painted(goal, x, y), painted(goal, near_x, near_y)
line = goal[0] + torch.linspace(-0.3, 0.3, 301)
cut = painted(goal, line, goal[1:])[0]
inside = (x**2 + y[:, None] ** 2 <= 4) & (y[:, None] >= 0)  # the half disc
share = float((landscape[inside] > 0).double().mean())

# %%
figure, panels = plt.subplots(1, 3, figsize=(12, 3.3), width_ratios=(1.5, 1, 1.1))
shades = ListedColormap(["#FFFFFF", "#F8D9A0", "#E69F00", "#7A5C00"])
levels = BoundaryNorm([-0.01, 0.001, 0.9, 1.1, 100], 4)
for axes, across, up, rewards in ((panels[0], x, y, landscape), (panels[1], near_x, near_y, near)):
    axes.pcolormesh(across, up, rewards, cmap=shades, norm=levels)
    axes.set(xlabel="x (length units)", ylabel="y (length units)", aspect="equal")
arc = np.linspace(0, np.pi, 100)
panels[0].plot(2 * np.cos(arc), 2 * np.sin(arc), color="grey", linewidth=0.8)
panels[0].plot(0, 0, marker="x", color="black", markersize=7)
panels[0].set_title("the plane")
panels[1].set_title("around the goal")
panels[2].plot(line - goal[0], cut, color="#7A5C00")
panels[2].set(yscale="symlog", xlabel="x from the goal (length units)", ylabel="reward at t = 0")
panels[2].set_yticks([0, 1, 10, 100], ["0", "1", "10", "100"])
panels[2].set_title("a cut through the goal")
plt.show()

# %% [markdown]
# *Figure 1. The reward of standing still, painted by one call of your step per place, for one goal: white pays nothing, the two light rings one minus the distance (the inner one more than 0.9), dark the remaining steps. The cross is the start, the arc holds all goals. Right: the same along a line through the goal, logarithmic above 1.*

# %% tags=["reveal", "tolerance:abs=0.1"]
assert 0.007 < share < 0.013
guess.reveal("share", f"{100 * share:.1f} % of the places of the grid within the half disc pay.")

# %% [markdown] tags=["reveal"]
# One hundredth: a plain, and one small peak. The goal lies on the rim, so only about half of its disc of radius 0.2 is inside, and $\tfrac12 \cdot 0.2^2 / (\tfrac12 \cdot 2^2) = 1\,\%$. The arrival disc
# is a hundred times smaller still. Outside of the disc no slope leads in: one step to the left or to the right, the reward is the same zero.

# %% [markdown]
# **A policy that knows nothing.** An untrained policy draws its action from a Gaussian around nearly zero with $\sigma = 1$, in units of 0.1; each component is clipped to $[-1, 1]$, and your
# step shortens what is still too long. It acts a hundred times and could get as far as $100 \cdot 0.1 = 10$ units. *Predict first:* how far is it from the start after 100 steps, typically?

# %%
guess.ask("distance", "typical distance after 100 steps, length units")


# %%
def episode(goal, actions):
    """Return the places (time + 1, 2) and the rewards (time,) of one episode, by your step."""
    places, rewards = [torch.zeros(2)], []
    for time, action in enumerate(actions):
        move = 0.1 * action.clamp(-1, 1)  # a policy acts in units of 0.1
        moved, reward, done = step(places[-1], move, goal, time)
        places.append(torch.as_tensor(moved, dtype=torch.float32))
        rewards.append(float(reward))
        if done:
            break
    return torch.stack(places), torch.tensor(rewards)


random = torch.Generator().manual_seed(0)
walks = [episode(goal, torch.randn(100, 2, generator=random)) for _ in range(5) for goal in goals]
far = torch.stack([places.norm(dim=-1) for places, _ in walks])  # (walk, time + 1)
paid = sum(bool((rewards != 0).any()) for _, rewards in walks)
print(f"{paid} of {len(walks)} episodes were paid")

# %%
figure, (plane, away) = plt.subplots(1, 2, figsize=(10, 3.5))
point.draw_tasks(plane, goals)
for places, _ in walks[:12]:
    plane.plot(places[:, 0], places[:, 1], linewidth=0.9)
away.plot(far.T, color="#BBBBBB", linewidth=0.6)
away.plot(far.square().mean(0).sqrt(), color="#0072B2", label="root mean square")
away.axhline(1.8, color="#E69F00", linestyle="--", label="the nearest place that pays")
away.set(xlabel="steps taken", ylabel="distance from the start (length units)")
away.legend(loc="upper left")
plt.show()

# %% [markdown]
# *Figure 2. Left: twelve episodes of your Point2D under an untrained policy, one per goal; the discs pay. Right: the distance from the start over the episode, sixty episodes (thin) and their root mean square (thick); the dashed line is the nearest that a disc comes to the start.*

# %% tags=["reveal", "tolerance:rel=0.1"]
typical = far.square().mean(0).sqrt()
ratio = typical[100] / typical[25]
assert 0.6 < typical[100] < 1.2 and 1.5 < ratio < 2.6
guess.reveal("distance", f"{typical[100]:.1f} length units (root mean square of the sixty).")
print(f"four times as many steps, from 25 to 100, bring it {ratio:.1f} times as far")

# %% [markdown] tags=["reveal"]
# Less than a tenth of what is possible. Steps in independent directions cancel: their *squared* lengths add up, so the distance grows with the square root of the time, and four times as many steps lead only about twice as far. A distance
# of 1.8 lies at about twice the typical one, and even there the walk must hit the one disc that pays.

# %% [markdown]
# ## 2 · Finish or loiter?
#
# The point stands just outside of the inner disc, at $d = 0.02$, and could finish with its next step, the one with the time index $t$. Or it could stay where it is and collect $1 - 0.02$ in each of the
# steps $t, \dots, 99$.
#
# *Predict first:* from which step $t$ on does it pay to loiter, if returns are plain sums ($\gamma = 1$)? And if later rewards are discounted by $\gamma = 0.95$ per step, as in the paper?

# %%
guess.ask("loiter", "loitering pays from step ..., with gamma 1; with 0.95")

# %% [markdown]
# ### Exercise 2 · What loitering gains
#
# *Difficulty 2 of 3, planned for 8 minutes.* By how much is loitering until step 99 better than finishing in step $t$, with later rewards discounted by $\gamma$ per step from $t$ on?
#
# <details><summary>Hint 1: how many steps are there to loiter?</summary>
# From t to 99, both included. Try it with t = 99: how many are they then?
# </details>
#
# <details><summary>Hint 2: what is discounted?</summary>
# The reward of step t counts in full, whether it is the jackpot or the first 0.98. Each later one counts by one more factor.
# </details>
#
# <details><summary>Hint 3: a sum or a formula?</summary>
# A sum in Python works for every discount. A closed formula divides by 1 − γ, so it needs another case for γ = 1.
# </details>


# %% tags=["exercise-loitering"]
def loitering_gain(time, discount):
    """Return what loitering from step ``time`` to 99 earns more than finishing in step ``time``."""
    ### BEGIN SOLUTION
    waited = sum(0.98 * discount**k for k in range(100 - time))
    finished = 100 - time - 1
    return waited - finished
    ### END SOLUTION


# %%
checked = check.loitering_gain(loitering_gain)
clock.at("finish or loiter")

# %% [markdown]
# Your formula is a claim about your environment, so we let the point do both, one after the other, by your step from exercise 1.


# %% tags=["loitering-measured"]
def rewards_from(time, move):
    """Return the rewards of a point at the edge that makes the same move until its episode ends."""
    place, rewards, done = goal + torch.tensor([0.0201, 0.0]), [], False
    while time < 100 and not done:
        moved, reward, done = step(place, move, goal, time)
        place, time = torch.as_tensor(moved, dtype=torch.float32), time + 1
        rewards.append(float(reward))
    return torch.tensor(rewards)


def measured_gain(time, discount):
    """Return by how much the episode that stays has the larger return than the one that steps in."""
    stays, steps_in = torch.zeros(2), torch.tensor([-0.0201, 0.0])
    returns = (discounted_returns(rewards_from(time, m), discount)[0] for m in (stays, steps_in))
    return float(next(returns) - next(returns))


times = range(0, 100, 3)
gains = {g: np.array([measured_gain(time, g) for time in times]) for g in (1.0, 0.95)}
if checked:
    formula = {g: np.array([float(loitering_gain(time, g)) for time in times]) for g in gains}
    apart = max(np.abs(formula[discount] - gains[discount]).max() for discount in gains)
    print(f"formula and episodes differ by at most {apart:.3f} (the point stands at 0.0201)")

# %% tags=["loitering"]
figure, axes = plt.subplots(figsize=(6.4, 3.2))
looks = {1.0: ("-", "o", "#0072B2"), 0.95: ("--", "s", "#D55E00")}
for discount, (line, marker, colour) in looks.items():
    name = f"discount {discount:g}"
    axes.plot(times, gains[discount], marker, color=colour, markersize=4, label=name)
    if checked:
        axes.plot(times, formula[discount], line, color=colour, linewidth=1)
axes.axhline(0, color="black", linewidth=0.8)
axes.set(yscale="symlog", xlabel="step t", ylabel="loitering less finishing", ylim=(-110, 2))
axes.set_yticks([-100, -10, -1, 0, 1], ["-100", "-10", "-1", "0", "1"])
axes.legend(loc="lower right")
plt.show()

# %% [markdown]
# *Figure 3. What loitering at the edge of the inner disc earns more than finishing, by the time index of the step: episodes of your Point2D (marks) and your formula (lines). Linear between -1 and 1, logarithmic beyond; above the black line, loitering pays.*

# %% tags=["reveal"]
first = {}
for discount in (1.0, 0.95):
    better = [time for time in range(100) if measured_gain(time, discount) > 0]
    first[discount] = better[0]
    assert better == list(range(better[0], 100))  # from there to the end
assert 50 <= first[1.0] <= 52 and first[0.95] == 94
guess.reveal("loiter", f"from step {first[1.0]} on, and with 0.95 from step {first[0.95]} on.")

# %% [markdown] tags=["reveal"]
# Early the jackpot is far ahead: at $t = 0$ it is worth 99, and with a discount of 0.95 all the waiting is worth less than 20. Late the jackpot shrinks to nothing, and loitering wins: in the second half of the episode if returns are plain sums, in the last six steps with
# the paper's discount. A learner that gets to its goal only at the end of an episode is told to stay outside. An optimal demonstrator arrives after some twenty steps, so nothing in this workbook depends on it.

# %% [markdown]
# **Bonus: mend the reward.** *Difficulty 3 of 3, pen and paper.* Somebody wants a reward for which it never pays to loiter, whatever the step and the discount. What is the smallest whole number that must be added to the jackpot? Show it for the loiterer that stays
# to the end, and for the one that loiters first and finishes later.
#
# <details><summary>Hint: the worst discount</summary>
# Waiting is worth most when nothing is discounted. Compare the two sums for γ = 1, then argue that every smaller γ makes waiting worth less.
# </details>
#
# <details><summary>Solution</summary>
#
# Add one, and pay $100 - t$ in place of $100 - t - 1$: count the arriving step among those that are paid out. Without a discount, staying to the end earns $0.98\,(100 - t) < 100 - t$ for every $t \le 99$. Loitering for $k$ steps and finishing
# then earns $0.98\,k + (100 - t - k) = 100 - t - 0.02\,k$, which is less, too. A discount below 1 shrinks every term of the waiting but the first, and leaves the immediate jackpot as it is.
#
# With the paper's jackpot, staying to the end pays if $0.98\,(100 - t) > 99 - t$, that is $0.02\,t > 1$, $t > 50$. It is the "− 1" alone that makes it pay.
#
# </details>

# %% [markdown]
# ## 3 · The others
#
# **TwoWheeled Locomotion.** A robot with a heading $\theta$, a linear velocity $v \in [0, 0.22]$ and an angular velocity $\omega \in [-2.84, 2.84]$, in steps of $dT = 0.5$ seconds:
#
# $$x_{t+1} = x_t + v_t \cos(\theta_t)\, dT, \qquad y_{t+1} = y_t + v_t \sin(\theta_t)\, dT, \qquad \theta_{t+1} = \theta_t + \omega_t\, dT .$$
#
# It must *turn* before it can drive to the side, and its heading is never wrapped: after three turns to the left it stands at $6\pi$. Rewards as for the point, with a disc of 0.5 and a box $|x - x_g|, |y - y_g| \le 0.2$ that pays the remaining
# steps; 24 training goals. Leaving the arena $|x|, |y| \le 2.5$ ends the episode.
#
# **Changing dynamics.** The same robot, slower ($v \le 0.15$, $|\omega| \le 1.5$), one goal at $(2, 1)$ for all tasks, a box of 0.1, and a *residual angular velocity* $\omega_g$ that makes task $i$ what it is: a
# drift that the robot does not see. The paper prints $\theta + \omega_g + \omega\, dT$; since $\omega_g$ is a velocity, we use $\theta + (\omega + \omega_g)\, dT$ (the environment `two_wheeled_literal_drift` has the printed one).
#
# **HalfCheetah Forward-Backward.** A planar body with six joints, simulated by MuJoCo; the task is a direction $d_g = \pm 1$. With $x_0$ the place of its start, control cost $c_t = 0.05\, \|a_t\|^2$ and $dT = 0.05$ seconds
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
# *Figure 4. The four environments after 40 random actions: the orange disc pays, and the box in it, where there is one, ends the episode. The cheetah is MuJoCo's own picture where there is a GL library, a drawing of the same body where there is none.*
#
# And this is what each of them pays on the straight way from the start:

# %% tags=["reward-shapes"]
place = torch.linspace(0, 3, 1501)  # after the step
along = torch.tensor([[1.0, 0, 0], [2 / math.sqrt(5), 1 / math.sqrt(5), 0]])  # to either goal
ends, boxes = torch.tensor([[2.0, 0], [2, 1]]), (0.2, 0.1)
robots = [
    two_wheeled.sparse_reward(place[:, None] * way, end, 0, box)[0]
    for way, end, box in zip(along, ends, boxes, strict=True)
]
run = half_cheetah.run_reward(place - 0.05, place, 1, 0, 0.05) * (place > 2)  # at 1 m/s
shapes = (point2d.sparse_reward((place - 2).abs(), 0), robots[0], run, robots[1])
figure, panels = plt.subplots(1, 4, figsize=(12, 2.7), sharey=True)
for axes, name, rewards in zip(panels, FAMILIES, shapes, strict=True):
    axes.fill_between(place, rewards, facecolor="#F8D9A0", edgecolor="#C27C00")
    unit = "m" if name == "half_cheetah" else "length units"
    axes.set(title=name, yscale="symlog", xlabel=f"from the start ({unit})", ylim=(0, 150))
panels[0].set_yticks([0, 1, 10, 100], ["0", "1", "10", "100"])
panels[0].set_ylabel("reward at t = 0")
plt.show()

# %% [markdown]
# *Figure 5. The reward of a step that ends so far along the straight way from the start to the goal, logarithmic above 1; the cheetah is sent forward and runs at 1 m/s without effort. Three peaks behind a plain, and one plain that ends in a step.*
#
# ### Exercise 3 · Drive
#
# *Difficulty 3 of 3, planned for 12 minutes.* Be the demonstrator: write a driver that is *told the goal* and reaches it from any place and heading, within 30 steps from two units away. It looks at one state and returns the two velocities, within their limits. There are
# many right answers.
#
# <details><summary>Hint 1: what must the driver know?</summary>
# How far the goal lies to the left or right of the robot's nose: the direction from the robot to the goal (<code>math.atan2</code> or <code>torch.atan2</code>, y first) less the heading.
# </details>
#
# <details><summary>Hint 2: the long way round</summary>
# With a heading of 6π and a goal straight ahead the difference of the two angles is −6π, although nothing needs to be turned. <code>math.remainder</code> brings any angle into [−π, π].
# </details>
#
# <details><summary>Hint 3: how fast?</summary>
# A turn lasts half a second, so an angle is turned in one step by a velocity of twice the angle, where the limit allows it. Driving while the nose points elsewhere leads away.
# </details>


# %% tags=["exercise-steer"]
def steer(state, goal):
    """Return (v, omega) for a robot in the state (x, y, heading), a tensor (3,), and a goal (2,)."""
    ### BEGIN SOLUTION
    x, y, heading = state.tolist()
    bearing = math.atan2(float(goal[1]) - y, float(goal[0]) - x)
    off = math.remainder(bearing - heading, 2 * math.pi)  # the short way round
    omega = max(-2.84, min(2.84, off / 0.5))
    return (0.22 if abs(off) < 0.5 else 0.0), omega
    ### END SOLUTION


# %%
can_drive = check.steer(steer)
clock.at("the others")


def driven(environment, tasks, targets):
    """Return ways (time, task, 3), returns (task,) and successes of your driver, one robot per task."""
    states, ways, alive = environment.reset(tasks, 1), [], torch.ones(len(tasks), 1)
    returns, success = torch.zeros(len(tasks), 1), torch.zeros(len(tasks), 1)
    for time in range(environment.horizon):
        ways.append(states[:, 0])
        asked = [steer(*pair) for pair in zip(states[:, 0], targets, strict=True)]
        v, omega = torch.tensor([[float(part) for part in pair] for pair in asked]).T
        actions = torch.stack([2 * v / environment.v_limit - 1, omega / environment.omega_limit])
        moved = environment.step(tasks, states, actions.T[:, None], time)
        returns, success = returns + alive * moved.rewards, success + alive * moved.success
        states = torch.where(alive[..., None] > 0, moved.states, states)
        alive = alive * ~moved.terminated
    return torch.stack(ways), returns[:, 0], success[:, 0]


# %% [markdown]
# **Your driver in the package's environments.** First TwoWheeled, with its 24 goals. Then the family with changing dynamics: nine residual angular velocities from $-0.8$ to $0.8$ rad/s, which turn the robot while it drives,
# and which your driver does not know. *Predict first:* how many of the nine does it bring to the goal?

# %%
guess.ask("drift", "robots with a drift that arrive, of 9")

# %%
wheeled, drift = make("two_wheeled"), make("two_wheeled_drift")
tasks, drifts = wheeled.training_tasks(), drift.training_tasks()
shared = torch.tensor([[2.0, 1.0]]).expand(len(drifts), 2)
if can_drive:
    ways, returns, arrived = driven(wheeled, tasks, tasks)
    figure, panels = plt.subplots(1, 2, figsize=(10, 3.6))
    wheeled.draw_tasks(panels[0], tasks)
    panels[0].plot(*ways[..., :2].permute(2, 0, 1), color="#0072B2", linewidth=0.9)
    drifting, _, arrived_adrift = driven(drift, drifts, shared)
    drift.draw_tasks(panels[1], drifts)
    panels[1].set(xlim=(-0.6, 2.6), ylim=(-0.6, 1.8))
    for task, way in enumerate(drifting.unbind(1)):
        look = {"color": plt.cm.viridis(task / 8), "linestyle": "--" if drifts[task] < 0 else "-"}
        label = f"{float(drifts[task]):+.1f} rad/s" if task % 4 == 0 else None
        panels[1].plot(way[:, 0], way[:, 1], label=label, **look)
    panels[1].legend(loc="upper left")
    for axes, title in zip(panels, ("two_wheeled", "two_wheeled_drift"), strict=True):
        axes.set_title(title)
    plt.show()

# %% [markdown]
# *Figure 6. Your driver's ways: to the 24 goals of TwoWheeled (left), and to the goal that nine robots with different residual angular velocities share (right; from the most negative drift, dark, to the most positive, light; dashed where the drift turns to the right). Discs pay.*

# %% tags=["reveal", "tolerance:abs=0.3"]
if can_drive:
    assert arrived.sum() >= 20 and arrived_adrift.sum() >= 1
    guess.reveal("drift", f"{arrived_adrift.sum():.0f} of 9.")
    print(f"TwoWheeled: {arrived.sum():.0f} of 24 goals, mean return {returns.mean():.1f}")

# %% [markdown] tags=["reveal"]
# A driver that looks at its heading in every step corrects what it did not know, so it arrives under a drift, too, on a way that is bent: each step the robot is turned by up to 0.4 rad before the driver can answer. (One that drives only while it points at
# the goal to within less than 0.4 rad may turn on the spot for ever under the largest drifts. If yours does, you know why.)
#
# So the tasks are easy, for somebody who knows the goal. A learner is told neither the goal nor the drift; all it has is the rewards that it happens to meet.

# %% [markdown]
# ## 4 · How rarely it pays
#
# An untrained Gaussian policy ($\sigma = 1$) acts in every training task of every family. An episode counts if a single one of its steps is paid. A rate that is seen $k$ times in $n$ episodes is uncertain; we
# give **Wilson's interval** at 95 %, which stays sensible for small $k$.
#
# *Predict first:* in which of the four environments is an untrained policy rewarded most often? In which least?

# %%
guess.ask("most", "rewarded most often", FAMILIES)
guess.ask("least", "rewarded least often", FAMILIES)

# %% [markdown]
# From here on the package's batched environments take over: all episodes of all tasks in one go, where yours would need minutes.

# %% tags=["how-rarely", "tolerance:rel=0.2", "tolerance:abs=0.05"]
clock.at("how rarely it pays")
rates, intervals, rollouts = {}, {}, {}
for name in FAMILIES:
    environment = make(name)
    tasks = environment.training_tasks()
    untrained = policy.initialise(environment.state_dim, environment.action_dim, seed=0)
    each = 40 if name == "half_cheetah" else 2400 // len(tasks)
    random = torch.Generator().manual_seed(0)
    rollouts[name] = rollout = collect(environment, tasks, untrained, each, random)
    paid, count = int((rollout.rewards != 0).any(-1).sum()), rollout.mask.shape[:2].numel()
    rates[name], intervals[name] = paid / count, wilson_interval(paid, count)
    low, high = (100 * end for end in intervals[name])
    print(f"{name:18}{100 * rates[name]:6.2f} % of {count} episodes [{low:.2f}, {high:.2f}]")

# %%
figure, axes = plt.subplots(figsize=(7, 2.6))
for place, name in enumerate(rates):
    low, high = intervals[name]
    axes.plot([100 * low, 100 * high], [place, place], color="black", linewidth=2)
    axes.plot(100 * rates[name], place, marker="o", color="#D55E00", linestyle="none")
axes.set_yticks(range(len(rates)), rates)
axes.set(xscale="log", xlabel="episodes with any reward (%)", ylim=(3.5, -0.5))
axes.set_xticks([0.03, 0.1, 0.3, 1, 3, 10, 30], ["0.03", "0.1", "0.3", "1", "3", "10", "30"])
plt.show()

# %% [markdown]
# *Figure 7. How often an untrained policy sees any reward: rate (dot) and 95 % interval (line), over all training tasks, logarithmic scale.*

# %% tags=["reveal", "tolerance:rel=0.2", "tolerance:abs=0.05"]
assert intervals["point2d"][1] < 0.01
assert intervals["two_wheeled"][1] < 0.05 and intervals["two_wheeled_drift"][1] < 0.05
most, least = max(rates, key=rates.get), min(rates, key=rates.get)
assert most == "half_cheetah" and least == "point2d"
guess.reveal("most", f"{most}, {100 * rates[most]:.1f} % of its episodes.")
guess.reveal("least", f"{least}, {100 * rates[least]:.2f} % of its episodes.")

# %% [markdown] tags=["reveal"]
# The cheetah is the least sparse: a random wriggle sometimes carries it two metres, often enough the wrong way, where it is paid *negatively* for going on. For the point the rate is around one in a thousand. The wheeled robot is paid,
# by these counts, some twenty times as often (the intervals allow anything from five to a hundred times): it keeps part of its heading from step to step, so it gets farther, and its disc is larger and begins nearer.

# %% [markdown]
# **Is it the same environment as yours?** Replay the policy's actions in your Point2D: the episodes that were paid, and ten that were not.

# %% tags=["point-equals-package"]
rollout = rollouts["point2d"]
was_paid = (rollout.rewards != 0).any(-1)  # (task, episode)
chosen = was_paid.nonzero().tolist() + (~was_paid).nonzero()[::239][:10].tolist()
apart = 0.0
for task, number in chosen:
    places, rewards = episode(goals[task], rollout.actions[task, number])
    length = int(rollout.mask[task, number].sum())
    assert check.agree(places[:-1], rollout.states[task, number, :length])
    assert check.agree(rewards, rollout.rewards[task, number, :length])
    apart = max(apart, float((rewards - rollout.rewards[task, number, :length]).abs().max()))
print(f"{len(chosen)} episodes, {int(was_paid.sum())} of them paid")
print(f"largest difference between your rewards and the package's: {apart:.4f}")

# %% [markdown]
# ### Exercise 4 · How long must one wait?
#
# *Difficulty 1 of 3, planned for 5 minutes.* With probability `rate` an episode is rewarded. How many episodes must be collected so that *at least one* is rewarded with probability `confidence`?
#
# <details><summary>Hint 1: the other way round</summary>
# What is the chance that n episodes in a row see nothing?
# </details>
#
# <details><summary>Hint 2: out of the exponent</summary>
# A logarithm brings n down. Mind that the logarithm of a probability is negative, and that episodes come whole.
# </details>


# %% tags=["exercise-waiting"]
def episodes_needed(rate, confidence):
    """Return the smallest whole number of episodes."""
    ### BEGIN SOLUTION
    return math.ceil(math.log(1 - confidence) / math.log(1 - rate))
    ### END SOLUTION


# %%
checked = check.episodes_needed(episodes_needed)


def number(answer):
    """Return the plain number in an answer, be it a tensor, an array or a number."""
    return np.asarray(answer).item()


# %% [markdown]
# An iteration of the paper's algorithms collects 20 episodes per task (Table 1, its hyper-parameters). *Predict first:* how many iterations does a task of Point2D wait until it has seen its first reward with a probability of 95 %?

# %%
guess.ask("wait", "iterations of 20 episodes, Point2D")

# %% tags=["reveal", "waiting", "tolerance:rel=0.6", "statistical"]
batch = 20  # episodes per task and iteration, Table 1
if checked:
    waits = {name: number(episodes_needed(rates[name], 0.95)) for name in FAMILIES}
    assert waits["point2d"] > 40 * batch and waits["two_wheeled"] > 5 * batch
    guess.reveal("wait", f"{waits['point2d'] / batch:.1f} iterations, at the rate seen here.")
    for name, (low, high) in intervals.items():
        ends = [number(episodes_needed(rate, 0.95)) / batch for rate in (high, low)]
        print(f"{name:18}{waits[name] / batch:6.1f}, between {ends[0]:.1f} and {ends[1]:.1f}")

# %% [markdown]
# Does it come true? A simulation waits for the first reward 20,000 times per family: numpy's `geometric` draws how many episodes it takes until something of a given probability happens.

# %% tags=["waiting-curves", "tolerance:abs=1.5"]
dice, episodes = np.random.default_rng(0), np.geomspace(1, 20000, 200)
first_reward = {name: dice.geometric(rates[name], size=20000) for name in FAMILIES}
figure, axes = plt.subplots(figsize=(7, 3.2))
for name, line in zip(FAMILIES, ("-", "--", "-.", ":"), strict=True):
    within = first_reward[name][:, None] <= episodes
    axes.plot(episodes, 100 * within.mean(0), line, label=name)
    if checked:
        came = 100 * (first_reward[name] <= waits[name]).mean()
        axes.plot(waits[name], came, marker="o", color="black", linestyle="none")
        print(f"{name:18}{came:6.1f} % had come by the number of episodes you gave")
axes.axvline(20, color="grey", linewidth=0.8)
axes.text(22, 80, "one batch", color="grey", fontsize=9)
axes.set(xscale="log", xlabel="episodes", ylabel="chance of a reward among them (%)")
axes.set_xticks([1, 10, 100, 1000, 10000], ["1", "10", "100", "1,000", "10,000"])
axes.legend(loc="lower right")
plt.show()

# %% [markdown]
# *Figure 8. How often the first reward has come after so many episodes, in a simulation at the rates of Figure 7. The dots are your answers for 95 %, the grey line is the batch of one task in one iteration.*

# %% [markdown] tags=["reveal"]
# In each of those iterations the task learns nothing from rewards. And the number itself is uncertain: the rate rests on a handful of paid episodes, and the ends of its interval put the wait between about a quarter and several times as many iterations. (It is the wait of a policy that stays untrained. In the paper's algorithms all tasks share one meta-policy, and a reward in any of the other eleven changes it earlier.) What is rarely seen is also badly measured.

# %% [markdown]
# **Turn it yourself.** The sliders move the goal along the semicircle and change the radius of the disc that pays; 500 walks of an untrained policy stay the same. How large must the disc be until every second walk is paid?

# %% tags=["widget-sparsity", "nbval-ignore-output"]
walks = sparsity.random_walks()
sparsity.sparsity_sliders(walks)

# %% tags=["widget-lesson"]
sparsity.sparsity_picture(walks, angle=90, radius=1.55)

# %% [markdown]
# *Figure 9. Left: 500 untrained walks, some of those that meet the disc in thick lines, some of the others in thin ones. Right: the share that a disc of each radius would pay. At the paper's radius next to none; for every second walk the disc must reach three quarters of the way back to the start.*

# %% tags=["tolerance:abs=0.1"]
for angle in (0, 45, 90, 135, 180):
    needed = sparsity.closest_approaches(walks, angle)
    met, half = int((needed <= 0.2).sum()), float(needed.median())
    assert met <= 10 and 1.4 < half < 1.8
    print(f"goal at {angle:3} degrees: every second walk needs a radius of {half:.1f}")

# %% [markdown]
# Wherever the goal lies, the answer is about the same. A larger disc is no way out: a reward that a random walk meets says hardly more than "not backwards".
#
# ## 5 · What the gradient is then
#
# Notebook 01: the gradient of $\mathcal L^{\mathrm{RL}}$ is minus the mean of $\hat A_t\, \nabla_\theta \log \pi_\theta(a_t \mid s_t)$, with advantages $\hat A_t$ from the returns $G_t$, less a fitted baseline $B(s_t)$, normalised within the task. TwoWheeled has 24 tasks, and each
# collects 20 episodes with the same untrained policy.
#
# *Predict first:* a task in which at least one episode was rewarded has a gradient of length 0.15, on average. How long is the gradient of a task in which none was?

# %%
guess.ask("gradient", "length of the gradient without any reward")

# %% tags=["zero-gradient"]
clock.at("what the gradient is then")
start = policy.per_task(policy.initialise(3, 2, seed=0), 24)


def task_gradients(seed, bonus=0.0, normalised=True, family=wheeled, start=start):
    """Return each task's policy gradient (task, parameter), whether it saw a reward, and the rollout."""
    draws = torch.Generator().manual_seed(seed)
    rollout = collect(family, family.training_tasks(), start, 20, draws)
    seen = (rollout.rewards > 0).any(-1).any(-1)  # (task,)
    rollout = rollout._replace(rewards=rollout.rewards + bonus * rollout.mask)
    rollout = Score(normalise=normalised)(rollout)
    leaves = {name: value.clone().requires_grad_() for name, value in start.items()}
    loss = losses.rl_loss(leaves, rollout).sum()
    parts = torch.autograd.grad(loss, list(leaves.values()))
    return torch.cat([part.flatten(1) for part in parts], dim=1), seen, rollout


gradients, seen, batch_of_20 = task_gradients(seed=0)
lengths = gradients.norm(dim=1)
print(f"{int(seen.sum())} of 24 tasks saw a reward")

# %% tags=["reveal", "tolerance:rel=0.2", "tolerance:abs=0.02"]
assert (lengths[~seen] == 0).all() and (lengths[seen] > 0).all()
assert (~seen).sum() > 4
longest, shortest = float(lengths[~seen].max()), float(lengths[seen].min())
guess.reveal("gradient", f"{longest:g}. That is the longest of the {int((~seen).sum())}.")
print(f"with a reward: {lengths[seen].mean():.2f} on average, the shortest {shortest:.2f}")
expected = 24 * (first_reward["two_wheeled"] <= 20).mean()
print(f"tasks that see a reward, expected by the simulation of Figure 8: {expected:.1f}")

# %% [markdown] tags=["reveal"]
# Not small: zero, to the last digit. (How many tasks see a reward is what exercise 4 leads one to expect, within the chance of one batch.) The chain from the rewards to the gradient, with the numbers of two of these tasks:


# %% tags=["reveal", "tolerance:rel=0.5"]
def links(rollout, task, gradients):
    """Return the largest size of each link of the chain in one task."""
    returns = discounted_returns(rollout.rewards, 0.95)
    baseline = linear_baseline(rollout, 0.95)
    steps = (rollout.rewards, returns, baseline, (returns - baseline) * rollout.mask)
    sizes = [float(values[task].abs().max()) for values in (*steps, rollout.advantages)]
    return [*sizes, float(gradients[task].norm())]


unpaid, rewarded = int((~seen).nonzero()[0]), int(seen.nonzero()[0])
chain = {
    "no episode is paid": links(batch_of_20, unpaid, gradients),
    "some episodes are paid": links(batch_of_20, rewarded, gradients),
}
assert not any(chain["no episode is paid"]) and all(chain["some episodes are paid"])
figure = reward_chain(chain)
plt.show()

# %% [markdown]
# *Figure 10. From the rewards of 20 episodes to the policy gradient: the largest number of each link, and the length of the gradient, in two tasks of TwoWheeled. Dashed boxes are exactly zero.*
#
# ### On paper · Prove it
#
# *Difficulty 2 of 3, planned for 5 minutes.* Show that the gradient of a task without a reward is exactly zero, not small. Go through the links one by one; the baseline minimises $\sum_t (w^\top f(s_t) - G_t)^2 + \rho\, \|w\|^2$ over its weights $w$, with features $f$ and a small $\rho > 0$. Then
# say which of these would help: a longer step size, TRPO (the longest step that changes the policy by no more than a given amount, notebook 05), a neural network as the baseline, ten times as many episodes.
#
# <details><summary>Hint: which weights?</summary>
# The sum that is minimised is never negative. For which weights is it zero, if all returns are zero?
# </details>
#
# <details><summary>Solution</summary>
#
# All rewards are 0, so all returns $G_t$ are 0. The fitted sum is then $\sum_t (w^\top f(s_t))^2 + \rho\,\|w\|^2 \ge 0$, and it is 0 for $w = 0$ and, since $\rho > 0$, for no other weights. So the baseline is 0, the difference $G_t - B(s_t)$ is 0, and so is
# its mean. Normalising divides 0 by a deviation of 0 plus $10^{-8}$, which is 0. The gradient is a mean of terms $0 \cdot \nabla_\theta \log \pi_\theta$, that is 0, whatever the policy.
#
# A longer step along zero is no step. TRPO looks for the best direction for the same zero gradient: there is none, and nothing moves. Another baseline can only do harm: one that is not exactly zero here would put its own error in place of the missing reward.
# More episodes help, and only by finding a reward; Figure 8 says how many it takes.
#
# </details>
#
# ## 6 · Dense and sparse, live
#
# Is the environment perhaps too hard? The same learner, TRPO with a policy that is told the goal (notebook 03), learns once from the **dense** reward $-d$, minus the distance, once from the **sparse** one: 16 iterations of 192 episodes each on Point2D.
#
# *Predict first:* with the sparse reward, which share of the goals does it reach in the last iteration? And with the dense one?

# %%
guess.ask("live", "goals reached in iteration 16, %: sparse; dense")

# %% tags=["dense-and-sparse"]
clock.at("dense and sparse, live")
success = {}
for reward in ("dense", "sparse"):
    config = ExpertConfig(env="point2d", reward=reward, iterations=16)
    success[reward] = [100 * iterate.success for iterate in train_expert(config)]
figure, axes = plt.subplots(figsize=(6, 3))
looks = {"dense": ("o", "-", "#0072B2"), "sparse": ("^", ":", "#D55E00")}
for reward, (marker, line, colour) in looks.items():
    look = {"marker": marker, "linestyle": line, "color": colour, "markevery": 4}
    axes.plot(success[reward], label=f"{reward} reward", **look)
axes.set(xlabel="TRPO iteration", ylabel="episodes that reach the goal (%)", ylim=(-3, 103))
axes.legend(loc="upper left")
plt.show()

# %% [markdown]
# *Figure 11. Share of episodes that reach their goal while a policy that is told the goal learns from the dense and from the sparse reward, as measured on the machine that ran this notebook.*

# %% tags=["reveal", "dense-learns", "statistical", "tolerance:abs=20"]
assert success["dense"][-1] > 50
assert success["sparse"][-1] < 15
shares = {reward: f"{share[-1]:.1f} %" for reward, share in success.items()}
guess.reveal("live", f"sparse {shares['sparse']}; dense {shares['dense']}")

# %% [markdown] tags=["reveal"]
# The task is easy. It is the *reward* that is hard. (Not hopeless: one policy that is told the goal can pool the lucky episodes of all goals. How many it reaches after 30 iterations depends on the seed and the processor; on TwoWheeled, luck is
# more frequent: try `iterations=40` or `env="two_wheeled"`.) A dense reward, though, needs somebody who can measure the distance to the goal at every step; a demonstration needs somebody who has been there once.

# %% [markdown]
# ## 7 · A constant tiny reward (further reading)
#
# The released code pays $10^{-5}$ where the paper pays 0. Who would mind? But advantages are **normalised**: each task's are shifted and scaled to mean 0 and standard deviation 1.
#
# *Predict first:* in a task without any real reward, how long is the gradient now, compared with a task that *was* rewarded?

# %%
guess.ask("tiny", "length, as a multiple of that of a rewarded task")

# %% tags=["reveal", "constant-reward", "tolerance:0.3"]
clock.at("a constant tiny reward")
tiny, _, tiny_batch = task_gradients(seed=0, bonus=1e-5)
plain, _, _ = task_gradients(seed=0, bonus=1e-5, normalised=False)
lengths = {
    "reward 0": gradients.norm(dim=1),
    "reward 1e-5, normalised": tiny.norm(dim=1),
    "reward 1e-5, as it is": plain.norm(dim=1),
}
ratio = lengths["reward 1e-5, normalised"][~seen].mean() / lengths["reward 0"][seen].mean()
assert ratio > 0.5
assert lengths["reward 1e-5, as it is"][~seen].max() < 1e-4
for name, values in lengths.items():
    without, with_one = float(values[~seen].mean()), float(values[seen].mean())
    print(f"{name:23} tasks without a reward {without:.1e}, with one {with_one:.1e}")
guess.reveal("tiny", f"{float(ratio):.2f} times as long as from a real reward.")

# %% tags=["reveal", "tolerance:rel=0.5"]
chain[r"the first, with $10^{-5}$"] = links(tiny_batch, unpaid, tiny)
figure = reward_chain(chain)
plt.show()

# %% [markdown]
# *Figure 12. The chain of Figure 10, and in the last row the task without a reward once more, with $10^{-5}$ added to every step: follow where it shrinks and where it grows.*

# %% [markdown] tags=["reveal"]
# The baseline cannot fit a constant reward perfectly: the return to come falls from about $10^{-5}/(1-\gamma)$ to $10^{-5}$ along the episode, and a cubic in $t$ follows that only nearly. What is left is about as small as the reward itself;
# dividing by its standard deviation blows it up to size 1.

# %% [markdown]
# ### Exercise 5 · Is it a signal?
#
# *Difficulty 3 of 3, planned for 12 minutes.* A gradient may be long and still say nothing. An experiment tells: collect several batches with the same policy in the same task. If the gradient knows where to go, all batches say the same; if it is noise, each says something else.
# Turn that into one number that does not depend on how long the gradients are: the mean, over all pairs of *different* batches, of the cosine of the angle between their gradients. It is 1 if all point the same way, and around 0 if they know nothing of each other.
#
# <details><summary>Hint 1: lengths away</summary>
# The cosine of the angle between two vectors is the product of two vectors of length 1.
# </details>
#
# <details><summary>Hint 2: which pairs?</summary>
# A table of all products also holds every batch with itself. Those are 1 whatever the gradients are, so they would make noise look like a signal.
# </details>


# %% tags=["exercise-agreement"]
def agreement(gradients):
    """Return the mean cosine between the gradients (batch, parameter) of two different batches."""
    ### BEGIN SOLUTION
    directions = gradients / gradients.norm(dim=1, keepdim=True)
    cosines = directions @ directions.T
    count = len(gradients)
    return (cosines.sum() - count) / (count * (count - 1))
    ### END SOLUTION


# %%
checked = check.agreement(agreement)

# %% [markdown]
# Ten batches of the same untrained policy, on Point2D with $10^{-5}$ in tasks that saw no reward, and with the dense reward $-d$; then on TwoWheeled with its dense reward. *Predict first:* how far do the batches of a task agree?

# %%
guess.ask("agree", "1e-5, Point2D; dense, Point2D; dense, TwoWheeled")

# %% tags=["cosines"]
same = policy.per_task(policy.initialise(2, 2, seed=0), 12)
families = {
    "1e-5, point2d": (point, 1e-5, same),
    "dense, point2d": (make("point2d", reward="dense"), 0.0, same),
    "dense, two_wheeled": (make("two_wheeled", reward="dense"), 0.0, start),
}
found = {}
for name, (family, bonus, params) in families.items():
    batches = [task_gradients(seed, bonus, family=family, start=params) for seed in range(10)]
    of_tasks = torch.stack([batch[0] for batch in batches], dim=1)  # (task, batch, parameter)
    paid = torch.stack([batch[1] for batch in batches], dim=1)  # a dense reward is never above 0
    found[name] = [of_one[~seen_one] for of_one, seen_one in zip(of_tasks, paid, strict=True)]

# %% tags=["cosines-figure"]
if checked:
    agreements = {
        name: [float(agreement(of_one)) for of_one in tasks] for name, tasks in found.items()
    }
    figure, axes = plt.subplots(figsize=(6.8, 2.4))
    looks = (("s", "#D55E00"), ("o", "#0072B2"), ("^", "#777777"))
    for place, (name, (marker, colour)) in enumerate(zip(found, looks, strict=True)):
        values = agreements[name]
        axes.plot(values, [place] * len(values), marker, color=colour, alpha=0.6)
    axes.axvline(0, color="black", linewidth=0.8)
    axes.set_yticks(range(3), found)
    axes.set(xlabel="agreement of ten batches", xlim=(-0.5, 1.05), ylim=(2.6, -0.6))
    plt.show()

# %% [markdown]
# *Figure 13. How far the policy gradients of ten batches agree, by your function, one mark per task: with a constant reward of $10^{-5}$ in tasks without a reward, and with a dense reward in two environments. At 1 all batches say the same, around 0 they know nothing of each other.*

# %% tags=["reveal", "tolerance:abs=0.06"]
if checked:
    means = [float(np.mean(values)) for values in agreements.values()]
    assert abs(means[0]) < 0.15 and means[1] > 0.9 and means[2] < 0.4
    for name, of_tasks in found.items():
        print(f"{name:19}mean length {float(torch.cat(of_tasks).norm(dim=-1).mean()):.2f}")
    answers = "; ".join(f"{mean:.2f}" for mean in means)
    guess.reveal("agree", f"{answers}, on average over the tasks.")

# %% [markdown] tags=["reveal"]
# On Point2D with the dense reward all batches say the same. With the constant one they agree as little as random directions. Their length does not tell: here they are shorter, on TwoWheeled, above, they were about as long as from a real reward. It is no surprise: what the baseline leaves over depends on the time $t$ (and a little on the state), not on the action, and the expected $\nabla_\theta \log \pi_\theta$ is zero (notebook 01).
# So the expectation of such a gradient is zero: it points nowhere, and a single batch does not know that. The policy takes steps, and takes them at random. In this workbook the reward elsewhere is 0, as the paper writes, and advantages whose spread is zero stay zero.
#
# Did TwoWheeled surprise you? A dense reward is no guarantee: 20 episodes of a robot that turns at random say little about where the goal is. A reward makes a gradient; how many episodes make it a signal is another question, and your function answers it.

# %% [markdown]
# ## 8 · How the cheetah runs (further reading)
#
# A gait is a sequence of poses. These are the demonstrations of the two directions, at the same six moments:

# %% tags=["cheetah-strip"]
clock.at("how the cheetah runs")
data = load_demonstrations("optimal", "half_cheetah")
cheetah = make("half_cheetah")
figure, rows = plt.subplots(2, 6, figsize=(12, 4.4))
tilts = {}
for panels, task in zip(rows, (0, 5), strict=True):
    for axes, moment in zip(panels, range(30, 54, 4), strict=True):
        cheetah.draw(axes, data.tasks[task], data.states[task, 0, : moment + 1])
        axes.set(title=f"{0.05 * moment:.2f} s", xlabel="x (m)", ylim=(-0.2, 1.6))
        axes.set_yticks([])
        axes.set_aspect("equal")
    tilts[float(data.tasks[task])] = float(data.states[task, 0, :, 1].abs().max().rad2deg())
plt.show()
assert tilts[1.0] > 60 and tilts[-1.0] < 45
for direction, tilt in tilts.items():
    print(f"direction {direction:+.0f}: its body tilts by up to {tilt:.0f} degrees")

# %% [markdown]
# *Figure 14. Six moments of the optimal demonstrations, forward (top) and backward (bottom); the orange region is where the reward begins.*
#
# Backward it runs level. Forward it tips over its front leg until it nearly stands on its nose, falls back and goes on: fast, and not pretty. "Optimal" means here what it means in the paper, trained to the end, and no more.
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
# | cheetah paid for $\lvert x - x_0 \rvert > 2$ | "in the correct direction" in words, either way in the formula | either way | either way |
# | how a cheetah starts | not said | pose and velocities disturbed | at rest, always the same |
#
# ## What was shown
#
# - The paper's four environments; Point2D written by you and equal to the package's, episode by episode.
# - Arriving early pays; arriving late does not, and then it would pay to loiter.
# - A driver of a few lines that is told the goal reaches it, under a drift that it does not know, too.
# - An untrained point is paid in fewer than one episode of a hundred; most tasks of a batch see no reward.
# - Where no reward is seen, the policy gradient is exactly zero; a constant $10^{-5}$ with normalised advantages makes it long, and the batches disagree on where it points.
# - With a dense reward the same learner reaches most goals after sixteen iterations, with the sparse one hardly any.
#
# **Next** notebook 03 makes the demonstrations that fill the gap.
#
# **References** Finn, Abbeel and Levine (2017), *MAML*; Gupta et al. (2018), *Meta-reinforcement learning of structured exploration strategies*; Todorov, Erez and Tassa (2012), *MuJoCo*; Wilson (1927); Rengarajan et al. (2022), the paper.
