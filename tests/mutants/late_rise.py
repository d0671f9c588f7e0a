def _fifths(returns):
    window = len(returns) // 5
    return returns[-window:].mean(), returns[-2 * window : -window].mean(), window


def sign(returns, floor):
    """sign is turned"""
    last, before, _ = _fifths(returns)
    return (before - last) / max(last, floor)


def in_units_of_return(returns, floor):
    """divide it by the level"""
    last, before, _ = _fifths(returns)
    return last - before


def without_floor(returns, floor):
    """at least `floor`"""
    last, before, _ = _fifths(returns)
    return (last - before) / last


def of_the_level_before(returns, floor):
    """the level at the end"""
    last, before, _ = _fifths(returns)
    return (last - before) / max(before, floor)


def whole_run(returns, floor):
    """over the whole run"""
    last, _, window = _fifths(returns)
    return (last - returns[:window].mean()) / max(last, floor)


def everything_before(returns, floor):
    """only one fifth"""
    last, _, window = _fifths(returns)
    return (last - returns[:-window].mean()) / max(last, floor)
