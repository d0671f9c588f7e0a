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
# # 04 · Theorem 1: what it proves, and what it does not
#
# The paper backs its algorithm with a theorem: a lower bound on how much one meta-iteration improves the policy. In
# environments small enough to solve exactly we can put *numbers* on both sides of every line of its proof, and most of these numbers will come
# from functions that you write. You will see that the theorem is right, that half of it can be thrown away, and that the sentence after it, the one
# that leads to the algorithm, fails in an environment with **two states**.
#
# **You will be able to**
#
# - derive Theorem 1 move by move, and say which rule and which assumption each move uses,
# - say in which of its inequalities the bound loses how much,
# - prove that the first group of its terms is never positive,
# - derive the two states in which the step from theorem to algorithm fails.
#
# **You need** linear algebra (a linear system, an expectation as a sum), paper and a pencil. **Time**: the core, Sections 1 to 5, is planned for
# 90 minutes; further reading, Sections 6 to 11, for another 60, in any order. The machine computes one of them. **Paper** Sections 2 and 3, Appendix A of
# Rengarajan et al., NeurIPS 2022.

# %%
import matplotlib.pyplot as plt
import numpy as np
import torch

from emrld_lite.adapt import Adaptation
from emrld_lite.classroom import checks as check
from emrld_lite.classroom.clock import Clock
from emrld_lite.classroom.predict import Guesses
from emrld_lite.classroom.proof_drops import DROPS, MOVES, drops
from emrld_lite.classroom.sketches.goal_corridor import corridor
from emrld_lite.classroom.sketches.swamp import two_states
from emrld_lite.classroom.sketches.waterfall import waterfall
from emrld_lite.classroom.widgets import bounds
from emrld_lite.classroom.widgets import swamp as swamp_widget
from emrld_lite.experiments import plotting
from emrld_lite.tabular import (
    LEFT_RIGHT,
    Claims,
    ExactMetaRL,
    TabularMDP,
    corridor_step,
    exact_meta_train,
    figures,
    gridworld,
    many_families,
    mixed,
    optimal_policy,
    proof_lines,
    random_family,
    related_bounds,
    slippery_pair,
    theorem_1,
)
from emrld_lite.tabular.search import hunt

plotting.use_style()
torch.set_num_threads(1)  # leaves the other cores to you
guess = Guesses()

# %%
clock = Clock(
    {
        "environments one can solve": 15,
        "the proof": 35,
        "what the bound promises": 10,
        "group 1": 12,
        "two states": 18,
    },
    further={
        "tighter and older bounds": 12,
        "the search and the repair": 10,
        "from likelihood to distance": 10,
        "exact EMRLD": 14,
        "break an assumption": 6,
        "what the meta-gradient leaves out": 8,
    },
)

# %% [markdown]
# ## 1 · Environments one can solve
#
# A **finite Markov decision process** has states $s$, actions $a$, transition probabilities $P(s' \mid s, a)$, rewards
# $R(s, a)$, a distribution $\rho$ of first states and a discount $0 \le \gamma < 1$. A policy is a table $\pi(a \mid s)$ (the paper
# writes $\pi(s, a)$). Averaging over the actions leaves a Markov chain with $P_\pi(s' \mid s) = \sum_a \pi(a \mid s)\, P(s' \mid s, a)$ and
# rewards $R_\pi(s) = \sum_a \pi(a \mid s)\, R(s, a)$. Everything we need is then a sum or a linear system:
#
# | symbol | name | equation |
# |---|---|---|
# | $V^\pi(s)$ | value | $(I - \gamma P_\pi)\, V = R_\pi$ |
# | $Q^\pi(s, a)$ | action value | $Q = R + \gamma P V$ |
# | $A^\pi(s, a)$ | advantage | $A = Q - V$, so $\sum_a \pi(a \mid s)\, A^\pi(s, a) = 0$ |
# | $J(\pi)$ | objective | $J = \sum_s \rho(s)\, V^\pi(s)$ |
# | $d^\pi(s)$ | visitation, a distribution | $d^\pi(s) = (1 - \gamma) \sum_{t \ge 0} \gamma^t\, \mathbb P(s_t = s)$ |
#
# The last row says it in words: $d^\pi(s)$ is the share of its *discounted time* that the policy spends in $s$. And a return times $1 - \gamma$ is a return **per step**, a mean over discounted time.
#
# A **task family** is a list of such environments, one per task $i$, with task probabilities $p(i)$. Ours is a corridor: five cells in a
# row, the goal at the left end or at the right end. The move into the goal pays 1, and the walk starts again in the middle. The *old* policy tosses a coin, the
# *demonstrator* makes the right move nine times in ten, and the *new* policy is half of each.
# **Change it!** The numbers of the proof follow; where an assertion stops you, you have found a family of which a sentence here is not true.

# %% tags=["the-family"]
clock.at("environments one can solve")
gamma, step_size = 0.9, 0.5
mdps = gridworld(1, 5, [(0, 0), (0, 4)], start=(0, 2), discount=gamma, moves=LEFT_RIGHT)
task_weights = torch.tensor([0.5, 0.5], dtype=torch.float64)  # p(i)
demo = [mixed(optimal_policy(mdp), noise=0.2) for mdp in mdps]  # (state, action) per task
old = [torch.full_like(policy, 1 / policy.shape[1]) for policy in demo]  # tosses a coin
new = [(1 - step_size) * before + step_size * goal for before, goal in zip(old, demo, strict=True)]
family = (mdps, task_weights, old, new, demo)
advantage = torch.stack([mdp.advantage(policy) for mdp, policy in zip(mdps, old, strict=True)])
pi_old, pi_new, pi_demo = (torch.stack(policies) for policies in (old, new, demo))
average_of_old = (pi_old * advantage).sum(-1).abs().max()
assert average_of_old < 1e-12
print(f"the old policy's average advantage is {average_of_old:.11f} at most, in every state")

# %% [markdown]
# ### Exercise 1 · How often is each state visited?
#
# *Difficulty 2 of 3, planned for 8 minutes.* The table defines $d^\pi$ as an infinite sum. Turn it into a linear system, and solve that.
#
# <details><summary>Hint 1: one step of the chain</summary>
# It takes the distribution p of today's state to P<sub>π</sub><sup>T</sup> p. So the distribution at time t is a power of a matrix, times ρ.
# </details>
#
# <details><summary>Hint 2: the sum over time</summary>
# It is a geometric series, of a matrix in place of a number. What is 1 + q + q² + …, and what takes the place of the division?
# </details>
#
# <details><summary>Hint 3: torch</summary>
# <code>torch.einsum("sa,sat->st", policy, transition)</code> is P<sub>π</sub>; <code>torch.linalg.solve(matrix, vector)</code> solves a system; <code>matrix.T</code> transposes;
# <code>torch.eye(n, dtype=torch.float64)</code> is the unit matrix.
# </details>


# %% tags=["exercise-visitation"]
def visitation(transition, initial, policy, discount):
    """Return d, (state,), from (state, action, state), (state,), (state, action), a number."""
    ### BEGIN SOLUTION
    step = torch.einsum("sa,sat->st", policy, transition)
    matrix = torch.eye(len(initial), dtype=torch.float64) - discount * step
    return torch.linalg.solve(matrix.T, (1 - discount) * initial)
    ### END SOLUTION


# %%
solved = check.visitation(visitation)


def visits(mdp, policy):
    """Return d by your function, or by the package's until yours is right."""
    if not solved:
        return mdp.visitation(policy)
    ours = visitation(mdp.transition, mdp.initial, policy, float(mdp.discount))
    return torch.as_tensor(ours).double()


def told(values, digits=3):
    """Return numbers as text, without a minus before zero."""
    numbers = torch.as_tensor(values).flatten()
    return ", ".join(f"{round(float(x), digits) + 0.0:.{digits}f}" for x in numbers)


assert check.agree(visits(mdps[0], demo[0]), mdps[0].visitation(demo[0]))
print("the demonstrator's d in task 0:", told(visits(mdps[0], demo[0])))
print("TabularMDP.visitation has it  :", told(mdps[0].visitation(demo[0])))

# %% [markdown]
# <details><summary>What happened, after you have solved it</summary>
#
# The distribution at time $t$ is $(P_\pi^{\mathsf T})^t \rho$, and $\sum_t \gamma^t (P_\pi^{\mathsf T})^t$ is the inverse of $I - \gamma P_\pi^{\mathsf T}$. So $d$ solves
# $(I - \gamma P_\pi)^{\mathsf T} d = (1 - \gamma)\, \rho$, the *transposed* system of $V$: values look forward, visits come from behind.
#
# </details>
#
# From here on $d$ is your $d$.

# %%
d_old, d_new, d_demo = (
    torch.stack([visits(mdp, policy) for mdp, policy in zip(mdps, policies, strict=True)])
    for policies in (old, new, demo)
)  # (task, state)
figure, panels = plt.subplots(1, 2, figsize=(9.5, 3.2), sharey=True)
for task, (axes, end) in enumerate(zip(panels, (0, 4), strict=True)):
    shares = {"old": d_old[task], "new": d_new[task], "demonstrator": d_demo[task]}
    corridor(axes, shares, start=2, goal=end)
    axes.set_title(f"task {task}")
panels[0].set_ylabel("visitation d (sums to 1)")
panels[1].legend()
plt.show()

