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
# # 06 · EMRLD: Algorithm 1, trained live
#
# One policy, and twelve goals that it must tell apart. A reward that is zero nearly everywhere, and a single
# demonstration per goal. In this notebook you write the three functions that EMRLD consists of, train a policy with them,
# and then take its adaptation apart: at the end the policy looks at one demonstration, takes **a gradient step or two**, and walks
# to the goal.
#
# **You will be able to**
#
# - write EMRLD's adaptation step and, with it, its warm-started variant EMRLD-WS,
# - say what the meta-gradient differentiates, and check it by finite differences,
# - run Algorithm 1 from your own parts, line by line,
# - design an experiment that says which part of the adaptation matters, and how surely.
#
# **You need** notebook 01 (Gaussian policy, policy gradient, behaviour cloning); 05 (MAML, TRPO) helps. **Time** the core is planned
# for 88 minutes, of which the machine computes two to four; 12 more are further reading. **Paper** Section 3 (algorithm, Algorithm 1),
# Section 4.1 (Point2D) and Table 1 of Rengarajan et al., NeurIPS 2022.

# %%
import time
from dataclasses import replace
from functools import partial

import matplotlib.pyplot as plt
import torch
from IPython.display import display

from emrld_lite import policy, train
from emrld_lite.adapt import adapt, warm_start
from emrld_lite.algorithms import ALGORITHMS
from emrld_lite.classroom import by_hand
from emrld_lite.classroom import checks as check
from emrld_lite.classroom.clock import Clock
from emrld_lite.classroom.live import while_it_is_quick
from emrld_lite.classroom.predict import Guesses
from emrld_lite.classroom.sketches.two_levels import two_levels
from emrld_lite.classroom.widgets.adaptation import (
    Adapter,
    Weights,
    adaptation_picture,
    adaptation_sliders,
)
from emrld_lite.classroom.widgets.learning_curve import LiveCurve, unlabelled_panels
from emrld_lite.config import TrainConfig
from emrld_lite.demonstrations import load_demonstrations
from emrld_lite.experiments import lottery, plotting, runs
from emrld_lite.experiments.evaluation import evaluate_run
from emrld_lite.experiments.results import seeds_of
from emrld_lite.learners import TaskData, Trpo, policies_after
from emrld_lite.rollout import Rollout, collect, episode_returns
from emrld_lite.trpo import surrogate_gradient

plotting.use_style()
torch.set_num_threads(1)  # leaves the other cores to you
guess = Guesses()
clock = Clock(
    {
        "twelve tasks, twelve demonstrations": 8,
        "one adaptation step": 20,
        "the meta-update": 22,
        "the loop, live": 12,
        "what one gradient step does": 18,
        "without demonstrations": 8,
    },
    further={"how lucky was I": 8, "where paper and code differ": 4},
)

# %% [markdown]
# ## 1 · Twelve tasks, twelve demonstrations
#
# A *task* $i$ is a Markov decision process; here all tasks share states, actions and dynamics and differ in the
# goal. The reward is **sparse**: zero unless the point is within 0.2 of its goal, where it is one minus the
# distance. Within 0.02 the remaining steps are paid out at once, and the episode ends (Appendix B). So a
# return of about 80 means: straight to the goal and right onto it.
#
# Each task comes with demonstration data $\mathcal D^{\mathrm{dem}}_i$: the states and actions of **one**
# trajectory, no rewards.

# %%
clock.at("twelve tasks, twelve demonstrations")
config = TrainConfig(algorithm="emrld-ws", demos="optimal", seed=0)
environment, score = config.environment(), config.score()  # score: from rewards to advantages
demos = {quality: load_demonstrations(quality, "point2d") for quality in ("optimal", "suboptimal")}
figure, panels = plt.subplots(1, 2, figsize=(9, 3.4), sharey=True)
for axes, (quality, shown) in zip(panels, demos.items(), strict=True):
    environment.draw_tasks(axes, shown.tasks)
    for task in range(len(shown.tasks)):
        plotting.demonstration(shown.states[task, 0, : int(shown.lengths()[task])], axes)
    axes.set_title(f"{quality}: {int(shown.lengths().sum())} state-action pairs in all")
    axes.label_outer()
plt.show()

# %% [markdown]
# *Figure 1. The demonstrations (dashed), one per task, the goals (stars) and the regions in which a reward is paid
# (discs). The optimal ones end on the goal; the sub-optimal ones are noisy and stop short of the reward.*
#
# Everything below uses the optimal ones. **Predict first.** An untrained policy tries each of the twelve tasks twenty times. In how many of these
# 240 episodes does it see any reward at all?

# %%
guess.ask("rewarded", "episodes of 240 that see a reward")

# %% tags=["how-sparse", "tolerance:whole=4", "reveal"]
data = demos["optimal"]
meta_params = policy.initialise(environment.state_dim, environment.action_dim, seed=0)
random = torch.Generator().manual_seed(1)
before = score(collect(environment, data.tasks, meta_params, config.episodes, random))
paid = before.rewards.sum(-1) > 0  # (task, episode)
assert paid.float().mean() < 0.05
guess.reveal("rewarded", f"{int(paid.sum())} of 240, in {int(paid.any(1).sum())} of the tasks")

# %% [markdown]
# ## 2 · One adaptation step
#
# EMRLD's adaptation adds two gradients: one of the rewards that the policy found, and one of behaviour cloning, which needs no reward.
# Starting from the *meta-parameter* $\theta_k$ of iteration $k$, task $i$ gets
#
# $$\theta_{k,i} = \theta_k - \alpha\, \nabla_\theta \Big( w_{\mathrm{rl}}\, \mathcal L^{\mathrm{RL}}_i(\theta; \mathcal D^{\mathrm{tr}}_i)
# + w_{\mathrm{bc}}\, \mathcal L^{\mathrm{BC}}_i(\theta; \mathcal D^{\mathrm{dem}}_i) \Big) \Big|_{\theta = \theta_k} . \qquad\text{(adapt)}$$
#
# $\mathcal D^{\mathrm{tr}}_i$ are trajectories of the meta-policy $\pi_{\theta_k}$ in task $i$, $\alpha = 0.01$ is the adaptation learning
# rate, $\mathcal L^{\mathrm{RL}}_i = -\operatorname{mean}(\log \pi_\theta(a \mid s)\, \hat A)$ is the loss of notebook 01 with advantages $\hat A$, and
# $\mathcal L^{\mathrm{BC}}_i = -\operatorname{mean}(\log \pi_\theta(a \mid s))$ over the demonstration
# (here $\log \pi_\theta$ in both losses is averaged over the action's dimensions, as in the released code). The
# weights are $w_{\mathrm{bc}} = 1$ and $w_{\mathrm{rl}} = 0.2$ for optimal, $1$ for sub-optimal data (Table 1).
#
# ### Exercise 1 · The adaptation step
#
# *Difficulty 2 of 3, planned for 10 minutes.* Write equation (adapt) for one task. `theta` is one long vector, and the losses are functions of it.
# The meta-update will ask how $\theta_{k,i}$ changes *with* $\theta_k$, and the answer has two parts: the point that you step from moves, and so does the
# gradient there. Your step must keep both.
#
# <details><summary>Hint 1: how do I get a gradient as a vector, and not as a field of theta?</summary>
# <code>torch.autograd.grad(loss, theta)</code> returns a tuple with the gradient.
# </details>
#
# <details><summary>Hint 2: the check says "first-order"</summary>
# By default the gradient comes back as a bare number, which has forgotten theta. Look up what <code>create_graph</code> does.
# </details>


