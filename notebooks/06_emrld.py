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
# One policy. Twelve goals it must tell apart. A reward that is zero nearly everywhere, and a single
# recorded path for each goal. In about a minute, on this machine, the policy will learn to look at one path, take
# **one gradient step**, and walk to the goal. Without the paths, the same method gets nowhere near.
#
# **You will be able to**
#
# - write EMRLD's adaptation step and its warm-started variant, EMRLD-WS,
# - explain what the meta-gradient differentiates, and check it by finite differences,
# - walk through Algorithm 1 line by line, and train it,
# - read from one picture what a single gradient step does to a policy.
#
# **You need** notebook 01 (Gaussian policy, policy gradient, behaviour cloning); 05 (MAML) helps. **Time** about 75 minutes, of
# which the machine computes two to three. **Paper** Section 3 (algorithm, Algorithm 1), Section 4.1 (Point2D) and
# Table 1 of Rengarajan et al., NeurIPS 2022.

# %%
import time

import matplotlib.pyplot as plt
import torch
from emrld_lite.classroom.two_levels import two_levels

from emrld_lite import losses, policy, train
from emrld_lite.adapt import adapt, warm_start
from emrld_lite.algorithms import ALGORITHMS
from emrld_lite.classroom import checks as check
from emrld_lite.classroom.clock import Clock
from emrld_lite.classroom.widgets.adaptation import adaptation_slider, adapted_paths
from emrld_lite.classroom.widgets.learning_curve import LiveCurve
from emrld_lite.config import TrainConfig
from emrld_lite.demonstrations import load_demonstrations
from emrld_lite.experiments import lottery, plotting, runs
from emrld_lite.learners import TaskData, Trpo, policies_after
from emrld_lite.rollout import Rollout, collect, episode_returns
from emrld_lite.trpo import surrogate_and_kl, surrogate_gradient

plotting.use_style()
torch.set_num_threads(1)  # leaves the other cores to you
clock = Clock(
    {
        "twelve tasks, twelve paths": 10,
        "one adaptation step": 20,
        "the meta-update": 15,
        "the loop, live": 15,
        "what one gradient step does": 15,
    }
)

# %% [markdown]
# ## 1 · Twelve tasks, twelve paths
#
# A *task* $i$ is a Markov decision process; here all tasks share states, actions and dynamics and differ in the
# goal. The reward is **sparse**: zero unless the point is within 0.2 of its goal, where it is one minus the
# distance. Within 0.02 the remaining steps are paid out at once, and the episode ends (Appendix B). So a
# return of about 80 means: straight to the goal and right onto it.
#
# Each task comes with demonstration data $\mathcal D^{\mathrm{dem}}_i$: the states and actions of **one**
# trajectory, no rewards.

# %%
clock.at("twelve tasks, twelve paths")
config = TrainConfig(algorithm="emrld-ws", demos="optimal", seed=0)
environment, score = config.environment(), config.score()  # rewards to advantages
demos = {quality: load_demonstrations(quality, "point2d") for quality in ("optimal", "suboptimal")}
figure, panels = plt.subplots(1, 2, figsize=(9, 3.4), sharey=True)
for axes, (quality, data) in zip(panels, demos.items(), strict=True):
    environment.draw_tasks(axes, data.tasks)
    for task in range(len(data.tasks)):
        plotting.demonstration(data.states[task, 0, : int(data.lengths()[task])], axes)
    axes.set_title(f"{quality}: {int(data.lengths().sum())} state-action pairs in all")
plt.show()

# %% [markdown]
# *Figure 1. The demonstrations (dashed), one per task, the goals (stars) and the regions in which a reward is paid
# (discs). Sub-optimal paths are noisy and stop short of the reward.*
#
# **Predict first.** An untrained policy tries each of the twelve tasks twenty times. In how many of these
# 240 episodes does it see any reward at all?

