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
# worlds small enough to solve exactly we can put *numbers* on both sides of every line of its proof. You will
# see that the theorem is right, that half of it can be thrown away, and that the sentence after it, the one
# that leads to the algorithm, fails in a world with **two states**.
#
# **You will be able to**
#
# - derive Theorem 1 move by move, and say which rule and which assumption each move uses,
# - compute every term of it exactly, and compare it with an older bound,
# - prove a tighter bound in two lines, say what it costs, and mend the one that breaks,
# - say what the theorem does not cover in the paper's own experiments,
# - tell what the meta-gradient of the real algorithm leaves out.
#
# **You need** linear algebra (a linear system, an expectation as a sum); the one equation of EMRLD that is used stands in Section 6. **Time**
# about 100 minutes, of which the machine computes one. **Paper** Sections 2 and 3, Appendix A of Rengarajan et al.,
# NeurIPS 2022.

# %%
import matplotlib.pyplot as plt
import numpy as np
import torch

from emrld_lite.adapt import Adaptation
from emrld_lite.classroom import checks as check
from emrld_lite.classroom.clock import Clock
from emrld_lite.classroom.widgets import bounds
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
clock = Clock(
    {
        "worlds one can solve": 15,
        "the proof": 30,
        "ten thousand families": 5,
        "beyond the paper": 25,
        "from likelihood to distance": 5,
        "exact EMRLD": 10,
        "break it yourself": 5,
        "what the meta-gradient leaves out": 5,
    }
)

# %% [markdown]
# ## 1 · Worlds one can solve
#
# A **finite Markov decision process** has states $s$, actions $a$, transition probabilities $P(s' \mid s, a)$, rewards
# $R(s, a)$, a distribution $\rho$ of first states and a discount $0 \le \gamma < 1$. A policy is a table $\pi(a \mid s)$ (the paper
# writes $\pi(s, a)$). Averaging over the actions leaves a Markov chain with $P_\pi(s' \mid s) = \sum_a \pi(a \mid s)\, P(s' \mid s, a)$ and
# rewards $R_\pi(s) = \sum_a \pi(a \mid s)\, R(s, a)$. Everything we need is then a linear system:
#
# | symbol | name | solves |
# |---|---|---|
# | $V^\pi(s)$ | value | $(I - \gamma P_\pi)\, V = R_\pi$ |
# | $Q^\pi(s, a)$ | action value | $Q = R + \gamma P V$ |
# | $A^\pi(s, a)$ | advantage | $A = Q - V$, so $\sum_a \pi(a \mid s)\, A^\pi(s, a) = 0$ |
# | $J(\pi)$ | objective | $J = \sum_s \rho(s)\, V^\pi(s)$ |
# | $d^\pi(s)$ | visitation, a distribution | $(I - \gamma P_\pi)^{\mathsf T} d = (1 - \gamma)\, \rho$ |
#
# A **task family** is a list of such worlds, one per task $i$, with task probabilities $p(i)$. Ours, for this notebook: five cells in a
# row, the goal at the left end or at the right end. The move into the goal pays 1, and the walk starts again in the middle.
# **Change it!** The numbers of the proof follow (Figure 3 and the sliders keep this corridor). Where an assertion stops you, you have found a family of which a sentence here is not true.

# %% tags=["the-family"]
clock.at("worlds one can solve")
gamma, step_size = 0.9, 0.5
mdps = gridworld(1, 5, [(0, 0), (0, 4)], start=(0, 2), discount=gamma, moves=LEFT_RIGHT)
task_weights = torch.tensor([0.5, 0.5])  # p(i)
demo = [mixed(optimal_policy(mdp), noise=0.2) for mdp in mdps]  # (state, action) per task
old = [torch.full_like(policy, 1 / policy.shape[1]) for policy in demo]  # tosses a coin
new = [(1 - step_size) * before + step_size * goal for before, goal in zip(old, demo, strict=True)]
family = (mdps, task_weights, old, new, demo)
advantage = mdps[0].advantage(old[0])
average = (old[0] * advantage).sum(-1).abs().max()
assert average < 1e-12
print(f"the old policy's average advantage is {average:.11f} at most, in every state")

# %% [markdown]
# ### Exercise 1 · How often is each state visited?
#
# *Difficulty 2 of 3, 10 minutes.* $d^\pi(s) = (1 - \gamma) \sum_t \gamma^t\, \mathbb P(s_t = s)$. Solve for it.
#
# <details><summary>Hint 1: why a linear system?</summary>
# One step of the chain takes the distribution p of today's state to P<sub>π</sub><sup>T</sup> p. Sum the geometric series of γ P<sub>π</sub><sup>T</sup>.
# </details>
#
# <details><summary>Hint 2: which torch functions?</summary>
# <code>torch.einsum("sa,sat->st", policy, transition)</code> is P<sub>π</sub>; <code>torch.linalg.solve(matrix, vector)</code> solves; <code>matrix.T</code> transposes.
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
if check.visitation(visitation):
    ours = visitation(mdps[0].transition, mdps[0].initial, demo[0], gamma)
    assert torch.allclose(ours, mdps[0].visitation(demo[0]))
    print("Your d equals emrld_lite.tabular.TabularMDP.visitation.")

# %%
figure, panels = plt.subplots(1, 2, figsize=(9, 2.8), sharey=True)
figures.visits(family, panels)
plt.show()

# %% [markdown]
# *Figure 1. Where three policies spend their (discounted) time, for the task with the left goal (state 0) and with the right goal
# (state 4). The goal itself is never stayed in: the move into it ends in the middle.*
#
# The old policy wanders about; the demonstrator stays between middle and goal; the new policy, half of each, is in between.
#
# ## 2 · The proof
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
# *Difficulty 1 of 3, 5 minutes.* Find $C_1$, and the largest $\Delta$ that the assumption allows.
#
# <details><summary>Hint 1: what is averaged, what is not?</summary>
# The actions, by the demonstrator. Not the states, not the tasks: the assumption speaks of every one of them.
# </details>
#
# <details><summary>Hint 2: the shape of the average</summary>
# <code>(demo * advantage).sum(-1)</code> has one number per task and state.
# </details>


