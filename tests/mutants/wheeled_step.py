import torch


def _driven(state, v, angle, turn, dt):
    x, y, heading = state.unbind(-1)
    place = [x + v * dt * torch.cos(angle), y + v * dt * torch.sin(angle), heading + turn]
    return torch.stack(place, dim=-1)


def turns_first(state, v, omega, dt):
    """the old heading"""
    return _driven(state, v, state[..., 2] + omega * dt, omega * dt, dt)


def turn_without_time(state, v, omega, dt):
    """omega dT"""
    return _driven(state, v, state[..., 2], omega, dt)


def swapped(state, v, omega, dt):
    """swapped"""
    return _driven(state, v, torch.pi / 2 - state[..., 2], omega * dt, dt)


def place_without_time(state, v, omega, dt):
    """the drive lasts dT too"""
    return _driven(state, v / dt, state[..., 2], omega * dt, dt)