# %% [markdown]
# *Figure 1. The corridor of each task, and where three policies spend their discounted time. The nearer a policy is to the demonstrator, the more of its time lies
# between start and goal. The goal itself is never stayed in: the move into it ends in the middle.*
#
# ## 2 · The statement, and its proof by moves
#
# In iteration $k$ the **meta-policy** $\pi_k$ is adapted to each task, which gives $\pi_{k,i}$; after the meta-update it is
# $\pi_{k+1,i}$. Below, "old" is $\pi_{k,i}$, "new" is $\pi_{k+1,i}$, and $A_i$ is short for $A_i^{\pi_{k,i}}$, the **old** advantage. The value of a meta-policy is
# that of its adapted policies, $J_{\mathrm{meta}}(\pi_k) = \mathbb E_{i \sim p}[J_i(\pi_{k,i})]$.
#
# > **Assumption 1.** $\mathbb E_{a \sim \pi^{\mathrm{dem}}_i(\cdot \mid s)}[A_i(s, a)] \ge \Delta$ for every state $s$ and every task $i$: in every state, the
# > demonstrator's next action is better than the old policy's by $\Delta$.
#
# > **Theorem 1.** Under Assumption 1, with $C_1 = \max_{i, s, a} |A_i(s, a)|$, the improvement of one meta-iteration is at least the sum of two groups:
#
# $$\begin{aligned} J_{\mathrm{meta}}(\pi_{k+1}) - J_{\mathrm{meta}}(\pi_k) \;\ge\;& \underbrace{\frac{1}{1-\gamma}\, \mathbb E_{i,\; (s,a) \sim d_i^{\pi_{k,i}}}\Big[\frac{\pi_{k+1,i}(a \mid s)}{\pi_{k,i}(a \mid s)}\, A_i(s, a)\Big] - \frac{2 C_1}{1-\gamma}\, \mathbb E_i\big[D_{TV}^{\pi_{k,i}}(\pi_{k+1,i}, \pi_{k,i})\big]}_{\text{group 1}} \\ &+ \underbrace{\frac{\Delta}{1-\gamma} - \frac{2 C_1}{1-\gamma}\, \mathbb E_i\big[D_{TV}^{\pi_{k+1,i}}(\pi_{k+1,i}, \pi_i^{\mathrm{dem}})\big]}_{\text{group 2}} . \end{aligned}$$
#
# Here $D_{TV}(\pi_1, \pi_2) = \frac12 \sum_a |\pi_1(a \mid s) - \pi_2(a \mid s)|$ is the total variation in a state $s$, and a policy as superscript, $D_{TV}^{\pi}$, means its
# average over $s \sim d^\pi$. (The paper prints the two as Assumption 3.1 and Theorem 3.2; here they are called Assumption 1 and Theorem 1.)
#
# ### Exercise 2 · The numbers of Assumption 1
#
# *Difficulty 1 of 3, planned for 5 minutes.* Find $C_1$, and the largest $\Delta$ that the assumption allows. The proof below will use your two numbers.
#
# <details><summary>Hint 1: what is averaged, what is not?</summary>
# The actions, by the demonstrator. Not the states, not the tasks: the assumption speaks of every one of them.
# </details>
#
# <details><summary>Hint 2: what would make the assumption false?</summary>
# A single state of a single task in which the average lies below Δ. And for C<sub>1</sub>: a terrible action counts as much as a wonderful one.
# </details>


# %% tags=["exercise-assumption"]
def assumption_numbers(advantage, demo):
    """Return (C1, Delta) from two tensors (task, state, action)."""
    ### BEGIN SOLUTION
    return advantage.abs().max(), (demo * advantage).sum(-1).min()
    ### END SOLUTION


# %% tags=["assumption-1"]
solved_numbers = check.assumption_numbers(assumption_numbers)
clock.at("the proof")
theorem = theorem_1(*family)
c1, delta = float(theorem.c1), float(theorem.delta)  # until yours are right, the package's
if solved_numbers:
    c1, delta = (float(number) for number in assumption_numbers(advantage, pi_demo))
assert check.agree([c1, delta], [theorem.c1, theorem.delta])
assert delta > 0
print(f"C1 = {c1:.4f}, Delta = {delta:.4f}: Assumption 1 holds with a positive Delta")

# %% [markdown]
# Now the proof, as numbered moves, each with the one rule it uses. Under each, its two sides on our family, as
# `proof_lines` computes them with your $C_1$ and $\Delta$, and beside them the left side once more, computed in the cell from your $d$.

# %%
lines = {line.name: line for line in proof_lines(*family, Claims(delta=delta, c1=c1))}


def show(name, ours=None):
    """Print both sides of a line of the proof, and its left side from your own parts."""
    line = lines[name]
    assert line.holds(), name
    print(f"{name:16} {told(line.left, 6)} {line.relation} {told(line.right, 6)}", end="")
    if ours is not None:
        assert check.agree(ours, line.left), name
        print(f"   (from your parts: {told(ours, 6)})", end="")
    print()


def expect(d, table):
    """Return the average over tasks and over states from d, of a table summed over its actions."""
    return (task_weights * (d[..., None] * table).sum((-2, -1))).sum()


# %% [markdown]
# **Move 1 (definition).** Values are discounted sums of rewards, so $J_i(\pi) = \sum_s \rho(s) V^\pi(s)$ and also
# $J_i(\pi) = \frac{1}{1-\gamma} \sum_s d^\pi(s) \sum_a \pi(a \mid s) R(s, a)$. (One number per task, for the new policy.)

# %% tags=["proof-objective"]
rewards = torch.stack([mdp.reward for mdp in mdps])
show("objective", (d_new * (pi_new * rewards).sum(-1)).sum(-1) / (1 - gamma))

# %% [markdown]
# **Move 2 (performance difference lemma, Lemma 1; Kakade and Langford, 2002).** For any two policies $\pi_1$, $\pi_2$ in one environment,
#
# $$J(\pi_1) - J(\pi_2) = \frac{1}{1 - \gamma}\, \mathbb E\big[A(s, a)\big] ,$$
#
# but whose advantage is it, and over whose states and whose actions goes the mean?
#
# *Proof.* Follow $\pi_1$ from $s_0 \sim \rho$. In expectation, $A^{\pi_2}(s_t, a_t) = R(s_t, a_t) + \gamma V^{\pi_2}(s_{t+1}) - V^{\pi_2}(s_t)$. Multiply by $\gamma^t$
# and sum over $t$: the values **telescope** and only $-V^{\pi_2}(s_0)$ is left, so the sum is $J(\pi_1) - J(\pi_2)$. And for any function $f$,
# $\sum_t \gamma^t\, \mathbb E f(s_t, a_t)$ is $\frac{1}{1-\gamma}$ times the mean of $f$ over the states $d^{\pi_1}$ and the actions of $\pi_1$, by the definition of $d$. $\square$
#
# ### Exercise 3 · The right side of the lemma
#
# *Difficulty 2 of 3, planned for 6 minutes.* You get more than you need: read the proof, and choose whose states and whose actions count.
#
# <details><summary>Hint 1: whose trajectory was followed in the proof?</summary>
# π<sub>1</sub> is the new policy here, π<sub>2</sub> the old one. Only the advantage is the old one's.
# </details>
#
# <details><summary>Hint 2: shapes</summary>
# <code>visits[:, None]</code> is (state, 1) and multiplies a table (state, action).
# </details>


# %% tags=["exercise-lemma"]
def performance_difference(advantage, visits_old, visits_new, old, new, discount):
    """Return J(new) - J(old) from tables (state, action), visits (state,) and a number."""
    ### BEGIN SOLUTION
    return (visits_new[:, None] * new * advantage).sum() / (1 - discount)
    ### END SOLUTION


# %% tags=["proof-lemma-1"]
solved_lemma = check.performance_difference(performance_difference)


def gain(mdp, before, after):
    """Return J(after) - J(before) by your lemma, or by two solves until yours is right."""
    if not solved_lemma:
        return float(mdp.objective(after) - mdp.objective(before))
    d_before, d_after = visits(mdp, before), visits(mdp, after)
    parts = mdp.advantage(before), d_before, d_after, before, after
    return float(performance_difference(*parts, float(mdp.discount)))


gains = torch.tensor([gain(*each) for each in zip(mdps, old, new, strict=True)]).double()
show("lemma_1", gains)

# %% [markdown]
# **What happened.** States, actions and time belong to the policy that walks; only the yardstick, $A^{\pi_2}$, belongs to the other one:
#
# $$J(\pi_1) - J(\pi_2) = \frac{1}{1 - \gamma}\, \mathbb E_{s \sim d^{\pi_1},\, a \sim \pi_1}\big[A^{\pi_2}(s, a)\big] . \qquad\text{(1)}$$
#
# With the *old* states in place of the new ones it is the surrogate that policy-gradient methods climb, right only near the old policy. The whole theorem is about that difference.
#
# **Move 3 (the lemma for meta-policies).** Insert the definition of $J_{\mathrm{meta}}$; pull the difference into the expectation
# (linearity); apply the lemma in each task; write the two expectations as one:
#
# $$\begin{aligned}(1-\gamma)\big(J_{\mathrm{meta}}(\pi_{k+1}) - J_{\mathrm{meta}}(\pi_k)\big)
# &= (1-\gamma)\big(\mathbb E_i[J_i(\pi_{k+1,i})] - \mathbb E_i[J_i(\pi_{k,i})]\big) && \text{definition} \\
# &= (1-\gamma)\, \mathbb E_i[J_i(\pi_{k+1,i}) - J_i(\pi_{k,i})] && \text{linearity} \\
# &= \mathbb E_i\big[\mathbb E_{s \sim d_i^{\pi_{k+1,i}},\, a \sim \pi_{k+1,i}}[A_i]\big] && \text{Lemma 1} \\
# &= \mathbb E_{i,\; s \sim d_i^{\pi_{k+1,i}},\; a \sim \pi_{k+1,i}}[A_i] . && \text{(meta-PDL)}\end{aligned}$$
#
# (The appendix has $a \sim \pi_{1,i}$ in the last line; a slip of the pen for $\pi_{k+1,i}$.)

# %% tags=["proof-meta-pdl"]
show("meta_definition")
show("meta_linearity", (1 - gamma) * (task_weights * gains).sum())
show("meta_lemma")
show("meta_joint", expect(d_new, pi_new * advantage))

# %% [markdown]
# **Move 4 (add and subtract).** The same expectation under the **old** states is added and subtracted, and what shares its actions is collected:
#
# $$(1-\gamma)\big(J_{\mathrm{meta}}(\pi_{k+1}) - J_{\mathrm{meta}}(\pi_k)\big) =
# \sum_i p(i) \sum_s d_i^{\pi_{k,i}} \sum_a \pi_{k+1,i}\, A_i
# + \sum_i p(i) \sum_s \big(d_i^{\pi_{k+1,i}} - d_i^{\pi_{k,i}}\big) \sum_a \pi_{k+1,i}\, A_i . \qquad\text{(inter)}$$

# %% tags=["proof-inter"]
show("add_and_subtract")
by_old_states = expect(d_old, pi_new * advantage)
show("inter", by_old_states + expect(d_new - d_old, pi_new * advantage))

# %% [markdown]
# **Move 5 (the demonstrator enters).** In the second term of (inter), write $\pi_{k+1,i} = \pi^{\mathrm{dem}}_i + (\pi_{k+1,i} - \pi^{\mathrm{dem}}_i)$ under the new
# states, and $\pi_{k+1,i} = \pi_{k,i} + (\pi_{k+1,i} - \pi_{k,i})$ under the old ones. With $d^{\mathrm{new}}$ for $d_i^{\pi_{k+1,i}}$, $d^{\mathrm{old}}$ for $d_i^{\pi_{k,i}}$, $\pi^{\mathrm{dem}}$ for $\pi^{\mathrm{dem}}_i$ and $A$ for $A_i$, that makes four sums:
#
# $$\mathbb E_{i, d^{\mathrm{new}}} \sum_a \pi^{\mathrm{dem}} A \;+\; \mathbb E_{i, d^{\mathrm{new}}} \sum_a (\pi_{k+1,i} - \pi^{\mathrm{dem}}) A
# \;-\; \mathbb E_{i, d^{\mathrm{old}}} \sum_a (\pi_{k+1,i} - \pi_{k,i}) A \;-\; \mathbb E_{i, d^{\mathrm{old}}} \sum_a \pi_{k,i} A .$$
#
# (The appendix writes $A^{\pi_2}$ in the first of them, for $A^{\pi_{k,i}}$.)