# %% tags=["exercise-assumption"]
def assumption_numbers(advantage, demo):
    """Return (C1, Delta) from two tensors (task, state, action)."""
    ### BEGIN SOLUTION
    return advantage.abs().max(), (demo * advantage).sum(-1).min()
    ### END SOLUTION


# %% tags=["assumption-1"]
clock.at("the proof")
theorem = theorem_1(*family)
if check.assumption_numbers(assumption_numbers):
    advantages = torch.stack([mdp.advantage(policy) for mdp, policy in zip(mdps, old, strict=True)])
    c1, delta = assumption_numbers(advantages, torch.stack(demo))
    assert torch.isclose(c1, theorem.c1) and torch.isclose(delta, theorem.delta)
    assert theorem.delta > 0
    print(f"C1 = {c1:.4f}, Delta = {delta:.4f}: Assumption 1 holds with a positive Delta")

# %% [markdown]
# Now the proof, as numbered moves, each with the one rule it uses. Under each, its two sides on our family,
# each computed from its own formula by `proof_lines`.

# %%
lines = {line.name: line for line in proof_lines(*family)}


def show(*names):
    """Print both sides of lines of the proof; stop where one does not hold."""
    for name in names:
        line = lines[name]
        sides = [
            ", ".join(f"{round(float(x), 6) + 0.0:.6f}" for x in side.flatten())
            for side in (line.left, line.right)
        ]
        assert line.holds(), name
        print(f"{name:16} {sides[0]} {line.relation} {sides[1]}")


# %% [markdown]
# **Move 1 (definition).** Values are discounted sums of rewards, so $J_i(\pi) = \sum_s \rho(s) V^\pi(s)$ and also
# $J_i(\pi) = \frac{1}{1-\gamma} \sum_s d^\pi(s) \sum_a \pi(a \mid s) R(s, a)$. (One number per task, for the new policy.)

# %% tags=["proof-objective"]
show("objective")

# %% [markdown]
# **Move 2 (performance difference lemma, Lemma 1; Kakade and Langford, 2002).** For any two policies $\pi_1$, $\pi_2$ in one world,
#
# $$J(\pi_1) - J(\pi_2) = \frac{1}{1 - \gamma}\, \mathbb E_{s \sim d^{\pi_1},\, a \sim \pi_1}\big[A^{\pi_2}(s, a)\big] . \qquad\text{(1)}$$
#
# *Proof.* Follow $\pi_1$ from $s_0 \sim \rho$. In expectation, $A^{\pi_2}(s_t, a_t) = R(s_t, a_t) + \gamma V^{\pi_2}(s_{t+1}) - V^{\pi_2}(s_t)$. Multiply by $\gamma^t$
# and sum over $t$: the values **telescope** and only $-V^{\pi_2}(s_0)$ is left, so the sum is $J(\pi_1) - J(\pi_2)$. And for any function $f$,
# $\sum_t \gamma^t\, \mathbb E f(s_t, a_t) = \frac{1}{1-\gamma} \mathbb E_{d^{\pi_1}, \pi_1} f$, by the definition of $d$. $\square$
#
# ### Exercise 3 · The right side of the lemma
#
# *Difficulty 2 of 3, 5 minutes.* You get more than you need: choose whose states and whose actions count.
#
# <details><summary>Hint 1: whose trajectory was followed in the proof?</summary>
# That of the new policy. Only the advantage is the old one's.
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
if check.performance_difference(performance_difference):
    visits = [mdps[0].visitation(policy) for policy in (old[0], new[0])]
    ours = performance_difference(advantage, *visits, old[0], new[0], gamma)
    assert torch.isclose(ours, mdps[0].objective(new[0]) - mdps[0].objective(old[0]))
    show("lemma_1")

# %% [markdown]
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
show("meta_definition", "meta_linearity", "meta_lemma", "meta_joint")

# %% [markdown]
# **Move 4 (add and subtract).** The same expectation under the **old** states is added and subtracted, and what shares its actions is collected:
#
# $$(1-\gamma)\big(J_{\mathrm{meta}}(\pi_{k+1}) - J_{\mathrm{meta}}(\pi_k)\big) =
# \sum_i p(i) \sum_s d_i^{\pi_{k,i}} \sum_a \pi_{k+1,i}\, A_i
# + \sum_i p(i) \sum_s \big(d_i^{\pi_{k+1,i}} - d_i^{\pi_{k,i}}\big) \sum_a \pi_{k+1,i}\, A_i . \qquad\text{(inter)}$$

# %% tags=["proof-inter"]
show("add_and_subtract", "inter")

# %% [markdown]
# **Move 5 (the demonstrator enters).** In the second term of (inter), write $\pi_{k+1,i} = \pi^{\mathrm{dem}}_i + (\pi_{k+1,i} - \pi^{\mathrm{dem}}_i)$ under the new
# states, and $\pi_{k+1,i} = \pi_{k,i} + (\pi_{k+1,i} - \pi_{k,i})$ under the old ones. With $d^{\mathrm{new}}$ for $d_i^{\pi_{k+1,i}}$, $d^{\mathrm{old}}$ for $d_i^{\pi_{k,i}}$, $\pi^{\mathrm{dem}}$ for $\pi^{\mathrm{dem}}_i$ and $A$ for $A_i$, that makes four sums:
#
# $$\mathbb E_{i, d^{\mathrm{new}}} \sum_a \pi^{\mathrm{dem}} A \;+\; \mathbb E_{i, d^{\mathrm{new}}} \sum_a (\pi_{k+1,i} - \pi^{\mathrm{dem}}) A
# \;-\; \mathbb E_{i, d^{\mathrm{old}}} \sum_a (\pi_{k+1,i} - \pi_{k,i}) A \;-\; \mathbb E_{i, d^{\mathrm{old}}} \sum_a \pi_{k,i} A .$$
#
# (The appendix writes $A^{\pi_2}$ in the first of them, for $A^{\pi_{k,i}}$.)

# %% tags=["proof-second-term"]
show("second_term")

# %% [markdown]
# **Move 6, step (a): four facts.** One for each sum:
#
# 1. the first is at least $\Delta$, by **Assumption 1**: an average is at least the minimum;
# 2. the last is **zero**: an advantage has mean 0 under its own policy;
# 3. and 4. the two in the middle are at least minus the sum of their **absolute values**.
#
# Added up, the second term of (inter) is at least $\Delta - \mathbb E_{i, d^{\mathrm{new}}} \sum_a |\pi_{k+1,i} - \pi^{\mathrm{dem}}| |A| - \mathbb E_{i, d^{\mathrm{old}}} \sum_a |\pi_{k+1,i} - \pi_{k,i}| |A|$.

