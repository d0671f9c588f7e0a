def all_the_way():
    """the action is taken whose |A| is below C1"""
    return (1.0, 0.0, 0.0), (1.0, 0.0, 0.0)


def a_small_step():
    """are asked for"""
    return (0.6, 1 / 3, 1 - 0.6 - 1 / 3), (0.4, 1 / 3, 0.6 - 1 / 3)


def beyond_the_demonstrator():
    """better than the demonstrator"""
    return (0.45, 1 / 3, 0.55 - 1 / 3), (0.6, 1 / 3, 0.4 - 1 / 3)


def a_greedy_demonstrator():
    """the new policy and the demonstrator differ in the action"""
    return (1.0, 0.0, 0.0), (0.55, 1 / 3, 0.45 - 1 / 3)


def more_of_everything():
    """must sum to 1"""
    return (0.6, 0.6, 0.0), (0.6, 0.4, 0.0)


def rewards_for_probabilities():
    """must not be negative"""
    return (1.0, 0.0, -1.0), (1.0, 0.0, -1.0)


def one_policy():
    """two policies"""
    return (0.6, 0.3, 0.1)