# %% tags=["exercise-adaptation"]
def adaptation_step(theta, rl_loss, bc_loss, w_rl, w_bc, alpha):
    """Return theta_i, (parameter,); rl_loss and bc_loss map theta to a scalar."""
    ### BEGIN SOLUTION
    loss = w_rl * rl_loss(theta) + w_bc * bc_loss(theta)
    (gradient,) = torch.autograd.grad(loss, theta, create_graph=True)
    return theta - alpha * gradient
    ### END SOLUTION


# %%
clock.at("one adaptation step")
checked = check.adaptation_step(adaptation_step)
# Until yours is right, the package's; `vectors` only turns its answer into one tensor.
step = by_hand.vectors(adaptation_step if checked else by_hand.adaptation_step)

# %% [markdown]
# From here on this notebook calls `step`, which is your function once it is right. It takes one task at a time; the package's `adapt` takes all twelve in one batch,
# which is faster. Both do the same:

# %%
emrld = ALGORITHMS["emrld"].adaptation("optimal")  # alpha, and the weights of Table 1
theta = policy.to_vector(meta_params).requires_grad_()  # all parameters as one vector
parts = by_hand.separate(meta_params, before, data, emrld)  # a pair of losses per task
weights = (emrld.w_rl, emrld.w_bc, emrld.adapt_lr)
ours = [step(theta, part.rl_loss, part.bc_loss, *weights).detach() for part in parts]
batched = adapt(meta_params, before, data, emrld)
for task in (0, 3, 8):
    package = policy.to_vector({name: value[task] for name, value in batched.items()})
    assert check.agree(ours[task], package)
    lengths = [float((vector - theta.detach()).norm()) for vector in (ours[task], package)]
    print(f"task {task}: your step is {lengths[0]:.4f} long, the package's {lengths[1]:.4f}")

# %% [markdown]
# **Predict first.** With the weights $(w_{\mathrm{rl}}, w_{\mathrm{bc}}) = (1, 0)$ the step is the policy gradient's alone, which is MAML's adaptation; with $(0, 1)$ it is cloning alone. For how many of the
# twelve tasks does the untrained policy's RL step have the length zero, exactly?

# %%
guess.ask("silent", "tasks of 12 in which the RL step is zero")

# %% tags=["two-halves", "tolerance:whole=3", "reveal"]
figure, axes = plt.subplots(figsize=(7.6, 2.8))
lengths = {}
for place, (name, pair, colour, hatch) in enumerate(
    (("RL alone", (1, 0), "#9A6A00", ""), ("cloning alone", (0, 1), "#BBBBBB", "///"))
):
    moved = [step(theta, part.rl_loss, part.bc_loss, *pair, emrld.adapt_lr) for part in parts]
    lengths[name] = [float((vector - theta).norm().detach()) for vector in moved]
    spots = [task + 0.4 * place - 0.2 for task in range(12)]
    axes.bar(spots, lengths[name], 0.38, label=name, color=colour, hatch=hatch)
axes.set(xlabel="task", ylabel="length of the step in theta", xticks=range(12))
axes.legend(loc="upper center", ncols=2)
plt.show()
silent = sum(length == 0 for length in lengths["RL alone"])
assert min(lengths["cloning alone"]) > 0 and silent == int((~paid.any(1)).sum())
guess.reveal("silent", f"{silent}: all the tasks without a reward, and only those")

# %% [markdown] tags=["reveal"]
# *Figure 2. How far the untrained policy moves, per task, by the rewards alone (full bars) and by its demonstration alone (hatched). A full bar is rare, and short
# where there is one; every task has a hatched bar.*
#
# Where nothing is rewarded, every advantage is zero, and so is the policy gradient. A full bar comes from an episode that was rewarded by luck; another draw of the 240 episodes puts it into another task, or has none.
# The demonstration moves the policy in every task, and from the first iteration on.

# %% [markdown]
# **EMRLD-WS** (warm start) puts one cloning step in front, with the same $\alpha$ and no weight:
#
# $$\tilde\theta_{k,i} = \theta_k - \alpha\, \nabla_\theta \mathcal L^{\mathrm{BC}}_i(\theta; \mathcal D^{\mathrm{dem}}_i) \big|_{\theta = \theta_k},
# \qquad \text{then (adapt) starting from } \tilde\theta_{k,i} . \qquad\text{(ws)}$$
#
# The trajectories $\mathcal D^{\mathrm{tr}}_i$ are then collected with $\pi_{\tilde\theta_{k,i}}$, which already leans towards the goal: they are
# more likely to contain a reward. It takes nothing new to write it, only your step twice:


# %% tags=["warm-start"]
rule = config.adaptation("optimal")  # EMRLD-WS


def adapted(theta, part):
    """Return theta_i of EMRLD-WS: first a step on the demonstration alone, then EMRLD's step."""
    warm = step(theta, part.rl_loss, part.bc_loss, 0.0, 1.0, rule.adapt_lr)
    return step(warm, part.rl_loss, part.bc_loss, rule.w_rl, rule.w_bc, rule.adapt_lr)


batched = adapt(meta_params, before, data, rule)
ours = by_hand.together([adapted(theta, part) for part in parts], meta_params)
assert all(check.agree(ours[name], batched[name]) for name in ours)
moves = [
    torch.cat([(end[name] - meta_params[name]).flatten(1) for name in end], 1).norm(dim=1).mean()
    for end in (ours, batched)
]
print("mean way of the twelve policies: {:.4f} by your step, {:.4f} by adapt".format(*moves))

