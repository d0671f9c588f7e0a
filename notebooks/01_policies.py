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
# # 01 · Policies: from a Gaussian to behaviour cloning
#
# A robot that has never moved must draw its first action from somewhere. In this workbook it draws
# from a normal distribution whose mean is computed by a small neural network. Everything that
# follows, up to the last figure of the paper, is about moving that mean to better places.
#
# **You will be able to**
#
# - write the log-density of a Gaussian policy and sample from it,
# - derive the REINFORCE gradient, check it against a number it cannot have copied, and say what nearly all code drops from it,
# - make it quieter with a baseline, measure by how much, and write generalised advantage estimation (GAE),
# - clone a demonstrated path, and see what the clone does at the path's end.
#
# **You need** calculus, a little probability, and Python with tensors. **Time** about 75 minutes;
# all computing together takes under a minute on two cores. **Paper** Section 2 (Preliminaries) and
# Appendix C (Experimental Setup) of Rengarajan et al., *Enhanced Meta Reinforcement Learning using
# Demonstrations in Sparse Reward Environments*, NeurIPS 2022.

# %%
import matplotlib.pyplot as plt
import torch

from emrld_lite import advantage, losses, policy
from emrld_lite.classroom import checks as check
from emrld_lite.classroom.clock import Clock
from emrld_lite.demonstrations import load_demonstrations
from emrld_lite.demonstrators import cloning
from emrld_lite.envs import make
from emrld_lite.envs.point2d import STEP_LIMIT, displacement
from emrld_lite.experiments import plotting
from emrld_lite.rollout import collect, episode_returns

plotting.use_style()
torch.set_num_threads(1)
clock = Clock(
    {
        "a policy is a distribution": 15,
        "the mean is a network": 10,
        "episodes and returns": 10,
        "the REINFORCE gradient": 20,
        "a baseline and GAE": 10,
        "behaviour cloning": 10,
    }
)

# %% [markdown]
# ## 1 · A policy is a distribution
#
# A *policy* $\pi(s, \cdot)$ gives, for a state $s$, a distribution over actions $a$. Ours is Gaussian:
#
# $$a \sim \mathcal N\big(\mu_\theta(s), \operatorname{diag}(\sigma^2)\big),$$
#
# where $\theta$ collects all the numbers we may change, $\mu_\theta(s)$ is the mean action in state
# $s$ and $\sigma$ holds one standard deviation for each action dimension. The dimensions are
# independent given the state.
#
# **Predict first.** The point robot of this workbook moves by $0.1\,a$ per step. The environment clips each component of
# $a$ to $[-1, 1]$ and then shortens a move that is longer than 0.1. With $\mu = 0$ and $\sigma = 1$, what share of the drawn
# actions does it alter: a third, a half, more?

# %%
clock.at("a policy is a distribution")
random = torch.Generator().manual_seed(0)
drawn = torch.randn(10_000, 2, generator=random)  # (sample, action), mu = 0 and sigma = 1
moves = displacement(drawn, "at-most")  # what the environment makes of them
altered = ((moves - STEP_LIMIT * drawn).norm(dim=1) > 1e-6).float().mean()
assert abs(altered - 0.607) < 0.03  # P(|a| > 1) = exp(-1/2) for two standard normal components
print(f"share of the actions that is altered: {altered:.2f}; exp(-1/2) is 0.607")

# %%
figure, axes = plt.subplots(figsize=(4.2, 3.6))
axes.scatter(*drawn[:1500].T, s=4, alpha=0.4, color="#56B4E9", label="drawn actions")
turn = torch.linspace(0, 2 * torch.pi, 200)
axes.plot(turn.cos(), turn.sin(), color="black", linewidth=1.2, label="what the robot can do")
axes.set(xlabel="action $a_1$ (units of 0.1 length)", ylabel="action $a_2$ (units of 0.1 length)")
axes.set_aspect("equal")
axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
plt.show()

# %% [markdown]
# *Figure 1. Actions drawn with $\sigma = 1$ (dots) and the disc of the moves that the robot can make (circle).*
#
# Six actions of ten lie outside of the disc, and the environment alters them. We keep the action *as drawn*: its density is a
# Gaussian's, which the altered action's is not, and densities are what gradients need. Clipping and shortening
# happen inside the environment.