# %% tags=["proof-a"]
show("a_assumption", "a_zero", "a_absolute_demo", "a_absolute_old", "a")

# %% [markdown]
# **Move 7, step (b): Hölder's inequality.** $|A| \le C_1$, and $\sum_a |\pi_1 - \pi_2| = 2 D_{TV}$. (The paper writes "=" here; it is an inequality, in the right direction.)

# %% tags=["proof-b"]
show("b_demo", "b_old", "b")

# %% [markdown]
# **Move 8.** Insert (b) in (inter), divide by $1 - \gamma$, and name the first sum of (inter) as the importance-weighted advantage. That is Theorem 1. $\square$

# %% tags=["proof-theorem"]
show("theorem")
assert theorem.bound <= theorem.improvement
print(f"group 1 {theorem.group_1:.4f}, group 2 {theorem.group_2:.4f}")

# %% [markdown]
# The theorem holds. On this family it only excludes a loss of more than 2.7, where the truth is a gain of 1.3. A bound can be
# right and say little, and from here on we ask *how much* it says.
#
# ## 3 · Ten thousand families
#
# **Predict first.** Random families: two to eight states, up to six tasks, discounts up to 0.999, sparse and dense rewards,
# policies from uniform to nearly deterministic. How many of ten thousand violate the bound? In how many is the bound *positive*, that is, does it
# promise any improvement at all?

# %% tags=["ten-thousand", "tolerance:abs=1.5", "tolerance:whole=2"]
clock.at("ten thousand families")
batches = [figures.everything(random) for random in many_families(seed=0, total=10_000)]
sample = {name: torch.cat([batch[name] for batch in batches]) for name in batches[0]}
scale = torch.maximum(sample["improvement"].abs(), sample["bound"].abs()).clamp(min=1)
valid = ("bound", "bound_group_2", "bound_average_delta", "trust_region", "repaired")
broken = {
    name: int(((sample[name] - sample["improvement"]) / scale > 1e-9).sum()) for name in valid
}
assert not any(broken.values()), broken
positive = {name: (sample[name] > 0).double().mean() for name in (*valid, "improvement")}
assert positive["bound"] < 0.001 < positive["bound_average_delta"] < positive["trust_region"]
better = sample["delta"] > 1e-9  # Assumption 1 holds with a positive Delta
assert not (sample["bound"][~better] > 1e-6).any()
given = {name: (sample[name][better] > 0).double().mean() for name in positive}
assert (
    given["bound"] < 0.1 and given["bound"] < given["bound_group_2"] < given["bound_average_delta"]
)
print(f"{len(scale)} families, violations beyond 1e-9 relative: {sum(broken.values())}")
print(f"Delta is positive in {better.double().mean():.1%}, in {int(better.sum())} of them")
print("positive in               of all   where Delta > 0")
for name, share in positive.items():
    print(f"{name:20} {share:11.2%} {given[name]:17.1%}")

# %%
figure, panels = plt.subplots(1, 3, figsize=(11, 3.5), sharey=True)
for axes, name in zip(panels, ("bound", "bound_average_delta", "trust_region"), strict=True):
    figures.against_improvement(sample["improvement"], sample[name], axes, name)
    axes.axhline(0, color="black", linewidth=0.6, linestyle=(0, (1, 2)))
panels[0].set_ylabel("bound (return)")
plt.show()

# %% [markdown]
# *Figure 2. Ten thousand random families: true improvement across, bound upwards, both on symmetric log scales. A point above the black
# line would be a violation; a point on it, a tight bound; a point above the dotted line, a promise. Middle and right: two bounds of the next section.*
#
# No point crosses the line. The bound is hardly ever positive, but that says little about the theorem: our demonstrators are drawn at random, so in 98 or 99 of 100 families some state has a demonstrator that is worse than the old policy, $\Delta \le 0$, and
# then the bound *cannot* be positive. The fair question is asked where Assumption 1 holds with $\Delta > 0$ (right column). There most steps improve; the printed bound says so in at most a few families of a hundred, its second group alone more often,
# and with the average $\Delta$ of the next section in more than one of ten. (Random sampling is also a weak hunter of violations. `tests/test_tabular.py` lets a property-based tester and gradient ascent look for them, too.)
#
# ## 4 · Beyond the paper
#
# ### The first group is never positive
#
# *Proof.* Since $\sum_a \pi_{k,i} A = 0$, the expectation in group 1 is $\mathbb E_{i, d^{\mathrm{old}}} \sum_a (\pi_{k+1,i} - \pi_{k,i}) A$. By Hölder it is at most $2 C_1\, \mathbb E_i D_{TV}^{\pi_{k,i}}(\pi_{k+1,i}, \pi_{k,i})$,
# and exactly that is subtracted. $\square$
#
# So the second group **alone** is a valid bound, and never a worse one. It also has a direct proof of two lines, from (meta-PDL):
#
# $$\begin{aligned}(1-\gamma)\big(J_{\mathrm{meta}}(\pi_{k+1}) - J_{\mathrm{meta}}(\pi_k)\big) &= \mathbb E_{i, d^{\mathrm{new}}} \sum_a \pi^{\mathrm{dem}} A + \mathbb E_{i, d^{\mathrm{new}}} \sum_a (\pi_{k+1,i} - \pi^{\mathrm{dem}}) A \\
# &\ge \Delta_{\mathrm{avg}} - 2 C_1\, \mathbb E_i D_{TV}^{\pi_{k+1,i}}(\pi_{k+1,i}, \pi_i^{\mathrm{dem}}) , \end{aligned} \qquad\text{(2)}$$
#
# with $\Delta_{\mathrm{avg}} = \mathbb E_{i,\; s \sim d_i^{\pi_{k+1,i}},\; a \sim \pi_i^{\mathrm{dem}}}[A_i(s, a)] \ge \Delta$.
#
# The old states never appear. And the proof needs only the **average** $\Delta_{\mathrm{avg}}$, not Assumption 1's minimum.
# The price: $\Delta_{\mathrm{avg}}$ is an average over the states of the *new* policy, which nobody has visited yet when the step is chosen. In a solved world we can compute it; an algorithm knows it only afterwards. Assumption 1, a statement about every state, can at least be claimed beforehand.