# %% tags=["proof-second-term"]
sums = [
    expect(d_new, pi_demo * advantage),
    expect(d_new, (pi_new - pi_demo) * advantage),
    -expect(d_old, (pi_new - pi_old) * advantage),
    -expect(d_old, pi_old * advantage),
]
print("the four sums:", told(sums, 6))
show("second_term", sum(sums))

# %% [markdown]
# **Move 6, step (a): four facts.** One for each sum:
#
# 1. the first is at least $\Delta$, by **Assumption 1**: an average is at least the minimum;
# 2. the last is **zero**: an advantage has mean 0 under its own policy;
# 3. and 4. the two in the middle are at least minus the sum of their **absolute values**.
#
# Added up, the second term of (inter) is at least $\Delta - \mathbb E_{i, d^{\mathrm{new}}} \sum_a |\pi_{k+1,i} - \pi^{\mathrm{dem}}| |A| - \mathbb E_{i, d^{\mathrm{old}}} \sum_a |\pi_{k+1,i} - \pi_{k,i}| |A|$.

# %% tags=["proof-a"]
for name, ours in zip(("a_assumption", "a_absolute_demo", "a_absolute_old"), sums, strict=False):
    show(name, ours)
show("a_zero", sums[3])
show("a", sum(sums))

# %% [markdown]
# **Move 7, step (b): Hölder's inequality.** $|A| \le C_1$, and $\sum_a |\pi_1 - \pi_2| = 2 D_{TV}$. (The paper writes "=" here; it is an inequality, in the right direction.)

# %% tags=["proof-b"]
show("b_demo", expect(d_new, (pi_new - pi_demo).abs() * advantage.abs()))
show("b_old", expect(d_old, (pi_new - pi_old).abs() * advantage.abs()))
show("b")

# %% [markdown]
# **Move 8.** Insert (b) in (inter), divide by $1 - \gamma$, and name the first sum of (inter) as the importance-weighted advantage. That is Theorem 1. $\square$

# %% tags=["proof-theorem"]
show("theorem", (task_weights * gains).sum())
assert theorem.bound <= theorem.improvement
print(f"group 1 {theorem.group_1:.4f}, group 2 {theorem.group_2:.4f}")

# %% [markdown]
# The theorem holds. On this family it only excludes a loss of more than 2.7, where the truth is a gain of 1.3. A bound can be
# right and say little, and from here on we ask *how much* it says.
#
# ## 3 · What the bound promises
#
# ### Where it loses
#
# Eight moves lead from the true improvement to the bound, and only five of their lines are inequalities of their own; the others are equations, or add up what stands above them. What lies between 1.27 and -2.66 is therefore lost in five inequalities: the minimum for an average
# (Assumption 1), twice the absolute values, twice Hölder.
#
# **Predict first.** Which of them loses most on the corridor?

# %%
clock.at("what the bound promises")
culprits = [
    "minimum for an average",
    "absolute values",
    "Hölder (demonstrator)",
    "Hölder (old policy)",
]
guess.ask("loss", "Where does the bound lose most?", culprits)

# %% tags=["reveal", "waterfall"]
figure, axes = plt.subplots(figsize=(8.4, 3.4))
waterfall(axes, family)
plt.show()
lost = {name: float(drop) / (1 - gamma) for name, drop in drops(list(lines.values())).items()}
worst = max(lost, key=lost.get)
far_end = (pi_demo * advantage).sum(-1).flatten().argmin()
assert check.agree(sum(lost.values()), theorem.improvement - theorem.bound)
assert worst == "a_assumption" and 0.5 < lost[worst] / sum(lost.values()) < 0.6
assert (
    0.05 < d_new.flatten()[far_end] < 0.07
    and max(lost["a_absolute_demo"], lost["a_absolute_old"]) < 1e-9
)
guess.reveal("loss", f"{DROPS[worst]}: {lost[worst]:.2f} of {sum(lost.values()):.2f}")
print(
    f"The new policy spends {d_new.flatten()[far_end]:.1%} of its time in the state that sets Delta."
)

# %% [markdown]
# *Figure 2. From the true improvement of the corridor down to the bound, one inequality at a time: each bar begins where the one above it ends. Computed from the lines of the proof above.*

# %% [markdown] tags=["reveal"]
# - **The minimum** takes more than half. Assumption 1 asks for one $\Delta$ in every state, so the far end of the corridor sets it for all cells, though the new policy is hardly ever there.
# - **Hölder** takes the rest, since it counts every action as if its advantage were $C_1$. That is true in the cell before the goal alone.
# - **Absolute values** take nothing here: each policy is a mixture of a coin and of a better demonstrator, so every change goes from the worse action to the better one and all terms have one sign.
#
# The last two drops together, Hölder and the absolute values of the old policy, are minus group 1. Section 4 says why.

# %% [markdown]
# ### Ten thousand families
#
# One family may be bad luck. Random ones have two to eight states, up to six tasks, discounts up to 0.999, sparse and dense rewards,
# policies from uniform to nearly deterministic. Functions that solve one environment at a time, as yours do, would take long for so many, so the package solves them in batches. On three
# small families, both:

# %%
three = random_family(torch.Generator().manual_seed(1), 3, 2, 4, 3, discounts=[0.9])
several, weights, before, after, _ = three
for index in range(3):
    one_by_one = 0.0
    for task, mdp in enumerate(several):
        alone = TabularMDP(
            mdp.transition[index], mdp.reward[index], mdp.initial[index], mdp.discount[index]
        )
        difference = gain(alone, before[task][index], after[task][index])
        one_by_one += float(weights[task, index]) * difference
    batched = float(theorem_1(*three).improvement[index])
    assert check.agree(one_by_one, batched)
    print(
        f"family {index}: improvement {one_by_one:+.4f} by your parts, {batched:+.4f} in the batch"
    )

# %% [markdown]
# **Predict first.** In how many of them is the bound *positive*, that is, does it promise any improvement at all?

# %%
guess.ask("positive", "families in which the bound is positive, % of all")

# %% tags=["reveal", "ten-thousand", "tolerance:abs=1.5", "tolerance:whole=2"]
batches = [figures.everything(random) for random in many_families(seed=0, total=10_000)]
sample = {name: torch.cat([batch[name] for batch in batches]) for name in batches[0]}
scale = torch.maximum(sample["improvement"].abs(), sample["bound"].abs()).clamp(min=1)
above = int(((sample["bound"] - sample["improvement"]) / scale > 1e-9).sum())
better = sample["delta"] > 1e-9  # Assumption 1 holds with a positive Delta
positive = {name: (sample[name] > 0).double() for name in ("bound", "improvement")}
assert not above and not (sample["bound"][~better] > 1e-6).any()
assert positive["bound"].mean() < 0.001 < positive["improvement"].mean()
assert positive["bound"][better].mean() < 0.1
guess.reveal("positive", f"{positive['bound'].mean():.2%} of {len(scale):,}; violated in {above}")
print(f"Delta is positive in {better.double().mean():.1%}, in {int(better.sum())} of them")
print("positive in               of all   where Delta > 0")
for name, hit in positive.items():
    print(f"{name:20} {hit.mean():11.2%} {hit[better].mean():17.1%}")

# %% tags=["reveal"]
figure, panels = plt.subplots(1, 2, figsize=(9, 3.6), sharey=True)
for axes, chosen, title in zip(
    panels, (slice(None), better), ("all families", "those with Delta > 0"), strict=True
):
    figures.against_improvement(
        sample["improvement"][chosen], sample["bound"][chosen], axes, "bound"
    )
    axes.axhline(0, color="black", linewidth=0.6, linestyle=(0, (1, 2)))
    axes.set_title(title)
panels[1].lines[0].set(markersize=6, alpha=1.0)
panels[0].set_ylabel("Theorem 1 as printed (return)")
plt.show()

# %% [markdown] tags=["reveal"]
# *Figure 3. Ten thousand random families: true improvement across, the printed bound upwards, both on symmetric log scales. A point above the black
# line would be a violation; a point above the dotted line is a promise. Right: the families of which Assumption 1 is true with a positive Delta.*
#
# No point crosses the line. The bound is hardly ever positive, but that says little about the theorem: our demonstrators are drawn at random, so in 98 or 99 of 100 families some state has a demonstrator that is worse than the old policy, $\Delta \le 0$, and
# then the bound *cannot* be positive. The fair question is asked where Assumption 1 holds with $\Delta > 0$ (right column, right panel). There most steps improve; the bound says so in at most a few families of a hundred.
# (Random sampling is also a weak hunter of violations. `tests/test_tabular.py` lets a property-based tester and gradient ascent look for them, too.)

# %% [markdown]
# ## 4 · Group 1 is never positive
#
# "Maximising the first term in group one with a constraint on its second term will ensure a higher lower bound", says the paper, and
# that TRPO (the meta-update, notebook 05) does this. How high can it get?
#
# ### Pen and paper A · The first group
#
# *Difficulty 2 of 3, planned for 6 minutes.* Prove that group 1 is never positive, whatever the policies are. Two facts of the proof above are enough; no computer.
#
# <details><summary>Hint 1: the ratio</summary>
# Write the expectation over a ∼ π<sub>k,i</sub> as a sum over a. What is left of the ratio?
# </details>
#
# <details><summary>Hint 2: add a zero</summary>
# An advantage has mean 0 under its own policy. So the old policy may be subtracted from the new one without a change.
# </details>
#
# <details><summary>Hint 3: the other term</summary>
# Move 7 has an upper bound for exactly the sum that is now there.
# </details>
#
# <details><summary>Solution</summary>
#
# The ratio cancels: the expectation in group 1 is $\mathbb E_{i, d^{\mathrm{old}}} \sum_a \pi_{k+1,i} A$. Since $\sum_a \pi_{k,i} A = 0$ in every state, it equals
#
# $$\mathbb E_{i, d^{\mathrm{old}}} \sum_a (\pi_{k+1,i} - \pi_{k,i}) A \;\le\; C_1\, \mathbb E_{i, d^{\mathrm{old}}} \sum_a |\pi_{k+1,i} - \pi_{k,i}| \;=\; 2 C_1\, \mathbb E_i D_{TV}^{\pi_{k,i}}(\pi_{k+1,i}, \pi_{k,i}) ,$$
#
# by Hölder, and exactly that is subtracted. $\square$ What is lost between the two sides is what absolute values and Hölder lose for the old policy: the last two drops of the waterfall.
#
# </details>
#
# So the most that group 1 can reach is zero, which leaving the policy alone reaches as well. The theorem does not say that the RL part helps. And the second group **alone** is a valid bound, and never a worse one.
# It also has a direct proof of two lines, from (meta-PDL):
#
# $$\begin{aligned}(1-\gamma)\big(J_{\mathrm{meta}}(\pi_{k+1}) - J_{\mathrm{meta}}(\pi_k)\big) &= \mathbb E_{i, d^{\mathrm{new}}} \sum_a \pi^{\mathrm{dem}} A + \mathbb E_{i, d^{\mathrm{new}}} \sum_a (\pi_{k+1,i} - \pi^{\mathrm{dem}}) A \\
# &\ge \Delta_{\mathrm{avg}} - 2 C_1\, \mathbb E_i D_{TV}^{\pi_{k+1,i}}(\pi_{k+1,i}, \pi_i^{\mathrm{dem}}) , \end{aligned} \qquad\text{(2)}$$
#
# with $\Delta_{\mathrm{avg}} = \mathbb E_{i,\; s \sim d_i^{\pi_{k+1,i}},\; a \sim \pi_i^{\mathrm{dem}}}[A_i(s, a)] \ge \Delta$, the first of the four sums of Move 5. The old states never appear, and the **average** is all that is needed, not Assumption 1's minimum.
# The price: $\Delta_{\mathrm{avg}}$ is an average over the states of the *new* policy, which nobody has visited yet when the step is chosen. In a solved environment we can compute it; an algorithm knows it only afterwards. Assumption 1, a statement about every state, can at least be claimed beforehand.

