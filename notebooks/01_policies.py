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
# - derive the REINFORCE gradient and check it against a number it cannot have copied,
# - make it quieter with a linear baseline and generalised advantage estimation (GAE),
# - clone a demonstrated path, and see where cloning alone stops short.
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
# **Predict first.** The point robot of this workbook moves by $0.1\,a$ a step, with each component of
# $a$ clipped to $[-1, 1]$. With $\mu = 0$ and $\sigma = 1$, what share of the drawn components is clipped:
# a tenth, a third, a half?

# %%
clock.at("a policy is a distribution")
random = torch.Generator().manual_seed(0)
drawn = torch.randn(10_000, 2, generator=random)  # (sample, action), mu = 0 and sigma = 1
clipped = (drawn.abs() > 1).float().mean()
assert abs(clipped - 0.317) < 0.02  # P(|z| > 1) of a standard normal
print(f"share of the components that is clipped: {clipped:.2f}; of a standard normal: 0.317")

# %%
figure, axes = plt.subplots(figsize=(4.2, 3.6))
axes.scatter(*drawn[:1500].T, s=4, alpha=0.4, color="#56B4E9", label="drawn actions")
box = torch.tensor([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]])
axes.plot(*box.T, color="black", linewidth=1.2, label="what the robot can do")
axes.set(xlabel="action $a_1$ (units of 0.1 length)", ylabel="action $a_2$ (units of 0.1 length)")
axes.set_aspect("equal")
axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
plt.show()

# %% [markdown]
# *Figure 1. Actions drawn with $\sigma = 1$ (dots) and the box to which they are clipped (square).*
#
# About a third of the components falls outside $[-1, 1]$. We keep the action *as drawn*: its density is a
# Gaussian's, which the clipped action's is not, and densities are what gradients need. Clipping
# happens inside the environment.

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
# return of a trajectory $\tau = (s_0, a_0, s_1, \dots)$. The difficulty: $\theta$ sits in the *distribution*,
# not in $G$. Three moves get it out.
#
# | move | because |
# |---|---|
# | $\nabla_\theta J = \int G(\tau)\, \nabla_\theta p_\theta(\tau)\, d\tau$ | $G(\tau)$ does not depend on $\theta$ |
# | $\hphantom{\nabla_\theta J} = \mathbb E_\tau\big[G(\tau)\, \nabla_\theta \log p_\theta(\tau)\big]$ | $\nabla p = p\, \nabla \log p$ |
# | $\hphantom{\nabla_\theta J} = \mathbb E_\tau\big[\sum_t G_t\, \nabla_\theta \log \pi_\theta(a_t \mid s_t)\big]$ | dynamics do not depend on $\theta$; rewards before $t$ do not depend on $a_t$ |
#
# (In the last move, $G_t$ counts rewards discounted from time $t$ on. Counting from 0 would put a
# factor $\gamma^t$ in front of each term; nearly all code, the paper's included, drops it.)
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
for name, value in (("finite differences", differences), ("REINFORCE", reinforce)):
    assert abs(value - 2.0) < 0.02
    print(f"{name:>18}: {value:.3f}")

# %% [markdown]
# Both agree with the exact answer, $-2(\mu - 1) = 2$, as far as a million draws can tell. Finite differences moved $\mu$ and looked at the
# rewards again. REINFORCE never differentiated the reward: it only asked how much more likely each action would
# become. That is why it also works when the reward is a black box, or zero nearly everywhere.
#
# ### Exercise 3 · The loss whose gradient is REINFORCE
#
# *Difficulty 2 of 3, 10 minutes.* Automatic differentiation wants a *loss*. Write the one whose gradient
# is minus the policy gradient: the mean over the steps that were taken. `mask` is 1 for those and 0 after
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
# Here is the whole algorithm: collect, score, step. `normalise` shifts and scales the returns of all
# steps to mean 0 and deviation 1, which fixes the size of a step whatever the units of the reward.


# %% tags=["live-reinforce", "statistical", "tolerance:abs=5"]
def improve(params, scored, rate=0.05):
    """Return params after one gradient step on the RL loss of a scored rollout."""
    leaves = policy.detach(params, requires_grad=True)
    loss = losses.rl_loss(leaves, scored).mean()
    gradients = torch.autograd.grad(loss, list(leaves.values()))
    return {
        name: (value - rate * gradient).detach()
        for (name, value), gradient in zip(leaves.items(), gradients, strict=True)
    }


def train(score, iterations=40):
    """Return the mean return of each iteration and the last policy; ``score`` fills advantages."""
    current, history = policy.initialise(2, 2, seed=0), []
    random = torch.Generator().manual_seed(1)
    for _ in range(iterations):
        rollout = collect(environment, goal, current, 20, random)
        history.append(float(episode_returns(rollout).mean()))
        current = improve(current, score(rollout))
    return history, current


def plain_returns(rollout):
    """Score every step by its normalised return."""
    returns = advantage.discounted_returns(rollout.rewards, 0.95)
    return rollout._replace(advantages=advantage.normalise(returns, rollout.mask))


plain_history, _ = train(plain_returns)
untrained_return, plain_return = plain_history[0], sum(plain_history[-5:]) / 5
assert plain_return > untrained_return + 50
print(f"mean return: {untrained_return:.1f} at first, {plain_return:.1f} over the last five steps")

