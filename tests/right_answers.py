"""Right answers in other styles and types than the solutions; every check must accept each.

Functions are named after their exercise, with a word behind a double underscore.
"""

import math
from fractions import Fraction

import numpy as np
import torch


def log_density__distribution(mean, log_sigma, actions):
    return torch.distributions.Normal(mean, log_sigma.exp()).log_prob(actions).sum(dim=-1)


def log_density__numpy(mean, log_sigma, actions):
    mean, log_sigma, actions = (part.detach().numpy() for part in (mean, log_sigma, actions))
    each = -((actions - mean) ** 2) / (2 * np.exp(2 * log_sigma)) - log_sigma
    return (each - 0.5 * np.log(2 * np.pi)).sum(axis=-1)


def log_density__double(mean, log_sigma, actions):
    return log_density__distribution(mean.double(), log_sigma.double(), actions.double())


def discounted_returns__lists(rewards, discount):
    return [
        [sum(discount**k * float(r) for k, r in enumerate(row[t:])) for t in range(len(row))]
        for row in rewards
    ]


def discounted_returns__double(rewards, discount):
    returns = torch.zeros(rewards.shape, dtype=torch.float64)
    for t in range(rewards.shape[1] - 1, -1, -1):
        after = returns[:, t + 1] if t + 1 < rewards.shape[1] else 0.0
        returns[:, t] = rewards[:, t] + discount * after
    return returns


def discounted_returns__matrix(rewards, discount):
    steps = torch.arange(rewards.shape[1])
    later = steps[:, None] - steps[None]  # (later time, time)
    return rewards @ torch.where(later >= 0, discount ** later.clamp(min=0).float(), 0.0)


def reinforce_loss__boolean_mask(log_probs, returns, mask):
    taken = mask.bool()
    return -(log_probs[taken] * returns[taken]).mean()


def reinforce_loss__one_element(log_probs, returns, mask):
    return (log_probs * -returns * mask).sum().reshape(1) / mask.sum()


def reinforce_loss__double(log_probs, returns, mask):
    return (
        -torch.einsum("et,et,et->", *(x.double() for x in (log_probs, returns, mask))) / mask.sum()
    )


def advantages__columns(rewards, values, discount, gae_lambda):
    columns, running, after = [], 0.0, 0.0
    for t in reversed(range(rewards.shape[1])):
        running = rewards[:, t] + discount * after - values[:, t] + discount * gae_lambda * running
        after = values[:, t]
        columns.insert(0, running)
    return torch.stack(columns, 1)


def advantages__numpy(rewards, values, discount, gae_lambda):
    return advantages__columns(rewards, values, discount, gae_lambda).double().numpy()


def point_step__tensors(position, move, goal, time):
    new = position + move * torch.clamp(0.1 / move.norm().clamp(min=1e-9), max=1.0)
    away = torch.dist(new, goal)
    paid = torch.where(away <= 0.02, torch.tensor(99.0 - time), (1 - away) * (away <= 0.2))
    return new, paid, away <= 0.02


def point_step__lists(position, move, goal, time):
    (x, y), (dx, dy), (gx, gy) = position.tolist(), move.tolist(), goal.tolist()
    length = math.hypot(dx, dy)
    if length > 0.1:
        dx, dy = 0.1 * dx / length, 0.1 * dy / length
    away = math.hypot(x + dx - gx, y + dy - gy)
    reward = 99 - time if away <= 0.02 else 1 - away if away <= 0.2 else 0
    return [[x + dx, y + dy], np.float32(reward), np.bool_(away <= 0.02)]


def loitering_gain__closed_form(time, discount):
    left = 100 - time
    waiting = left if discount == 1 else (1 - discount**left) / (1 - discount)
    return np.float64(0.98 * waiting - left + 1)


def loitering_gain__tensor(time, discount):
    return (0.98 * discount ** torch.arange(100 - time).double()).sum() - (99 - time)


def wheeled_step__columns(state, v, omega, dt):
    moved = state.clone()
    moved[:, 0] += v * dt * state[:, 2].cos()
    moved[:, 1] += v * dt * state[:, 2].sin()
    moved[:, 2] += omega * dt
    return moved


def wheeled_step__numpy(state, v, omega, dt):
    return wheeled_step__columns(state, v, omega, dt).double().numpy()


def episodes_needed__float(rate, confidence):
    return float(np.ceil(np.log(1 - confidence) / np.log(1 - rate)))


def episodes_needed__loop(rate, confidence):
    count, missed = 0, 1.0
    while 1 - missed < confidence:
        count, missed = count + 1, missed * (1 - rate)
    return np.int64(count)


def episodes_needed__tensor(rate, confidence):
    return torch.tensor(math.ceil(math.log(1 - confidence, 1 - rate)))