# %% [markdown]
# All five algorithms of the paper's comparison are rows of one table, and the code is that table. EMRLD changes two cells of
# MAML's row; Meta-BC and GMPS clone in the meta-update (notebook 05 has their story):

# %%
print(f"{'':10}{'warm start':>12}{'w_rl':>10}{'w_bc':>6}{'meta-update':>20}")
for row in ALGORITHMS.values():
    w_rl = "0.2 or 1" if row.w_rl is None else f"{row.w_rl:g}"
    start = "one BC step" if row.warm_start else "-"
    outer = "RL, TRPO" if row.learner is Trpo else "cloning, Adam"
    print(f"{row.label:10}{start:>12}{w_rl:>10}{row.w_bc:>6g}{outer:>20}")

# %% [markdown]
# ## 3 · The meta-update
#
# After adaptation we collect $\mathcal D^{\mathrm{val}}_i$ with the adapted policies $\pi_{\theta_{k,i}}$ and ask: how should the *meta*-parameter
# move so that these adapted policies get a higher return? The paper's answer is
#
# $$\theta_{k+1} = \theta_k - \beta\, \nabla_\theta \sum_i \mathcal L^{\mathrm{RL}}_i\big(\theta_{k,i}(\theta);\, \mathcal D^{\mathrm{val}}_i\big), \qquad\text{(meta)}$$
#
# where $\theta_{k,i}(\theta)$ is the whole adaptation step as a function of where it starts. Its Jacobian is
# $I - \alpha \nabla^2(\dots)$ (with a warm start, which is one more step, the product of two such matrices): it holds *second derivatives*, which say how to move $\theta$ so that its own gradient becomes more useful. A *first-order* method leaves them out: it takes
# the Jacobian for $I$. Note where the demonstrations act: only inside $\theta_{k,i}(\theta)$.
#
# The step length $\beta$ comes from TRPO (trust-region policy optimisation): the largest step that keeps the mean
# Kullback-Leibler (KL) divergence between the adapted policies before and after it under a bound, and lowers the surrogate
#
# $$\mathcal S_i(\theta) = -\operatorname{mean}\Big( \tfrac{\pi_{\mathrm{new}}(a \mid s)}{\pi_{\mathrm{old}}(a \mid s)}\, \hat A \Big) ,$$
#
# a mean over the steps of $\mathcal D^{\mathrm{val}}_i$. *Old* is the policy that collected $\mathcal D^{\mathrm{val}}_i$; it stays what it was while $\theta$ is tried out. *New* is the policy
# that $\theta$ adapts to. In the meta-update $\log \pi_\theta$ is that of the whole action, as a ratio of densities must be; the mean over its dimensions, which the adaptation takes, would only shorten the gradient.
#
# **With pencil and paper** (4 minutes). Equation (meta) has $\mathcal L^{\mathrm{RL}}$, TRPO has $\mathcal S$. Show that at $\theta = \theta_k$ both have the same gradient, and
# say what the KL divergence and *its* gradient are there.
#
# <details><summary>Full solution</summary>
#
# Only $\pi_{\mathrm{new}}$ depends on $\theta$, so $\nabla_\theta \mathcal S_i = -\operatorname{mean}\big(\tfrac{\nabla_\theta \pi_{\mathrm{new}}}{\pi_{\mathrm{old}}} \hat A\big)
# = -\operatorname{mean}\big(\tfrac{\pi_{\mathrm{new}}}{\pi_{\mathrm{old}}} \nabla_\theta \log \pi_{\mathrm{new}}\, \hat A\big)$. At $\theta = \theta_k$ new and old are the same policy and the ratio is 1,
# which leaves $-\operatorname{mean}(\nabla_\theta \log \pi_{\mathrm{new}}\, \hat A) = \nabla_\theta \mathcal L^{\mathrm{RL}}_i$. Away from $\theta_k$ they differ: the ratio corrects for episodes that another
# policy collected.
#
# The divergence between a policy and itself is 0, its smallest value, so its gradient is 0 as well. Only its curvature, the Fisher matrix, is not zero, and that is all that a TRPO
# step needs to know about it (notebook 05 takes that step apart).
#
# </details>
#
# ### Exercise 2 · The surrogate
#
# *Difficulty 1 of 3, planned for 4 minutes.* You get log-densities, as always, and a mask with a 1 for each step that was taken. The gradient must flow through `new_log_prob`.
#
# <details><summary>Hint 1: where is the ratio?</summary>
# A ratio's logarithm is a difference of logarithms.
# </details>
#
# <details><summary>Hint 2: which mean?</summary>
# Over the steps that were taken, as in notebook 01: divide by the sum of the mask.
# </details>


# %% tags=["exercise-surrogate"]
def surrogate(new_log_prob, old_log_prob, advantages, mask):
    """Return TRPO's surrogate loss, a scalar, from tensors (episode, time)."""
    ### BEGIN SOLUTION
    ratio = torch.exp(new_log_prob - old_log_prob)
    return -(ratio * advantages * mask).sum() / mask.sum()
    ### END SOLUTION


# %%
clock.at("the meta-update")
checked = check.surrogate(surrogate)
task_surrogate = surrogate if checked else by_hand.surrogate  # until yours is right

# %% [markdown]
# ### Exercise 3 · The loss of one iteration
#
# *Difficulty 3 of 3, planned for 10 minutes.* Put the two together into the number that one iteration of Algorithm 1 lowers: the mean over tasks of the surrogate *after adaptation*, as a
# function of the meta-parameter `theta`. Each entry of `tasks` holds what one task's $\mathcal D^{\mathrm{val}}_i$ consists of:
#
# | | |
# |:---|:---|
# | `task.log_prob(theta_i)` | log-densities of its actions under the policy `theta_i`, (episode, time) |
# | `task.collected_with` | the adapted parameter $\theta_{k,i}$ whose policy collected it, a constant |
# | `task.advantages`, `task.mask` | as in Exercise 2 |
#
# `adapted(theta, task)` is the function of section 2, and `surrogate` is yours. Which policy is old, and which is new? Your answer decides what the gradient means.
#
# <details><summary>Hint 1: it gives minus the mean advantage, whatever theta is</summary>
# Then new and old move together and their ratio is always 1. The old policy is a fact about the data: it does not depend on the theta that is tried out.
# </details>
#
# <details><summary>Hint 2: where does theta come in?</summary>
# In one place only. Episodes of the adapted policy cannot judge theta itself, only the policy that theta adapts to.
# </details>


