"""Wrong answers to notebook 05's `meta_gradient`; each docstring is the sentence the check must say."""


def _gradient(weights, states, actions, advantages):
    return states.T @ (advantages * (states @ weights - actions)) / len(states)


def _hessian(states, actions, advantages):
    return states.T @ (advantages[:, None] * states) / len(states)


def first_order(w, before, after, alpha):
    """the factor (I - alpha H) is missing"""
    return _gradient(w - alpha * _gradient(w, *before), *after)


def outer_gradient_at_the_start(w, before, after, alpha):
    """belongs at the adapted weights, not at w"""
    outer = _gradient(w, *after)
    return outer - alpha * _hessian(*before) @ outer


def hessian_of_the_later_data(w, before, after, alpha):
    """H belongs to the data before the step"""
    outer = _gradient(w - alpha * _gradient(w, *before), *after)
    return outer - alpha * _hessian(*after) @ outer


def plus_for_minus(w, before, after, alpha):
    """the sign of H is turned"""
    outer = _gradient(w - alpha * _gradient(w, *before), *after)
    return outer + alpha * _hessian(*before) @ outer


def no_alpha(w, before, after, alpha):
    """the learning rate alpha in front of H is missing"""
    outer = _gradient(w - alpha * _gradient(w, *before), *after)
    return outer - _hessian(*before) @ outer


def sums(w, before, after, alpha):
    """divide g and H by the number of steps"""
    outer = 20 * _gradient(w - alpha * 20 * _gradient(w, *before), *after)
    return outer - alpha * 20 * _hessian(*before) @ outer


def twenty_steps(w, before, after, alpha):
    """numbers differ"""
    states, _, advantages = before
    outer = _gradient(w - alpha * len(states) / 20 * _gradient(w, *before), *after)
    return outer - alpha * len(states) / 20 * _hessian(*before) @ outer


def steps_in_place(w, before, after, alpha):
    """you changed `w` in place"""
    w -= alpha * _gradient(w, *before)
    outer = _gradient(w, *after)
    return outer - alpha * _hessian(*before) @ outer