# %% tags=["how-sparse", "tolerance:whole=4"]
meta_params = policy.initialise(environment.state_dim, environment.action_dim, seed=0)
random = torch.Generator().manual_seed(0)
tasks = demos["optimal"].tasks  # (task, 2)
before = collect(environment, tasks, meta_params, config.episodes, random)  # (task, episode, time)
rewarded = (before.rewards.sum(-1) > 0).float().mean()
assert rewarded < 0.05
print(f"episodes that see a reward: {int((before.rewards.sum(-1) > 0).sum())} of 240")

# %% [markdown]
# Where nothing is rewarded, every advantage is zero, and so is the policy gradient. MAML, which adapts by the
# policy gradient alone, has nearly nothing to adapt with.
#
# ## 2 · One adaptation step
#
# EMRLD adds a second gradient, which is there from the first iteration on: that of behaviour cloning.
# Starting from the *meta-parameter* $\theta_k$ of iteration $k$, task $i$ gets
#
# $$\theta_{k,i} = \theta_k - \alpha\, \nabla_\theta \Big( w_{\mathrm{rl}}\, \mathcal L^{\mathrm{RL}}_i(\theta; \mathcal D^{\mathrm{tr}}_i)
# + w_{\mathrm{bc}}\, \mathcal L^{\mathrm{BC}}_i(\theta; \mathcal D^{\mathrm{dem}}_i) \Big) \Big|_{\theta = \theta_k} . \qquad\text{(adapt)}$$
#
# $\mathcal D^{\mathrm{tr}}_i$ are trajectories of the meta-policy $\pi_{\theta_k}$ in task $i$, $\alpha = 0.01$ is the adaptation learning
# rate, $\mathcal L^{\mathrm{RL}}_i = -\operatorname{mean}(\log \pi_\theta(a \mid s)\, \hat A)$ is the loss of notebook 01 with advantages $\hat A$
# (here $\log \pi_\theta$ in both losses is averaged over the action's dimensions, as in the released code), and
# the weights are $w_{\mathrm{bc}} = 1$ and $w_{\mathrm{rl}} = 0.2$ for optimal, $1$ for sub-optimal data (Table 1).
#
# ### Exercise 1 · The adaptation step
#
# *Difficulty 2 of 3, 10 minutes.* Write equation (adapt) for one task. The losses are functions of $\theta$.
# The meta-update will differentiate *through* your step, so the gradient must itself stay in the graph.
#
# <details><summary>Hint 1: which torch function?</summary>
# <code>torch.autograd.grad(loss, theta)</code> returns a tuple with the gradient.
# </details>
#
# <details><summary>Hint 2: it works, but the check says "first-order"</summary>
# By default the gradient comes back as a bare number. <code>create_graph=True</code> keeps how it depends on theta.
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
if check.adaptation_step(adaptation_step):
    emrld = ALGORITHMS["emrld"].adaptation("optimal")
    averaged = emrld.log_density  # over the action's two dimensions
    scored = score(before)
    one, data = scored.take(slice(3, 4)), demos["optimal"].take(slice(3, 4))
    theta = policy.to_vector(meta_params).requires_grad_()
    ours = adaptation_step(
        theta,
        lambda vector: losses.rl_loss(policy.from_vector(vector, meta_params), one, averaged)[0],
        lambda vector: losses.bc_loss(
            policy.from_vector(vector, meta_params), data, density=averaged
        )[0],
        emrld.w_rl,
        emrld.w_bc,
        emrld.adapt_lr,
    )
    package = adapt(meta_params, scored, demos["optimal"], emrld)  # all twelve tasks at once
    fourth = policy.to_vector({name: value[3] for name, value in package.items()})
    assert torch.allclose(ours, fourth, atol=1e-6)
    print("Your step equals emrld_lite.adapt.adapt, which takes it for all tasks at once.")