# %% tags=["exercise-meta-loss"]
def meta_loss(theta, tasks, adapted, surrogate):
    """Return the mean over tasks of the surrogate after adaptation, a scalar in theta's graph."""
    ### BEGIN SOLUTION
    losses = []
    for task in tasks:
        old = task.log_prob(task.collected_with)
        new = task.log_prob(adapted(theta, task))
        losses.append(surrogate(new, old, task.advantages, task.mask))
    return torch.stack(losses).mean()
    ### END SOLUTION


# %%
checked = check.meta_loss(meta_loss)
iteration_loss = meta_loss if checked else by_hand.meta_loss  # until yours is right

# %% [markdown]
# **Is its gradient the meta-gradient?** We ask three ways how the loss changes in a random direction: by automatic differentiation of your function, by moving $\theta$ a little to
# either side and adapting anew, and by the package's batched meta-gradient. In double precision the three must agree to many digits. The rewards are
# drawn at random, since without any the gradient would be zero.

# %% tags=["meta-gradient-check"]
random = torch.Generator().manual_seed(3)
four = data.take(slice(0, 4)).map(lambda values: values.double())  # four tasks are enough
double = {name: value.double() for name, value in meta_params.items()}
drawn = collect(environment, data.tasks[:4], meta_params, 3, random)
rewards = torch.randn(drawn.rewards.shape, generator=random) * drawn.mask
drawn = drawn._replace(rewards=rewards)
drawn = score(Rollout(*(part.double() for part in drawn[:4]), drawn.success))
theta = policy.to_vector(double).requires_grad_()
parts = by_hand.separate(double, drawn, four, rule)
parts = by_hand.with_validation(parts, double, drawn, [adapted(theta, part) for part in parts])
(gradient,) = torch.autograd.grad(
    iteration_loss(theta, parts, adapted, task_surrogate).double().sum(), theta
)

# %% tags=["three-slopes"]
direction = torch.randn(theta.shape, generator=random, dtype=torch.float64)


def nudged(amount):
    """Return the loss of the meta-parameter moved along the direction."""
    moved = (theta + amount * direction).detach().requires_grad_()
    return float(iteration_loss(moved, parts, adapted, task_surrogate).detach())


slope = (nudged(1e-7) - nudged(-1e-7)) / 2e-7  # a longer nudge would cross corners of the relus
everything = TaskData(drawn, drawn, four)
piece = surrogate_gradient(double, lambda at: policies_after(at, everything, rule, True), drawn)
slopes = [float(gradient @ direction), slope, float(piece.gradient @ direction) / len(parts)]
print("your function {:.5f}, finite differences {:.5f}, the package {:.5f}".format(*slopes))
assert max(slopes) - min(slopes) < 1e-4 * abs(slope)
short = replace(rule, second_order=False)
first = surrogate_gradient(double, lambda at: policies_after(at, everything, short, True), drawn)
print(f"a first-order gradient would say {float(first.gradient @ direction) / len(parts):.5f}")
assert abs(float(first.gradient @ direction) / len(parts) - slope) > 1e-3 * abs(slope)

# %% [markdown]
# The differences know that the adaptation's gradient moves with $\theta$, and so does your function; the first-order gradient does not, and its slope is another.
#
# ## 4 · The loop, live
#
# **Algorithm 1** (the paper's, with its line numbers)
#
# | line | |
# |---:|:---|
# | 1 | **Input:** set $\mathcal T$ of $N$ tasks, demonstration data $\mathcal D^{\mathrm{dem}}_i$ for task $i = 1, \dots, N$ |
# | 2 | **Input:** adaptation learning rate $\alpha$, meta-learning rate $\beta$ |
# | 3 | Initialise the meta-parameter $\theta_0$ |
# | 4 | **for** $k = 0, 1, \dots$ **do** |
# | 5 | $\quad$ **for** $i \in \mathcal T$ **do** |
# | 6 | $\qquad$ Execute the meta-policy $\pi_{\theta_k}$ in task $i$ to collect $\mathcal D^{\mathrm{tr}}_i$ |
# | 7 | $\qquad$ **Task adaptation:** compute $\theta_{k,i}$ from $\mathcal D^{\mathrm{tr}}_i$ and $\mathcal D^{\mathrm{dem}}_i$ by (adapt) |
# | 8 | $\qquad$ Execute the adapted policy $\pi_{\theta_{k,i}}$ in task $i$ to collect $\mathcal D^{\mathrm{val}}_i$ |
# | 9 | $\quad$ **end for** |
# | 10 | $\quad$ **Meta-parameter update:** $\theta_{k+1}$ by (meta) from all $\mathcal D^{\mathrm{val}}_i$ |
# | 11 | **end for** |

# %%
figure = two_levels()
plt.show()

# %% [markdown]
# *Figure 3. One iteration. Blue boxes are policies, yellow ones data; dashed arrows are what the demonstration does. The meta-policy $\theta_k$ (in EMRLD-WS: after one cloning step, $\tilde\theta_{k,i}$)
# collects $\mathcal D^{\mathrm{tr}}_i$; one gradient of both losses makes the adapted policy of task $i$; its episodes $\mathcal D^{\mathrm{val}}_i$ change the meta-policy, and the gradient of that change
# goes back through the whole adaptation (dotted).*
#
# Here is one iteration from your own parts. Rollouts have the axes `(task, episode, time, dim)`; `together` stacks your twelve vectors, so that all tasks can be rolled out at once, and
# `trust_region_step` is TRPO's step of notebook 05 along the gradient that you hand it.


# %% tags=["algorithm-1"]
def iteration(params, learner, random):
    """Return theta_{k+1}, D^tr, D^val and what the step did: lines 5 to 10."""
    start = warm_start(params, data, rule)  # EMRLD-WS only: the first half of `adapted`
    before = score(collect(environment, data.tasks, start, config.episodes, random))  # line 6
    parts = by_hand.separate(params, before, data, rule)
    theta = policy.to_vector(params).requires_grad_()
    vectors = [adapted(theta, part) for part in parts]  # line 7
    task_params = by_hand.together(vectors, params)
    after = score(collect(environment, data.tasks, task_params, config.episodes, random))  # line 8
    parts = by_hand.with_validation(parts, params, after, vectors)
    loss = iteration_loss(theta, parts, adapted, task_surrogate).sum()
    (gradient,) = torch.autograd.grad(loss, theta)
    collected = TaskData(before, after, data)
    moved = by_hand.trust_region_step(  # line 10
        learner, params, float(loss.detach()), gradient, collected, rule, random
    )
    return moved[0], before, after, moved[1]


