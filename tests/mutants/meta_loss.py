import torch


def _old(task):
    return task.log_prob(task.collected_with)


def summed(theta, tasks, adapted, surrogate):
    """sum over tasks"""
    return sum(
        surrogate(task.log_prob(adapted(theta, task)), _old(task), task.advantages, task.mask)
        for task in tasks
    )


def ratio_of_one(theta, tasks, adapted, surrogate):
    """every ratio is 1"""
    losses = []
    for task in tasks:
        new = task.log_prob(adapted(theta, task))
        losses.append(surrogate(new, new.detach(), task.advantages, task.mask))
    return torch.stack(losses).mean()


def not_adapted(theta, tasks, adapted, surrogate):
    """not adapted"""
    losses = [surrogate(task.log_prob(theta), _old(task), task.advantages, task.mask) for task in tasks]
    return torch.stack(losses).mean()


def against_the_meta_policy(theta, tasks, adapted, surrogate):
    """not the meta-policy"""
    losses = [
        surrogate(
            task.log_prob(adapted(theta, task)),
            task.log_prob(theta.detach()),
            task.advantages,
            task.mask,
        )
        for task in tasks
    ]
    return torch.stack(losses).mean()


def swapped(theta, tasks, adapted, surrogate):
    """swapped"""
    losses = [
        surrogate(_old(task), task.log_prob(adapted(theta, task)), task.advantages, task.mask)
        for task in tasks
    ]
    return torch.stack(losses).mean()


def returns_in_the_loop(theta, tasks, adapted, surrogate):
    """`return` stand inside the loop"""
    for task in tasks:
        new = task.log_prob(adapted(theta, task))
        return surrogate(new, _old(task), task.advantages, task.mask)


def in_a_row(theta, tasks, adapted, surrogate):
    """the task before it ended"""
    losses = []
    for task in tasks:
        theta = adapted(theta, task)
        losses.append(surrogate(task.log_prob(theta), _old(task), task.advantages, task.mask))
    return torch.stack(losses).mean()


def first_order(theta, tasks, adapted, surrogate):
    """does not go through the adaptation step"""
    losses = []
    for task in tasks:
        step = (adapted(theta, task) - theta).detach()
        losses.append(
            surrogate(task.log_prob(theta + step), _old(task), task.advantages, task.mask)
        )
    return torch.stack(losses).mean()


def cut(theta, tasks, adapted, surrogate):
    """no gradient by theta"""
    losses = [
        surrogate(
            task.log_prob(adapted(theta, task).detach()), _old(task), task.advantages, task.mask
        )
        for task in tasks
    ]
    return torch.stack(losses).mean()


def all_steps_together(theta, tasks, adapted, surrogate):
    """every task weighs the same"""
    steps = sum(task.mask.sum() for task in tasks)
    total = 0.0
    for task in tasks:
        new = task.log_prob(adapted(theta, task))
        total = total + task.mask.sum() * surrogate(new, _old(task), task.advantages, task.mask)
    return total / steps


def centred(theta, tasks, adapted, surrogate):
    """you changed `task.advantages` in place"""
    losses = []
    for task in tasks:
        task.advantages -= task.advantages.mean()
        new = task.log_prob(adapted(theta, task))
        losses.append(surrogate(new, _old(task), task.advantages, task.mask))
    return torch.stack(losses).mean()