# %% [markdown]
# ### Exercise 1 · The log-density of a joint action
#
# *Difficulty 1 of 3, 5 minutes.* One dimension has the density
# $\frac{1}{\sigma\sqrt{2\pi}} \exp\!\big(-\frac{(a-\mu)^2}{2\sigma^2}\big)$. Write the **logarithm** of
# the density of the whole action. You get $\log\sigma$ rather than $\sigma$: any real number is then
# a valid parameter.
#
# <details><summary>Hint 1: I do not know where to start</summary>
# Take the logarithm of the one-dimensional density: it has three terms.
# </details>
#
# <details><summary>Hint 2: my numbers have one axis too many</summary>
# Independent dimensions multiply their densities, so their logs add: sum over the last axis.
# </details>
#
# <details><summary>Hint 3: nearly the solution</summary>
# $\sum_j \big[-\tfrac12 \big(\tfrac{a_j-\mu_j}{\sigma_j}\big)^2 - \log\sigma_j - \tfrac12\log 2\pi\big]$
# </details>


# %% tags=["exercise-log-density"]
def log_density(mean, log_sigma, actions):
    """Return log N(actions; mean, sigma), (...), from tensors of shape (..., action)."""
    ### BEGIN SOLUTION
    standardised = (actions - mean) / log_sigma.exp()
    constant = 0.5 * torch.log(torch.tensor(2 * torch.pi))
    return (-0.5 * standardised**2 - log_sigma - constant).sum(-1)
    ### END SOLUTION


# %%
if check.log_density(log_density):
    ours = log_density(torch.zeros(4, 2), torch.ones(4, 2), drawn[:4])
    package = policy.log_density(policy.Gaussian(torch.zeros(4, 2), torch.ones(4, 2)), drawn[:4])
    assert torch.allclose(ours, package)
    print("Your function gives the same numbers as emrld_lite.policy.log_density.")

# %% [markdown]
# ## 2 · The mean is a network
#
# The mean $\mu_\theta(s)$ is a multilayer perceptron: two hidden layers of 100 units, each a matrix
# product followed by $\operatorname{relu}(z) = \max(z, 0)$ (Appendix C). We hold its parameters in a
# plain dictionary of tensors. There is no module, no hidden state: a policy *is* its numbers, and
# adapting it to a task will simply make another dictionary.

# %%
clock.at("the mean is a network")
params = policy.initialise(state_dim=2, action_dim=2, seed=0)
for name, value in params.items():
    print(f"{name:10} {tuple(value.shape)}")
print(sum(value.numel() for value in params.values()), "numbers in all")


# %% tags=["build-network"]
def network_mean(params, states):
    """Return the mean action, (sample, action), at states (sample, state)."""
    hidden = torch.relu(states @ params["weight_0"] + params["bias_0"])  # (sample, 100)
    hidden = torch.relu(hidden @ params["weight_1"] + params["bias_1"])  # (sample, 100)
    return hidden @ params["weight_2"] + params["bias_2"]  # (sample, 2)


states = torch.randn(5, 2, generator=random)
package = policy.mean(params, states[None])[0]  # the package wants a leading task axis
assert torch.allclose(network_mean(params, states), package, atol=1e-6)
print("Six lines of matrix algebra equal emrld_lite.policy.mean.")

# %% [markdown]
# The package's version does the same for many tasks at once. Its axes are always
# `(task, episode, time, dim)`; each parameter may carry a task axis too, and then every task has a
# policy of its own. That one convention is what makes meta-learning fast later on.

# %% [markdown]
# ## 3 · Episodes and returns
#
# **Point2D Navigation** (Appendix B): a point starts at the origin and wants to reach a goal at
# distance 2 within 100 steps of length at most 0.1. Notebook 02 builds it from its formula; here we
# use it. For the first half of this notebook we take the *dense* reward $R_t = -d_{t+1}$, where
# $d_{t+1}$ is the distance to the goal after the step. The sparse reward of the paper comes in the
# end.
#
# **Predict first.** How far from the start does an untrained policy end up after 100 steps?

# %%
clock.at("episodes and returns")
environment = make("point2d", reward="dense")
goal = torch.tensor([[0.0, 2.0]])  # (task, 2): one task
untrained = collect(environment, goal, params, episodes=20, random=random)
for name in ("states", "actions", "rewards", "mask"):
    print(f"{name:8} {tuple(getattr(untrained, name).shape)}")

