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
# - write the log-density of a Gaussian policy, and train and clone policies with it,
# - derive the REINFORCE gradient with a pencil, and check it against a number it cannot have copied,
# - design an experiment that measures how noisy a gradient is, and judge what a baseline is worth,
# - clone a demonstrated path, and say what the clone does at the path's end.
#
# **You need** calculus, a little probability, and Python with tensors. **Time** planned: 90 minutes, the exercises included,
# and 20 more of further reading (section 7); all computing together takes about two minutes on two cores. **Paper** Section 2 (Preliminaries) and
# Appendix C (Experimental Setup) of Rengarajan et al., *Enhanced Meta Reinforcement Learning using
# Demonstrations in Sparse Reward Environments*, NeurIPS 2022.
#
# What you write, you use: your log-density, your returns and your experiment produce the figures below. Until yours is right, the workbook's own steps in.

# %%
import math

import matplotlib.pyplot as plt
import torch

from emrld_lite import advantage, losses, policy
from emrld_lite.classroom import checks as check
from emrld_lite.classroom import noise
from emrld_lite.classroom.clock import Clock
from emrld_lite.classroom.predict import Guesses
from emrld_lite.classroom.sketches.causality import what_an_action_changes
from emrld_lite.classroom.widgets import exploration, gae
from emrld_lite.demonstrations import load_demonstrations
from emrld_lite.demonstrators import cloning
from emrld_lite.envs import make
from emrld_lite.envs.point2d import STEP_LIMIT, displacement
from emrld_lite.experiments import plotting
from emrld_lite.rollout import collect, episode_returns

