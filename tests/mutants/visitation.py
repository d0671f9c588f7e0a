import torch


def _solved(transition, initial, policy, discount):
    step = (policy[:, :, None] * transition).sum(1)
    return step, torch.eye(len(initial), dtype=torch.float64) - discount * step


def unnormalised(transition, initial, policy, discount):
    """1 - gamma is missing"""
    _, matrix = _solved(transition, initial, policy, discount)
    return torch.linalg.solve(matrix.T, initial)


def backwards(transition, initial, policy, discount):
    """transpose"""
    _, matrix = _solved(transition, initial, policy, discount)
    return (1 - discount) * torch.linalg.solve(matrix, initial)


def even_actions(transition, initial, policy, discount):
    """weighted by the policy"""
    _, matrix = _solved(transition, initial, torch.full_like(policy, 1 / policy.shape[1]), discount)
    return (1 - discount) * torch.linalg.solve(matrix.T, initial)


def only_the_start(transition, initial, policy, discount):
    """where the walk starts"""
    return initial


def hundred_terms(transition, initial, policy, discount):
    """numbers differ"""
    step = (policy[:, :, None] * transition).sum(1)
    now, total = initial, 0 * initial
    for time in range(60):
        total, now = total + (1 - discount) * discount**time * now, now @ step
    return total
