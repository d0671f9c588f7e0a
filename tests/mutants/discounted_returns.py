import torch


def from_the_start(rewards, discount):
    """discounts from time t on"""
    powers = discount ** torch.arange(rewards.shape[1], dtype=rewards.dtype)
    return (rewards * powers).flip(-1).cumsum(-1).flip(-1)


def undiscounted(rewards, discount):
    """undiscounted"""
    return rewards.flip(-1).cumsum(-1).flip(-1)


def past(rewards, discount):
    """sums the future"""
    return rewards.cumsum(-1)


def without_own_reward(rewards, discount):
    """the reward R_t itself is missing"""
    returns, running = torch.zeros_like(rewards), torch.zeros_like(rewards[:, 0])
    for t in reversed(range(rewards.shape[1])):
        returns[:, t] = discount * running
        running = rewards[:, t] + discount * running
    return returns


def in_place(rewards, discount):
    """you changed `rewards` in place"""
    for t in reversed(range(rewards.shape[1] - 1)):
        rewards[:, t] += discount * rewards[:, t + 1]
    return rewards


def one_number(rewards, discount):
    """of shape (4, 7), got (4,)"""
    return rewards.sum(-1)


def _returns(rewards, discount, last):
    returns, after = torch.zeros_like(rewards), torch.zeros_like(rewards[:, 0])
    for time in range(last, -1, -1):
        returns[:, time] = after = rewards[:, time] + discount * after
    return returns


def fixed_discount(rewards, discount):
    """numbers differ"""
    return _returns(rewards, 0.9, rewards.shape[1] - 1)


def seven_steps(rewards, discount):
    """numbers differ"""
    return _returns(rewards, discount, min(6, rewards.shape[1] - 1))


def only_double(rewards, discount):
    """single and double precision are mixed"""
    steps = torch.arange(rewards.shape[1], dtype=torch.float64)
    later = steps[:, None] - steps
    return rewards @ torch.where(later >= 0, discount ** later.clamp(min=0), 0.0)