# %%
plotting.use_style()
torch.set_num_threads(1)
guess = Guesses()
clock = Clock(
    {
        "a policy is a distribution": 12,
        "the mean is a network": 5,
        "episodes and returns": 13,
        "the REINFORCE gradient": 28,
        "a baseline": 22,
        "behaviour cloning": 10,
    },
    further={"generalised advantage estimation": 20},
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
# $a = (a_1, a_2)$ to $[-1, 1]$ and then shortens a move that is longer than 0.1. With $\mu = 0$ and $\sigma = 1$, which share of the drawn
# actions does it alter?

# %%
clock.at("a policy is a distribution")
guess.ask("altered", "share of the drawn actions that are altered, %")

# %% tags=["reveal"]
random = torch.Generator().manual_seed(0)
drawn = torch.randn(10_000, 2, generator=random)  # (sample, action), mu = 0 and sigma = 1
moves = displacement(drawn, "at-most")  # what the environment makes of them
altered = float(((moves - STEP_LIMIT * drawn).norm(dim=1) > 1e-6).float().mean())
exact = exploration.altered_share(1.0)
assert abs(exact - math.exp(-0.5)) < 1e-9 and abs(altered - exact) < 0.03
guess.reveal("altered", f"{100 * altered:.0f} % of these draws, {100 * exact:.1f} % of all")

# %% tags=["reveal"]
figure, axes = plt.subplots(figsize=(4.2, 3.6))
axes.scatter(*drawn[:1500].T, s=4, alpha=0.4, color="#56B4E9", label="drawn actions")
turn = torch.linspace(0, 2 * torch.pi, 200)
axes.plot(turn.cos(), turn.sin(), color="black", linewidth=1.2, label="what the robot can do")
axes.set(xlabel="action $a_1$ (units of 0.1 length)", ylabel="action $a_2$ (units of 0.1 length)")
axes.set_aspect("equal")
axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
plt.show()

# %% [markdown] tags=["reveal"]
# *Figure 1. Actions drawn with $\sigma = 1$ (dots) and the disc of the moves that the robot can make (circle): most of the dots lie outside of it.*
#
# An action is altered when it lies outside of the disc of radius 1, and the length of two independent standard normal components is above 1 with probability $e^{-1/2}$.
# We keep the action *as drawn*: its density is a Gaussian's, which the altered action's is not, and densities are what gradients need. Clipping and shortening
# happen inside the environment.

# %% [markdown]
# ### Exercise 1 · The log-density of a joint action
#
# *Difficulty 1 of 3, planned for 5 minutes.* One dimension has the density
# $\frac{1}{\sigma\sqrt{2\pi}} \exp\!\big(-\frac{(a-\mu)^2}{2\sigma^2}\big)$. Write the **logarithm** of
# the density of the whole action. You get $\log\sigma$ rather than $\sigma$: any real number is then
# a valid parameter. Stay in torch: sections 4 to 6 differentiate what you write.
#
# <details><summary>Hint 1: I do not know where to start</summary>
# Take the logarithm of the one-dimensional density: it has three terms.
# </details>
#
# <details><summary>Hint 2: my numbers have one axis too many</summary>
# Independent dimensions multiply their densities. What does the logarithm make of a product?
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
checked = check.log_density(log_density)


def package_density(mean, log_sigma, actions):
    """Return the same numbers by the package, which keeps mean and log sigma together."""
    return policy.log_density(policy.Gaussian(mean, log_sigma), actions)


density = log_density if checked else package_density  # until yours is right, the package's
given = torch.zeros(3, 2), torch.ones(3, 2), drawn[:3]
print("density:", [f"{float(value):.3f}" for value in density(*given)])
print("package:", [f"{float(value):.3f}" for value in package_density(*given)])
assert check.agree(density(*given), package_density(*given))

# %% [markdown]
# A sum over the dimensions, since the logarithm of a product is a sum. Wherever a log-density is needed in this notebook, `density` is called: yours.
#
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
apart = (network_mean(params, states) - package).abs().max()
assert apart < 1e-6
print(f"largest difference from emrld_lite.policy.mean: {apart:.5f}")

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
# $d_{t+1}$ is the distance to the goal after the step. The sparse reward of the paper comes in section 6.
#
# **Predict first.** How far from the start is an untrained policy after 100 steps, on average? And if $\sigma$ were ten times as large?

# %%
clock.at("episodes and returns")
guess.ask("distance", "mean distance from the start after 100 steps, length units")
guess.ask("wider", "with sigma 10", ["ten times as far", "about three times", "hardly farther"])

# %% tags=["reveal", "tolerance:abs=0.05"]
environment = make("point2d", reward="dense")
goal = torch.tensor([[0.0, 2.0]])  # (task, 2): one task
untrained = collect(environment, goal, params, episodes=20, random=random)
for name in ("states", "actions", "rewards", "mask"):
    print(f"{name:8} {tuple(getattr(untrained, name).shape)}")
distance = float(untrained.states[0, :, -1].norm(dim=-1).mean())
ends = exploration.measured_spread(params)
spread = dict(zip(ends.sigmas, ends.distances, strict=True))
assert distance < 1.2 and spread[10.0] < 1.3 * spread[1.0]
guess.reveal("distance", f"{distance:.2f}; the goal is 2 away")
wide, usual = spread[10.0], spread[1.0]
guess.reveal("wider", f"the ends of the paths scatter by {wide:.2f}, with sigma 1 by {usual:.2f}")

# %% [markdown]
# **Turn it yourself.** The slider sets $\sigma$; the policy's mean and the random draws stay. What becomes of the paths when $\sigma$ is tiny? Why does a huge $\sigma$ not help?

# %% tags=["nbval-ignore-output"]
exploration.exploration_sliders(params, ends)

# %% tags=["reveal"]
exploration.exploration_picture(params, ends, sigma=1.0)

# %% [markdown] tags=["reveal"]
# *Figure 2. Left: twenty episodes of the untrained policy (lines), the start (cross), a goal (star) and the region around it in which the paper's sparse reward is paid (disc). Right: how far the paths' ends scatter (solid: formula, dots: measured) and which share of the actions is altered (dotted), for every $\sigma$; the dashed line is the $\sigma$ of the left panel. The scatter stops growing where nearly all actions are altered.*
#
# A hundred steps of length $\ell$ in independent directions lead $10\,\ell$ away, not $100\,\ell$: variances add, distances do not. A step is never longer than 0.1, so the scatter is never above 1, whatever $\sigma$ is.
# A large $\sigma$ therefore only makes the direction random; a tiny one makes all paths the same, wherever the mean happens to lead. No $\sigma$ takes the robot to the goal. But some paths end nearer to it than others, and that difference is all
# that a policy gradient needs.

# %% [markdown]
# ### Exercise 2 · Discounted returns
#
# *Difficulty 1 of 3, planned for 5 minutes.* The *return* from time $t$ is the discounted sum of the rewards still
# to come, $G_t = \sum_{k \ge t} \gamma^{k-t} R_k$, with the discount $\gamma < 1$ (0.95 in the paper's Table 1). Make it for all steps of all episodes, without a double loop over time.
#
# <details><summary>Hint 1: a double loop feels clumsy</summary>
# How does $G_t$ follow from $G_{t+1}$?
# </details>
#
# <details><summary>Hint 2: where do I begin?</summary>
# At the end: after the last step nothing is to come. Walk backwards in time, all episodes at once.
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
checked = check.discounted_returns(discounted_returns)


def package_returns(rewards, discount):
    """Return the same by the package, which wants a leading task axis."""
    return advantage.discounted_returns(rewards[None], discount)[0]


returns_to_go = discounted_returns if checked else package_returns


def returns_of(rollout):
    """Return G_t of every step, (task, episode, time), by your function; gamma = 0.95."""
    flat = torch.as_tensor(returns_to_go(rollout.rewards.flatten(0, 1), 0.95)).float()
    return flat.reshape(rollout.rewards.shape)


package = advantage.discounted_returns(untrained.rewards, 0.95)
assert check.agree(returns_of(untrained), package)
print(f"mean return from the start: {returns_of(untrained)[..., 0].mean():.2f}")
print(f"the package's:              {package[..., 0].mean():.2f}")

# %% [markdown]
# ## 4 · The REINFORCE gradient
#
# We want $\nabla_\theta J(\theta)$, where $J(\theta) = \mathbb E_{\tau \sim p_\theta}[G(\tau)]$ is the expected
# return of a trajectory $\tau = (s_0, a_0, s_1, a_1, \dots)$ and $G(\tau) = \sum_t \gamma^t R_t$. The trajectory has the density
#
# $$p_\theta(\tau) = \rho(s_0)\, \prod_t \pi_\theta(a_t \mid s_t)\, P(s_{t+1} \mid s_t, a_t),$$
#
# with $\rho$ the start and $P$ the dynamics, neither of which we know. The difficulty: $\theta$ sits in the *distribution*, not in $G$.

# %%
clock.at("the REINFORCE gradient")
what_an_action_changes()
plt.show()

# %% [markdown]
# *Figure 3. One episode of five steps. The parameters $\theta$ act only where an action is drawn (blue boxes). When $a_2$ is drawn, the rewards before it are already there; it can change only its own and the later ones.*
#
# ### Exercise 3 · REINFORCE with a pencil
#
# *Difficulty 3 of 3, planned for 15 minutes, on paper.* The gradient $\nabla_\theta \log \pi_\theta(a \mid s)$ is called the **score**.
#
# 1. Show that $\nabla_\theta J = \mathbb E_\tau\big[G(\tau)\, \nabla_\theta \log p_\theta(\tau)\big]$. Why is it worth turning the integral into an expectation?
# 2. Which factors of $p_\theta(\tau)$ are left in $\nabla_\theta \log p_\theta(\tau)$?
# 3. Show that the expected score is zero in every state: $\mathbb E_{a \sim \pi_\theta(s, \cdot)}\big[\nabla_\theta \log \pi_\theta(a \mid s)\big] = 0$.
# 4. Now the expectation holds products of one reward $\gamma^k R_k$ and one score, that of step $t$. Which of them vanish, and by which of your results?
# 5. Collect what is left for the score of step $t$ and write it with $G_t$. What stands in front of $G_t$?
#
# <details><summary>Hint 1: a gradient of a density is no expectation</summary>
# Divide and multiply by the density: which function has the derivative $\nabla p / p$?
# </details>
#
# <details><summary>Hint 2: the expected score</summary>
# Write it as an integral, and use the same step backwards. What does a density integrate to, whatever $\theta$ is?
# </details>
#
# <details><summary>Hint 3: which products vanish</summary>
# Take the expectation in two stages: first over $a_t$ with everything up to $s_t$ held fixed. Figure 3 shows which rewards are then constants.
# </details>
#
# <details><summary>Solution, all five steps</summary>
#
# **1.** $\nabla J = \nabla \int G(\tau)\, p_\theta(\tau)\, d\tau = \int G(\tau)\, \nabla p_\theta(\tau)\, d\tau$, since $G(\tau)$ does not depend on $\theta$ (for Gaussians derivative and integral may be exchanged). With $\nabla p = p\, \nabla \log p$ this is $\int p_\theta(\tau)\, G(\tau)\, \nabla \log p_\theta(\tau)\, d\tau$, an expectation. An expectation can be estimated by a mean over trajectories that we drew; an integral over $\nabla p$ cannot.
#
# **2.** The logarithm of the product is a sum, and neither $\log\rho(s_0)$ nor $\log P(s_{t+1} \mid s_t, a_t)$ contains $\theta$: $\nabla \log p_\theta(\tau) = \sum_t \nabla \log \pi_\theta(a_t \mid s_t)$. The unknown dynamics are gone.
#
# **3.** $\int \pi_\theta(a \mid s)\, \nabla \log \pi_\theta(a \mid s)\, da = \int \nabla \pi_\theta(a \mid s)\, da = \nabla \int \pi_\theta(a \mid s)\, da = \nabla 1 = 0$.
#
# **4.** Take $k < t$. Given everything up to $s_t$, the reward $R_k$ is a constant, and only $a_t$ is still to be drawn: $\mathbb E\big[\gamma^k R_k \nabla \log \pi_\theta(a_t \mid s_t)\big] = \mathbb E\big[\gamma^k R_k\, \mathbb E[\nabla \log \pi_\theta(a_t \mid s_t) \mid s_t]\big] = 0$ by step 3. For $k \ge t$ the reward depends on $a_t$, and the product stays.
#
# **5.** What is left for step $t$ is $\sum_{k \ge t} \gamma^k R_k = \gamma^t \sum_{k \ge t} \gamma^{k-t} R_k = \gamma^t G_t$. Together:
# $$\nabla_\theta J = \mathbb E_\tau\Big[\sum_t \gamma^t\, G_t\, \nabla_\theta \log \pi_\theta(a_t \mid s_t)\Big].$$
# The factor $\gamma^t$ is there because $G(\tau)$ discounts from the start and $G_t$ from time $t$ on.
# </details>

# %% tags=["score-is-zero", "tolerance:abs=0.002"]
mean = torch.full((100_000, 1), 0.3, requires_grad=True)
log_sigma = torch.full_like(mean, -0.5)
drawn = mean.detach() + log_sigma.exp() * torch.randn(mean.shape, generator=random)
(scores,) = torch.autograd.grad(density(mean, log_sigma, drawn).sum(), mean)
error = scores.std() / len(scores) ** 0.5
assert abs(scores.mean()) < 5 * error
print(f"mean score, by your log-density: {scores.mean():.4f}, its standard error {error:.4f}")
print(f"a single score is about {scores.std():.2f} long")

# %% [markdown]
# Step 3 in numbers: single scores are large, their mean is zero within its error.
#
# ### Exercise 4 · The gradient from one episode
#
# *Difficulty 2 of 3, planned for 8 minutes.* A problem of one state: in each step the action is drawn from $\mathcal N(\mu, \sigma^2)$, and $\mu$ is the only parameter. Write what your derivation makes of one episode:
# its estimate of $dJ/d\mu$. Find the score with a pencil, without automatic differentiation.
#
# <details><summary>Hint 1: the score</summary>
# Only one of the three terms of $\log \mathcal N(a; \mu, \sigma)$ contains $\mu$.
# </details>
#
# <details><summary>Hint 2: one number per episode</summary>
# Every step of the episode has its own score, its own weight and its own place in time; the trajectory's log-density adds them.
# </details>


# %% tags=["exercise-policy-gradient"]
def policy_gradient(actions, returns, mean, sigma, discount):
    """Return each episode's estimate of dJ/dmu, (episode,), from actions and G_t, (episode, time)."""
    ### BEGIN SOLUTION
    score = (actions - mean) / sigma**2
    factor = discount ** torch.arange(actions.shape[1])  # (time,)
    return (factor * returns * score).sum(1)
    ### END SOLUTION


# %%
checked = check.policy_gradient(policy_gradient)

# %% [markdown]
# **Predict first.** Two steps, the reward $-(a_t - 1)^2$ in each, $\gamma = 0.5$, $\mu = 0$ and $\sigma = 1$. Then $J(\mu) = -(1 + \gamma)\big((\mu - 1)^2 + 1\big)$, and the exact gradient is $2 (1 + \gamma) = 3$.
# Nearly all code, the paper's and ours included, leaves the factor $\gamma^t$ out. What does the estimate come to without it?

# %%
guess.ask("dropped", "the estimate without gamma^t, where the exact gradient is 3")

# %% tags=["reveal", "reinforce-finite-differences", "tolerance:abs=0.01"]
noise_drawn = torch.randn(1_000_000, 2, generator=random)  # (episode, time): the actions at mu = 0
step = 1e-2


def objective(mu, horizon):
    """Return the mean discounted return over actions mu + noise."""
    rewards = -((mu + noise_drawn[:, :horizon] - 1) ** 2)
    return (rewards * 0.5 ** torch.arange(horizon)).sum(1).mean()


for horizon, exact in ((1, 2.0), (2, 3.0)):
    finite = (objective(step, horizon) - objective(-step, horizon)) / (2 * step)
    assert abs(finite - exact) < 0.05
    print(f"{horizon} step(s): exact {exact:.2f}, finite differences {finite:.2f}", end="")
    if checked:
        actions = noise_drawn[:, :horizon]
        to_go = torch.as_tensor(returns_to_go(-((actions - 1) ** 2), 0.5)).float()
        yours = [policy_gradient(actions, to_go, 0.0, 1.0, factor) for factor in (0.5, 1.0)]
        with_it, without = (float(torch.as_tensor(each).mean()) for each in yours)
        print(f", yours {with_it:.2f}, yours without gamma^t {without:.2f}", end="")
    print()

# %% tags=["reveal", "dropped-factor", "tolerance:abs=0.01"]
if checked:
    print(f"of a single episode's estimate the deviation is {torch.as_tensor(yours[0]).std():.2f}")
    assert abs(with_it - 3.0) < 0.06 and abs(without - 4.0) < 0.06, "see the line above"
guess.reveal("dropped", f"{2.0 * horizon:.1f}, since both steps count alike")

# %% [markdown] tags=["reveal"]
# Finite differences moved $\mu$ and looked at the rewards again. REINFORCE never differentiated the reward: it only asked how much more likely each action would
# become. That is why it is also *defined* where the reward is a black box, or zero nearly everywhere. Whether it is of any *use* there is
# another question; notebook 02 shows that it is exactly zero as long as no episode is rewarded.
#
# Without $\gamma^t$ the second step counts as much as the first, and the sum is no longer the gradient of $J$. Here only its length
# changes; in a policy whose parameters act at different times the direction changes as well. With $\gamma = 0.95$ the factor would weigh the steps after the first 90
# less than a hundredth, and we want a policy that acts well late, too. From here on we drop it, as the released code does, and call the result the *policy gradient* all the same.
#
# The deviation of one episode's estimate is more than twice the gradient. Section 5 is about that.

# %% [markdown]
# ### From the gradient to a loss
#
# With ten thousand parameters nobody finds scores with a pencil. Automatic differentiation wants a *loss*; the one below has minus the policy gradient as its gradient, if the `weights` are the returns $G_t$.
# It is a mean over the steps that were taken: episodes end at different times but share one tensor, and `mask` is 0 for the padding after an episode's end.


# %% tags=["loss-of-weights"]
def loss_of(leaves, data, weights):
    """Return -mean(log pi * weights) over the steps taken, summed over tasks, by your log-density."""
    gaussian = policy.distribution(leaves, data.states)
    log_probs = density(gaussian.mean, gaussian.log_sigma, data.actions)  # (task, episode, time)
    return -losses.task_mean(log_probs * weights, data.mask).sum()


def uphill(at, data, weights):
    """Return minus the gradient of ``loss_of``, a dict like ``at``."""
    leaves = policy.detach(at, requires_grad=True)
    slopes = torch.autograd.grad(loss_of(leaves, data, weights), list(leaves.values()))
    return {name: -slope for name, slope in zip(leaves, slopes, strict=True)}


scored = untrained._replace(advantages=returns_of(untrained))
ours, package = loss_of(params, scored, scored.advantages), losses.rl_loss(params, scored)[0]
assert check.agree(ours, package)
print(
    f"loss by your log-density and returns: {float(ours):.3f}; the package's: {float(package):.3f}"
)

# %% [markdown]
# ## 5 · A baseline
#
# $G_t$ is noisy: it blames or praises $a_t$ for everything that came after. Subtracting any function
# $V(s_t)$ of the state (or of state and time) leaves the expectation of the gradient as it is, since it multiplies a score whose expectation is zero (your step 3). The paper's *baseline* is linear in a few features of state
# and time, fitted to the returns of each task by least squares (Appendix C; $\odot$ multiplies component by component):
#
# $$\zeta_{s,t} = \big(s,\; s \odot s,\; 0.01 t,\; (0.01 t)^2,\; (0.01 t)^3,\; 1\big), \qquad V(s_t) = w^\top \zeta_{s,t} .$$

# %% tags=["build-baseline"]
clock.at("a baseline")
features = advantage.baseline_features(untrained)  # (task, episode, time, 8)
returns = returns_of(untrained)
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
# ### Exercise 5 · By how much is the gradient quieter?
#
# *Difficulty 3 of 3, planned for 12 minutes.* Design the experiment. You can draw as many batches of episodes as you like, all from the same policy; `estimate` turns a batch and the values to subtract from its returns into one estimate of the gradient. The
# **noise** of an estimate is the root of the mean squared distance of the estimates from their own mean, where the squared distance is the sum over the parameters.
# Compare several baselines such that nothing but the baseline differs between them.
#
# <details><summary>Hint 1: what may differ?</summary>
# If two baselines see different batches, is a difference the baselines' or the batches'?
# </details>
#
# <details><summary>Hint 2: one batch gives one estimate</summary>
# An estimate is a vector. Collect one per batch and baseline, `torch.stack` them, and only then ask how far they lie apart.
# </details>
#
# <details><summary>Hint 3: why hand back the estimates, too?</summary>
# A baseline that made the gradient quiet by making it wrong would show in their mean. An experiment should be able to find that out.
# </details>


# %% tags=["exercise-compare-baselines"]
def compare_baselines(draw, estimate, baselines, batches):
    """Return {name: (estimates (batch, parameter), noise)} for the named baselines.

    draw() -> a new batch; baselines[name](batch) -> values; estimate(batch, values) -> (parameter,).
    """
    ### BEGIN SOLUTION
    estimates = {name: [] for name in baselines}
    for _ in range(batches):
        batch = draw()  # the same for every baseline
        for name, baseline in baselines.items():
            estimates[name].append(estimate(batch, baseline(batch)))
    found = {}
    for name, several in estimates.items():
        stacked = torch.stack(several)
        distances = (stacked - stacked.mean(0)).square().sum(1)  # (batch,), squared
        found[name] = (stacked, distances.mean().sqrt())
    return found
    ### END SOLUTION


# %%
checked = check.compare_baselines(compare_baselines)
experiment = compare_baselines if checked else noise.compare_baselines

# %% [markdown]
# Three baselines: nothing, a constant (the mean of the batch's returns), and the linear one. Each batch has twenty episodes of the untrained policy, and the whole experiment runs three times with other draws.
#
# **Predict first.** Which share of the noise does the constant leave, and which the linear baseline?

# %%
guess.ask("constant", "noise left by the constant, % of the noise without a baseline")
guess.ask("linear", "noise left by the linear baseline, %")


# %% tags=["baselines"]
def nothing(rollout):
    """Return zeros, (task, episode, time)."""
    return torch.zeros_like(rollout.rewards)


def constant(rollout):
    """Return the mean of each task's returns at every step."""
    means = losses.task_mean(returns_of(rollout), rollout.mask)  # (task,)
    return means[:, None, None].expand_as(rollout.rewards)


def linear(rollout):
    """Return the linear baseline, fitted to each task's returns."""
    return advantage.linear_baseline(rollout, discount=0.95)


def estimate(batch, values):
    """Return the gradient of the untrained policy's J by one batch, (parameter,)."""
    return policy.to_vector(uphill(params, batch, returns_of(batch) - values))


# %% tags=["reveal", "baseline-noise", "tolerance:0.05"]
baselines = {"no baseline": nothing, "a constant": constant, "linear": linear}
runs = []
for seed in (1, 2, 3):
    draws = torch.Generator().manual_seed(seed)
    runs.append(
        experiment(
            lambda g=draws: collect(environment, goal, params, 20, g), estimate, baselines, 20
        )
    )
left = {name: [float(run[name][1] / run["no baseline"][1]) for run in runs] for name in baselines}
for name, shares in left.items():
    lengths = [float(torch.as_tensor(run[name][0]).mean(0).norm()) for run in runs]
    print(f"{name:12} noise left:", ", ".join(f"{100 * share:.1f} %" for share in shares), end="; ")
    print("mean gradient", ", ".join(f"{length:.2f}" for length in lengths), "long")
assert max(left["a constant"]) < 0.6 and max(left["linear"]) < 0.5 * min(left["a constant"])
guess.reveal("constant", f"{100 * sum(left['a constant']) / 3:.1f} %")
guess.reveal("linear", f"{100 * sum(left['linear']) / 3:.1f} %")

# %% tags=["reveal"]
noise.clouds(runs[0])
plt.show()

# %% [markdown] tags=["reveal"]
# *Figure 4. Twenty estimates of the same gradient (dots) and their mean (cross) under three baselines, seen in one plane: along the mean gradient (arrow) and in the direction in which they scatter most. The clouds shrink from left to right; their centres stay.*
#
# **How to judge it.** The constant leaves about two fifths of the noise, the linear baseline about an eighth. The three repetitions differ by far less than the baselines do, so the order is no luck. The clouds' centres agree within
# their scatter divided by $\sqrt{20}$: the baselines changed the noise, not the gradient. (Strictly, the constant and the linear baseline are fitted to the very returns that they are subtracted from, which shortens the expected estimate a little: with episodes of a single step by one part in their number.)
#
# Why does a mere constant help that much? All rewards are negative, so without it *every* action is discouraged, the good ones a little less. With twenty episodes the discouragements cancel only roughly.

# %% [markdown]
# ### What is a quiet gradient worth?
#
# Here is the whole algorithm: collect, weigh, step, with your log-density and your returns. Five policies learn under each of the three baselines. All weights are divided by the same number, the deviation of the returns, so that the *expected* step
# is the same under all three, and only the noise differs.


# %% tags=["live-reinforce"]
def weights_of(rollout, seeds):
    """Return (G - V) / deviation of G; the tasks are ``seeds`` policies per baseline, in order."""
    parts = [rollout.take(slice(k * seeds, (k + 1) * seeds)) for k in range(len(baselines))]
    values = [baseline(part) for baseline, part in zip(baselines.values(), parts, strict=True)]
    returns = returns_of(rollout)
    deviation = losses.task_mean((returns - constant(rollout)).square(), rollout.mask).sqrt()
    return (returns - torch.cat(values)) / deviation[:, None, None]


def train(rate, seeds=5, iterations=40):
    """Return mean returns, (iteration, baseline, seed), of policies that learn with steps of ``rate``."""
    starts = [policy.initialise(2, 2, seed=seed) for _ in baselines for seed in range(seeds)]
    current = {name: torch.stack([start[name] for start in starts]) for name in starts[0]}
    history, random = [], torch.Generator().manual_seed(1)
    for _ in range(iterations):
        rollout = collect(environment, goal.expand(len(starts), 2), current, 20, random)
        history.append(episode_returns(rollout).mean(1))
        step = uphill(current, rollout, weights_of(rollout, seeds))
        current = {name: value + rate * step[name] for name, value in current.items()}
    return torch.stack(history).unflatten(1, (len(baselines), seeds))


# %% [markdown]
# **Predict first.** The policies take forty steps, once short ones (rate 0.05) and once twelve times as long. How far ahead of no baseline does the linear one end with the short steps? And who falls behind with the long ones?

# %%
guess.ask("short", "short steps: lead of the linear baseline at the end, units of return")
guess.ask("long", "long steps: who falls behind?", ["nobody", "no baseline", "all but the linear"])

# %% tags=["reveal", "live-reinforce-returns", "statistical", "tolerance:abs=25"]
histories = {rate: train(rate) for rate in (0.05, 0.6)}  # (iteration, baseline, seed)
for rate, history in histories.items():
    print(f"rate {rate}: {history[0].mean():.1f} at first; mean return over all steps", end=" ")
    print("(the middle one of five policies):")
    for name, middle in zip(baselines, history.mean(0).median(-1).values, strict=True):
        print(f"  {name:12} {middle:.1f}")
ends_short = histories[0.05][-5:].mean(0).median(-1).values  # (baseline,)
whole_long = histories[0.6].mean(0).median(-1).values
assert ends_short.max() - ends_short.min() < 8
assert whole_long[1] - whole_long[0] > 8 and whole_long[2] - whole_long[0] > 8
guess.reveal("short", f"{ends_short[2] - ends_short[0]:.1f} of about 100 that were learned")
behind = ", ".join(f"{name} {value:.1f}" for name, value in zip(baselines, whole_long, strict=True))
guess.reveal("long", f"return over the training: {behind}")

# %% tags=["reveal"]
figure, panels = plt.subplots(1, 2, figsize=(8.4, 3.4), sharey=True)
looks = {
    "no baseline": (":", "#D55E00"),
    "a constant": ("--", "#777777"),
    "linear": ("-", "#0072B2"),
}
for axes, (rate, history) in zip(panels, histories.items(), strict=True):
    for place, (name, (line, colour)) in enumerate(looks.items()):
        each = history[:, place]  # (iteration, seed)
        axes.plot(each.median(1).values, linestyle=line, color=colour, label=name)
        low, high = each.amin(1), each.amax(1)
        axes.fill_between(range(len(each)), low, high, color=colour, alpha=0.15, linewidth=0)
    axes.axhline(-150, color="black", linewidth=0.6)
    axes.set(xlabel="gradient step", title=f"steps of rate {rate}", ylim=(-300, -40))
panels[0].set_ylabel("mean return, dense reward")
panels[0].legend(loc="lower right")
plt.show()

# %% [markdown] tags=["reveal"]
# *Figure 5. Mean return while five policies learn under each baseline, with short steps (left) and with steps twelve times as long (right): the middle one of the five, and bands from the lowest to the highest (cut at −300). The thin line marks a return of −150. On the left the curves lie on each other; on the right the dotted one falls behind, and its band is wide.*

# %% [markdown]
# ### Exercise 6 · Read Figure 5
#
# *Difficulty 1 of 3, planned for 5 minutes.* Read the first two off the figure, and choose a sentence for the third.
#
# 1. Left: how far apart are the three curves at step 20?
# 2. After how many steps does the curve of the linear baseline first lie above −150, left and right?
# 3. Which sentence does the figure support? **A** The linear baseline finds better policies than the constant. **B** The noise of the gradient decides how long a step may be. **C** A baseline changes where the gradient points.

# %%
guess.ask("apart", "1. distance of the curves at step 20, left, units of return")
guess.ask("passes", "2. steps until the linear baseline is above -150, left and right")
guess.ask("sentence", "3. the sentence", ["A", "B", "C"])

# %% tags=["reveal", "statistical", "tolerance:abs=6", "tolerance:whole=5"]
at_twenty = histories[0.05][20].median(-1).values  # (baseline,)
middle = {rate: history[:, 2].median(-1).values for rate, history in histories.items()}
passes = [int((curve > -150).nonzero()[0]) for curve in middle.values()]  # left, right
assert passes[1] < passes[0]
guess.reveal("apart", f"{at_twenty.max() - at_twenty.min():.1f}; the bands are wider")
guess.reveal("passes", f"{passes[0]} steps left, {passes[1]} right")
guess.reveal("sentence", "B")

# %% [markdown] tags=["reveal"]
# **A** is not supported: the curves of constant and linear lie within each other's bands nearly everywhere, and five policies decide nothing about so small a lead. **C** is refuted by Figure 4, and by the left panel: the same expected steps give the same curves.
# **B** is what the two panels show together: long steps learn several times faster, for those who can bear them. With short steps the noise of forty gradients averages out, and an eighth of the noise buys next to nothing. With long steps the noise throws some policies off before the next gradient can correct it; the middle one still ends above all those of the short steps.
#
# This workbook, like nearly all code, divides the advantages by *their own* deviation. The linear baseline makes them about three times smaller, so the division makes the step three times longer: so a quiet gradient learns faster there.
# From now on every RL loss in this workbook uses these normalised advantages, `advantage.Score`.
#
# *How far can you trust this?* It is one problem, one network and one rule for the step. Where returns differ much from state to state, a constant will do worse against the linear baseline than it does here.

# %% [markdown]
# ### Bonus · The best constant
#
# *Difficulty 3 of 3, for the fast.* Is the mean return the best constant $b$? The estimate from one sample is $(G - b)\, z$ with the score $z$. Find the $b$ that makes its noise smallest, and estimate it from samples.
#
# <details><summary>Hint 1: what of the noise depends on b?</summary>
# The noise squared is $\mathbb E\big[(G - b)^2 |z|^2\big]$ less the squared length of the mean. Which of the two does not move with $b$, and why?
# </details>
#
# <details><summary>Hint 2: a parabola</summary>
# Multiply out: it is quadratic in $b$. Where is its slope zero?
# </details>


# %% tags=["exercise-best-constant"]
def best_constant(scores, returns):
    """Return the least noisy constant b, a number, from scores (sample, parameter), returns (sample,)."""
    ### BEGIN SOLUTION
    squared = scores.square().sum(1)  # (sample,)
    return (squared * returns).sum() / squared.sum()
    ### END SOLUTION


# %%
checked = check.best_constant(best_constant)

# %% tags=["reveal", "best-constant", "tolerance:abs=0.15"]
actions = noise_drawn[:, :1]  # one step, mu = 0 and sigma = 1: the score is the action
outcomes = -((actions[:, 0] - 1) ** 2)
tried = {"nothing": 0.0, "the mean": float(outcomes.mean())}
if checked:
    tried["your constant"] = float(torch.as_tensor(best_constant(actions, outcomes)))
for name, value in tried.items():
    each = (outcomes - value) * actions[:, 0]
    print(f"{name:13} {value:5.2f}: mean {each.mean():.2f}, variance {each.var():.2f}")

# %% [markdown]
# <details><summary>Solution and explanation of the bonus</summary>
#
# The mean of the estimate does not depend on $b$, since $\mathbb E[b\, z] = 0$. What is left is $\mathbb E[(G-b)^2 |z|^2] = \mathbb E[G^2|z|^2] - 2 b\, \mathbb E[G|z|^2] + b^2\, \mathbb E[|z|^2]$, smallest at
# $$b^\star = \frac{\mathbb E\big[|z|^2\, G\big]}{\mathbb E\big[|z|^2\big]},$$
# a mean of the returns in which samples with long scores weigh more. In the one-step problem $z = a$ and $G = -(a-1)^2$, so $b^\star = -\mathbb E[a^4 - 2a^3 + a^2] / \mathbb E[a^2] = -(3 + 1) = -4$, while the mean return is $-2$. The variances are $30 + 8b + b^2$: 30 with nothing, 18 with the mean, 14 with $b^\star$.
# The mean is popular because it needs no scores; that it is not the best is seldom worth the trouble.
# </details>

# %% [markdown]
# ## 6 · Behaviour cloning
#
# Sometimes somebody has already been where we want to go. A *demonstration* is a list of states and actions
# $\mathcal D^{\mathrm{dem}} = \{(s, a)\}$. *Behaviour cloning* makes these actions likely (Section 3):
#
# $$\mathcal L^{\mathrm{BC}}(\theta) = -\!\!\sum_{(s,a) \in \mathcal D^{\mathrm{dem}}} \log \pi_\theta(a \mid s) .$$
#
# It is a plain supervised loss: no reward, no rollout. Up to the length of the sum it is the loss of section 4 with all weights one, on actions that somebody else took. We fit one policy to each of the workbook's twelve
# demonstrated trajectories, all twelve at once: their parameters carry a task axis. We do so for the optimal trajectories and
# for the sub-optimal ones, which are noisy and *stop before the region where the reward is paid*.
#
# **Predict first.** The demonstrator of the optimal trajectories has a return of about 80 (it needs some 20 of the 100
# steps, and the remaining ones are paid out at the goal). What is the mean return of its twelve clones? And what does the clone of a sub-optimal demonstration do where the demonstration ends?

# %%
clock.at("behaviour cloning")
guess.ask("clones", "mean return of the clones of optimal trajectories")
guess.ask("end", "a sub-optimal demonstration's clone", ["stops there", "turns back", "goes on"])


# %% tags=["live-cloning", "tolerance:abs=0.002"]
def clone(demos, steps=400, rate=3e-3):
    """Return task_params fitted by Adam to one demonstration each, with your log-density."""
    start = policy.per_task(policy.initialise(2, 2, seed=0), len(demos.tasks))
    leaves = {name: value.clone().requires_grad_() for name, value in start.items()}
    optimiser = torch.optim.Adam(leaves.values(), lr=rate, fused=True)  # faster, same formula
    for _ in range(steps):
        optimiser.zero_grad()
        loss_of(leaves, demos, torch.ones_like(demos.mask)).backward()
        optimiser.step()
    return policy.detach(leaves)


demonstrations = {name: load_demonstrations(name, "point2d") for name in ("optimal", "suboptimal")}
ours = clone(demonstrations["optimal"], steps=20)
package = cloning.clone(demonstrations["optimal"], steps=20)
apart = max(float((ours[name] - package[name]).abs().max()) for name in ours)
assert apart < 0.01
print(f"your clones after 20 steps differ from emrld_lite's by at most {apart:.4f}")

# %% tags=["reveal", "cloning-returns", "statistical", "tolerance:abs=4"]
sparse = make("point2d")
rollouts, returns = {}, {}
for quality, demos in demonstrations.items():
    rollouts[quality] = collect(sparse, demos.tasks, clone(demos), 20, random)
    returns[quality] = float(episode_returns(rollouts[quality]).mean())
    print(f"clones of {quality} trajectories: mean return {returns[quality]:.1f}")
assert returns["suboptimal"] + 10 < returns["optimal"] < 70
guess.reveal("clones", f"{returns['optimal']:.1f}")

# %% tags=["reveal", "clones-run-past", "statistical", "tolerance:abs=8"]
past_share = {}
for quality, rollout in rollouts.items():
    taken = rollout.mask == 1  # (task, episode, time)
    gaps = (rollout.states - sparse.training_tasks()[:, None, None]).norm(dim=-1)
    near = gaps.masked_fill(~taken, torch.inf).amin(-1) < 0.2  # (task, episode)
    past = rollout.states.norm(dim=-1).amax(-1) > 2.2  # farther out than the disc reaches
    demos = demonstrations[quality]
    last = demos.actions[range(12), 0, demos.lengths() - 1].norm(dim=-1).mean()
    entered, past_share[quality] = (100 * float(part.float().mean()) for part in (near, past))
    print(f"{quality:10} {entered:5.1f} % of the episodes enter the disc,", end=" ")
    print(f"{past_share[quality]:5.1f} % run past it; the last demonstrated", end=" ")
    print(f"action is {float(last):.2f} of a full step long")
    assert entered > 80 and (last > 0.8 if quality == "suboptimal" else last < 0.6)
assert past_share["suboptimal"] > 80 and past_share["optimal"] < 75
guess.reveal("end", f"{past_share['suboptimal']:.1f} % of the episodes go on, past the goal")

# %% tags=["reveal"]
figure, panels = plt.subplots(1, 2, figsize=(7.4, 4.2), sharey=True)
task = 5
for axes, (quality, demos) in zip(panels, demonstrations.items(), strict=True):
    sparse.draw_tasks(axes, demos.tasks[task : task + 1])
    plotting.trajectories(rollouts[quality], axes, task=task, episodes=20)
    plotting.demonstration(demos.states[task, 0, : int(demos.lengths()[task])], axes)
    axes.set(title=f"{quality}: mean return {returns[quality]:.0f}", xlim=(-4, 4), ylim=(-1, 10))
plt.show()

# %% [markdown] tags=["reveal"]
# *Figure 6. Twenty episodes (thin lines) of a policy cloned from one demonstration (dashed) with your log-density, for one of the twelve goals
# (star) and its reward region (disc). Both clones find the disc; nearly all paths of the right one run straight through it. Titles: mean sparse return over all twelve clones.*
#
# Both find the region that pays, and neither stops there: the clones of the optimal data return half of what the demonstrations do, those of the sub-optimal data a little, where the demonstrations themselves end before any reward. Beyond the goal there are no data, and a network continues what it has learned:
# it drives on. The optimal demonstration at least slows down at its end, and about half of its clones' episodes stay. The sub-optimal one ends at full speed, and nearly all of its clones' episodes run
# straight through and away. (The clones also act with noise of their own; notebook 03 separates the two causes.)
#
# Cloning knows only *one* goal: move the star and the
# policy is lost. EMRLD meta-trains a policy so that a single gradient step, with one demonstration per goal, is enough (notebook 06).

# %% [markdown]
# ## What was shown
#
# - A Gaussian policy is a network for the mean and a $\log\sigma$; its log-density is a sum over dimensions.
# - The environment alters most actions of $\sigma = 1$, and no $\sigma$ makes a random walk reach far: a hundred steps lead ten step lengths away.
# - REINFORCE needs only rewards and scores; finite differences give the same number, as long as $\gamma^t$ stays in.
# - A constant takes out most of the gradient's noise, the linear baseline most of the rest. Short steps hardly profit from either. With long steps the policies without a baseline fall behind, and some are thrown off; a constant prevents that as well as the linear one.
# - Cloning is the same loss with all weights one. It follows a demonstration, for its own goal only, and drives on where the demonstration ends.
#
# **Next** notebook 02 shows what becomes of this gradient when the reward is sparse. What follows here is further reading.

# %% [markdown]
# ## 7 · Generalised advantage estimation (further reading)
#
# *Generalised advantage estimation* (GAE; Schulman et al., 2016) goes one step further than a baseline. With the residual
# $\delta_t = R_t + \gamma V(s_{t+1}) - V(s_t)$, it sums
#
# $$\hat A_t = \sum_{k \ge 0} (\gamma\lambda)^k\, \delta_{t+k} .$$
#
# With $\lambda = 1$ the values cancel in pairs and $\hat A_t = G_t - V(s_t)$, the baseline of section 5; with $\lambda = 0$ it trusts
# $V$ after a single step. The paper's Table 1 calls $\lambda$ "GAE $\tau$" and sets it to 1.
#
# ### Exercise 7 · GAE
#
# *Difficulty 2 of 3, planned for 10 minutes.* The value after the last step is 0.
#
# <details><summary>Hint 1: the sum looks familiar</summary>
# You have written a sum of this kind in exercise 2. Of what, and with which factor?
# </details>
#
# <details><summary>Hint 2: V of the next state</summary>
# All but the last column of "the value of the next state" stand in `values` already.
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
checked = check.advantages(advantages)


def package_advantages(rewards, values, discount, gae_lambda):
    """Return the same by the package, which wants a leading task axis."""
    return advantage.generalised_advantage(rewards[None], values[None], discount, gae_lambda)[0]


estimator = advantages if checked else package_advantages
values = advantage.linear_baseline(untrained, discount=0.95)[0]
for gae_lambda in (0.0, 0.9, 1.0):
    ours = torch.as_tensor(estimator(untrained.rewards[0], values, 0.95, gae_lambda))
    package = package_advantages(untrained.rewards[0], values, 0.95, gae_lambda)
    assert check.agree(ours, package, tolerance=1e-3)
    print(f"lambda {gae_lambda}: yours at the start {ours[:, 0].mean():.3f}", end=", ")
    print(f"the package's {package[:, 0].mean():.3f}")

# %% [markdown]
# **What does $\lambda$ trade?** Here is a question whose answer is known: by how much is a first step *towards* the goal better than one *away* from it, if the untrained policy draws all later actions? Two thousand pairs of episodes that share their draws answer it nearly without error. Then your GAE answers it from one pair of episodes that share *no* draws, as in a real batch, or from the mean of some such pairs,
# with $V$ the linear baseline (fitted to twenty other episodes) or zero. The *bias* is the mean estimate less the exact number, the *noise* the deviation of the estimates, and the *error* the root of the sum of their squares.
#
# **Predict first.** Which $\lambda$ has the smallest error with the linear baseline, if you have one pair of episodes? And if you have 256?

# %%
clock.at("generalised advantage estimation")
guess.ask("one", "lambda with the smallest error, one pair")
guess.ask("many", "lambda with the smallest error, mean of 256 pairs")

# %% tags=["reveal", "gae-bias-and-noise", "tolerance:abs=0.1"]
differences = gae.advantage_differences(params, estimator)
print(f"exact difference: {differences.exact:.2f}")
for what in gae.VALUES:
    for gae_lambda in (0.0, 0.5, 0.9, 1.0):
        bias, deviation = differences.error_parts(what, gae_lambda, count=1)
        print(f"V is {what}, lambda {gae_lambda:.1f}: bias {bias:.2f}, noise {deviation:.2f}")
best = {count: gae.best_lambda(differences, gae.VALUES[0], count) for count in gae.COUNTS}
assert best[1] < 0.6 and best[256] > 0.95 and abs(differences.biases["zero", 1.0]) < 1e-3
guess.reveal("one", f"{best[1]:.2f}")
guess.reveal("many", f"{best[256]:.2f}")

# %% tags=["reveal", "nbval-ignore-output"]
gae.gae_sliders(differences)

# %% tags=["reveal"]
gae.gae_picture(differences, gae_lambda=0.95, values="the linear baseline", count=16)

# %% [markdown] tags=["reveal"]
# *Figure 7. Left: means of sixteen estimates by your GAE at $\lambda = 0.95$, their expectation (dashed) and the exact difference (solid). Right: bias (dashed), noise (dotted) and error (solid) for every $\lambda$; the star marks the smallest error, the thin line the $\lambda$ of the left panel. Bias falls and noise rises with $\lambda$.*
#
# At $\lambda = 0$ there is no noise at all in this question, since the first step is given, and the whole error is $V$'s: it is fitted to all places and times at once and flattens the slope at the start. At $\lambda = 1$ there is no bias, whatever $V$ is, and all the noise of a hundred steps.
# Averaging takes out noise but never bias. So the best $\lambda$ is small for one pair and 1 for many. Move the sliders to see two more things: how far the star wanders between 1 and 256 pairs, and that with $V = 0$ a small $\lambda$ is blind to all but the next reward.
#
# A policy gradient averages over thousands of steps, which speaks for the paper's $\lambda = 1$ in these short episodes. Longer episodes, and a better $V$, speak for less.

# %% [markdown]
# ## Where paper and code differ (further reading)
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
#
# **References** Williams (1992), *Simple statistical gradient-following algorithms*; Greensmith et al. (2004), *Variance reduction techniques for gradient
# estimates in reinforcement learning* (the best constant); Schulman et al. (2016),
# *High-dimensional continuous control using generalized advantage estimation*; Duan et al. (2016),
# *Benchmarking deep reinforcement learning for continuous control* (the linear baseline).
