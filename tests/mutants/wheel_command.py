import torch


def _wheels(action, bias, clip=True, firmware=True, sign=1, across=0.08, radius=0.033, stop=True):
    if stop and not torch.isfinite(action).all():
        return 0.0, 0.0
    if clip:
        action = action.clamp(-1, 1)
    v, omega = (action[0] + 1) * 0.075, action[1] * 1.5 + sign * bias
    if firmware:
        v, omega = v.clamp(-0.22, 0.22), omega.clamp(-2.84, 2.84)
    return (v - across * omega) / radius, (v + across * omega) / radius


def unclipped(action, bias):
    """clip the action"""
    return _wheels(action, bias, clip=False)


def trusts_the_policy(action, bias):
    """clamp what is sent"""
    return _wheels(action, bias, firmware=False)


def subtracts_the_bias(action, bias):
    """not subtracted"""
    return _wheels(action, bias, sign=-1)


def no_bias(action, bias):
    """bias is missing"""
    return _wheels(action, 0.0)


def whole_track(action, bias):
    """half the track"""
    return _wheels(action, bias, across=0.16)


def rim(action, bias):
    """divide by the wheel's radius"""
    return _wheels(action, bias, radius=1.0)


def right_first(action, bias):
    """left and right are swapped"""
    return _wheels(action, bias)[::-1]


def drives_on(action, bias):
    """both wheels must stop"""
    return _wheels(action, bias, stop=False)


def nan_only(action, bias):
    """both wheels must stop"""
    return _wheels(action, bias, stop=bool(torch.isnan(action).any()))


def stops_but_turns(action, bias):
    """both wheels must stop"""
    if not torch.isfinite(action).all():
        return -0.08 * bias / 0.033, 0.08 * bias / 0.033
    return _wheels(action, bias)


def bias_inside_the_action(action, bias):
    """not part of the action"""
    if not torch.isfinite(action).all():
        return 0.0, 0.0
    return _wheels(torch.stack([action[0], action[1].clamp(-1, 1) + bias / 1.5]), 0.0)


def reverses(action, bias):
    """does not reverse"""
    left, right = _wheels(action, bias)
    if not torch.isfinite(action).all():
        return 0.0, 0.0
    change = (action[0].clamp(-1, 1) * 0.15 - (action[0].clamp(-1, 1) + 1) * 0.075) / 0.033
    return left + change, right + change
