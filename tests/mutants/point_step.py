import torch


def _reward(distance, time):
    if distance <= 0.02:
        return 100.0 - time - 1
    return 1.0 - distance if distance <= 0.2 else 0.0


def _shortened(move):
    return move * min(1.0, 0.1 / max(float(move.norm()), 1e-12))


def slip_of_the_pen(position, move, goal, time):
    """slip of the pen"""
    move = _shortened(move)
    moved = torch.stack([position[0] + move[0], position[0] + move[1]])
    distance = float((moved - goal).norm())
    return moved, _reward(distance, time), distance <= 0.02


def clipped_one_by_one(position, move, goal, time):
    """one by one"""
    moved = position + move.clamp(-0.1, 0.1)
    distance = float((moved - goal).norm())
    return moved, _reward(distance, time), distance <= 0.02


def old_distance(position, move, goal, time):
    """after the step"""
    distance = float((position - goal).norm())
    return position + _shortened(move), _reward(distance, time), distance <= 0.02


def near_wins(position, move, goal, time):
    """second line"""
    moved = position + _shortened(move)
    distance = float((moved - goal).norm())
    return moved, (1.0 - distance if distance <= 0.2 else 0.0), distance <= 0.02


def one_step_more(position, move, goal, time):
    """100 - t - 1"""
    moved = position + _shortened(move)
    distance = float((moved - goal).norm())
    reward = _reward(distance, time)
    return moved, reward + 1 if distance <= 0.02 else reward, distance <= 0.02


def never_done(position, move, goal, time):
    """the episode ends"""
    moved = position + _shortened(move)
    return moved, _reward(float((moved - goal).norm()), time), False