# %% tags=["first-group", "tolerance:abs=1.5"]
clock.at("group 1")
names = ("bound", "bound_group_2", "bound_average_delta")
slack = 1e-9 * scale
assert (sample["group_1"] <= slack).all()
for looser, tighter in zip(names, (*names[1:], "improvement"), strict=True):
    assert (sample[looser] <= sample[tighter] + slack).all()
given = [(sample[name][better] > 0).double().mean() for name in names]
assert given == sorted(given) and given[0] < 0.1 < given[-1]
print(f"group 1 is {sample['group_1'].max():.6f} at most in ten thousand families")
for name, share in zip(names, given, strict=True):
    below = (sample["improvement"] - sample[name]).median()
    print(f"{figures.LABELS[name]:22} lies {below:.2f} below the truth, in the median;", end="")
    print(f" positive in {share:.1%} where Delta > 0")
assert check.agree(sums[0], theorem.average_delta)
print(f"on the corridor: Delta {delta:.4f}, its average {sums[0]:.4f} from your d")

# %% [markdown]
# ### The family under your fingers
#
# Demonstrator's quality, step towards it, discount, and *stubbornness*: with that probability the left task's demonstrator makes the
# wrong move in the cell before its goal. Look for three things: what one stubborn state does to $\Delta$ and to the average; which bound is exact at a step of 1; what is lost then all the same.

# %% tags=["widget-bounds", "nbval-ignore-output"]
bounds.bound_sliders()

# %%
bounds.bound_picture()

# %% [markdown]
# *Figure 4. The sliders, as a still picture with a stubborn demonstrator, in return per step. Its one bad state turns Delta negative, and the minimum alone takes three times what the step gains. The two tighter bounds stand where they are reached.*
#
# At a step of 1 the new policy *is* the demonstrator. Then nothing is lost for the demonstrator, the average-$\Delta$ bound (2) is exact, and the printed bound still loses the minimum and its whole first group.

# %% tags=["widget-lessons"]
stubborn, whole = theorem_1(*corridor_step(stubbornness=0.6)), theorem_1(*corridor_step(share=1.0))
assert stubborn.delta < 0 < stubborn.average_delta
minimum = (stubborn.bound_average_delta - stubborn.bound_group_2) / stubborn.improvement
assert 2.8 < minimum < 3.5 and whole.bound < 0
assert torch.isclose(whole.bound_average_delta, whole.improvement)
print(
    f"stubborn: Delta {stubborn.delta:.3f}, average {stubborn.average_delta:.3f}; the minimum takes"
)
print(f"          {minimum:.1f} times the improvement")
print(
    f"a step of 1: improvement {whole.improvement:.3f}, average Delta {whole.bound_average_delta:.3f},"
)
print(f"             second group {whole.bound_group_2:.3f}, printed {whole.bound:.3f}")

# %% [markdown]
# ### Bonus · A step on which nothing is lost
#
# *For the fast; difficulty 3 of 3, planned for 8 minutes beyond the 90.* One state, three actions that pay $1$, $0$ and $-1$; the old policy takes each with probability $\frac13$. Choose a demonstrator and a new policy, so that
# the new policy gains at least $0.2$ per step and the bound *as printed* is exact.
#
# <details><summary>Hint 1: which inequalities are left?</summary>
# With one state the minimum is the average. Absolute values lose nothing while every change goes from worse to better, and the new policy no further than the demonstrator.
# </details>
#
# <details><summary>Hint 2: Hölder</summary>
# It counts every change of probability as if the action's |A| were C<sub>1</sub>. Of which actions is that true?
# </details>


# %% tags=["exercise-tight"]
def tight_step():
    """Return (demo, new), each a list of three probabilities."""
    ### BEGIN SOLUTION
    return [0.65, 1 / 3, 0.35 - 1 / 3], [0.55, 1 / 3, 0.45 - 1 / 3]
    ### END SOLUTION


# %%
solved_tight = check.tight_step(tight_step)
if solved_tight:
    chosen = [torch.as_tensor(p, dtype=torch.float64).reshape(1, 3) for p in tight_step()]
    shown, step = (policy / policy.sum() for policy in chosen)
    one_state = TabularMDP(torch.ones(1, 3, 1), [[1, 0, -1]], [1], gamma)
    even = torch.full((1, 3), 1 / 3)
    figure, axes = plt.subplots(figsize=(8.4, 3.2))
    waterfall(axes, ([one_state], [1.0], [even], [step], [shown]), per_step=True)
    plt.show()

# %% [markdown]
# *Figure 5 (once the bonus is solved). The waterfall of a step on which Theorem 1 loses nothing: no drop between the truth and the bound.*
#
# <details><summary>Why it works, after you have tried</summary>
#
# Under the even policy $A = (1, 0, -1)$ and $C_1 = 1$. Hölder is exact where probability moves only between actions with $|A| = C_1$: from the last action to the first. The middle one must keep its $\frac13$ in both policies. With
# $\frac13 + y$ for the new policy's first action and $\frac13 + x$ for the demonstrator's, $0 \le y \le x$, group 1 is $2y - 2y = 0$, group 2 is $2x - 2(x - y) = 2y$, and the improvement is $2y$. So no constant in the theorem can be made smaller.
#
# </details>
#
# ## 5 · Two states that break the next sentence
#
# Group 2 asks for closeness to the demonstrator in the states of the **new** policy, which no one has visited yet. "Hence, in
# practice, we replace that term" by the distance in the states of the **demonstrator**, $D_{TV}^{\mathrm{dem}}$: that can be sampled, and it is what cloning minimises. Is what remains still a bound?
# The smallest environment that answers has a path, and next to it a swamp that the demonstrator never enters:
#
# | | action 0 | action 1 | action 2 |
# |---|---|---|---|
# | on the path (start) | $+1$, stay on the path | $-1$, stay | $0$, into the swamp |
# | in the swamp | $+1$, back to the path | $-1$, back | $-1$, stay in the swamp |
# | old policy, both states | $\frac12$ | $\frac12$ | $0$ |
# | demonstrator, both states | $\frac12 + x$ | $\frac12 - x$ | $0$ |
# | new policy on the path | $\frac12 + x$ | $\frac12 - x - \varepsilon$ | $\varepsilon$ |
# | new policy in the swamp | $0$ | $0$ | $1$ |

# %%
clock.at("two states")
x, slip = 0.25, 0.1
(swamp,), _, (before,), (after,), (shown,) = pair = slippery_pair(gamma, slip, x)
figure, panels = plt.subplots(1, 2, figsize=(11.5, 2.9))
for axes, policy, name in zip(panels, (shown, after), ("demonstrator", "new policy"), strict=True):
    two_states(axes, swamp, policy)
    axes.set_title(name)
plt.show()

# %% [markdown]
# *Figure 6. The two states, with x = 0.25 and a slip of 0.1. The wider an arrow, the likelier; dotted grey arrows are never taken. On the path the new policy does nearly as the demonstrator does, but once in a while it slips; in the swamp, where nobody ever showed what to do, it stays.*
#
# **Predict first.** With $\gamma = 0.9$ and a slip of one in ten steps, which share of its discounted time does the new policy spend in the swamp?

# %%
guess.ask("swamp", "share of its time that the new policy spends in the swamp, %")

# %% [markdown]
# ### Pen and paper B · The promise and the truth
#
# *Difficulty 3 of 3, planned for 8 minutes.* With letters $\gamma$, $\varepsilon$, $x$ in place of numbers, and everything per step. The full solution of each part is folded; use it when stuck, and go on with the next.
#
# 1. What are the old policy's values, and so the advantages, $C_1$ and $\Delta$? Does Assumption 1 hold?
# 2. Replace the new policy's states by the demonstrator's, in group 2 as the paper does. What does the theorem now promise?
# 3. Which share $\sigma$ of its time does the new policy spend in the swamp?
# 4. What is the true improvement?
#
# <details><summary>Solution of part 1</summary>
#
# The old policy takes $+1$ and $-1$ equally often, in both states, so its values are 0. Then $Q = R$, and the advantages are the rewards: $C_1 = 1$. The demonstrator's average advantage is $(\frac12 + x) - (\frac12 - x) = 2x$ in **both** states, so $\Delta = 2x > 0$ and Assumption 1 holds.
#
# </details>
#
# <details><summary>Solution of part 2</summary>
#
# The old policy and the demonstrator are always on the path. There the new policy's average advantage is $(\frac12 + x) - (\frac12 - x - \varepsilon) = 2x + \varepsilon$, its distance from the old policy is $x + \varepsilon$, and from the demonstrator $\varepsilon$. So group 1 is
# $(2x + \varepsilon) - 2(x + \varepsilon) = -\varepsilon$, the substituted group 2 is $2x - 2\varepsilon$, and the promise is $2x - 3\varepsilon$ per step.
#
# </details>
#
# <details><summary>Solution of part 3</summary>
#
# Visits flow: whoever is in the swamp was on the path a step ago and slipped, or was in the swamp already. So $\sigma = \gamma\,\big((1 - \sigma)\,\varepsilon + \sigma\big)$, and $\sigma = \dfrac{\gamma\varepsilon}{1 - \gamma + \gamma\varepsilon}$.
#
# </details>
#
# <details><summary>Solution of part 4</summary>
#
# Lemma 1: the average of the old advantage over the new policy's states and actions. On the path that is $2x + \varepsilon$, in the swamp $-1$. The truth is $(1 - \sigma)(2x + \varepsilon) - \sigma$ per step.
#
# </details>

