def sign(returns, window):
    """sign is turned"""
    return returns[-2 * window : -window].mean() - returns[-window:].mean()


def two_points(returns, window):
    """are noise"""
    return returns[-1] - returns[-window]


def whole_run(returns, window):
    """over the whole run"""
    return returns[-window:].mean() - returns[:window].mean()


def everything_before(returns, window):
    """only one window"""
    return returns[-window:].mean() - returns[:-window].mean()


def fixed_window(returns, window):
    """numbers differ"""
    return returns[-15:].mean() - returns[-30:-15].mean()