def episodes_needed__array(rate, confidence):
    return np.ceil(np.array([math.log(1 - confidence) / math.log(1 - rate)])).astype(int)


def with_task__repeat(states, tasks):
    return torch.cat((states, tasks.unsqueeze(1).repeat(1, states.shape[1], 1)), 2)


def with_task__numpy(states, tasks):
    spread = np.repeat(tasks.numpy()[:, None], states.shape[1], axis=1)
    return np.concatenate([states.numpy(), spread], axis=-1)


def steps_before_reward__lists(distance, margin):
    counts = []
    for row in distance.tolist():
        close = [step for step, away in enumerate(row) if away <= margin]
        counts.append(close[0] if close else len(row))
    return counts


def steps_before_reward__stacked(distance, margin):
    return tuple(torch.tensor(float(n)) for n in steps_before_reward__lists(distance, margin))


def nearest_distance__broadcast(states, data):
    return (states[:, None] - data[None]).pow(2).sum(-1).sqrt().amin(1)


def nearest_distance__stacked(states, data):
    return torch.stack([(data - state).norm(dim=1).min() for state in states])


def nearest_distance__numpy(states, data):
    gaps = states.numpy()[:, None] - data.numpy()[None]
    return np.linalg.norm(gaps, axis=-1).min(axis=1)


def visitation__sum(transition, initial, policy, discount):
    step = (policy[:, :, None] * transition).sum(1)
    now, total = initial, torch.zeros_like(initial)
    for time in range(1500):
        total, now = total + (1 - discount) * discount**time * now, now @ step
    return total


def visitation__numpy(transition, initial, policy, discount):
    step = np.einsum("sa,sat->st", policy.numpy(), transition.numpy())
    inverse = np.linalg.inv(np.eye(len(step)) - discount * step)
    return ((1 - discount) * initial.numpy() @ inverse).astype(np.float32)


def performance_difference__float(advantage, visits_old, visits_new, old, new, discount):
    return float(torch.einsum("s,sa,sa->", visits_new, new, advantage)) / (1 - discount)


def performance_difference__relative(advantage, visits_old, visits_new, old, new, discount):
    return (visits_new @ ((new - old) * advantage).sum(1)).numpy() / (1 - discount)


def assumption_numbers__floats(advantage, demo):
    return float(advantage.abs().max()), float((demo * advantage).sum(2).min())


def assumption_numbers__list(advantage, demo):
    return [advantage.abs().amax(), torch.einsum("tsa,tsa->ts", demo, advantage).amin()]


def assumption_numbers__array(advantage, demo):
    return np.array(assumption_numbers__floats(advantage, demo), dtype=np.float32)


def break_the_substitution__list():
    return [np.float32(0.995), np.float64(0.04)]


def break_the_substitution__fractions():
    return Fraction(995, 1000), Fraction(1, 25)


def break_the_substitution__tensors():
    return torch.tensor(0.99), torch.tensor([0.05])


def likelihood_distance__plain(cloning_loss, entropy):
    return math.sqrt((cloning_loss - entropy) / 2)


def likelihood_distance__numpy(cloning_loss, entropy):
    return np.float32(np.sqrt(0.5 * (float(cloning_loss) - float(entropy))))


def meta_gradient__autograd(w, before, after, alpha):
    def loss(weights, data):
        states, actions, advantages = data
        return 0.5 * (advantages * (states @ weights - actions) ** 2).mean()

    leaf = w.clone().requires_grad_()
    (inner,) = torch.autograd.grad(loss(leaf, before), leaf, create_graph=True)
    return torch.autograd.grad(loss(leaf - alpha * inner, after), leaf)[0]


def meta_gradient__numpy(w, before, after, alpha):
    return meta_gradient__autograd(w, before, after, alpha).numpy()


def conjugate_gradient__in_its_own_memory(product, target, iterations):
    x, r = torch.zeros_like(target), target.clone()
    p, rr = r.clone(), r.dot(r)
    for _ in range(iterations):
        if rr < 1e-20:
            break
        image = product(p)
        alpha = rr / p.dot(image)
        x += alpha * p
        r -= alpha * image
        new = r.dot(r)
        p.mul_(new / rr).add_(r)
        rr = new
    return x


def conjugate_gradient__residual_anew(product, target, iterations):
    x, p, r = 0 * target, target, target
    for _ in range(iterations):
        if float(r.norm()) == 0.0:
            return x
        image = product(p)
        x = x + (r @ p) / (p @ image) * p
        new = r - (r @ p) / (p @ image) * image
        p = new + (new @ new) / (r @ r) * p
        r = new
    return x.numpy()


def full_step__power(direction, product, max_kl):
    return direction * (2 * max_kl / float(direction @ product(direction))) ** 0.5


def full_step__numpy(direction, product, max_kl):
    return full_step__power(direction, product, max_kl).numpy()


