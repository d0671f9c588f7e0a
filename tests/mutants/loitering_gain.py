def sign_turned(time, discount):
    """sign is turned"""
    return 100 - time - 1 - sum(0.98 * discount**k for k in range(100 - time))


def one_more_paid_out(time, discount):
    """pays 100 - t - 1"""
    return sum(0.98 * discount**k for k in range(100 - time)) - (100 - time)


def last_step_forgotten(time, discount):
    """step 99 is one of them"""
    return sum(0.98 * discount**k for k in range(99 - time)) - (100 - time - 1)


def undiscounted(time, discount):
    """discount is missing"""
    return 0.98 * (100 - time) - (100 - time - 1)


def from_the_start(time, discount):
    """from step t on"""
    return sum(0.98 * discount**k for k in range(time, 100)) - (100 - time - 1)


def first_discounted(time, discount):
    """first step's reward is not discounted"""
    return sum(0.98 * discount ** (k + 1) for k in range(100 - time)) - (100 - time - 1)
