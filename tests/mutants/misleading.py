def straight(goal, walk):
    """it still finds the way"""
    return [walk(goal)], "stays behind"


def back_once_from_half_way(goal, walk):
    """in 2 of 4 trials"""
    return [walk(0.8 * goal, 0.6 * goal, goal)], "stays behind"


def never_at_the_goal(goal, walk):
    """does not reach its goal"""
    return [walk(0.9 * goal)], "stays behind"


def one_walk_misses(goal, walk):
    """walk 2 does not reach"""
    return [walk(goal), walk(-goal)], "runs past"


def too_long(goal, walk):
    """at most 100"""
    return [walk(*[0.5 * goal, 0 * goal] * 5, goal)], "stays behind"


def wrong_prediction(goal, walk):
    """not as you predicted: it stays behind"""
    return [walk(*[0.5 * goal, 0 * goal] * 3, goal)], "runs past"


def no_list(goal, walk):
    """put the walk into a list"""
    return walk(*[0.5 * goal, 0 * goal] * 3, goal), "stays behind"


def no_prediction(goal, walk):
    """a list of walks and a prediction"""
    return [walk(*[0.5 * goal, 0 * goal] * 3, goal)]


def another_word(goal, walk):
    """the prediction is one of"""
    return [walk(*[0.5 * goal, 0 * goal] * 3, goal)], "is lost"


def waits_too_long(goal, walk):
    """hardly anything"""
    return [walk(*[0.4 * goal, 0 * goal] * 4, 0.4 * goal, 0.2 * goal, goal)], "stays behind"