# %% [markdown]
# **EMRLD-WS** (warm start) puts one cloning step in front, with the same $\alpha$:
#
# $$\tilde\theta_{k,i} = \theta_k - \alpha\, \nabla_\theta \mathcal L^{\mathrm{BC}}_i(\theta; \mathcal D^{\mathrm{dem}}_i) \big|_{\theta = \theta_k},
# \qquad \text{then (adapt) starting from } \tilde\theta_{k,i} . \qquad\text{(ws)}$$
#
# The trajectories $\mathcal D^{\mathrm{tr}}_i$ are then collected with $\pi_{\tilde\theta_{k,i}}$, which already leans towards the goal: they are
# more likely to contain a reward.
#
# ### Exercise 2 · The warm start
#
# *Difficulty 2 of 3, 5 minutes.* Write (ws). It has a step more and nothing new.
#
# <details><summary>Hint 1: can I use Exercise 1?</summary>
# Yes: its second half <em>is</em> Exercise 1, from another start.
# </details>
#
# <details><summary>Hint 2: does the first step carry a weight?</summary>
# No. The paper's warm start is plain $\nabla \mathcal L^{\mathrm{BC}}$, without $w_{\mathrm{bc}}$.
# </details>


# %% tags=["exercise-warm-start"]
def warm_started_step(theta, rl_loss, bc_loss, w_rl, w_bc, alpha):
    """Return theta_i of EMRLD-WS, (parameter,); the losses map theta to a scalar."""
    ### BEGIN SOLUTION
    (gradient,) = torch.autograd.grad(bc_loss(theta), theta, create_graph=True)
    warm = theta - alpha * gradient
    (gradient,) = torch.autograd.grad(
        w_rl * rl_loss(warm) + w_bc * bc_loss(warm), warm, create_graph=True
    )
    return warm - alpha * gradient
    ### END SOLUTION


# %%
if check.warm_start_step(warm_started_step):
    print("In the package it is the same adapt, with one flag: Adaptation(warm_start=True).")

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
# move so that these adapted policies earn more? The paper's answer is
#
# $$\theta_{k+1} = \theta_k - \beta\, \nabla_\theta \sum_i \mathcal L^{\mathrm{RL}}_i\big(\theta_{k,i}(\theta);\, \mathcal D^{\mathrm{val}}_i\big), \qquad\text{(meta)}$$
#
# where $\theta_{k,i}(\theta)$ is the whole adaptation step as a function of where it starts. Its Jacobian is
# $I - \alpha \nabla^2(\dots)$: *second derivatives*. They carry the message "be a policy whose gradient is useful", and no
# first-order method hears it. Note where the demonstrations act: only inside $\theta_{k,i}(\theta)$.
#
# The step length $\beta$ comes from TRPO (trust-region policy optimisation): the largest step that keeps the mean
# Kullback-Leibler divergence between the adapted policies before and after it under a bound, and lowers the surrogate
#
# $$-\operatorname{mean}\Big( \tfrac{\pi_{\mathrm{new}}(a \mid s)}{\pi_{\mathrm{old}}(a \mid s)}\, \hat A \Big) .$$
#
# ### Exercise 3 · The surrogate
#
# *Difficulty 1 of 3, 5 minutes.* You get log-densities, as always.
#
# <details><summary>Hint 1: a ratio from logs</summary>
# $\pi_{\mathrm{new}} / \pi_{\mathrm{old}} = \exp(\log \pi_{\mathrm{new}} - \log \pi_{\mathrm{old}})$
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
if check.surrogate(surrogate):
    scored = score(before)
    other = policy.distribution(policy.initialise(2, 2, seed=1), scored.states)
    old = policy.distribution(meta_params, scored.states)
    logs = [policy.log_density(gaussian, scored.actions)[2] for gaussian in (other, old)]
    ours = surrogate(*logs, scored.advantages[2], scored.mask[2])
    assert torch.allclose(ours, losses.surrogate_loss(other, old, scored)[2], rtol=1e-4)
    print("Your surrogate equals emrld_lite.losses.surrogate_loss.")

# %% [markdown]
# **Is the meta-gradient right?** We nudge $\theta$ a little in a random direction, redo the adaptation, and look at how the
# surrogate changes. In double precision the two numbers must agree to many digits.