# %% [markdown]
# The package has the same loop, with all tasks in one batch and the same draws. After one iteration both must be at the same $\theta_1$:

# %% tags=["same-step"]
clock.at("the loop, live")
random = train.iteration_generator(config.seed, iteration=0)
by_parts, _, _, moved = iteration(meta_params, config.learner(meta_params), random)
package = next(train.meta_train(config, data))
start, *ends = map(policy.to_vector, (meta_params, by_parts, package.meta_params))
lengths = [float((end - start).norm()) for end in ends]
print(f"theta_1 lies {lengths[0]:.4f} from theta_0 by your parts, {lengths[1]:.4f} by the package")
print(f"KL of the step: {moved.kl:.4f} and {package.record.kl:.4f} nats")
assert check.agree(ends[0] - start, ends[1] - start, tolerance=1e-3)

# %% [markdown]
# Now repeat it. The first three iterations are yours; then the package, which is faster, goes on from your $\theta_3$. The dotted line is a mean return of 70, close to what the
# demonstrator gets. The grey curve is the return of $\mathcal D^{\mathrm{tr}}$, so after the warm start and *before* the adaptation step; the coloured one is that of
# $\mathcal D^{\mathrm{val}}$, *after* it.
#
# **Predict first.** Which of the two curves will rise, and when will they part?

# %%
guess.ask(
    "curves",
    "what will the curves do?",
    [
        "both rise as one",
        "both rise, the coloured one far ahead",
        "only the coloured one rises",
    ],
)

# %% tags=["live-training", "statistical", "tolerance:abs=45", "tolerance:whole=70", "reveal"]
config = TrainConfig(
    algorithm="emrld-ws", demos="optimal", seed=0, iterations=100, stop_at_return=70.0
)
curve, record, started = LiveCurve("emrld-ws", 100), train.Recorder(()), time.perf_counter()
params, learner = meta_params, config.learner(meta_params)
for number in range(3):  # your parts
    random = train.iteration_generator(config.seed, number)
    params, before, after, moved = iteration(params, learner, random)
    curve.add(record(number, before, after, 0, moved))
rest = train.meta_train(config, data, params, tuple(curve.records), learner.state())
stored = runs.SHIPPED / "point2d-optimal-emrld-ws-seed0"  # takes over where the machine is too busy
for iterate in while_it_is_quick(rest, stored, usual=45, minutes=8):
    curve.add(iterate.record)
curve.finish()
trained, last = iterate.meta_params, iterate.record
print(f"{len(curve.records)} meta-iterations in {time.perf_counter() - started:.0f} s")
returns = f"{last.return_before:.1f} after the warm start, {last.return_after:.1f} after the step"
assert last.return_after > max(40, last.return_before)
guess.reveal("curves", f"both rise, the coloured one far ahead; at the end {returns}")

# %% [markdown] tags=["reveal"]
# *Figure 4. Mean return over twelve training tasks and twenty episodes each, against meta-iterations, as measured on
# the machine that ran this notebook. The coloured curve climbs towards the dotted line; the grey one rises, too, and stays behind.*
#
# The training ends when the mean return reaches 70. If yours used up its 100 iterations, your processor's digits drew a slow
# lot: the policy it has by then serves for the rest of this notebook as well.
#
# In the first iterations the warm start changes nothing one can see; later it turns the policy towards its goal, but not all the way: the adaptation step does the rest.

# %% [markdown]
# ## 5 · What one gradient step does
#
# **Predict first.** You have trained a meta-policy. Let it act as it is, without any step, in all twelve tasks. What is its mean return?

# %%
guess.ask("meta", "mean return of the meta-policy itself, over the twelve tasks")

# %% tags=["what-one-step-does", "statistical", "tolerance:abs=45", "reveal"]
clock.at("what one gradient step does")
random = torch.Generator().manual_seed(7)
warm = warm_start(trained, data, rule)
before = score(collect(environment, data.tasks, warm, 20, random))
stages = {
    "meta-policy": trained,
    "after the warm start": warm,
    "after the adaptation step": adapt(trained, before, data, rule),
}
shown = {
    name: collect(environment, data.tasks, params, 20, random) for name, params in stages.items()
}
means = {name: float(episode_returns(rollout).mean()) for name, rollout in shown.items()}
assert means["after the adaptation step"] > means["meta-policy"] + 30
guess.reveal("meta", ", ".join(f"{name} {mean:.1f}" for name, mean in means.items()))

# %% tags=["statistical", "tolerance:abs=45", "reveal"]
task = 2
figure, panels = plt.subplots(1, 3, figsize=(11, 3.1), sharey=True)
for axes, (name, rollout) in zip(panels, shown.items(), strict=True):
    environment.draw_tasks(axes, data.tasks[task : task + 1])
    colour = "#777777" if name == "meta-policy" else plotting.LOOKS["emrld-ws"]["color"]
    plotting.trajectories(rollout, axes, task, episodes=20, color=colour)
    plotting.demonstration(data.states[task, 0, : int(data.lengths()[task])], axes)
    axes.set_title(f"{name}: return {episode_returns(rollout)[task].mean():.0f}")
    axes.label_outer()
plt.show()

# %% [markdown] tags=["reveal"]
# *Figure 5. Task 2, twenty episodes each (thin lines): the meta-policy itself, after the warm start, and after the adaptation
# step; the demonstration is dashed, titles give the mean return. From left to right: no idea of the goal; nearly in its direction; onto it.*
#
# The meta-policy is good at *no* task, and it need not be: no single policy can walk straight to twelve goals. Training has made it easy to adapt. Two gradient steps with $\alpha = 0.01$ move a
# policy this far only because the meta-update has made these gradients count.