# %% tags=["reveal", "two-state-counterexample"]
share = float(visits(swamp, after)[1])
truth = (1 - gamma) * gain(swamp, before, after)
promise = (1 - gamma) * float(related_bounds(*pair).substituted)
sigma = gamma * slip / (1 - gamma + gamma * slip)
by_hand = [sigma, (1 - sigma) * (2 * x + slip) - sigma, 2 * x - 3 * slip]
assert check.agree([share, truth, promise], by_hand)
assert theorem_1(*pair).delta > 0 and truth < 0 < promise
guess.reveal("swamp", f"{share:.1%}, by your d")
print(f"Per step: promised {promise:+.4f}, true {truth:+.4f} by your lemma.")
print(f"By the formulas of pen and paper: {told(by_hand, 4)} (share, truth, promise).")

# %% [markdown] tags=["reveal"]
# A slip of one in ten fills nearly half of the time, since the new policy never takes the way back. The substituted theorem promises a gain, the truth is a loss, and Assumption 1 is true: what remains is **not** a bound. Imitation learning knows this as **compounding
# errors**. The printed theorem survives, since it measures the distance in the new policy's states, where it is large.

# %% [markdown]
# ### Exercise 4 · How wrong can it be?
#
# *Difficulty 3 of 3, planned for 6 minutes.* With $x = 0.25$, choose $\gamma$ and $\varepsilon$ so that the substituted theorem promises at least $0.1$ per step, and the truth is $-0.4$ per step or less.
#
# <details><summary>Hint 1: the promise</summary>
# It does not depend on γ, and bounds the slip from above.
# </details>
#
# <details><summary>Hint 2: the truth</summary>
# With ε fixed, the share σ of time in the swamp grows with γ. How large must σ be? Put a few values into the formula for the truth.
# </details>


# %% tags=["exercise-break"]
def break_the_substitution():
    """Return (discount, slip), two plain numbers."""
    ### BEGIN SOLUTION
    return 0.99, 0.05
    ### END SOLUTION


# %%
rates, marks = [gamma], [slip]
if check.break_the_substitution(break_the_substitution):
    yours = [float(part) for part in break_the_substitution()]
    told_by = swamp_widget.per_step(*yours, x)
    print(
        f"promised {told_by['substituted']:+.4f} per step, true {told_by['improvement']:+.4f} per step"
    )
    rates.append(yours[0])
    marks.append(yours[1])

# %%
size = (1 + 4.6 * len(rates), 3.4)
figure, panels = plt.subplots(1, len(rates), figsize=size, sharey=True, squeeze=False)
names = ("substituted", "improvement", "bound")
for axes, rate, mark in zip(panels[0], rates, marks, strict=True):
    slips = np.linspace(0, 0.25, 26)
    figures.along(lambda s, g=rate: slippery_pair(g, s, x), slips, names, axes, per_step=True)
    axes.set(title=f"gamma = {rate:.4g}", xlabel="probability of the slip")
    axes.axhline(0, color="black", linewidth=0.6)
    axes.axvline(mark, color="#777777", linewidth=1, linestyle=(0, (1, 2)), label="chosen slip")
    axes.set_ylabel("return per step" if axes is panels[0, 0] else "")
panels[0, 0].legend(fontsize=8, loc="lower left")
plt.show()

# %% [markdown]
# *Figure 7. Per step, against the probability of the slip: the truth (thick), the theorem as printed (dashed, always below it) and the theorem with the demonstrator's states (dotted). Left, the slip of Figure 6; right, once Exercise 4 is solved, your discount and your slip.*
#
# With $\gamma \to 1$, $\varepsilon \to 0$ slowly and $x \to \frac12$ the promise goes to $+C_1$ per step, the truth to $-C_1$: the substituted bound can be as wrong as a bound can be. Move the three numbers yourself:

# %% tags=["widget-swamp", "nbval-ignore-output"]
swamp_widget.swamp_sliders()

# %%
swamp_widget.swamp_picture()

# %% [markdown]
# *Figure 8. The sliders, as a still picture: a slip of one in fifty, of which the demonstrator's states see next to nothing, and half of the time in the swamp. The theorem with the demonstrator's states promises a gain; the truth is a loss; the theorem as printed promises nothing.*

# %%
still = swamp_widget.per_step(0.98, 0.02, 0.25)
assert still["substituted"] > 0.4 and still["bound"] < still["improvement"] < -0.2
print(f"promised {still['substituted']:+.2f} per step, true {still['improvement']:+.2f} per step")

# %% [markdown]
# ### What the theorem does not cover
#
# The paper's experiments, and ours, differ from its setting in four ways that matter:
#
# - **Episodes that end at the goal**, as in Point2D and TwoWheeled. The end is an absorbing state, so $\Delta \le 0$ from the first iteration on (Section 6).
# - **Deterministic demonstrators.** The optimal demonstrations are mean actions without noise, the policies are Gaussian. A point and a density have total variation 1 in every state. Then group 2 is at most $(\Delta - 2 C_1)/(1-\gamma) < 0$, since $\Delta \le C_1$: it promises nothing, whatever is learned (numbers in Section 8).
# - **One step, not a minimum.** The adaptation takes a single gradient step on the cloning loss, and the loss is a sum over *one* undiscounted trajectory, not an expectation under $d^{\mathrm{dem}}$.
# - **Samples.** Advantages are estimates with a fitted baseline, normalised; the meta-update is TRPO's on the ratio of sampled actions.
#
# So the theorem is a *motive* for the cloning term, not a statement about the numbers in notebooks 06 to 08.
#
# ## What was shown
#
# - Theorem 1 holds: eight moves, eighteen lines, each with both sides equal or in order, and no violation in ten thousand random families.
# - More than half of what it loses on the corridor is lost to one word of Assumption 1, "every" state. With the average $\Delta_{\mathrm{avg}}$ the bound is tighter, and known only afterwards.
# - Its first group is never positive; without it the bound is tighter, too.
# - With the demonstrator's states it is no bound any more, with Assumption 1 true, in two states.
#
# **Next** notebook 05 brings MAML and the meta-gradient, notebook 06 the algorithm. The sections below are further reading, each by itself.
#

# %% [markdown]
# ## 6 · Tighter and older bounds (further reading)
#
# ### One absorbing state forces $\Delta \le 0$
#
# In a state that cannot be left, where every action pays the same, every advantage is 0, hence also the demonstrator's. Assumption 1 asks
# for $\Delta$ in *every* state, so $\Delta \le 0$, and group 2 can promise nothing. An episode that ends at its goal has such a
# state. The average $\Delta_{\mathrm{avg}}$ does not mind.

# %% tags=["absorbing-state"]
clock.at("tighter and older bounds")
ending = gridworld(1, 5, [(0, 0), (0, 4)], (0, 2), gamma, at_goal="absorb", moves=LEFT_RIGHT)
once = theorem_1(ending, task_weights, old, demo, demo)  # all the way to the demonstrator
assert once.delta <= 0 < once.average_delta
assert once.bound_group_2 <= 0 < once.bound_average_delta
print(f"Delta {abs(once.delta):.3f}, its average {once.average_delta:.3f}")
print(f"promised: {once.bound:.3f} printed, {once.bound_average_delta:.3f} with the average")
print(f"truth: {once.improvement:.3f}")

# %% [markdown]
# ### An older bound
#
# The **trust-region bound** of Achiam et al. (2017) knows nothing of demonstrators:
#
# $$J(\pi_1) - J(\pi_2) \ge \frac{1}{1-\gamma} \Big( \mathbb E_{d^{\pi_2},\, \pi_1}[A^{\pi_2}] - \frac{2\gamma\, \epsilon}{1-\gamma}\, D_{TV}^{\pi_2}(\pi_1, \pi_2) \Big), \qquad \epsilon = \max_s \big|\mathbb E_{a \sim \pi_1}[A^{\pi_2}(s, a)]\big| . \qquad\text{(3)}$$
#
# We average it over the tasks, and follow the straight way from the old policy to the demonstrator, on the corridor and on a single state with two actions that pay $+1$ and $-1$. **Predict first:** where on the corridor's way is (3) ahead of (2)?

# %%
guess.ask(
    "ahead",
    "The trust-region bound is ahead of the average-Delta bound",
    ["near the old policy", "near the demonstrator", "everywhere", "nowhere"],
)


# %% tags=["reveal", "tight-instance"]
def coin(share, lead=0.3):
    """Return the one-state family, the given share of the way to the demonstrator."""
    bandit = TabularMDP(torch.ones(1, 2, 1), [[1, -1]], [1], gamma)
    tables = [torch.tensor([[0.5 + x, 0.5 - x]]) for x in (0.0, share * lead, lead)]
    return [bandit], [1.0], *([table] for table in tables)


figure, panels = plt.subplots(1, 2, figsize=(10.5, 3.6))
names = ("improvement", "trust_region", "bound", "bound_group_2", "bound_average_delta")
ways = np.linspace(0, 1, 33)
tight = figures.along(coin, ways, names, panels[0])
way = figures.along(lambda share: corridor_step(share=share), ways, names, panels[1])
for axes, title in zip(panels, ("one state", "corridor"), strict=True):
    axes.set(title=title, xlabel="share of the demonstrator in the new policy")
panels[1].set(ylim=(-8, 4), ylabel="")
panels[1].legend(loc="lower left")
plt.show()

# %% [markdown]
# *Figure 9. Improvement (thick) and bounds along the straight way from the old policy to the demonstrator. Left: on the one-state
# family all but one of the lines lie upon each other. Right: on the corridor each bound has its place.*

# %% tags=["reveal", "each-wins-somewhere", "tolerance:abs=1.5"]
assert np.allclose(tight["bound"], tight["improvement"], atol=1e-5)
ahead = way["trust_region"] > way["bound_average_delta"]
assert ahead[1] and not ahead[-1]
assert np.isclose(way["bound_average_delta"][-1], way["improvement"][-1])
best_of_both = np.maximum(way["trust_region"], way["bound_average_delta"])
assert (best_of_both <= way["improvement"] + 1e-9).all()
guess.reveal("ahead", f"ahead up to a share of {ways[ahead].max():.2f}, behind from there on")
for name in names:
    print(f"at the demonstrator of the corridor: {figures.LABELS[name]:22}{way[name][-1]:+7.2f}")
assert way["bound"][-1] < 0 < way["bound_group_2"][-1]
older = (sample["trust_region"] > sample["bound"]).double().mean()
against = (sample["trust_region"] > sample["bound_average_delta"]).double().mean()
above = int(((sample["trust_region"] - sample["improvement"]) / scale > 1e-9).sum())
assert 0.2 < against < older < 0.8 and not above
print(f"trust region ahead of the printed bound in {older:.1%} of the random families,")
print(f"ahead of the average-Delta bound in {against:.1%}; violated in {above}")