# %% tags=["meta-gradient-check"]
rule = config.adaptation("optimal")  # EMRLD-WS
double = {name: value.double() for name, value in meta_params.items()}
exact = demos["optimal"].map(lambda values: values.double())
dense = torch.Generator().manual_seed(3)  # random rewards: nothing would flow with none
data = collect(environment, tasks, meta_params, 3, random)
data = data._replace(rewards=torch.randn(data.rewards.shape, generator=dense) * data.mask)
data = score(Rollout(*(part.double() for part in data[:4]), data.success))
bundle = TaskData(data, data, exact)
piece = surrogate_gradient(double, lambda leaves: policies_after(leaves, bundle, rule, True), data)
theta = policy.to_vector(double)
direction = torch.randn(theta.shape, generator=dense, dtype=torch.float64)


def nudged(amount):
    """Return the summed surrogate of the meta-parameter moved along the direction."""
    moved = policy.from_vector(theta + amount * direction, double)
    return surrogate_and_kl(policies_after(moved, bundle, rule), piece.old, data)[0]


slope = (nudged(1e-7) - nudged(-1e-7)) / 2e-7  # a longer nudge would cross corners of the relus
assert abs(piece.gradient @ direction - slope) < 1e-5 * abs(slope)
by_gradient = float(piece.gradient @ direction)
print(f"slope of the surrogate: meta-gradient {by_gradient:.5f}, differences {slope:.5f}")

# %% [markdown]
# **Why is the KL zero at first?** At $\theta = \theta_k$ the new adapted policies *are* the old ones, so the ratio is 1 and the
# divergence 0. Only its curvature, the Fisher matrix, is not zero, and that is all a TRPO step needs (notebook 05 takes that step apart).
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
# *Figure 2. One iteration. Blue boxes are policies, yellow ones data. The meta-policy collects $\mathcal D^{\mathrm{tr}}_i$; one gradient of both losses makes the adapted policy of
# task $i$; its episodes $\mathcal D^{\mathrm{val}}_i$ change the meta-policy, and the gradient of that change goes back through the adaptation (dotted). The demonstrations enter at one place only.*
#
# Here it is once by hand. Everything happens for all twelve tasks at once; axes are `(task, episode, time, dim)`.

# %% tags=["algorithm-1"]
clock.at("the loop, live")
data = demos["optimal"]
random = train.iteration_generator(config.seed, iteration=0)
start = warm_start(meta_params, data, rule)  # EMRLD-WS only
before = score(collect(environment, data.tasks, start, config.episodes, random))  # line 6
adapted = adapt(meta_params, before, data, rule)  # line 7
after = score(collect(environment, data.tasks, adapted, config.episodes, random))  # line 8
learner = config.learner(meta_params)  # here TRPO
by_hand, step = learner.update(meta_params, TaskData(before, after, data), rule, random)  # line 10

# %%
package = next(train.meta_train(config, data)).meta_params
apart = max(float((by_hand[name] - package[name]).abs().max()) for name in package)
assert apart == 0.0
print(f"largest difference between a parameter by hand and by emrld_lite.train.meta_train: {apart}")

# %% [markdown]
# Now repeat it. The dotted line is a mean return of 70, close to what the demonstrator earns. The grey curve is the
# return *before* the adaptation step (for EMRLD-WS: of the warm-started policy), the coloured one *after* it.
#
# **Predict first.** Which of the two curves will rise, and when will they part?

# %% tags=["live-training", "statistical", "tolerance:abs=45", "tolerance:whole=70"]
curve = LiveCurve("emrld-ws", iterations=100)
config = TrainConfig(
    algorithm="emrld-ws", demos="optimal", seed=0, iterations=100, stop_at_return=70.0
)
started = time.perf_counter()
for iterate in train.meta_train(config, demos["optimal"]):
    curve.add(iterate.record)
curve.finish()
seconds = time.perf_counter() - started
trained, last = iterate.meta_params, iterate.record
print(f"{len(curve.records)} meta-iterations, of 100 at most, in {seconds:.0f} s")
print(
    f"mean return: {last.return_before:.1f} before the adaptation step, {last.return_after:.1f} after"
)
assert last.return_after > max(40, last.return_before)

