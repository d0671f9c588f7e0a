def short_sighted():
    """larger discount"""
    return 0.9, 0.1


def slips_too_often():
    """slip is too large"""
    return 0.99, 0.2


def undiscounted():
    """must lie in [0, 1)"""
    return 1.0, 0.05


def more_than_there_is():
    """the slip must lie in"""
    return 0.99, 0.6


def never_slips():
    """no discount makes it worse"""
    return 0.999, 0.0