# %%
figure, axes = plt.subplots(figsize=(5, 3.6))
environment.draw_tasks(axes, goal)
plotting.trajectories(untrained, axes, episodes=20)
axes.plot(0, 0, marker="x", color="black", markersize=8, zorder=5)  # over the paths
axes.set_title("an untrained policy")
plt.show()
distance = untrained.states[0, :, -1].norm(dim=-1).mean()
assert distance < 1.9
print(f"mean distance from the start after 100 steps: {distance:.2f}; the goal is 2 away")

# %% [markdown]
# *Figure 2. Twenty episodes of an untrained policy (lines), the start (cross), the goal (star) and the
# region around it in which the paper's sparse reward is paid (disc).*
#
# The paths wander about: steps that point in random directions mostly cancel. None of the paths is
# good, but some end nearer to the goal than others, and that difference is all a policy gradient
# needs.
#
# ### Exercise 2 · Discounted returns
#
# *Difficulty 1 of 3, 5 minutes.* The *return* from time $t$ is the discounted sum of the rewards still
# to come, $G_t = \sum_{k \ge t} \gamma^{k-t} R_k$, with the discount $\gamma < 1$ (0.95 in the paper's Table 1).
#
# <details><summary>Hint 1: a double loop feels clumsy</summary>
# Write $G_t$ in terms of $G_{t+1}$: a single loop backwards in time is enough.
# </details>
#
# <details><summary>Hint 2: nearly the solution</summary>
# $G_t = R_t + \gamma\, G_{t+1}$, starting from $G_T = 0$ after the last step.
# </details>


# %% tags=["exercise-returns"]
def discounted_returns(rewards, discount):
    """Return G_t, (episode, time), from rewards (episode, time)."""
    ### BEGIN SOLUTION
    returns = torch.zeros_like(rewards)
    following = torch.zeros_like(rewards[:, 0])  # (episode,)
    for time in reversed(range(rewards.shape[1])):
        following = rewards[:, time] + discount * following
        returns[:, time] = following
    return returns
    ### END SOLUTION


# %%
if check.discounted_returns(discounted_returns):
    ours = discounted_returns(untrained.rewards[0], 0.95)
    package = advantage.discounted_returns(untrained.rewards, 0.95)[0]
    assert torch.allclose(ours, package)
    print("Your function gives the same numbers as emrld_lite.advantage.discounted_returns.")

# %% [markdown]
# ## 4 · The REINFORCE gradient
#
# We want $\nabla_\theta J(\theta)$, where $J(\theta) = \mathbb E_{\tau \sim \pi_\theta}[G(\tau)]$ is the expected
# return of a trajectory $\tau = (s_0, a_0, s_1, \dots)$ with the density $p_\theta(\tau)$, and $G(\tau) = G_0$. The difficulty: $\theta$ sits in the *distribution*,
# not in $G$. Three moves get it out.
#
# | move | because |
# |---|---|
# | $\nabla_\theta J = \int G(\tau)\, \nabla_\theta p_\theta(\tau)\, d\tau$ | $G(\tau)$ does not depend on $\theta$ |
# | $\hphantom{\nabla_\theta J} = \mathbb E_\tau\big[G(\tau)\, \nabla_\theta \log p_\theta(\tau)\big]$ | $\nabla p = p\, \nabla \log p$ |
# | $\hphantom{\nabla_\theta J} = \mathbb E_\tau\big[\sum_t \gamma^t\, G_t\, \nabla_\theta \log \pi_\theta(a_t \mid s_t)\big]$ | dynamics do not depend on $\theta$; rewards before $t$ do not depend on $a_t$ |
#
# The last move has two parts. $\log p_\theta(\tau)$ is a sum over the steps, and only its terms $\log \pi_\theta(a_t \mid s_t)$ contain $\theta$. Their gradient
# $\nabla_\theta \log \pi_\theta(a \mid s)$ is called the **score**, and its expectation is zero, since $\mathbb E_a[\nabla_\theta \log \pi_\theta] = \int \nabla_\theta \pi_\theta\, da = \nabla_\theta 1 = 0$. So the
# rewards before $t$ multiply a score whose expectation is zero and drop out. What is left of $G(\tau)$ for the step $t$ is $\gamma^t R_t + \gamma^{t+1} R_{t+1} + \dots = \gamma^t G_t$.
#
# **Predict first.** We test this on the smallest problem there is: one state, one step, one action
# $a \sim \mathcal N(\mu, 1)$ and the reward $R(a) = -(a - 1)^2$. At $\mu = 0$, what is the gradient of
# $J(\mu) = -(\mu - 1)^2 - 1$?