# %% tags=["first-group"]
clock.at("beyond the paper")
slack = 1e-9 * scale
assert (sample["group_1"] <= slack).all()
assert (sample["bound"] <= sample["bound_group_2"] + slack).all()
assert (sample["bound_group_2"] <= sample["bound_average_delta"] + slack).all()
print(f"group 1 is {sample['group_1'].max():.6f} at most")
for name in ("bound", "bound_group_2", "bound_average_delta"):
    below = (sample["improvement"] - sample[name]).median()
    print(f"{name:20} lies {below:.2f} below the truth, in the median")

# %% [markdown]
# "Maximising the first term in group one with a constraint on its second term will ensure a higher lower bound", says the paper, and
# that TRPO does this. So it does, but the most it can reach is zero, which leaving the policy alone reaches as well. The theorem does not
# say that the RL part helps.
#
# ### One absorbing state forces $\Delta \le 0$
#
# In a state that cannot be left, where every action pays the same, every advantage is 0, hence also the demonstrator's. Assumption 1 asks
# for $\Delta$ in *every* state, so $\Delta \le 0$, and group 2 can promise nothing. An episode that ends at its goal has such a
# state. The average $\Delta_{\mathrm{avg}}$ does not mind.

# %% tags=["absorbing-state"]
ending = gridworld(1, 5, [(0, 0), (0, 4)], (0, 2), gamma, at_goal="absorb", moves=LEFT_RIGHT)
once = theorem_1(ending, task_weights, old, demo, demo)  # all the way to the demonstrator
assert once.delta <= 0 < once.average_delta
assert once.bound_group_2 <= 0 < once.bound_average_delta
print(f"Delta {abs(once.delta):.3f}, its average {once.average_delta:.3f}")
print(f"promised: {once.bound:.3f} printed, {once.bound_average_delta:.3f} with the average")
print(f"truth: {once.improvement:.3f}")

# %% [markdown]
# ### Where the bounds are tight, and an older one
#
# **A tight instance.** One state, two actions that pay $+1$ and $-1$; the old policy tosses a coin, so $A = \pm 1 = \pm C_1$. The demonstrator takes the
# good action with probability $\frac12 + x$, the new policy with $\frac12 + y$, $0 \le y \le x$. Then $\Delta = 2x$,
# the distances are $y$ and $x - y$, group 1 is $2y - 2y = 0$, group 2 is $2x - 2(x - y) = 2y$, and the improvement is $2y$ (each over $1 - \gamma$): **equality all the way**.
#
# **The trust-region bound** of Achiam et al. (2017) knows nothing of demonstrators:
#
# $$J(\pi_1) - J(\pi_2) \ge \frac{1}{1-\gamma} \Big( \mathbb E_{d^{\pi_2},\, \pi_1}[A^{\pi_2}] - \frac{2\gamma\, \epsilon}{1-\gamma}\, D_{TV}^{\pi_2}(\pi_1, \pi_2) \Big), \qquad \epsilon = \max_s \big|\mathbb E_{a \sim \pi_1}[A^{\pi_2}(s, a)]\big| . \qquad\text{(3)}$$
#
# We average it over the tasks. **Predict first:** on the way from the old policy to the demonstrator, where does it win, and where does (2)?


# %% tags=["tight-instance"]
def coin(share, lead=0.3):
    """Return the one-state family, the given share of the way to the demonstrator."""
    world = TabularMDP(torch.ones(1, 2, 1), [[1, -1]], [1], gamma)
    tables = [torch.tensor([[0.5 + x, 0.5 - x]]) for x in (0.0, share * lead, lead)]
    return [world], [1.0], *([table] for table in tables)


figure, panels = plt.subplots(1, 2, figsize=(10.5, 3.6))
names = ("improvement", "trust_region", "bound", "bound_group_2", "bound_average_delta")
shares = np.linspace(0, 1, 33)
tight = figures.along(coin, shares, names, panels[0])
way = figures.along(lambda share: corridor_step(share=share), shares, names, panels[1])
for axes, title in zip(panels, ("one state", "five cells, two goals"), strict=True):
    axes.set(title=title, xlabel="share of the demonstrator in the new policy")
panels[1].set_ylim(-8, 4)
panels[1].legend(loc="lower left")
plt.show()

# %% [markdown]
# *Figure 3. Improvement (thick) and bounds along the straight way from the old policy to the demonstrator. Left: on the one-state
# family all but one of the lines lie upon each other. Right: on the five cells each bound has its place.*

# %% tags=["each-wins-somewhere"]
assert np.allclose(tight["bound"], tight["improvement"], atol=1e-5)
ahead = way["trust_region"] > way["bound_average_delta"]
assert ahead[1] and not ahead[-1]
assert np.isclose(way["bound_average_delta"][-1], way["improvement"][-1])
assert (
    np.maximum(way["trust_region"], way["bound_average_delta"]) <= way["improvement"] + 1e-9
).all()
for name in names:
    print(f"at the demonstrator of the five cells: {figures.LABELS[name]:22}{way[name][-1]:+7.2f}")
assert way["bound"][-1] < 0 < way["bound_group_2"][-1]
older = (sample["trust_region"] > sample["bound"]).double().mean()
against = (sample["trust_region"] > sample["bound_average_delta"]).double().mean()
assert 0.2 < against < older < 0.8
print(f"trust region ahead of the printed bound in {older:.1%} of the random families,")
print(f"ahead of the average-Delta bound in {against:.1%}")

# %% [markdown]
# Close to the old policy the trust-region bound wins: it is exact where nothing changes. Close to the **demonstrator** (2) wins, and it is exact when the new policy *is* the
# demonstrator: then the distance is 0, and $\Delta_{\mathrm{avg}} / (1-\gamma)$ is Lemma 1. The *printed* bound is negative even there: its first group charges for every step away from the old policy. The maximum of the two is a valid bound as well,
# and the best to use. In our random families each is ahead about half of the time; other ways of drawing them give other shares.
#
# ### The sentence after the theorem
#
# Group 2 asks for closeness to the demonstrator in the states of the **new** policy, which no one has visited yet. "Hence, in
# practice, we replace that term" by the distance in the states of the **demonstrator**, $D_{TV}^{\mathrm{dem}}$. Is what remains still a bound?
#
# For the tight bound (the second group alone), random search answers at once:

# %% tags=["substitution-random"]
random = torch.Generator().manual_seed(0)
for states in (2, 3):
    small = random_family(random, 20_000, tasks=1, states=states, actions=2)
    parts = figures.everything(small)
    gap = (1 - small[0][0].discount) * (parts["substituted_group_2"] - parts["improvement"])
    found = int((gap > 0.01).sum())
    assert found > 5
    print(f"{states} states: broken by more than 0.01 a step in {found} of 20,000 families,")
    print(f"          by up to {gap.max():.2f} a step")

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
    print(f"bound less truth at most {float(broken_by.max()):+.3f} C1 a step")

# %% [markdown]
# So the printed theorem does **not** survive the substitution. Here is a counterexample small enough to check by hand, found by asking what the climb had built: a path, and
# next to it a swamp that the demonstrator never enters.
#
# | | action 0 | action 1 | action 2 |
# |---|---|---|---|
# | on the path (start) | $+1$, stay on the path | $-1$, stay | $0$, into the swamp |
# | in the swamp | $+1$, back to the path | $-1$, back | $-1$, stay in the swamp |
# | old policy, both states | $\frac12$ | $\frac12$ | $0$ |
# | demonstrator, both states | $\frac12 + x$ | $\frac12 - x$ | $0$ |
# | new policy on the path | $\frac12 + x$ | $\frac12 - x - \varepsilon$ | $\varepsilon$ |
# | new policy in the swamp | $0$ | $0$ | $1$ |
#
# The old values are 0, so the advantages are the rewards: $C_1 = 1$, and $\Delta = 2x > 0$ in every state: **Assumption 1 holds**. Under the old and the demonstrator's states
# (all path) group 1 is $(2x + \varepsilon) - 2(x + \varepsilon) = -\varepsilon$, and the substituted group 2 is $2x - 2\varepsilon$. So the substituted theorem promises $2x - 3\varepsilon$ a step.
# But a share $\sigma = \gamma\varepsilon / (1 - \gamma + \gamma\varepsilon)$ of the new policy's time goes to the swamp, and the truth is $(1 - \sigma)(2x + \varepsilon) - \sigma$.

# %% tags=["two-state-counterexample"]
x, slip = 0.25, 0.1
swamp = slippery_pair(gamma, slip, x)
truth = (1 - gamma) * theorem_1(*swamp).improvement
promise = (1 - gamma) * related_bounds(*swamp).substituted
share = gamma * slip / (1 - gamma + gamma * slip)
assert torch.isclose(truth, torch.tensor((1 - share) * (2 * x + slip) - share).double())
assert torch.isclose(promise, torch.tensor(2 * x - 3 * slip).double())
assert theorem_1(*swamp).delta > 0 and truth < 0 < promise
print(f"promised {promise:+.4f} a step, true {truth:+.4f} a step")

# %%
figure, panels = plt.subplots(1, 2, figsize=(10, 3.4), sharey=True)
names = ("improvement", "substituted", "bound")
for axes, rate in zip(panels, (0.9, 0.99), strict=True):
    slips = np.linspace(0, 0.15, 31)
    figures.along(lambda s, g=rate: slippery_pair(g, s, x), slips, names, axes, per_step=True)
    axes.set(title=f"gamma = {rate}", xlabel="probability of the slip")
    axes.axhline(0, color="black", linewidth=0.6)
panels[1].set_ylabel("")
panels[1].legend()
plt.show()

# %% [markdown]
# *Figure 4. The two-state family: truth (thick), the theorem as printed (dashed, below it) and the theorem with the demonstrator's states (dotted,
# above it), per discounted step, against the probability of the slip.*
#
# A small slip, rare where the demonstrator walks, leads to a place where nobody ever showed what to do. Imitation learning knows this as **compounding
# errors**. With $\gamma \to 1$, $\varepsilon \to 0$ slowly and $x \to \frac12$ the promise goes to $+C_1$ a step, the truth to $-C_1$: the substituted bound can be as wrong as a bound can be.
#
# ### Exercise 4 · Break it yourself
#
# *Difficulty 3 of 3, 10 minutes.* With $x = 0.25$, choose $\gamma$ and $\varepsilon$ so that the substituted theorem promises at least $0.1$ a step, and the truth is $-0.4$ a step or less.
#
# <details><summary>Hint 1: the promise</summary>
# 2x − 3ε ≥ 0.1 bounds the slip from above, whatever γ is.
# </details>
#
# <details><summary>Hint 2: the truth</summary>
# With ε fixed, the share σ of time in the swamp grows with γ. Put σ = 0.8 into the formula for the truth and see.
# </details>


# %% tags=["exercise-break"]
def break_the_substitution():
    """Return (discount, slip), two plain numbers."""
    ### BEGIN SOLUTION
    return 0.99, 0.05
    ### END SOLUTION


# %%
if check.break_the_substitution(break_the_substitution):
    discount, slip = break_the_substitution()
    yours = slippery_pair(discount, slip, 0.25)
    promise = (1 - discount) * related_bounds(*yours).substituted
    truth = (1 - discount) * theorem_1(*yours).improvement
    print(f"promised {promise:+.4f} a step, true {truth:+.4f} a step")