# %% [markdown]
# *Figure 3. Mean return over twelve training tasks and twenty episodes each, against meta-iterations, as measured on
# the machine that ran this notebook.*
#
# The training ends when the mean return reaches 70. If yours used up its 100 iterations, your processor's digits drew a slow
# lot: the policy it has by then serves for the rest of this notebook as well.
#
# Both rise. The grey curve is the policy after the warm start, one cloning step on one path; in the first iterations
# that step changes nothing one can see, and later it points the policy towards its goal. The coloured curve adds one
# step on path and rewards together. The meta-policy they both start from does *not* become good at any task, and it
# must not: no single policy can walk to twelve goals. It becomes easy to adapt, as section 5 shows.
#
# ### How lucky was I?
#
# Your run took the number of iterations that the cell printed. Another seed takes another number, and so does the same seed on another
# processor: it adds up in another order, the last digits differ, and after a few iterations the curves part. So a
# single run says little about a method. `python -m emrld_lite lottery` trains again and again, with other seeds and as
# if on other machines (*lots*); the repository keeps the table (`data/lottery.csv`).
#
# **Predict first.** How far apart are the quickest and the slowest of twenty seeds: ten per cent, or a factor of two?

# %% tags=["how-lucky"]
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

# %% tags=["how-lucky-figure", "nbval-ignore-output"]
figure, axes = plt.subplots(figsize=(7.4, 0.8 + 0.55 * len(rows)))
plotting.waits(rows, max(draw.budget for draw in draws), axes)
axes.axvline(len(curve.records), color="black", linestyle=":", label="your run")
axes.legend(loc="lower right")
plt.show()

# %% [markdown]
# *Figure 4. Meta-iterations until the mean return first is 70: a point per seed, the median as a bar, your own run dotted; a cross
# stands for a seed that used its budget up. A lot is a machine as far as the digits go: this kind of processor (own), or one without vector kernels (plain), or one whose matrix products add
# up as on the oldest (compatible).*
#
# Every seed of EMRLD-WS gets there, under every lot, and the slowest takes nearly twice as long as the quickest. Without the warm start it takes longer, and
# a quarter of the seeds use up their 120 iterations; `data/lottery.csv` has the best return of each. Whoever shows
# one curve of a method shows one point of this figure, and a claim about the method is a claim about the whole row.
#
# ## 5 · What one gradient step does
#
# One training task, twenty episodes each: with the meta-policy itself, after the warm start (one step on the path), and
# after the adaptation step (path and rewards together).

# %% tags=["what-one-step-does"]
clock.at("what one gradient step does")
task = 2
one = demos["optimal"].take(slice(task, task + 1))
random = torch.Generator().manual_seed(7)
warm = warm_start(trained, one, rule)
collected = score(collect(environment, one.tasks, warm, 20, random))
stages = {
    "meta-policy": trained,
    "after the warm start": warm,
    "after the adaptation step": adapt(trained, collected, one, rule),
}
shown = {
    name: collect(environment, one.tasks, params, 20, random) for name, params in stages.items()
}

# %% tags=["statistical", "tolerance:abs=45"]
figure, panels = plt.subplots(1, 3, figsize=(11, 3.1), sharey=True)
for axes, (name, rollout) in zip(panels, shown.items(), strict=True):
    environment.draw_tasks(axes, one.tasks)
    plotting.trajectories(rollout, axes, episodes=20)
    plotting.demonstration(one.states[0, 0], axes)
    axes.set_title(f"{name}: return {episode_returns(rollout).mean():.0f}")
plt.show()
returns = [float(episode_returns(rollout).mean()) for rollout in shown.values()]
print("mean returns:", ", ".join(f"{mean:.1f}" for mean in returns))
assert returns[2] > returns[0] + 20