# %% tags=["reinforce-finite-differences", "tolerance:abs=0.005"]
clock.at("the REINFORCE gradient")


def expected_reward(mu, noise):
    """Return the mean reward over actions mu + noise; mu may be any number."""
    return (-((mu + noise - 1) ** 2)).mean()


noise = torch.randn(1_000_000, generator=random)
step = 1e-2
differences = (expected_reward(step, noise) - expected_reward(-step, noise)) / (2 * step)
rewards = -((noise - 1) ** 2)  # the actions at mu = 0 are the noise itself
score = noise  # d/dmu log N(a; mu, 1) = a - mu
reinforce = (rewards * score).mean()
assert abs(score.mean()) < 0.01
for name, value in (("finite differences", differences), ("REINFORCE", reinforce)):
    assert abs(value - 2.0) < 0.05
    print(f"{name:>18}: {value:.3f}")
print(f"        mean score: {score.mean() + 0.0:.3f}")

# %% [markdown]
# Both agree with the exact answer, $-2(\mu - 1) = 2$, as far as a million draws can tell. Finite differences moved $\mu$ and looked at the
# rewards again. REINFORCE never differentiated the reward: it only asked how much more likely each action would
# become. That is why it is also *defined* where the reward is a black box, or zero nearly everywhere. Whether it is of any *use* there is
# another question; notebook 02 shows that it is exactly zero as long as no episode is rewarded.
#
# ### The factor that nearly all code drops
#
# The factor $\gamma^t$ says that later steps count for less in $J$. Nearly all code, the paper's and ours included, leaves it out: with $\gamma = 0.95$ the steps after the first 90
# would count for less than a hundredth, and we want a policy that acts well late, too. What is left is no longer the gradient of $J$. How far is it off? Two steps of the same
# problem, the reward $-(a_t - 1)^2$ in each, with $\gamma = 0.5$: the exact gradient at $\mu = 0$ is $2 + 0.5 \cdot 2 = 3$.

# %% tags=["dropped-factor", "tolerance:abs=0.01"]
noise = torch.randn(1_000_000, 2, generator=random)  # (episode, time), the actions at mu = 0
discounts = 0.5 ** torch.arange(2.0)  # gamma^t
rewards = -((noise - 1) ** 2)
returns = advantage.discounted_returns(rewards, 0.5)  # G_t


def objective(mu):
    """Return the mean discounted return over actions mu + noise."""
    return (-((mu + noise - 1) ** 2) * discounts).sum(1).mean()


estimates = {
    "finite differences": (objective(step) - objective(-step)) / (2 * step),
    "with gamma^t": (discounts * returns * noise).sum(1).mean(),
    "without gamma^t": (returns * noise).sum(1).mean(),
}
for (name, value), exact in zip(estimates.items(), (3.0, 3.0, 4.0), strict=True):
    assert abs(value - exact) < 0.06
    print(f"{name:>18}: {value:.2f}")

# %% [markdown]
# With the factor REINFORCE agrees with finite differences; without it, the second step counts as much as the first and the sum is 4. Here only the length
# changes. In a policy whose parameters act at different times the direction changes as well. From here on we drop the factor, as the paper does, and call the result the
# *policy gradient* all the same.
#
# ### Exercise 3 · The loss whose gradient is REINFORCE
#
# *Difficulty 2 of 3, 10 minutes.* Automatic differentiation wants a *loss*. Write the one whose gradient
# is minus the policy gradient (without $\gamma^t$): the mean over the steps that were taken. `mask` is 1 for those and 0 after
# an episode's end. $G_t$ is a number, not something to differentiate.
#
# <details><summary>Hint 1: why "mean over the steps that were taken"?</summary>
# Episodes end at different times but share one tensor. What lies after the end is padding; it must
# neither add to the sum nor to the count.
# </details>
#
# <details><summary>Hint 2: nearly the solution</summary>
# $-\dfrac{\sum_{e,t} m_{e,t}\, \log\pi_\theta(a_{e,t} \mid s_{e,t})\, G_{e,t}}{\sum_{e,t} m_{e,t}}$
# </details>