# %% [markdown]
# ## 5 · A baseline and GAE
#
# $G_t$ is noisy: it blames or praises $a_t$ for everything that came after. Subtracting any function
# $V(s_t)$ of the state alone leaves the expectation of the gradient as it is, since
# $\mathbb E_{a}[\nabla_\theta \log \pi_\theta(a \mid s)] = 0$. The paper's *baseline* is linear in a few features of state
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


baseline_history, trained = train(with_baseline)
baseline_return = sum(baseline_history[-5:]) / 5
figure, axes = plt.subplots(figsize=(5.4, 3.2))
axes.plot(plain_history, linestyle=":", color="#999999", label="returns only")
axes.plot(baseline_history, color="#0072B2", label="minus the linear baseline")
axes.set(xlabel="gradient step", ylabel="mean return, dense reward")
axes.legend(loc="best")
plt.show()
assert baseline_return > plain_return + 1
print(
    f"last five steps: {plain_return:.1f} by returns only, {baseline_return:.1f} with the baseline"
)

# %% [markdown]
# *Figure 3. Mean return of 20 episodes on one dense goal, with (solid) and without (dotted) the linear
# baseline; one seed.*
#
# It helps a little: the return rises by about 90 instead of 84. (With seeds 1 to 4 the lead is 3 to 8.) Little is left to gain,
# since normalising has already subtracted the mean; what the baseline takes out beyond it is how the return depends on
# place and time. From now on every RL loss in this workbook uses these advantages.

# %% [markdown]
# ## 6 · Behaviour cloning
#
# Sometimes somebody has already been where we want to go. A *demonstration* is a list of states and actions
# $\mathcal D^{\mathrm{dem}} = \{(s, a)\}$. *Behaviour cloning* makes these actions likely (Section 3):
#
# $$\mathcal L^{\mathrm{BC}}(\theta) = -\!\!\sum_{(s,a) \in \mathcal D^{\mathrm{dem}}} \log \pi_\theta(a \mid s) .$$
#
# It is a plain supervised loss: no reward, no rollout. We fit one policy to each of the workbook's twelve
# demonstrated paths, all twelve at once: their parameters carry a task axis. We do so for the optimal paths and
# for the sub-optimal ones, which are noisy and *stop before the region where the reward is paid*.
#
# **Predict first.** The demonstrator of the optimal paths earns a return of about 80 (it needs some 20 of the 100
# steps, and the remaining ones are paid out at the goal). What will the twelve clones earn on average: 80, 60, 40?


# %% tags=["live-cloning"]
def clone(demos, steps=400, rate=3e-3):
    """Return task_params fitted to one demonstration each by Adam, and the loss after each step."""
    start = policy.per_task(policy.initialise(2, 2, seed=0), len(demos.tasks))
    leaves = {name: value.clone().requires_grad_() for name, value in start.items()}
    optimiser = torch.optim.Adam(leaves.values(), lr=rate)
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
figure, panels = plt.subplots(1, 2, figsize=(8.4, 3.4), sharey=True)
task = 5
for axes, quality in zip(panels, rollouts, strict=True):
    demos = load_demonstrations(quality, "point2d")
    sparse.draw_tasks(axes, demos.tasks[task : task + 1])
    plotting.trajectories(rollouts[quality], axes, task=task, episodes=20)
    plotting.demonstration(demos.states[task, 0, : int(demos.lengths()[task])], axes)
    axes.set_title(f"{quality}: mean return {returns[quality]:.0f}")
plt.show()
assert returns["suboptimal"] + 10 < returns["optimal"] < 70
for quality, earned in returns.items():
    print(f"clones of {quality} paths: mean return {earned:.1f}")

# %% [markdown]
# *Figure 4. Twenty episodes (thin lines) of a policy cloned from one demonstration (dashed), for one of the twelve goals
# (star) and its reward region (disc). Titles: mean sparse return over all twelve clones.*
#
# Both head for the goal, and both fall short of the demonstrator. A small error leads to a state that is not in
# the data, where the next error is larger, and beyond the goal there is no data at all. The sub-optimal clones
# suffer most: nobody showed them the last stretch. Cloning also knows only *one* goal: move the star and the
# policy is lost. Notebook 06 repairs all of this with one gradient step.

# %% [markdown]
# ## Where paper and code differ
#
# | point | paper | released code | this workbook |
# |---|---|---|---|
# | $\sigma$ | fixed | learned, starts at 1 | learned by default; `--no-learn-sigma` keeps it at 1 |
# | log-density | of the joint action | averaged over action dimensions | joint |
# | BC loss | sum over the data | mean | mean by default; `--bc-reduction sum` |
# | baseline's time | time index | index over all episodes in a row | time within the episode |
#
# In all four the mathematics stays what you have just derived; only the size of a step changes, or, in the last
# row, what the baseline can explain. `data/paper_ledger.toml` lists each of them with what was measured.

# %% [markdown]
# ## What was shown
#
# - A Gaussian policy is a network for the mean and a $\log\sigma$; its log-density is a sum over dimensions.
# - REINFORCE needs only rewards and $\nabla \log\pi$; finite differences gave the same number.
# - A linear baseline takes the predictable part out of the returns; GAE interpolates between the two.
# - Cloning follows a demonstration, as far as it reaches and for its own goal only.
#
# **Next** notebook 06 adapts one policy to twelve goals with these two losses together.
#
# **References** Williams (1992), *Simple statistical gradient-following algorithms*; Schulman et al. (2016),
# *High-dimensional continuous control using generalized advantage estimation*; Duan et al. (2016),
# *Benchmarking deep reinforcement learning for continuous control* (the linear baseline).