# %% [markdown]
# ### The repair, and its price
#
# Closeness in the demonstrator's states *is* enough, at the price of one more factor $1/(1-\gamma)$:
#
# $$J_{\mathrm{meta}}(\pi_{k+1}) - J_{\mathrm{meta}}(\pi_k) \ge \frac{1}{1-\gamma}\Big(\mathbb E_{i,\, d_i^{\mathrm{dem}},\, \pi_i^{\mathrm{dem}}}[A_i] - \frac{2 C_1}{1-\gamma}\, \mathbb E_i D_{TV}^{\mathrm{dem}}(\pi_{k+1,i}, \pi_i^{\mathrm{dem}})\Big) . \qquad\text{(4)}$$
#
# *Proof, in one task.* Write $d_1, P_1$ for the visitation and the chain of the new policy, $d_0, P_0$ for those of the demonstrator.
#
# 1. *How far apart are the visitations?* Both solve a flow equation, $d_j = (1-\gamma)\rho + \gamma P_j^{\mathsf T} d_j$. Subtract: $(I - \gamma P_1^{\mathsf T})(d_1 - d_0) = \gamma (P_1 - P_0)^{\mathsf T} d_0$. The inverse
# of the matrix on the left, $\sum_t \gamma^t (P_1^{\mathsf T})^t$, stretches the 1-norm by at most $1/(1-\gamma)$; the right side has 1-norm at most $2\gamma D_{TV}^{\mathrm{dem}}$. So $\|d_1 - d_0\|_1 \le \frac{2\gamma}{1-\gamma} D_{TV}^{\mathrm{dem}}$. (This is Lemma 3 of Achiam et al., 2017.)
# 2. *Change the states.* Let $g(s) = \sum_a \pi_{k+1,i}(a \mid s) A(s, a)$, so $|g| \le C_1$. By (meta-PDL), $(1-\gamma)\big(J(\pi_{k+1,i}) - J(\pi_{k,i})\big) = \sum_s d_1 g \ge \sum_s d_0\, g - C_1 \|d_1 - d_0\|_1$.
# 3. *Change the actions.* By Hölder, $\sum_s d_0\, g \ge \mathbb E_{d_0, \mathrm{dem}}[A] - 2 C_1 D_{TV}^{\mathrm{dem}}$.
#
# Add up: $2 C_1 \big(1 + \frac{\gamma}{1-\gamma}\big) = \frac{2 C_1}{1-\gamma}$. $\square$
#
# By Lemma 1 the first term of (4) is simply $J_{\mathrm{meta}}(\mathrm{dem}) - J_{\mathrm{meta}}(\pi_k)$: *you gain what the demonstrator would, less the price of differing from it*.
# It holds in all our random families (`repaired` was among the five bounds above). The two-state family shows that the extra factor cannot be dropped: there a distance of
# about $1 - \gamma$ already costs a constant.

# %% tags=["the-repair"]
gains = torch.stack(
    [
        mdp.objective(shown) - mdp.objective(was)
        for mdp, was, shown in zip(mdps, old, demo, strict=True)
    ]
)
gain = (task_weights * gains).sum()
related = related_bounds(*family)
price = 2 * theorem.c1 * related.tv_demo_states / (1 - gamma) ** 2
assert torch.isclose(related.repaired, gain - price)
assert (sample["repaired"] <= sample["improvement"] + slack).all()
print(f"the demonstrator gains {gain:.4f}, the price is {price:.4f};")
print(f"(4) promises {related.repaired:.4f}, the truth is {theorem.improvement:.4f}")

# %% [markdown]
# ## 5 · From likelihood to distance
#
# EMRLD takes a gradient step on the cloning loss, an estimate of $\mathcal L^{\mathrm{BC}} = -\mathbb E_{d^{\mathrm{dem}},\, \pi^{\mathrm{dem}}}[\log \pi(a \mid s)]$, a likelihood. What has it to do with $D_{TV}^{\mathrm{dem}}$? Let
# $H$ be the demonstrator's mean entropy, $-\mathbb E_{d^{\mathrm{dem}}} \sum_a \pi^{\mathrm{dem}} \log \pi^{\mathrm{dem}}$. Then $\mathcal L^{\mathrm{BC}} - H$ is the mean Kullback-Leibler divergence $\mathbb E_{d^{\mathrm{dem}}} D_{KL}(\pi^{\mathrm{dem}} \,\|\, \pi)$.
# **Pinsker's inequality** says $D_{TV} \le \sqrt{D_{KL} / 2}$ in each state, and since the root is concave (Jensen), also on average.
#
# ### Exercise 5 · Pinsker
#
# *Difficulty 1 of 3, 3 minutes.* The largest mean distance that a value of the cloning loss allows.
#
# <details><summary>Hint 1: from loss to divergence</summary>
# The cloning loss is the divergence plus the entropy.
# </details>
#
# <details><summary>Hint 2: from divergence to distance</summary>
# Pinsker, with the mean divergence under the root.
# </details>


# %% tags=["exercise-pinsker"]
def likelihood_distance(cloning_loss, entropy):
    """Return a bound on the mean total variation, a scalar tensor."""
    ### BEGIN SOLUTION
    return torch.sqrt((cloning_loss - entropy) / 2)
    ### END SOLUTION


# %% tags=["pinsker"]
clock.at("from likelihood to distance")
check.likelihood_distance(likelihood_distance)
(world,), _, _, (near,), (expert,) = random_family(random, 3000, tasks=1, states=4, actions=3)
divergence = (expert * (expert / near).log()).nan_to_num(0.0).sum(-1)  # (family, state)
distance = 0.5 * (expert - near).abs().sum(-1)
shown, walked = world.visitation(expert), world.visitation(near)
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
# *Figure 5. Random policies and demonstrators: excess of the cloning loss over its minimum against the mean distance, in the demonstrator's
# states (left) and in those of the new policy (right). Black: the largest distance that Pinsker's inequality allows.*
#
# Cloning controls the distance where the demonstrator walks, and only there. With (4) a small enough loss gives a guarantee, a weak one; with the
# theorem's own term it is a hope. And how small the loss gets is not for the theorem to say.
#
# ### What the theorem does not cover
#
# The paper's experiments, and ours, differ from its setting in ways that matter:
#
# - **Deterministic demonstrators.** The optimal demonstrations are mean actions without noise, the policies are Gaussian. A point and a density have total variation 1 in every state, and the divergence is infinite. Then group 2 is at most $(\Delta - 2 C_1)/(1-\gamma) < 0$, since $\Delta \le C_1$: it promises nothing, whatever is learned.
# - **One step, not a minimum.** The adaptation takes a single gradient step on the cloning loss, and the loss is a sum over *one* undiscounted trajectory, not an expectation under $d^{\mathrm{dem}}$.
# - **Samples.** Advantages are estimates with a fitted baseline, normalised; the meta-update is TRPO's on the ratio of sampled actions.
#
# The first point in numbers: a Gaussian policy with $\sigma = 0.5$, and a demonstrator with the same mean whose own noise shrinks.

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
# So the theorem is a *motive* for the cloning term, not a statement about the numbers in notebooks 06 to 08.
#
# ## 6 · Exact EMRLD
#
# Now the algorithm itself, $\theta_i = \theta - \alpha \nabla_\theta \big(w_{\mathrm{rl}} \mathcal L^{\mathrm{RL}}_i(\theta) + w_{\mathrm{bc}} \mathcal L^{\mathrm{BC}}_i(\theta)\big)$ with $\mathcal L^{\mathrm{RL}}_i = -J_i$ and $\alpha = 5$, and no sampling anywhere: policies are softmax tables, the adaptation and the meta-update are differentiated through the linear
# solves. A grid of 9 × 9 cells, the start in the middle, eight goals on the edge; the move into the goal pays 1 and leads back to the start. We compare:
# both terms in the adaptation (EMRLD), cloning alone ($w_{\mathrm{rl}} = 0$), policy gradient alone (MAML), and EMRLD with a demonstrator that acts at random 60 % of the time.
#
# **Predict first.** With exact gradients, will MAML learn? And what becomes of $\Delta$ and $\Delta_{\mathrm{avg}}$ when the policy overtakes a poor demonstrator?

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
    shown = [mixed(policy, noise) for policy in best]
    rule = Adaptation(w_rl, w_bc, adapt_lr=5.0)
    problem = ExactMetaRL(grid, torch.full((8,), 1 / 8), shown, rule)
    runs[name] = list(exact_meta_train(problem, meta_lr=10.0, iterations=60))