# %% tags=["exercise-reinforce-loss"]
def reinforce_loss(log_probs, returns, mask):
    """Return a scalar loss from log-densities, returns and mask, each (episode, time)."""
    ### BEGIN SOLUTION
    return -(log_probs * returns * mask).sum() / mask.sum()
    ### END SOLUTION


# %%
if check.reinforce_loss(reinforce_loss):
    scored = untrained._replace(advantages=advantage.discounted_returns(untrained.rewards, 0.95))
    gaussian = policy.distribution(params, scored.states)
    log_probs = policy.log_density(gaussian, scored.actions)[0]
    ours = reinforce_loss(log_probs, scored.advantages[0], scored.mask[0])
    assert torch.allclose(ours, losses.rl_loss(params, scored)[0])
    print("Your loss equals emrld_lite.losses.rl_loss.")

# %% [markdown]
# ### Live: forty gradient steps
#
# Here is the whole algorithm: collect, score, step, for five seeds at once (each is a "task" with parameters of its own). `normalise` shifts and scales the returns of all
# steps to mean 0 and deviation 1, which fixes the size of a step whatever the units of the reward.


# %% tags=["live-reinforce", "statistical", "tolerance:abs=5"]
def gradient(seed_params, scored):
    """Return the gradient of each seed's RL loss, a dict of (seed, ...)."""
    leaves = policy.detach(seed_params, requires_grad=True)
    losses_of_seeds = losses.rl_loss(leaves, scored)  # (seed,), which do not touch each other
    found = torch.autograd.grad(losses_of_seeds.sum(), list(leaves.values()))
    return dict(zip(leaves, found, strict=True))


def train(score, seeds=5, iterations=40, rate=0.05):
    """Return the mean returns, (iteration, seed); ``score`` fills in advantages."""
    starts = [policy.initialise(2, 2, seed=seed) for seed in range(seeds)]
    current = {name: torch.stack([start[name] for start in starts]) for name in starts[0]}
    history, random = [], torch.Generator().manual_seed(1)
    for _ in range(iterations):
        rollout = collect(environment, goal.expand(seeds, 2), current, 20, random)
        history.append(episode_returns(rollout).mean(1))
        downhill = gradient(current, score(rollout))
        current = {name: value - rate * downhill[name] for name, value in current.items()}
    return torch.stack(history)


# %% tags=["live-reinforce-returns", "statistical", "tolerance:abs=5"]
def plain_returns(rollout):
    """Score every step by its normalised return."""
    returns = advantage.discounted_returns(rollout.rewards, 0.95)
    return rollout._replace(advantages=advantage.normalise(returns, rollout.mask))


plain_history = train(plain_returns)
first, plain_returns_late = plain_history[0], plain_history[-5:].mean(0)
assert (plain_returns_late > first + 50).all()
print(f"mean return at first {first.mean():.1f}, over the last five steps:")
print("by seed", ", ".join(f"{value:.1f}" for value in plain_returns_late))

# %% [markdown]
# ## 5 · A baseline and GAE
#
# $G_t$ is noisy: it blames or praises $a_t$ for everything that came after. Subtracting any function
# $V(s_t)$ of the state alone (or of state and time) leaves the expectation of the gradient as it is, since the expected score
# is zero. The paper's *baseline* is linear in a few features of state
# and time, fitted to the returns of each task by least squares (Appendix C):
#
# $$\zeta_{s,t} = \big(s,\; s \odot s,\; 0.01 t,\; (0.01 t)^2,\; (0.01 t)^3,\; 1\big), \qquad V(s_t) = w^\top \zeta_{s,t} .$$

# %% tags=["build-baseline"]
clock.at("a baseline and GAE")
features = advantage.baseline_features(untrained)  # (task, episode, time, 8)
returns = advantage.discounted_returns(untrained.rewards, 0.95)
design = features[0].reshape(-1, 8)
target = returns[0].reshape(-1, 1).double()
weights = torch.linalg.lstsq(design, target).solution  # least squares, no ridge
by_hand = (features[0] @ weights)[..., 0].float()
package = advantage.linear_baseline(untrained, discount=0.95)[0]
assert (by_hand - package).abs().max() < 1e-2 * returns.abs().max()  # the package adds a tiny ridge
explained = 1 - (returns[0] - package).var() / returns[0].var()
assert explained > 0.85
print(f"share of the returns' variance that the baseline explains: {explained:.2f}")