# %% [markdown]
# ### Exercise 4 · Which part matters?
#
# *Difficulty 2 of 3, planned for 10 minutes.* The adaptation has three parts: RL in the step ($w_{\mathrm{rl}}$), cloning in the step ($w_{\mathrm{bc}}$), and the warm start. Design an experiment that says what each adds to
# this trained policy, and how surely. `run(w_rl, w_bc, warm, seed)` below adapts it to all twelve tasks and returns the mean return of twenty episodes in each; `full` is `(w_rl, w_bc, warm)` as in training.
#
# Return a dictionary with an entry each for `"RL"`, `"cloning"` and `"warm start"`: a pair of how much return is lost when this part alone is left out, as a mean over the seeds, and the standard error of
# that mean. What else must stay the same, and which numbers' spread does the error come from? A part is left out when its weight is 0, or `warm` is `False`; neither takes another part with it.
#
# <details><summary>Hint 1: what to compare with what</summary>
# Four settings: the full one, and three in which one thing differs from it. Each runs with each of the seeds.
# </details>
#
# <details><summary>Hint 2: my errors are too large</summary>
# A seed decides the draws in all four settings alike, so its luck cancels in a difference within one seed. Take the differences first, then the standard deviation (with the number of seeds less one), then divide by
# the root of their number.
# </details>


# %%
def run(w_rl, w_bc, warm, seed, params=trained, usual=rule):
    """Return the mean return of twenty episodes per task after adapting the trained policy."""
    random = torch.Generator().manual_seed(seed)
    chosen = replace(usual, w_rl=w_rl, w_bc=w_bc, warm_start=warm)
    start = warm_start(params, data, chosen)
    before = score(collect(environment, data.tasks, start, 20, random))
    params = adapt(params, before, data, chosen)
    return float(episode_returns(collect(environment, data.tasks, params, 20, random)).mean())


# %% tags=["exercise-experiment"]
def what_parts_add(run, full, seeds):
    """Return {part: (return lost without it, standard error)} for RL, cloning and warm start."""
    ### BEGIN SOLUTION
    w_rl, w_bc, warm = full
    without = {
        "RL": (0.0, w_bc, warm),
        "cloning": (w_rl, 0.0, warm),
        "warm start": (w_rl, w_bc, False),
    }
    whole = torch.tensor([run(*full, seed) for seed in seeds])
    effects = {}
    for part, setting in without.items():
        drops = whole - torch.tensor([run(*setting, seed) for seed in seeds])
        effects[part] = (drops.mean(), drops.std() / len(seeds) ** 0.5)
    return effects
    ### END SOLUTION


# %%
checked = check.what_parts_add(what_parts_add)
experiment = what_parts_add if checked else by_hand.what_parts_add  # until yours is right

# %% [markdown]
# **Predict first**, before your experiment runs with four seeds: which parts does the policy miss when they are left out?

# %%
guess.ask(
    "matter",
    "what is missed?",
    ["RL most of all", "cloning alone", "cloning and warm start", "all three about alike"],
)

# %% tags=["which-part", "statistical", "tolerance:abs=70", "tolerance:whole=70", "reveal"]
effects = experiment(run, (rule.w_rl, rule.w_bc, True), tuple(range(4)))
effects = {part: [float(x) for x in effects[part]] for part in ("RL", "cloning", "warm start")}
figure, axes = plt.subplots(figsize=(6.4, 2.2))
for height, (drop, error) in enumerate(effects.values()):
    axes.errorbar(drop, height, xerr=2 * error, fmt="o", color="black", capsize=4)
axes.axvline(0, color="grey", linewidth=1)
axes.set(yticks=range(3), yticklabels=effects, ylim=(2.6, -0.6))
axes.set_xlabel("mean return lost without it, with two standard errors")
plt.show()
assert abs(effects["RL"][0]) < 5 < min(effects["cloning"][0], effects["warm start"][0])
told = [f"{part} {drop:.1f} (error {error:.1f})" for part, (drop, error) in effects.items()]
guess.reveal("matter", "lost without " + ", ".join(told))

# %% [markdown] tags=["reveal"]
# *Figure 6. What the mean return over twelve tasks loses when one part of the adaptation is left out: points are means over four seeds, bars two standard errors. Without RL in the step it loses next to nothing; without the
# cloning step or without the warm start much.*
#
# **The RL term of the adaptation hardly matters here**, and both cloning steps do: training has shaped a policy that needs the two together. That is no contradiction to the paper: this policy is trained, the data are
# optimal, and $w_{\mathrm{rl}} = 0.2$ is small. The rewards did their work elsewhere, in the meta-update, which is RL throughout.
#
# **How far does your experiment reach?** Its seeds draw episodes, nothing else. The errors say how surely *this* policy behaves so on *these* tasks. They do not cover other data or another training: for that,
# trainings must be drawn. Here are the five that the repository keeps, trained for 100 iterations without a stop at 70, with the same experiment:

# %% tags=["other-trainings", "tolerance:abs=3", "reveal"]
print("lost without    RL  cloning  warm start")
for seed, folder in enumerate(seeds_of(runs.SHIPPED, "point2d-optimal-emrld-ws")):
    other = runs.load_run(folder)
    theirs = partial(run, params=other.meta_params, usual=other.config.adaptation("optimal"))
    found = experiment(theirs, (0.2, 1.0, True), (0, 1))
    lost = [float(found[part][0]) for part in ("RL", "cloning", "warm start")]
    print(f"training {seed}  {lost[0]:5.1f} {lost[1]:8.1f} {lost[2]:11.1f}")
    assert abs(lost[0]) < 1 < 3 < min(lost[1:])

# %% [markdown] tags=["reveal"]
# The order is the same in every training: RL adds nothing that one could see, each cloning step something. How much differs several times over from one training to the next, so no single policy tells it; and it is less than in your policy, since a training that goes on beyond 70 lets the warm start do more of the turn. (Notebook 08 *trains* without either term.)

# %% [markdown]
# ### Turn the weights yourself
#
# The sliders repeat the adaptation of one task with other weights and the same draws. Grey are the episodes that it adapts on, $\mathcal D^{\mathrm{tr}}_i$; coloured are those of the adapted policy, with a marker where each ends.
# The colour names the algorithm whose adaptation it is: EMRLD-WS with the warm start, EMRLD without, MAML with $w_{\mathrm{bc}} = 0$ besides.
#
# **Predict first**, then move the slider: what does twice the weight on cloning, $w_{\mathrm{bc}} = 2$, do to the mean return over the twelve tasks?

# %%
guess.ask(
    "twice",
    "with w_bc = 2, the policy",
    ["reaches more goals", "does much the same", "misses many of them"],
)

# %% tags=["nbval-ignore-output"]
adapter = Adapter(environment, trained, data, rule)
adaptation_sliders(adapter, task=2)