# %%
looks = {
    "EMRLD": plotting.LOOKS["emrld"],
    "cloning only": {"color": "#777777", "linestyle": "-.", "marker": "v"},
    "MAML": plotting.LOOKS["maml"],
    "EMRLD, poor demonstrator": {**plotting.LOOKS["emrld"], "linestyle": ":", "marker": "x"},
}
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
# *Figure 6. Exact training on the grid, one update of the meta-table per meta-iteration: value of the adapted policies (thin dotted lines: what the optimal and the poor
# demonstrator earn), the largest Delta of Assumption 1 (symmetric log scale), and its average under the new policy.*

# %% tags=["assumption-1-initial-stages", "tolerance:0.15", "tolerance:abs=0.02", "tolerance:whole=2"]
final = {name: iterates[-1].objective for name, iterates in runs.items()}
assert runs["EMRLD"][0].objective > 3 * runs["MAML"][0].objective
assert final["EMRLD"] > final["MAML"] > 5 * runs["MAML"][0].objective
for name in ("EMRLD", "EMRLD, poor demonstrator"):
    deltas = [float(it.theorem.delta) for it in runs[name]]
    assert deltas[0] > 0 > deltas[-1]
passed = next(it.iteration for it in poor if it.objective > it.demonstrator)
turned = next(it.iteration for it in poor if it.theorem.average_delta < 0)
assert 0 < turned < passed and final["EMRLD, poor demonstrator"] > 1.3 * poor[0].demonstrator
for name, (first, *_, last) in runs.items():
    print(f"{name:25} return {first.objective:5.2f} to {last.objective:5.2f}, ", end="")
    print(f"Delta {first.theorem.delta:+.4f} to {last.theorem.delta:+.4f}")
print(f"the optimal demonstrator earns {demonstrated[0]:.2f}, the poor one {demonstrated[1]:.2f}:")
print(
    f"its average Delta turns negative in iteration {turned}, it is overtaken in iteration {passed}"
)

# %% [markdown]
# - **EMRLD leads from the first iteration on**, by the cloning gradient: that is group 2 at work.
# - **Assumption 1 is what the paper says it is**, true at first: $\Delta$ starts small and positive and then turns negative. What stays useful for longer is $\Delta_{\mathrm{avg}}$.
# - **The poor demonstrator is overtaken.** $\Delta_{\mathrm{avg}}$ turns negative *before* that: it is worse than the policy in the states that the policy visits. The bound has nothing to say any more, yet EMRLD goes on improving, by the reward in its adaptation and in its meta-update.
# - **Nobody comes near the optimal demonstrator**, which earns 3.35. With this $\alpha$ a single step is too short for it; cloning alone ends below MAML.
# - **Exact MAML learns**, slowly: its gradient is small, not zero. What stops MAML in notebook 06 is that *samples* of a small gradient are nearly all zero. (Sparsity is mild here: a coin-tossing walk does find an edge of a 9 × 9 grid.)
#
# Is cloning alone the worse choice, then? **Predict first:** what does one step of cloning earn from an untrained policy if $\alpha$ is 20, or 100?

# %% tags=["longer-steps", "tolerance:abs=0.02"]
weights = {"EMRLD": (1.0, 1.0), "cloning only": (0.0, 1.0), "MAML": (1.0, 0.0)}


def problem_with(name, alpha):
    """Return the grid with optimal demonstrators and one adaptation step of length alpha."""
    rule = Adaptation(*weights[name], adapt_lr=alpha)
    return ExactMetaRL(grid, torch.full((8,), 1 / 8), best, rule)


untrained = torch.zeros_like(grid[0].reward)
alphas = np.geomspace(1, 300, 16)
figure, axes = plt.subplots(figsize=(6.4, 3.2))
for name in weights:
    earned = [float(problem_with(name, alpha).meta_objective(untrained)) for alpha in alphas]
    axes.plot(alphas, earned, label=name, markevery=3, **looks[name])
axes.axhline(demonstrated[0], color="black", linewidth=0.8, linestyle=(0, (1, 2)))
axes.set(xscale="log", xlabel="step length alpha", ylabel="return, no meta-training")
axes.legend()
plt.show()
starts = {
    a: float(problem_with("cloning only", a).meta_objective(untrained)) for a in (5.0, 20.0, 100.0)
}
ends = {
    name: list(exact_meta_train(problem_with(name, 100.0), meta_lr=10.0, iterations=20))[
        -1
    ].objective
    for name in ("cloning only", "MAML")
}
assert starts[5.0] < 0.3 < 1.8 < starts[20.0] < 2.5 < starts[100.0]
assert ends["cloning only"] > 0.85 * demonstrated[0] and final["cloning only"] < final["MAML"]
print(
    "cloning alone, no meta-training: " + ", ".join(f"{v:.2f} at {a:g}" for a, v in starts.items())
)
print(
    f"alpha = 100, 20 iterations: cloning alone {ends['cloning only']:.2f}, MAML {ends['MAML']:.2f}"
)
print(
    f"alpha = 5, 60 iterations: cloning alone {final['cloning only']:.2f}, MAML {final['MAML']:.2f}"
)