def supervised_meta_loss__stacked(theta, tasks, alpha):
    losses = []
    for adapt_loss, bc_loss in tasks:
        gradient = torch.autograd.grad(adapt_loss(theta), [theta], create_graph=True)[0]
        losses.append(bc_loss(theta - alpha * gradient))
    return torch.stack(losses).mean()


def supervised_meta_loss__functional(theta, tasks, alpha):
    adapted = [theta - alpha * torch.func.grad(adapt)(theta) for adapt, _ in tasks]
    return sum(bc(point) for (_, bc), point in zip(tasks, adapted, strict=True)) / len(tasks)


def adaptation_step__two_gradients(theta, rl_loss, bc_loss, w_rl, w_bc, alpha):
    (rl,) = torch.autograd.grad(rl_loss(theta), theta, create_graph=True)
    (bc,) = torch.autograd.grad(bc_loss(theta), theta, create_graph=True)
    return theta.sub(alpha * (w_rl * rl + w_bc * bc))


def adaptation_step__functional(theta, rl_loss, bc_loss, w_rl, w_bc, alpha):
    return theta - alpha * torch.func.grad(lambda x: w_rl * rl_loss(x) + w_bc * bc_loss(x))(theta)


def adaptation_step__double(theta, rl_loss, bc_loss, w_rl, w_bc, alpha):
    return adaptation_step__two_gradients(theta.double(), rl_loss, bc_loss, w_rl, w_bc, alpha)


def warm_start_step__functional(theta, rl_loss, bc_loss, w_rl, w_bc, alpha):
    warm = theta - alpha * torch.func.grad(bc_loss)(theta)
    return adaptation_step__functional(warm, rl_loss, bc_loss, w_rl, w_bc, alpha)


def warm_start_step__reused(theta, rl_loss, bc_loss, w_rl, w_bc, alpha):
    warm = adaptation_step__two_gradients(theta, rl_loss, bc_loss, 0.0, 1.0, alpha)
    return adaptation_step__two_gradients(warm, rl_loss, bc_loss, w_rl, w_bc, alpha)


def surrogate__boolean_mask(new_log_prob, old_log_prob, advantages, mask):
    taken = mask > 0
    return -((new_log_prob - old_log_prob).exp() * advantages)[taken].mean()


def surrogate__quotient(new_log_prob, old_log_prob, advantages, mask):
    ratio = new_log_prob.exp().double() / old_log_prob.exp().double()
    return (ratio * -advantages * mask).sum().view(1) / mask.sum()


def interquartile_mean__sorted(scores):
    ordered = sorted(float(score) for score in np.ravel(scores))
    cut = len(ordered) // 4
    return sum(ordered[cut : len(ordered) - cut]) / (len(ordered) - 2 * cut)


def interquartile_mean__single(scores):
    return np.float32(interquartile_mean__sorted(scores))


def interquartile_mean__array(scores):
    return np.array([interquartile_mean__sorted(scores)])


def interquartile_mean__tensor(scores):
    return torch.tensor(interquartile_mean__sorted(scores))


def false_ahead_rate__comprehension(rule, runs, pairs, random):
    draws = random.exponential(size=(pairs, 2, runs))
    return np.mean([rule(*pair).low > 0 for pair in draws])


def false_ahead_rate__lists(rule, runs, pairs, random):
    ahead = [
        rule([random.random() for _ in range(runs)], [random.random() for _ in range(runs)])
        for _ in range(pairs)
    ]
    return torch.tensor([float(interval.low > 0) for interval in ahead]).mean()


def late_rise__split(returns, floor):
    window = len(returns) // 5
    last, before = np.mean(returns[-window:]), np.mean(returns[-2 * window : -window])
    return np.float32((last - before) / np.maximum(last, floor))


def late_rise__tensor(returns, floor):
    window = len(returns) // 5
    pair = torch.as_tensor(returns[-2 * window :]).view(2, window).mean(1)
    return (pair[1:] - pair[:1]) / pair[1:].clamp_min(floor)


def one_at_a_time__loop(control, changes):
    runs = {"control": dict(control)}
    for name in changes:
        runs[name] = {**control, **changes[name]}
    return runs


def seed_differences__sorted(control, switched):
    return {
        seed: np.float32(switched[seed] - control[seed])
        for seed in sorted(control)
        if seed in switched
    }


def seed_differences__tensors(control, switched):
    common = set(control).intersection(switched)
    return {seed: torch.tensor(switched[seed]) - control[seed] for seed in common}


def averaged_log_density__distribution(mean, sigma, action):
    return torch.distributions.Normal(mean, sigma).log_prob(action).mean(dim=-1)


def averaged_log_density__sum(mean, sigma, action):
    each = -((action - mean) ** 2) / (2 * sigma**2) - torch.log(sigma * math.sqrt(2 * math.pi))
    return each.double().sum(-1) / action.shape[-1]