# %% [markdown]
# **By how much does it quieten the gradient?** Twenty batches of twenty episodes, all from the same untrained policy, give twenty estimates of the same
# gradient. Their deviation from their mean is the noise. We compare plain returns, returns less their mean (a *constant* baseline), and returns less the linear baseline.
#
# **Predict first.** Which share of the noise does the constant take out, and which the linear baseline?

# %% tags=["baseline-noise", "tolerance:0.05"]
batches = 20
same = {name: value.clone() for name, value in policy.per_task(params, batches).items()}
rollout = collect(environment, goal.expand(batches, 2), same, 20, random)
returns = advantage.discounted_returns(rollout.rewards, 0.95)  # (batch, episode, time)
baselines = {
    "no baseline": torch.zeros_like(returns),
    "a constant": returns.mean((1, 2), keepdim=True),
    "linear baseline": advantage.linear_baseline(rollout, discount=0.95),
}
noise_of = {}
for name, values in baselines.items():
    parts = gradient(same, rollout._replace(advantages=returns - values)).values()
    estimates = torch.cat([part.flatten(1) for part in parts], dim=1)  # (batch, parameter)
    centre = estimates.mean(0)
    noise_of[name] = float((estimates - centre).norm(dim=1).square().mean().sqrt())
    print(f"{name:15} noise {noise_of[name]:.2f}, mean gradient {centre.norm():.2f} long")
assert noise_of["a constant"] < 0.6 * noise_of["no baseline"]
assert noise_of["linear baseline"] < 0.6 * noise_of["a constant"]

# %% [markdown]
# The constant alone leaves about a third of the noise, and the linear baseline about a third of that; the mean gradient stays nearly as long as it was.
#
# *Generalised advantage estimation* (Schulman et al., 2016) goes one step further. With the residual
# $\delta_t = R_t + \gamma V(s_{t+1}) - V(s_t)$, it sums
#
# $$\hat A_t = \sum_{k \ge 0} (\gamma\lambda)^k\, \delta_{t+k} .$$
#
# With $\lambda = 1$ the values cancel in pairs and $\hat A_t = G_t - V(s_t)$; with $\lambda = 0$ it trusts the
# baseline after a single step. The paper's Table 1 calls $\lambda$ "GAE $\tau$" and sets it to 1.
#
# ### Exercise 4 · GAE
#
# *Difficulty 2 of 3, 10 minutes.* The value after the last step is 0.
#
# <details><summary>Hint 1: the sum looks familiar</summary>
# It is a discounted sum of the residuals with the discount $\gamma\lambda$: you have written that loop.
# </details>
#
# <details><summary>Hint 2: V of the next state</summary>
# Shift the values by one step in time and put a column of zeros at the end.
# </details>


# %% tags=["exercise-gae"]
def advantages(rewards, values, discount, gae_lambda):
    """Return the advantage estimates, (episode, time), from rewards and values of that shape."""
    ### BEGIN SOLUTION
    after_the_end = torch.zeros_like(values[:, :1])
    following = torch.cat([values[:, 1:], after_the_end], dim=1)  # V(s_{t+1})
    residuals = rewards + discount * following - values
    estimates = torch.zeros_like(rewards)
    running = torch.zeros_like(rewards[:, 0])  # (episode,)
    for time in reversed(range(rewards.shape[1])):
        running = residuals[:, time] + discount * gae_lambda * running
        estimates[:, time] = running
    return estimates
    ### END SOLUTION


# %%
if check.advantages(advantages):
    values = advantage.linear_baseline(untrained, discount=0.95)
    ours = advantages(untrained.rewards[0], values[0], 0.95, 1.0)
    package = advantage.generalised_advantage(untrained.rewards, values, 0.95, 1.0)[0]
    assert torch.allclose(ours, package, atol=1e-4)
    print("Your function gives the same numbers as emrld_lite.advantage.generalised_advantage.")

# %% [markdown]
# **Predict first.** Same seed, same number of gradient steps: will the baseline help a little, a lot,
# or not at all?


# %% tags=["live-baseline", "statistical", "tolerance:abs=5"]
def with_baseline(rollout):
    """Score every step by its normalised advantage over the linear baseline."""
    return advantage.Score(discount=0.95, gae_lambda=1.0)(rollout)