# %% tags=["turned-weights", "statistical", "tolerance:abs=60", "tolerance:whole=70", "reveal"]
settings = [
    Weights(0.2, 1.0, True),  # Table 1
    Weights(0.2, 2.0, True),
    Weights(0.2, 1.0, False),
    Weights(2.0, 0.0, False),
]
figure = adaptation_picture(adapter, 2, settings)
display(figure)
found = [float(episode_returns(adapter.after(2, setting)).mean()) for setting in settings]
assert found[0] > found[3] + 15
usual, twice = run(rule.w_rl, 1.0, True, 0), run(rule.w_rl, 2.0, True, 0)
assert usual > twice + 5
guess.reveal("twice", f"it misses many: mean return {twice:.1f}, in place of {usual:.1f}")
print("task 2 in the four settings below:", ", ".join(f"{value:.1f}" for value in found))

# %% [markdown] tags=["reveal"]
# *Figure 7. Four settings in task 2, on the machine that ran this notebook (single tasks differ from training to training). Top left, Table 1: the warm start (grey) turns the policy most of the way, the step turns it onto the goal. Top right, $w_{\mathrm{bc}} = 2$: the step turns it too far. Bottom left, no
# warm start: one step is not enough. Bottom right, no demonstration at all: no reward in grey, so no step.*
#
# A cloning step here is no slow approach to the demonstrator: training has decided how far one turns the policy, and it made two of them end at the goal. A longer one overshoots.
# What a step does has been learned, its length included. In the last panel MAML's adaptation has nothing to work with: the grey episodes see no reward, and $w_{\mathrm{rl}} = 2$ times zero is zero.

# %% [markdown]
# **Bonus, for the fast.** Give task 2 the demonstration of task 9, which lies on the other side. Where does the adapted policy walk, and can $w_{\mathrm{rl}} = 2$ call it back? Predict, then try; `replace(data, states=...)` gives
# the same demonstrations with another field.
#
# <details><summary>An answer</summary>
#
# <pre>
# order = [9 if task == 2 else task for task in range(12)]
# wrong = replace(
#     data, states=data.states[order], actions=data.actions[order], mask=data.mask[order]
# )
# adaptation_picture(
#     Adapter(environment, trained, wrong, rule), 2, [Weights(0.2, 1.0, True), Weights(2.0, 1.0, True)]
# )
# </pre>
#
# It walks to the goal of task 9 and gets no reward, with either weight. The rewards of task 2 cannot correct the demonstration, because the warm start already leads away from where they are:
# $\mathcal D^{\mathrm{tr}}$ sees none. The demonstration decides where the policy looks; RL can only choose among what it has seen.
#
# </details>

# %% [markdown]
# ## 6 · And without demonstrations?
#
# The repository keeps five seeds each of EMRLD, EMRLD-WS and MAML (`data/runs/`, made by `python -m emrld_lite sweep data/grids/results.toml --out data/runs`).
# MAML runs the very same code with $w_{\mathrm{bc}} = 0$; it has a quarter of EMRLD's bound on the KL, with which it was ahead by 0.4 in a search of six settings with one seed (`data/grids/search.toml`).
#
# **Predict first.** EMRLD-WS is at a return of 70 or more after 100 iterations. Where is MAML after 500?

# %%
clock.at("without demonstrations")
guess.ask("maml", "MAML's mean return after 500 iterations")


# %% tags=["stored-curves", "reveal"]
def stored(name):
    """Return the stored learning curves of one algorithm, one per seed."""
    return [runs.load_run(folder).curve for folder in seeds_of(runs.SHIPPED, name)]


curves = {name: stored(f"point2d-optimal-{name}") for name in ("emrld", "emrld-ws", "maml")}
figure, axes = plt.subplots(figsize=(6.4, 3.4))
plotting.learning_curves(curves, axes)
axes.set_title("Point2D, optimal demonstrations")
plt.show()

# %% tags=["maml-starves", "reveal"]
curves["released start"] = stored("point2d-optimal-maml-xavier")
final = {
    name: [sum(row.return_after for row in curve[-10:]) / 10 for curve in seeds]
    for name, seeds in curves.items()
}
assert min(final["emrld"] + final["emrld-ws"]) >= 70
assert max(curve[59].return_after for curve in curves["maml"]) < 5  # after sixty iterations
assert max(final["maml"] + final["released start"]) < 15
for name, returns in final.items():
    print(f"{name:14} last ten iterations, per seed:", *(f"{value:5.1f}" for value in returns))
sixty = [f"{curve[59].return_after:.1f}" for curve in curves["maml"]]
print("maml after sixty iterations, per seed:", ", ".join(sixty))
guess.reveal("maml", ", ".join(f"{value:.1f}" for value in final["maml"]) + ", a seed each")

# %% [markdown] tags=["reveal"]
# *Figure 8. Mean return after adaptation; lines are means over five seeds, bands reach from the lowest to the highest; EMRLD-WS was trained for 100 iterations, EMRLD for 200, MAML for 500. With demonstrations both algorithms climb past 70; MAML stays near the bottom.*
#
# When EMRLD-WS has already found its goals, MAML has seen a handful
# of rewards by luck. Later these lucky episodes do teach it something. What?

# %% tags=["maml-walks", "reveal"]
figure, panels = plt.subplots(1, 5, figsize=(11, 2.3), sharex=True, sharey=True)
for axes, folder in zip(panels, seeds_of(runs.SHIPPED, "point2d-optimal-maml"), strict=True):
    walked = evaluate_run(runs.load_run(folder), data, steps=1).rollouts[1]
    environment.draw_tasks(axes, data.tasks)
    for path in walked.states.mean(1):  # (time, 2), the mean over a task's episodes
        axes.plot(*path.T, color=plotting.LOOKS["maml"]["color"], linewidth=0.8)
    axes.set_title(f"MAML, seed {folder.name[-1]}")
    axes.label_outer()
plt.show()

# %% [markdown] tags=["reveal"]
# *Figure 9. Where MAML's adapted policies go, each stored seed: a line per task, the mean over twenty episodes. Look at how long the lines of one seed lie together.*
#
# To walk along the semicircle, past one goal after the other, and for a good while the same way whatever the task. That
# earns about an eighth of the return of the others, and there it stays. The paper reports no learning at all. Is it the
# network's start? With that of its released code (`--network-start xavier`, the last row: three seeds) one seed has found nothing after 150 iterations, and the others do about as ours do after as many. The demonstrations change
# *where the adapted policy looks*; once a reward is found, the meta-update's RL does the rest. That is the paper's idea in one figure.

