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
    """the inner disc wins"""
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


def _stepped(position, move, goal, time, distance=None, wide=0.2, beyond=0.0, ends=False):
    moved = position + _shortened(move)
    gap = moved - goal
    away = float(gap.norm() if distance is None else distance(gap))
    if away <= 0.02:
        return moved, 99.0 - time, True
    return moved, (1 - away if away <= wide else max(0.0, beyond * (1 - away))), ends


def pays_everywhere(position, move, goal, time):
    """far from the goal"""
    return _stepped(position, move, goal, time, beyond=1.0)


def wide_radius(position, move, goal, time):
    """far from the goal"""
    return _stepped(position, move, goal, time, wide=0.5)


def manhattan(position, move, goal, time):
    """as the crow flies"""
    return _stepped(position, move, goal, time, lambda gap: gap.abs().sum())


def done_at_the_horizon(position, move, goal, time):
    """done is True too early"""
    return _stepped(position, move, goal, time, ends=time == 99)


def divides_by_no_move(position, move, goal, time):
    """not finite"""
    _, reward, done = _stepped(position, move, goal, time)
    length = move.norm()
    return position + move / length * length.clamp(max=0.1), reward, done


def moves_the_goal(position, move, goal, time):
    """you changed `goal` in place"""
    answer = _stepped(position, move, goal, time)
    goal -= answer[0]
    return answer