baseline_history = train(with_baseline)
lead = baseline_history[-5:].mean(0) - plain_returns_late  # (seed,)
figure, axes = plt.subplots(figsize=(5.4, 3.2))
looks = {"returns less their mean": (":", "#777777"), "less the linear baseline": ("-", "#0072B2")}
for (name, (line, colour)), history in zip(
    looks.items(), (plain_history, baseline_history), strict=True
):
    axes.plot(history.mean(1), linestyle=line, color=colour, label=name)
    low, high = history.amin(1), history.amax(1)
    axes.fill_between(range(len(history)), low, high, color=colour, alpha=0.15, linewidth=0)
axes.set(xlabel="gradient step", ylabel="mean return, dense reward")
axes.legend(loc="best")
plt.show()
early = (baseline_history - plain_history)[10]  # (seed,), after ten steps
assert lead.mean() > 1 and early.mean() > 15
for when, values in (("after ten steps", early), ("over the last five", lead)):
    each = ", ".join(f"{value:.1f}" for value in values)
    print(f"lead of the linear baseline {when}: {values.mean():.1f}; by seed {each}")

# %% [markdown]
# *Figure 3. Mean return of 20 episodes on one dense goal while five policies learn, with the linear baseline (solid) and with the mean as the only baseline
# (dotted): mean over the seeds, and the band from the lowest to the highest.*
#
# The linear baseline makes learning faster, not better: after ten steps it is far ahead, after forty a few units. Normalising has already subtracted the mean, which is a constant baseline,
# so the dotted curve is not the noisiest one could draw. From now on every RL loss in this workbook uses these advantages.

# %% [markdown]
# ## 6 · Behaviour cloning
#
# Sometimes somebody has already been where we want to go. A *demonstration* is a list of states and actions
# $\mathcal D^{\mathrm{dem}} = \{(s, a)\}$. *Behaviour cloning* makes these actions likely (Section 3):
#
# $$\mathcal L^{\mathrm{BC}}(\theta) = -\!\!\sum_{(s,a) \in \mathcal D^{\mathrm{dem}}} \log \pi_\theta(a \mid s) .$$
#
# It is a plain supervised loss: no reward, no rollout. We fit one policy to each of the workbook's twelve
# demonstrated trajectories, all twelve at once: their parameters carry a task axis. We do so for the optimal trajectories and
# for the sub-optimal ones, which are noisy and *stop before the region where the reward is paid*.
#
# **Predict first.** The demonstrator of the optimal trajectories earns a return of about 80 (it needs some 20 of the 100
# steps, and the remaining ones are paid out at the goal). What will the twelve clones earn on average: 80, 60, 40? And what does a clone do where its demonstration ends: stop, turn, go on?


# %% tags=["live-cloning"]
def clone(demos, steps=400, rate=3e-3):
    """Return task_params fitted to one demonstration each by Adam, and the loss after each step."""
    start = policy.per_task(policy.initialise(2, 2, seed=0), len(demos.tasks))
    leaves = {name: value.clone().requires_grad_() for name, value in start.items()}
    optimiser = torch.optim.Adam(leaves.values(), lr=rate, fused=True)  # faster, same formula
    history = []
    for _ in range(steps):
        loss = losses.bc_loss(leaves, demos).sum()  # (task,) summed: tasks do not touch each other
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        history.append(float(loss.detach()))
    return policy.detach(leaves), history


clock.at("behaviour cloning")
sparse = make("point2d")
rollouts, returns = {}, {}
for quality in ("optimal", "suboptimal"):
    demos = load_demonstrations(quality, "point2d")
    cloned, history = clone(demos)
    assert history[-1] < history[0]
    rollouts[quality] = collect(sparse, demos.tasks, cloned, 20, random)
    returns[quality] = float(episode_returns(rollouts[quality]).mean())
ours, package = clone(demos, steps=20)[0], cloning.clone(demos, steps=20)
assert all(torch.allclose(ours[name], package[name]) for name in ours)

# %% tags=["cloning-returns", "statistical", "tolerance:abs=4"]
figure, panels = plt.subplots(1, 2, figsize=(7.4, 4.2), sharey=True)
task = 5
for axes, quality in zip(panels, rollouts, strict=True):
    demos = load_demonstrations(quality, "point2d")
    sparse.draw_tasks(axes, demos.tasks[task : task + 1])
    plotting.trajectories(rollouts[quality], axes, task=task, episodes=20)
    plotting.demonstration(demos.states[task, 0, : int(demos.lengths()[task])], axes)
    axes.set(title=f"{quality}: mean return {returns[quality]:.0f}", xlim=(-4, 4), ylim=(-1, 10))