# %% [markdown]
# ### Exercise 5 · Read a figure
#
# *Difficulty 2 of 3, planned for 5 minutes.* Both panels show the first 100 iterations of stored trainings, means over five seeds. One is EMRLD, one EMRLD-WS.
#
# 1. Which is which, and by what sign do you know?
# 2. In panel B, what return does somebody get who uses the trained policy and forgets to adapt it? Is that a failed training?
# 3. Suppose that EMRLD's panel had its grey curve at 70 and its black one at 70. What would you conclude about the tasks?

# %%
figure, last_grey = unlabelled_panels()
display(figure)

# %% [markdown]
# *Figure 10. Mean return on $\mathcal D^{\mathrm{tr}}$ (grey, thin) and on $\mathcal D^{\mathrm{val}}$ (black, thick) of EMRLD and EMRLD-WS, in an order that the figure does not say. Look at the grey curves.*

# %%
guess.ask("panels", "which panel is EMRLD's?", ["A", "B"])

# %% tags=["read-the-curves", "reveal"]
assert last_grey["B"] < 5 and last_grey["A"] > 15
greys = f"grey ends at {last_grey['A']:.1f} in panel A and at {last_grey['B']:.1f} in panel B"
guess.reveal("panels", f"B is EMRLD, A is EMRLD-WS: {greys}")

# %% [markdown] tags=["reveal"]
# 1. **B is EMRLD.** $\mathcal D^{\mathrm{tr}}$ is collected by the meta-policy itself there, which is good at no task: grey lies at zero throughout. In EMRLD-WS one cloning step comes before grey is measured, so grey rises.
#    Panel A's black curve rises earlier, which could be the luck of a few seeds: it tells you less.
# 2. **About zero**, and the training has not failed: what is trained is the policy after adaptation, black. A meta-policy is not meant to be used as it is.
# 3. **That the tasks are not different enough**: one policy would do them all, and adaptation would add nothing. A benchmark of meta-learning should show both curves for this reason; the paper shows black alone.

# %% [markdown]
# ## What was shown
#
# - The adaptation step is one gradient of $w_{\mathrm{rl}} \mathcal L^{\mathrm{RL}} + w_{\mathrm{bc}} \mathcal L^{\mathrm{BC}}$; the warm start is the same step once more, on the demonstration alone.
# - The meta-gradient goes through that step: your loss, finite differences and the package agree.
# - Your parts make EMRLD-WS's first iterations, the first of them equal to the package's, which goes on from there to a return of about 70 on twelve sparse tasks; MAML stays at about an eighth of it.
# - The trained policy is good at no task before it adapts, and its adaptation lives on the demonstration; RL in the step added next to nothing to the policies that you tested.
#
# **Next** [notebook 07](07_results.ipynb): the whole comparison, and how far to trust it. Or train it yourself: `python -m emrld_lite train --help`,
# then adapt to goals it has never seen with `python -m emrld_lite evaluate`.

# %% [markdown]
# ## 7 · How lucky was I? (further reading)
#
# Your run took the number of iterations that its cell printed. Another seed takes another number, and so does the same seed on another
# processor: it adds up in another order, the last digits differ, and after a few iterations the curves part. So a
# single run says little about a method. `python -m emrld_lite lottery` trains again and again, with other seeds and as
# if on other machines (*lots*); the repository keeps the table (`data/lottery.csv`).
#
# **Predict first.** How far apart are the quickest and the slowest of twenty seeds of EMRLD-WS?

# %%
clock.at("how lucky was I")
guess.ask("lucky", "slowest against quickest", ["ten per cent", "a third", "a factor of two"])

# %% tags=["how-lucky", "reveal"]
draws = [draw for draw in lottery.load_draws() if not draw.options and draw.env == "point2d"]
rows = {
    f"{plotting.label(group[0].algorithm)} · {lot}, {threads} thread{'s' * (threads > 1)}": [
        draw.reached for draw in group
    ]
    for (_, lot, threads), group in lottery.grouped(draws).items()
}
print(lottery.summary(draws))
warm_started = [
    draw.reached for draw in draws if draw.algorithm == "emrld-ws" and draw.lot == "own"
]
assert None not in warm_started and max(warm_started) > 1.5 * min(warm_started)
without = [draw.reached for draw in draws if draw.algorithm == "emrld"]
assert 0.6 * len(without) < sum(wait is not None for wait in without) < len(without)
guess.reveal("lucky", f"{min(warm_started)} iterations against {max(warm_started)}")

# %% tags=["how-lucky-figure", "nbval-ignore-output", "reveal"]
figure, axes = plt.subplots(figsize=(7.4, 0.8 + 0.55 * len(rows)))
plotting.waits(rows, max(draw.budget for draw in draws), axes)
axes.axvline(len(curve.records), color="black", linestyle=":", label="your run")
axes.legend(loc="lower right")
plt.show()

# %% [markdown] tags=["reveal"]
# *Figure 11. Meta-iterations until the mean return first is 70: a point per seed, the median as a bar, your own run dotted; a cross
# stands for a seed that used its budget up. A lot is a machine as far as the digits go: this kind of processor (own), or one without vector kernels (plain), or one whose matrix products add
# up as on the oldest (compatible).*
#
# Every seed of EMRLD-WS gets there, under every lot, and the slowest takes nearly twice as long as the quickest. Without the warm start it takes longer, and
# a quarter of the seeds use up their 120 iterations; `data/lottery.csv` has the best return of each. Whoever shows
# one curve of a method shows one point of this figure, and a claim about the method is a claim about the whole row.

# %% [markdown]
# ## 8 · Where paper and code differ (further reading)
#
# | point | paper | released code | this workbook |
# |---|---|---|---|
# | which episodes count | $M$ trajectories | the first 20 to finish out of 30 (so short, successful ones) | exactly 20, none dropped; `--started-episodes 30` |
# | conjugate gradient | not described | direction and residual share memory, so directions are not conjugate | tested against a direct solve |
# | point's step | norm at most 0.1 | norm always 0.1 | at most; `--step-rule exact` |
# | reward elsewhere | 0 | $10^{-5}$ | 0 |
# | log-density in the adaptation | of the joint action | averaged over its dimensions | averaged; `--log-density joint` |
# | gradient that TRPO follows | of one iteration | of one iteration | running mean, half of it old; `--meta-momentum 0` |
# | network's start | not described | weights by Xavier's rule, zero biases | biases too, and a small last layer |
#
# **References** Finn, Abbeel and Levine (2017), *Model-agnostic meta-learning*; Schulman et al. (2015), *Trust region
# policy optimization*; Rengarajan et al. (2022), the paper.