# %% [markdown] tags=["reveal"]
# Close to the old policy the trust-region bound wins: it is exact where nothing changes. Close to the **demonstrator** (2) wins, and it is exact when the new policy *is* the
# demonstrator: then the distance is 0, and $\Delta_{\mathrm{avg}} / (1-\gamma)$ is Lemma 1. The *printed* bound is negative even there: its first group charges for every step away from the old policy. The maximum of the two is a valid bound as well,
# and the best to use. In our random families each is ahead about half of the time; other ways of drawing them give other shares.

# %% [markdown]
# ## 7 · How the two states were found, and a repair (further reading)
#
# For the tight bound (the second group alone) with the demonstrator's states, random search finds violations at once:

# %% tags=["substitution-random"]
clock.at("the search and the repair")
random = torch.Generator().manual_seed(0)
for states in (2, 3):
    small = random_family(random, 20_000, tasks=1, states=states, actions=2)
    parts = figures.everything(small)
    gap = (1 - small[0][0].discount) * (parts["substituted_group_2"] - parts["improvement"])
    found = int((gap > 0.01).sum())
    assert found > 5
    print(f"{states} states: broken by more than 0.01 per step in {found} of 20,000 families,")
    print(f"          by up to {gap.max():.2f} per step")

# %% [markdown]
# For the theorem **as printed**, with its negative first group, random search finds next to nothing. Climbing does better: start
# at random families and follow the gradient of (bound − improvement) through the linear solves.

# %% tags=["substitution-climb", "tolerance:abs=0.1", "tolerance:whole=1"]
climbed = {
    name: hunt(name, families=32, steps=200, discount=0.99)
    for name in ("bound", "bound_average_delta", "substituted")
}
worst = {name: float(found.violation.max()) for name, found in climbed.items()}
assert worst["bound"] <= 0 and worst["bound_average_delta"] <= 0
assert worst["substituted"] > 0.5
for name, found in climbed.items():
    broken_by = found.violation
    print(f"{name:20} broken in {int((broken_by > 0).sum())} of 32 climbs; ", end="")
    print(f"bound less truth at most {float(broken_by.max()):+.3f} C1 per step")

# %% [markdown]
# What the climbs had built, with the superfluous taken away, was the path and the swamp.
#
# ### The repair, and its price
#
# Closeness in the demonstrator's states *is* enough, at the price of one more factor $1/(1-\gamma)$:
#
# $$J_{\mathrm{meta}}(\pi_{k+1}) - J_{\mathrm{meta}}(\pi_k) \ge \frac{1}{1-\gamma}\Big(\mathbb E_{i,\, d_i^{\mathrm{dem}},\, \pi_i^{\mathrm{dem}}}[A_i] - \frac{2 C_1}{1-\gamma}\, \mathbb E_i D_{TV}^{\mathrm{dem}}(\pi_{k+1,i}, \pi_i^{\mathrm{dem}})\Big) . \qquad\text{(4)}$$
#
# By Lemma 1 the first term of (4) is simply $J_{\mathrm{meta}}(\mathrm{dem}) - J_{\mathrm{meta}}(\pi_k)$: *you gain what the demonstrator would, less the price of differing from it*.
#
# ### Pen and paper C · Prove the repair
#
# *Difficulty 3 of 3, planned for 10 minutes.* In one task. Write $d_1, P_1$ for the visitation and the chain of the new policy, $d_0, P_0$ for those of the demonstrator.
#
# <details><summary>Hint 1: three moves</summary>
# How far apart are the two visitations? Then change the states in (meta-PDL), and then the actions.
# </details>
#
# <details><summary>Hint 2: the visitations</summary>
# Both solve a flow equation, d = (1 − γ) ρ + γ P<sup>T</sup> d. Subtract one from the other.
# </details>
#
# <details><summary>Solution</summary>
#
# 1. *How far apart are the visitations?* Subtract the flow equations: $(I - \gamma P_1^{\mathsf T})(d_1 - d_0) = \gamma (P_1 - P_0)^{\mathsf T} d_0$. The inverse
# of the matrix on the left, $\sum_t \gamma^t (P_1^{\mathsf T})^t$, stretches the 1-norm by at most $1/(1-\gamma)$; the right side has 1-norm at most $2\gamma D_{TV}^{\mathrm{dem}}$. So $\|d_1 - d_0\|_1 \le \frac{2\gamma}{1-\gamma} D_{TV}^{\mathrm{dem}}$. (This is Lemma 3 of Achiam et al., 2017.)
# 2. *Change the states.* Let $g(s) = \sum_a \pi_{k+1,i}(a \mid s) A(s, a)$, so $|g| \le C_1$. By (meta-PDL), $(1-\gamma)\big(J(\pi_{k+1,i}) - J(\pi_{k,i})\big) = \sum_s d_1 g \ge \sum_s d_0\, g - C_1 \|d_1 - d_0\|_1$.
# 3. *Change the actions.* By Hölder, $\sum_s d_0\, g \ge \mathbb E_{d_0, \mathrm{dem}}[A] - 2 C_1 D_{TV}^{\mathrm{dem}}$.
#
# Add up: $2 C_1 \big(1 + \frac{\gamma}{1-\gamma}\big) = \frac{2 C_1}{1-\gamma}$. $\square$
#
# </details>
#
# It holds in all our random families. The two states show that the extra factor cannot be dropped: there a distance of
# about $1 - \gamma$ already costs a constant.

# %% tags=["the-repair"]
shown_gains = [gain(*each) for each in zip(mdps, old, demo, strict=True)]
of_demo = float((task_weights * torch.tensor(shown_gains).double()).sum())
related = related_bounds(*family)
price = 2 * theorem.c1 * related.tv_demo_states / (1 - gamma) ** 2
assert check.agree(related.repaired, of_demo - price)
above = int(((sample["repaired"] - sample["improvement"]) / scale > 1e-9).sum())
assert not above
print(f"the demonstrator gains {of_demo:.4f} by your lemma, the price is {price:.4f};")
print(f"(4) promises {related.repaired:.4f}, the truth is {theorem.improvement:.4f}")
print(f"(4) is violated in {above} of {len(scale):,} random families")

# %% [markdown]
# ## 8 · From likelihood to distance (further reading)
#
# EMRLD takes a gradient step on the cloning loss, an estimate of $\mathcal L^{\mathrm{BC}} = -\mathbb E_{d^{\mathrm{dem}},\, \pi^{\mathrm{dem}}}[\log \pi(a \mid s)]$, a likelihood. What has it to do with the distance $D_{TV}^{\mathrm{dem}}$?
#
# ### Pen and paper D · How far can a clone be?
#
# *Difficulty 2 of 3, planned for 5 minutes.* Given the value of the cloning loss and the demonstrator's mean entropy $H = -\mathbb E_{d^{\mathrm{dem}}} \sum_a \pi^{\mathrm{dem}} \log \pi^{\mathrm{dem}}$, bound the mean total variation from above.
# You may use **Pinsker's inequality**: in each state, $D_{TV}(p, q) \le \sqrt{D_{KL}(p \,\|\, q) / 2}$.
#
# <details><summary>Hint 1: from loss to divergence</summary>
# What is the loss of a perfect clone, and what is left when it is subtracted?
# </details>
#
# <details><summary>Hint 2: from one state to the mean</summary>
# The root is a concave function (Jensen).
# </details>
#
# <details><summary>Solution</summary>
#
# A perfect clone has $\mathcal L^{\mathrm{BC}} = H$, and the excess $\mathcal L^{\mathrm{BC}} - H$ is the mean Kullback-Leibler divergence $\mathbb E_{d^{\mathrm{dem}}} D_{KL}(\pi^{\mathrm{dem}} \,\|\, \pi)$. By Pinsker in each state and Jensen over the states,
#
# $$D_{TV}^{\mathrm{dem}} \le \sqrt{\big(\mathcal L^{\mathrm{BC}} - H\big) / 2} .$$
#
# </details>

# %% tags=["reveal", "pinsker"]
clock.at("from likelihood to distance")
(small,), _, _, (near,), (expert,) = random_family(random, 3000, tasks=1, states=4, actions=3)
divergence = (expert * (expert / near).log()).nan_to_num(0.0).sum(-1)  # (family, state)
distance = 0.5 * (expert - near).abs().sum(-1)
shown, walked = small.visitation(expert), small.visitation(near)
excess = (shown * divergence).sum(-1)  # the cloning loss less the entropy
far = (shown * distance).sum(-1)
elsewhere = (walked * distance).sum(-1)
pinsker = torch.sqrt(excess / 2)
assert (far <= pinsker + 1e-9).all() and (elsewhere > 1.05 * pinsker).any()
for whose, values in (("demonstrator", far), ("new policy", elsewhere)):
    above, most = int((values > pinsker + 1e-9).sum()), (values / pinsker).max()
    print(f"states of the {whose}: above Pinsker in {above} of 3,000, at most {most:.2f} of it")

# %%
figure, panels = plt.subplots(1, 2, figsize=(9.6, 3.4), sharey=True)
losses = np.geomspace(1e-4, 30, 200)
for axes, values, whose in zip(
    panels, (far, elsewhere), ("demonstrator", "new policy"), strict=True
):
    above = values > pinsker + 1e-9
    axes.plot(excess[~above], values[~above], ".", color="#56B4E9", markersize=3, rasterized=True)
    axes.plot(excess[above], values[above], "x", color="#D55E00", label="above it")
    axes.plot(losses, np.minimum(np.sqrt(losses / 2), 1), color="black", label="Pinsker")
    axes.set(xscale="log", xlim=(1e-4, 30), title=f"in the states of the {whose}")
    axes.set_xlabel("cloning loss less entropy (nats)")
panels[0].set_ylabel("mean total variation")
panels[1].legend()
plt.show()

# %% [markdown]
# *Figure 10. Random policies and demonstrators: excess of the cloning loss over its minimum against the mean distance, in the demonstrator's
# states (left) and in those of the new policy (right). Black: the largest distance that Pinsker's inequality allows. Crosses lie above it.*
#
# Cloning controls the distance where the demonstrator walks; in the new policy's states the same number bounds it only after division by $1-\gamma$ (step 1 of pen and paper C, with a distance of at most 1 in each state). So a small enough loss gives a guarantee, by (4) or in group 2
# itself, and a weak one. And how small the loss gets is not for the theorem to say.
#
# **Deterministic demonstrators, in numbers.** A Gaussian policy with $\sigma = 0.5$, and a demonstrator with the same mean whose own noise shrinks:

# %% tags=["deterministic-demonstrator"]
places = torch.linspace(-4, 4, 400_001, dtype=torch.float64)
policy_density = torch.distributions.Normal(0.0, 0.5)
distances = []
for noise in (0.5, 0.1, 0.01, 0.001):
    demonstrator = torch.distributions.Normal(0.0, noise)
    apart = (demonstrator.log_prob(places).exp() - policy_density.log_prob(places).exp()).abs()
    distances.append(0.5 * float(torch.trapezoid(apart, places)))
    kl = float(torch.distributions.kl_divergence(demonstrator, policy_density))
    print(f"noise {noise:5.3f}: total variation {distances[-1]:.3f}, divergence {kl:.2f} nats")
assert distances[0] < 1e-9 and distances[-1] > 0.98 and distances == sorted(distances)

# %% [markdown]
# The distance goes to 1, the divergence to infinity. However good the clone's mean is, group 2 then promises nothing.
#
# ## 9 · Exact EMRLD (further reading)
#
# Now the algorithm itself, $\theta_i = \theta - \alpha \nabla_\theta \big(w_{\mathrm{rl}} \mathcal L^{\mathrm{RL}}_i(\theta) + w_{\mathrm{bc}} \mathcal L^{\mathrm{BC}}_i(\theta)\big)$ with $\mathcal L^{\mathrm{RL}}_i = -J_i$ and $\alpha = 5$, and no sampling anywhere: policies are softmax tables, the adaptation and the meta-update are differentiated through the linear
# solves. A grid of 9 × 9 cells, the start in the middle, eight goals on the edge; the move into the goal pays 1 and leads back to the start. We compare:
# both terms in the adaptation (EMRLD), cloning alone ($w_{\mathrm{rl}} = 0$), policy gradient alone (MAML), and EMRLD with a demonstrator that acts at random 60 % of the time.
#
# **Predict first.** With exact gradients, no matter how small, will MAML learn? And a demonstrator is overtaken once the policy's return is higher: does $\Delta_{\mathrm{avg}}$ turn negative before that, at the same time, or after it?

# %%
guess.ask(
    "maml", "In 60 meta-iterations exact MAML", ["learns nothing", "learns slowly", "beats EMRLD"]
)

# %%
guess.ask(
    "turned",
    "For the poor demonstrator, the average Delta turns negative",
    ["before it is overtaken", "at that moment", "after it", "never"],
)

# %% tags=["exact-emrld"]
clock.at("exact EMRLD")
goals = [(0, 0), (0, 4), (0, 8), (4, 8), (8, 8), (8, 4), (8, 0), (4, 0)]
grid = gridworld(9, 9, goals, start=(4, 4), discount=0.95)
best = [optimal_policy(mdp) for mdp in grid]
settings = {
    "EMRLD": (1.0, 1.0, 0.0),
    "cloning only": (0.0, 1.0, 0.0),
    "MAML": (1.0, 0.0, 0.0),
    "EMRLD, poor demonstrator": (1.0, 1.0, 0.6),
}
runs = {}
for name, (w_rl, w_bc, noise) in settings.items():
    seen = [mixed(policy, noise) for policy in best]
    rule = Adaptation(w_rl, w_bc, adapt_lr=5.0)
    problem = ExactMetaRL(grid, torch.full((8,), 1 / 8), seen, rule)
    runs[name] = list(exact_meta_train(problem, meta_lr=10.0, iterations=60))

# %%
looks = {
    "EMRLD": plotting.LOOKS["emrld"],
    "cloning only": {"color": "#777777", "linestyle": "-.", "marker": "v"},
    "MAML": plotting.LOOKS["maml"],
    "EMRLD, poor demonstrator": {**plotting.LOOKS["emrld"], "linestyle": ":", "marker": "x"},
}

# %% tags=["reveal"]
figure, panels = plt.subplots(1, 3, figsize=(12, 3.5))
terms = {
    "J_meta (return)": lambda it: it.objective,
    "Delta, worst state": lambda it: it.theorem.delta,
    "average Delta": lambda it: it.theorem.average_delta,
}
for axes, (label, value) in zip(panels, terms.items(), strict=True):
    figures.exact_training(runs, looks, value, axes)
    axes.set(title=label)
poor = runs["EMRLD, poor demonstrator"]
demonstrated = runs["EMRLD"][0].demonstrator, poor[0].demonstrator
for height in demonstrated:
    panels[0].axhline(height, color="black", linewidth=0.8, linestyle=(0, (1, 2)))
panels[1].set_yscale("symlog", linthresh=1e-3)
panels[0].legend(fontsize=8)
plt.show()

# %% [markdown]
# *Figure 11. Exact training on the grid, one update of the meta-table per meta-iteration: value of the adapted policies (thin dotted lines: the returns of the optimal and of the poor
# demonstrator), the largest Delta of Assumption 1 (symmetric log scale), and its average under the new policy.*

# %% tags=["reveal", "assumption-1-initial-stages", "tolerance:0.15", "tolerance:abs=0.02", "tolerance:whole=2"]
final = {name: iterates[-1].objective for name, iterates in runs.items()}
assert runs["EMRLD"][0].objective > 3 * runs["MAML"][0].objective
assert final["EMRLD"] > final["MAML"] > 5 * runs["MAML"][0].objective
for name in ("EMRLD", "EMRLD, poor demonstrator"):
    deltas = [float(it.theorem.delta) for it in runs[name]]
    print(f"{name:24} return {runs[name][0].objective:.2f} to {final[name]:.2f}, ", end="")
    print(f"Delta {deltas[0]:+.4f} to {deltas[-1]:+.4f}")
    assert deltas[0] > 0 > deltas[-1]
passed = next(it.iteration for it in poor if it.objective > it.demonstrator)
turned = next(it.iteration for it in poor if it.theorem.average_delta < 0)
assert 0 < turned < passed and final["EMRLD, poor demonstrator"] > 1.3 * poor[0].demonstrator
guess.reveal(
    "maml",
    f"from {runs['MAML'][0].objective:.2f} to {final['MAML']:.2f}; EMRLD {final['EMRLD']:.2f}",
)
guess.reveal("turned", f"negative in iteration {turned}, overtaken in iteration {passed}")
print(
    f"return of the optimal demonstrator {demonstrated[0]:.2f}, of the poor {demonstrated[1]:.2f}"
)

# %% [markdown] tags=["reveal"]
# - **EMRLD leads from the start**, by the cloning gradient in its adaptation, before any meta-update. (Theorem 1 compares two meta-iterations and is silent on that.)
# - **On this grid Assumption 1 is what the paper says it is**, true at first, since the walk begins again at the goal. (Where an episode ends at its goal, as in Point2D and TwoWheeled, $\Delta$ is never positive: Section 6.) $\Delta$ starts small and positive and then turns negative. What stays useful for longer is $\Delta_{\mathrm{avg}}$.
# - **The poor demonstrator is overtaken.** $\Delta_{\mathrm{avg}}$ turns negative *before* that: it is worse than the policy in the states that the policy visits. The bounds promise nothing before or after that (Figure 13), and EMRLD goes on improving, by the reward in its adaptation and in its meta-update.
# - **Nobody comes near the optimal demonstrator**, whose return is 3.35. With this $\alpha$ a single step is too short for it; cloning alone ends below MAML.
# - **Exact MAML learns**, slowly: its gradient is small, not zero. What stops MAML in notebook 05 is that *samples* of a small gradient are nearly all zero. (Sparsity is mild here: a coin-tossing walk does find an edge of a 9 × 9 grid.)

# %% [markdown]
# Is cloning alone the worse choice, then? The step length is part of the comparison. **Predict first:** which return has one step of cloning from an untrained policy, with no meta-training at all, if $\alpha$ is 100 in place of 5?

# %%
guess.ask("long", "return after one cloning step with alpha = 100 (at 5 it is 0.23)")

# %% tags=["reveal", "longer-steps", "tolerance:abs=0.02"]
weights = {"EMRLD": (1.0, 1.0), "cloning only": (0.0, 1.0), "MAML": (1.0, 0.0)}


def problem_with(name, alpha):
    """Return the grid with optimal demonstrators and one adaptation step of length alpha."""
    rule = Adaptation(*weights[name], adapt_lr=alpha)
    return ExactMetaRL(grid, torch.full((8,), 1 / 8), best, rule)


untrained = torch.zeros_like(grid[0].reward)
alphas = np.geomspace(1, 300, 16)
figure, axes = plt.subplots(figsize=(6.4, 3.2))
for name in weights:
    reached = [float(problem_with(name, alpha).meta_objective(untrained)) for alpha in alphas]
    axes.plot(alphas, reached, label=name, markevery=3, **looks[name])
axes.axhline(demonstrated[0], color="black", linewidth=0.8, linestyle=(0, (1, 2)))
axes.set(xscale="log", xlabel="step length alpha", ylabel="return, no meta-training")
axes.legend()
plt.show()

# %% tags=["reveal", "tolerance:0.15", "tolerance:abs=0.02"]
starts = {
    a: float(problem_with("cloning only", a).meta_objective(untrained)) for a in (5.0, 20.0, 100.0)
}
*_, trained = exact_meta_train(problem_with("cloning only", 100.0), meta_lr=10.0, iterations=20)
assert 0.2 < starts[5.0] < 0.3 < 1.8 < starts[20.0] < 2.5 < starts[100.0]
assert trained.objective > 0.85 * demonstrated[0] and final["cloning only"] < final["MAML"]
guess.reveal("long", f"{starts[100.0]:.2f}; {starts[5.0]:.2f} at 5 and {starts[20.0]:.2f} at 20")
print(f"alpha = 100, 20 meta-iterations: cloning alone {trained.objective:.2f}")
print("alpha = 5, 60 meta-iterations: ", end="")
print(f"cloning alone {final['cloning only']:.1f}, MAML {final['MAML']:.1f}")

# %% [markdown]
# *Figure 12. Return after one exact adaptation step from the untrained policy against the length of the step; the dotted line is the optimal demonstrator's return.*

# %% [markdown] tags=["reveal"]
# That cloning alone falls behind is a matter of this step length. At $\alpha = 5$ the RL term more than doubles what it reaches; at $\alpha = 100$ one cloning step comes close to the demonstrator without that term, and without any meta-training. Which of the two terms matters is a question about the step length as well, and Theorem 1
# does not contain $\alpha$. (Reward enters at a second place, too: the meta-update follows $J_{\mathrm{meta}}$ in every one of these runs, with or without the RL term in the adaptation.)

# %% [markdown]
# And the bounds, along EMRLD's training?

# %% tags=["bounds-along-training", "tolerance:0.15"]
figure, axes = plt.subplots(figsize=(8, 3.4))
series = {
    "improvement": [float(it.theorem.improvement) for it in runs["EMRLD"]],
    "bound": [float(it.theorem.bound) for it in runs["EMRLD"]],
    "bound_average_delta": [float(it.theorem.bound_average_delta) for it in runs["EMRLD"]],
    "trust_region": [float(it.related.trust_region) for it in runs["EMRLD"]],
}
for name, values in series.items():
    axes.plot(values, label=figures.LABELS[name], markevery=8, **figures.LOOKS[name])