# %% [markdown]
# *Figure 7. Return after one exact adaptation step from the untrained policy against the length of the step; the dotted line is what the optimal demonstrator earns.*
#
# Cloning alone falls behind because its step is short, not because reward is missing: with $\alpha = 100$ it comes close to the demonstrator without any meta-training. Which of the two terms matters is a question about the step length as well, and Theorem 1
# does not contain $\alpha$. (Reward enters at a second place, too: the meta-update follows $J_{\mathrm{meta}}$ in every one of these runs, with or without the RL term in the adaptation.)
#
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
assert max(series["bound"] + series["bound_average_delta"]) < -8 < 0 < min(series["improvement"])
distances = [float(it.theorem.tv_demo) for it in runs["EMRLD"]]
assert min(distances) > 0.3 and max(distances) < 0.6
for name, values in series.items():
    print(f"{name:20} between {min(values):8.2f} and {max(values):6.2f}")
print(f"D_TV between {min(distances):.2f} and {max(distances):.2f}")

# %% [markdown]
# *Figure 8. Improvement of every meta-iteration of exact EMRLD (thick), and three lower bounds on it; symmetric log scale.*
#
# The improvement is positive all along (it zigzags once the meta-step has to be halved to keep it so), and Theorem 1 says "at least minus ten", or worse. One adaptation step leaves the policy far from the demonstrator
# ($D_{TV}$ about a half), and each unit of distance costs $2 C_1 / (1-\gamma)$, here 40 times $C_1$. The theorem explains the *direction*, get closer to the demonstrator while it is
# better; it does not explain the *amount*.
#
# ## 7 · Break it yourself
#
# **The family under your fingers.** Demonstrator's quality, step towards it, discount, and stubbornness: with that probability the left task's demonstrator makes the
# wrong move in the cell before its goal. With one stubborn state, watch $\Delta$ fall far below zero and the average by much less.

# %% tags=["widget-bounds", "nbval-ignore-output"]
clock.at("break it yourself")
bounds.bound_sliders()

# %%
bounds.bound_picture()

# %% [markdown]
# *Figure 9. The sliders' default, as a still picture: improvement, the two groups and three bounds on the five cells.*
#
# **What the proof takes for granted, one thing at a time.** Choose what is falsely claimed, and how falsely. Each row is a line of the proof; a cross is a line that fails.

# %% tags=["widget-assumptions", "nbval-ignore-output"]
bounds.assumption_sliders()

# %%
bounds.assumption_picture("Delta is claimed too large", 0.5)

# %% [markdown]
# *Figure 10. The lines of the proof when Delta is claimed too large by half of C1: the move that uses Assumption 1 fails first.*
#
# | false claim | first move to fail | what to notice |
# |---|---|---|
# | $\Delta$ too large | 6, `a_assumption` | claims up to $\Delta_{\mathrm{avg}}$ do no harm: only the average is used |
# | $C_1$ too small | 7, `b_demo` | small cuts do no harm: Hölder is generous |
# | the critic's $V$ is wrong at the start | 2, `lemma_1` | the values no longer telescope to $J$ |
# | the demonstrator's states | 7, `b_demo` | on the two-state family; every later line falls, the theorem too |
#
# A surprise: a critic that is wrong anywhere *but* in the first states breaks no **equation**. Adding any function of the state to $V$ changes rewards by a
# "potential", and potentials telescope away (Ng, Harada and Russell, 1999). Inequalities are another matter: $\Delta$ is claimed of the true advantage, and a critic that is wrong by much can push the demonstrator's average below it.

# %% tags=["which-move-fails"]
expected = ["a_assumption", "b_demo", "lemma_1", "b_demo"]
for claim, first in zip(bounds.FALSE_CLAIMS[1:], expected, strict=True):
    world, claims = bounds.broken(claim, 0.5)
    fallen = [line.name for line in proof_lines(*world, claims) if not line.holds()]
    assert fallen[0] == first
    print(f"{claim}: {len(fallen)} lines fall, first {fallen[0]}")
corridor = corridor_step()
for size in (3.0, 10.0):
    equations, moves = 0, set()
    for seed in range(100):
        drawn = torch.randn(5, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)
        drawn[2] = 0.0  # right in the middle cell, where the walk begins
        claims = Claims(value_error=size * drawn)
        fallen = [line for line in proof_lines(*corridor, claims) if not line.holds()]
        equations += any(line.relation == "=" for line in fallen)
        moves |= {(seed, line.name) for line in fallen}
    draws = len({seed for seed, _ in moves})
    print(
        f"critic wrong by about {size:g}: equations fall in {equations} of 100 draws, ",
        end="",
    )
    print(f"some line in {draws}")
    assert equations == 0 and {name for _, name in moves} <= {"a_assumption"}
assert draws > 5

# %% [markdown]
# ## Appendix · What the meta-gradient leaves out
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
# ## What was shown
#
# - Theorem 1 holds: eight moves, eighteen lines, each with both sides equal or in order, and no violation in ten thousand random families.
# - Its first group is never positive; $\Delta_{\mathrm{avg}}$ for $\Delta$ gives a tighter bound, which is known only afterwards.
# - With the demonstrator's states it fails, with Assumption 1 true, in two states; one more factor $1/(1-\gamma)$ mends it.
# - It does not cover deterministic demonstrators, single steps and samples, which is what the experiments have.
# - Exact EMRLD shows each term at work: cloning first, reward later; how much each matters depends on the step length.
#
# **Next** notebook 06 trains the real algorithm. Or draw your own families: `emrld_lite.tabular` has everything used here.
#
# **References** Kakade and Langford (2002), *Approximately optimal approximate RL*; Achiam et al. (2017), *Constrained policy optimization*; Ng, Harada and Russell (1999), *Policy invariance under reward
# transformations*; Rothfuss et al. (2019), *ProMP*; Stadie et al. (2018), *Some considerations on learning to explore via meta-RL*; Foerster et al. (2018), *DiCE*; Rengarajan et al. (2022), the paper.