# %% [markdown]
# *Figure 5. Twenty episodes (thin lines) of one task before adaptation, after the warm start and after the adaptation
# step; the demonstration is dashed. Returns are means over the episodes.*
#
# From left to right: no idea of the goal; in the right direction; onto the goal. Two gradient steps with $\alpha = 0.01$ move a
# policy this far only because meta-training has made its gradient count.
#
# **Turn the weights yourself.** The sliders repeat the adaptation step with other weights and the same random draws. Dotted are the
# episodes that it adapts on, $\mathcal D^{\mathrm{tr}}_i$; solid are those of the adapted policy. What happens with $w_{\mathrm{bc}} = 0$? The warm start still points the policy towards the goal; take
# its tick away too, and the demonstration plays no part at all. What happens with $w_{\mathrm{rl}} = 2$?

# %% tags=["nbval-ignore-output"]
adaptation_slider(environment, trained, demos["optimal"], rule, task=8)

# %%
figure = adapted_paths(
    environment, trained, demos["optimal"], rule, seed=0, task=8, w_rl=0.2, w_bc=1.0
)
figure

# %% [markdown]
# *Figure 6. The sliders' default, as a still picture: task 8 with the weights of Table 1.*
#
# ### And without demonstrations?
#
# The repository keeps three seeds of EMRLD, EMRLD-WS and MAML (`data/runs/`, made by `python -m emrld_lite train` with
# the settings of then, which `data/README.md` names).
# **Predict first:** where will MAML be after as many iterations?


# %% tags=["stored-curves"]
def stored(name):
    """Return the stored learning curves of one algorithm, one per seed."""
    return [runs.load_run(folder).curve for folder in sorted(runs.SHIPPED.glob(f"{name}-seed*"))]


curves = {name: stored(f"point2d-optimal-{name}") for name in ("emrld", "emrld-ws", "maml")}
figure, axes = plt.subplots(figsize=(6.4, 3.4))
plotting.learning_curves(curves, axes)
axes.set_title("Point2D, optimal demonstrations")
plt.show()

# %% tags=["maml-starves"]
curves["released start"] = stored("point2d-optimal-maml-xavier")
final = {
    name: [sum(row.return_after for row in curve[-10:]) / 10 for curve in seeds]
    for name, seeds in curves.items()
}
assert min(final["emrld"] + final["emrld-ws"]) >= 70
assert max(curve[59].return_after for curve in curves["maml"]) < 5  # after sixty iterations
assert max(final["maml"]) < 15
assert max(final["released start"]) < 1
for name, returns in final.items():
    print(f"{name:14} last ten iterations, per seed:", *(f"{value:5.1f}" for value in returns))
sixty = [f"{curve[59].return_after:.1f}" for curve in curves["maml"]]
print("maml after sixty iterations, per seed:", ", ".join(sixty))

# %% [markdown]
# *Figure 7. Mean return after adaptation; lines are means over three seeds, bands reach from the lowest to the highest.*
#
# MAML runs the very same code with $w_{\mathrm{bc}} = 0$. When EMRLD-WS has already found its goals, MAML has seen a handful
# of rewards by luck. Later these lucky episodes do teach it something: to walk up the middle, past the goals that
# lie there, for about a tenth of the return of the others. The paper reports no learning at all, and with the
# network's start of its released code (`--network-start xavier`) we find the same: all three seeds stay under 1. The demonstrations change
# *where the adapted policy looks*; once a reward is found, the meta-update's RL does the rest. That is the paper's idea in one figure.

# %% [markdown]
# ## Where paper and code differ
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
# ## What was shown
#
# - The adaptation step is one gradient of $w_{\mathrm{rl}} \mathcal L^{\mathrm{RL}} + w_{\mathrm{bc}} \mathcal L^{\mathrm{BC}}$; the warm start is one more.
# - The meta-gradient goes through that step; finite differences agree.
# - EMRLD-WS reaches a return of 70 on twelve sparse tasks in about a minute; MAML stays at a tenth of it.
#
# **Next** [notebook 07](07_results.ipynb): the whole comparison, and how far to trust it. Or train it yourself: `python -m emrld_lite train --help`,
# then adapt to goals it has never seen with `python -m emrld_lite evaluate`.
#
# **References** Finn, Abbeel and Levine (2017), *Model-agnostic meta-learning*; Schulman et al. (2015), *Trust region
# policy optimization*; Rengarajan et al. (2022), the paper.