plt.show()
assert returns["suboptimal"] + 10 < returns["optimal"] < 70
for quality, earned in returns.items():
    print(f"clones of {quality} trajectories: mean return {earned:.1f}")

# %% tags=["clones-run-past", "statistical", "tolerance:abs=8"]
for quality, rollout in rollouts.items():
    taken = rollout.mask == 1  # (task, episode, time)
    gaps = (rollout.states - sparse.training_tasks()[:, None, None]).norm(dim=-1)
    near = gaps.masked_fill(~taken, torch.inf).amin(-1) < 0.2  # (task, episode)
    past = rollout.states.norm(dim=-1).amax(-1) > 2.2  # farther out than the disc reaches
    assert near.float().mean() > 0.8
    assert past.float().mean() > 0.8 if quality == "suboptimal" else past.float().mean() < 0.75
    entered, left = (100 * share.float().mean() for share in (near, past))
    print(
        f"{quality:10} {entered:5.1f} % of the episodes enter the disc, {left:5.1f} % run past it"
    )
slowing = {}
for quality in rollouts:
    demos = load_demonstrations(quality, "point2d")
    last = demos.actions[range(12), 0, demos.lengths() - 1]  # (task, action)
    slowing[quality] = float(last.norm(dim=-1).mean())
    print(f"{quality:10} last demonstrated action: {slowing[quality]:.2f} of a full step long")
assert slowing["optimal"] < 0.6 < 0.8 < slowing["suboptimal"]

# %% [markdown]
# *Figure 4. Twenty episodes (thin lines) of a policy cloned from one demonstration (dashed), for one of the twelve goals
# (star) and its reward region (disc). Titles: mean sparse return over all twelve clones.*
#
# Both find the region that pays, and both earn less than the demonstrator, because they do not stop there. Beyond the goal there are no data, and a network continues what it has learned:
# it drives on. The optimal demonstration at least slows down at its end, and about half of its clones' episodes stay. The sub-optimal one ends at full speed, and nearly all of its clones' episodes run
# straight through and away. (The clones also act with noise of their own; notebook 03 separates the two causes.) Cloning knows only *one* goal: move the star and the
# policy is lost. EMRLD meta-trains a policy so that a single gradient step, with one demonstration per goal, is enough (notebook 06).

# %% [markdown]
# ## Where paper and code differ
#
# | point | paper | released code | this workbook |
# |---|---|---|---|
# | $\sigma$ | fixed | learned, starts at 1 | learned by default; `--no-learn-sigma` keeps it at 1 |
# | log-density in the losses | of the joint action | averaged over action dimensions | joint in this notebook; averaged in the adaptation, `--log-density joint` for the paper's |
# | $\gamma^t$ in the policy gradient | not written | dropped | dropped |
# | BC loss | sum over the data | mean | mean by default; `--bc-reduction sum` |
# | baseline | printed as $B = \zeta^\top G$, with $G$ the return | least squares | $V = w^\top \zeta$, with $w$ fitted to the returns |
# | baseline's time | time index | index over all episodes in a row | time within the episode |
#
# In all of them the mathematics stays what you have just derived; what changes is the size of a step, how much late steps count, or, in the last
# row, what the baseline can explain. `data/paper_ledger.toml` lists each of them with what was measured.

# %% [markdown]
# ## What was shown
#
# - A Gaussian policy is a network for the mean and a $\log\sigma$; its log-density is a sum over dimensions.
# - REINFORCE needs only rewards and scores; finite differences gave the same number, as long as $\gamma^t$ stays in.
# - A constant baseline leaves about a third of the gradient's noise, the linear one about a third of that; GAE trades noise against trust in the baseline.
# - Cloning follows a demonstration, for its own goal only, and drives on where the demonstration ends.
#
# **Next** notebook 06 adapts one policy to twelve goals with these two losses together.
#
# **References** Williams (1992), *Simple statistical gradient-following algorithms*; Schulman et al. (2016),
# *High-dimensional continuous control using generalized advantage estimation*; Duan et al. (2016),
# *Benchmarking deep reinforcement learning for continuous control* (the linear baseline).