axes.set_yscale("symlog", linthresh=0.01)
axes.set(xlabel="meta-iteration", ylabel="return gained per meta-iteration", ylim=(-200, 10))
axes.set_yticks([-100, -1, -0.01, 0.01, 1], ["-100", "-1", "-0.01", "0.01", "1"])
axes.legend(fontsize=8, loc="center left", bbox_to_anchor=(1, 0.5))
plt.show()

# %% tags=["tolerance:0.15"]
assert max(series["bound"] + series["bound_average_delta"]) < -8 < 0 < min(series["improvement"])
distances = [float(it.theorem.tv_demo) for it in runs["EMRLD"]]
assert min(distances) > 0.3 and max(distances) < 0.6
for name, values in series.items():
    print(f"{name:20} between {min(values):8.2f} and {max(values):6.2f}")
print(f"D_TV between {min(distances):.2f} and {max(distances):.2f}")

# %% [markdown]
# *Figure 13. Improvement of every meta-iteration of exact EMRLD (thick), and three lower bounds on it; symmetric log scale.*
#
# The improvement is positive all along (it zigzags once the meta-step has to be halved to keep it so), and Theorem 1 says "at least minus ten", or worse. One adaptation step leaves the policy far from the demonstrator
# ($D_{TV}$ about a half), and each unit of distance costs $2 C_1 / (1-\gamma)$, here 40 times $C_1$. The theorem explains the *direction*, get closer to the demonstrator while it is
# better; it does not explain the *amount*.
#
# ## 10 · Break an assumption (further reading)
#
# What the proof takes for granted, one thing at a time: below you choose what is falsely claimed, and how falsely. Each row is a line of the proof; a cross is a line that fails.
#
# **Predict first.** The distance to the demonstrator is measured in the demonstrator's states, as in Section 5. Which move fails first?

# %%
clock.at("break an assumption")
guess.ask("fails", "first move to fail", ["2", "4", "6", "7", "8"])

# %% tags=["reveal", "widget-assumptions", "nbval-ignore-output"]
bounds.assumption_sliders()

# %% tags=["reveal"]
bounds.assumption_picture()

# %% [markdown] tags=["reveal"]
# *Figure 14. The lines of the proof on the two states, when the distance is measured where the demonstrator walks: Hölder's inequality for the demonstrator fails first, and with it all that follows. How far a line holds is shown relative to its sides, on a symmetric log scale.*

# %% tags=["reveal", "which-move-fails"]
first = []
for claim in bounds.FALSE_CLAIMS[1:]:
    broken_family, claims = bounds.broken(claim, 0.5)
    fallen = [line.name for line in proof_lines(*broken_family, claims) if not line.holds()]
    first.append(fallen[0])
    print(f"{claim}: {len(fallen)} lines fall, first {fallen[0]}")
assert first == ["a_assumption", "b_demo", "lemma_1", "b_demo"]
guess.reveal("fails", f"move {MOVES[first[-1]]}")

# %% [markdown] tags=["reveal"]
# | false claim | first move to fail | what to notice |
# |---|---|---|
# | $\Delta$ too large | 6, Assumption 1 | claims up to $\Delta_{\mathrm{avg}}$ do no harm: only the average is used |
# | $C_1$ too small | 7, Hölder | small cuts do no harm: Hölder is generous |
# | the critic's $V$ is wrong at the start | 2, Lemma 1 | the values no longer telescope to $J$ |
# | the demonstrator's states | 7, Hölder | on the two-state family; every later line that uses it falls, the theorem too |
#
# A surprise: a critic that is wrong anywhere *but* in the first states breaks no **equation**. Adding any function of the state to $V$ changes rewards by a
# "potential", and potentials telescope away (Ng, Harada and Russell, 1999). Inequalities are another matter: $\Delta$ is claimed of the true advantage, and a critic that is wrong by much can push the demonstrator's average below it.

# %%
walk = corridor_step()
for size in (3.0, 10.0):
    equations, moves = 0, set()
    for seed in range(100):
        drawn = torch.randn(5, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)
        drawn[2] = 0.0  # right in the middle cell, where the walk begins
        claims = Claims(value_error=size * drawn)
        fallen = [line for line in proof_lines(*walk, claims) if not line.holds()]
        equations += any(line.relation == "=" for line in fallen)
        moves |= {(seed, line.name) for line in fallen}
    draws = len({seed for seed, _ in moves})
    print(f"critic wrong by about {size:g}: equations fall in {equations} of 100 draws, ", end="")
    print(f"some line in {draws}")
    assert equations == 0 and {name for _, name in moves} <= {"a_assumption"}
assert draws > 5

# %% [markdown]
# ## 11 · What the meta-gradient leaves out (further reading)
#
# The meta-update differentiates $J_i(\theta_i(\theta))$ with $\theta_i(\theta) = \theta + \alpha \nabla J_i(\theta)$ (take $w_{\mathrm{rl}} = 1$, $w_{\mathrm{bc}} = 0$). Exactly, by the chain rule,
#
# $$\nabla_\theta J_i(\theta_i(\theta)) = \big(I + \alpha \nabla^2 J_i(\theta)\big)\, \nabla J_i(\theta_i) .$$
#
# The algorithm does not have $J_i$. It has samples and the loss $-\operatorname{mean}(\log \pi_\theta(a \mid s)\, \hat A)$, in which samples and $\hat A$ are **fixed numbers**. The first derivative is right in expectation, as long as $\gamma^t$ is kept (notebook 01; the code drops it, the exact tables here keep it). The second is not: it misses how the *sampling*
# and the *advantages* change with $\theta$. In expectation the algorithm's matrix is
#
# $$\mathbb E_{d, \pi}\big[A(s, a)\, \nabla^2 \log \pi_\theta(a \mid s)\big] \quad\text{in place of}\quad \nabla^2 J .$$
#
# On a softmax table $\nabla^2 \log \pi(a \mid s)$ does not depend on $a$, and $\sum_a \pi A = 0$. So the expectation is **exactly zero**: of the RL term's second order *nothing* is left. What does survive is the second order of the
# cloning term, whose data do not depend on $\theta$. A variant with the ratio $\pi_\theta / \pi_{\mathrm{fixed}}$ for the logarithm keeps a part (Rothfuss et al., 2019).

# %% tags=["meta-gradient-dropped-term"]
clock.at("what the meta-gradient leaves out")
theta = torch.randn(5, 2, generator=torch.Generator().manual_seed(0), dtype=torch.float64)


def gradients(w_bc, alpha):
    """Return the meta-gradient by each inner loss, and the first-order one."""
    rule = Adaptation(1.0, w_bc, adapt_lr=alpha)
    by_loss = {
        kind: ExactMetaRL(mdps, task_weights, demo, rule, kind)
        for kind in ("exact", "log", "ratio")
    }
    found = {kind: problem.meta_gradient(theta) for kind, problem in by_loss.items()}
    return found | {"first order": by_loss["exact"].first_order_gradient(theta)}, by_loss["exact"]


found, exact = gradients(w_bc=1.0, alpha=0.5)
nudge = torch.randn(5, 2, generator=torch.Generator().manual_seed(1), dtype=torch.float64)
slope = (
    exact.meta_objective(theta + 1e-5 * nudge) - exact.meta_objective(theta - 1e-5 * nudge)
) / 2e-5
along = (found["exact"] * nudge).sum()
assert torch.isclose(along, slope, rtol=1e-6)
print(f"slope along a random direction: {along:.5f} exact, {slope:.5f} by finite differences")

# %%
print(f"{'relative error of the meta-gradient':38}{'log':>8}{'ratio':>8}{'first order':>13}")
for w_bc in (0.0, 1.0):
    for alpha in (0.1, 0.5, 2.0):
        found, _ = gradients(w_bc, alpha)
        norm = found["exact"].norm()
        error = {
            kind: float((value - found["exact"]).norm() / norm) for kind, value in found.items()
        }
        name = f"w_bc = {w_bc:g}, alpha = {alpha:g}"
        print(f"{name:38}{error['log']:8.1%}{error['ratio']:8.1%}{error['first order']:13.1%}")
        if not w_bc:
            assert torch.allclose(found["log"], found["first order"], atol=1e-12)
        elif alpha < 1:
            assert error["log"] > error["first order"]

# %% [markdown]
# Without cloning, the surrogate's meta-gradient *is* the first-order one. The dropped term grows with $\alpha$: a few per cent for small steps, a quarter and more for long ones. With cloning, keeping one second
# derivative and dropping the other can even be *further* from the exact gradient than dropping both: two errors that partly cancelled.
#
# In a Gaussian network policy (notebook 06) $\nabla^2 \log \pi$ does depend on the action, so something of the RL term's second order is left; that notebook's finite differences check the derivative
# *of the surrogate*, which is what the algorithm uses, not of $J$. A further dropped term, the dependence of $\mathcal D^{\mathrm{tr}}$ itself on $\theta$, is the subject of E-MAML (Stadie et al., 2018) and of DiCE (Foerster et al., 2018).
#
# ## Where the paper slips, and what we use
#
# | place | printed | here |
# |---|---|---|
# | (meta-PDL), last line | $a \sim \pi_{1,i}$ | $a \sim \pi_{k+1,i}$ |
# | second term of (inter), first sum | $A^{\pi_{2,i}}$ | $A^{\pi_{k,i}}$ |
# | step (b) | $=$ | $\ge$ |
# | group 1 | the ratio $\pi_{k+1,i} / \pi_{k,i}$ under $d^{\pi_{k,i}}$, silent on actions with $\pi_{k,i} = 0$ | $\sum_a \pi_{k+1,i} A$, as in the proof; the bound is valid either way, since group 1 stays at or below 0 |
# | $D_{TV}^{\pi}$ | a policy as superscript | states drawn from $d^\pi$ (Section 2) |
# | Assumption 1 | in every state | the average $\Delta_{\mathrm{avg}}$ is enough |
# | the new policy's states "replaced" by the demonstrator's | "in practice" | not a bound; (4) is |
#
# **Next** notebook 05. Or draw your own families: `emrld_lite.tabular` has everything used here.
#
# **References** Kakade and Langford (2002), *Approximately optimal approximate RL*; Achiam et al. (2017), *Constrained policy optimization*; Ng, Harada and Russell (1999), *Policy invariance under reward
# transformations*; Rothfuss et al. (2019), *ProMP*; Stadie et al. (2018), *Some considerations on learning to explore via meta-RL*; Foerster et al. (2018), *DiCE*; Rengarajan et al. (2022), the paper.
