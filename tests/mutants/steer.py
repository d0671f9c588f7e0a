import math


def _off(state, goal):
    x, y, heading = state.tolist()
    bearing = math.atan2(float(goal[1]) - y, float(goal[0]) - x)
    return math.remainder(bearing - heading, 2 * math.pi)


def _driven(off, v=0.22):
    return (v if abs(off) < 0.5 else 0.0), max(-2.84, min(2.84, off / 0.5))


def long_way_round(state, goal):
    """the short way round"""
    x, y, heading = state.tolist()
    return _driven(math.atan2(float(goal[1]) - y, float(goal[0]) - x) - heading)


def from_the_origin(state, goal):
    """own place and heading"""
    off = math.atan2(float(goal[1]), float(goal[0])) - float(state[2])
    return _driven(math.remainder(off, 2 * math.pi))


def along_first(state, goal):
    """y first"""
    x, y, heading = state.tolist()
    bearing = math.atan2(float(goal[0]) - x, float(goal[1]) - y)
    return _driven(math.remainder(bearing - heading, 2 * math.pi))


def turns_away(state, goal):
    """turns away"""
    v, omega = _driven(_off(state, goal))
    return v, -omega


def only_turns(state, goal):
    """never drives"""
    return 0.0, _driven(_off(state, goal))[1]


def only_drives(state, goal):
    """does not turn"""
    return 0.22, 0.0


def crawls(state, goal):
    """too slow"""
    return _driven(_off(state, goal), v=0.1)


def turns_too_fast(state, goal):
    """omega must stay between"""
    off = _off(state, goal)
    return (0.22 if abs(off) < 0.5 else 0.0), off / 0.5


def reverses(state, goal):
    """v must stay between"""
    return -0.1, _driven(_off(state, goal))[1]
