def _said(lost, excluded):
    if lost:
        return "a small loss" if excluded else "a loss"
    return "no loss that matters" if excluded else "cannot say"


def absence_of_evidence(rule, switched, control, worth):
    """so large a loss is not excluded"""
    gap = rule(switched, control)
    return _said(gap.high < 0, gap.high >= 0 or gap.low > -worth)


def by_the_estimate(rule, switched, control, worth):
    """no loss is shown"""
    gap = rule(switched, control)
    return _said(gap.estimate < 0, gap.low > -worth)


def estimate_excludes(rule, switched, control, worth):
    """so large a loss is not excluded"""
    gap = rule(switched, control)
    return _said(gap.high < 0, gap.estimate > -worth)


def wrong_end(rule, switched, control, worth):
    """so large a loss is not excluded"""
    gap = rule(switched, control)
    return _said(gap.high < 0, gap.high > -worth)


def low_below_zero(rule, switched, control, worth):
    """no loss is shown"""
    gap = rule(switched, control)
    return _said(gap.low < 0, gap.low > -worth)


def sides_swapped(rule, switched, control, worth):
    """Not yet"""
    gap = rule(control, switched)
    return _said(gap.high < 0, gap.low > -worth)


def worth_without_its_sign(rule, switched, control, worth):
    """beyond which any larger loss is excluded"""
    gap = rule(switched, control)
    return _said(gap.high < 0, gap.low > worth)


def a_fixed_size(rule, switched, control, worth):
    """Not yet"""
    gap = rule(switched, control)
    return _said(gap.high < 0, gap.low > -5)


def only_two_verdicts(rule, switched, control, worth):
    """return one of"""
    return "behind" if rule(switched, control).high < 0 else "not distinguishable"


def the_means_alone(rule, switched, control, worth):
    """you never ask the rule"""
    gap = switched.mean() - control.mean()
    return _said(gap < 0, gap > -worth)


def means_to_the_rule(rule, switched, control, worth):
    """hand the rule the scores"""
    gap = rule(switched[:1], control[:1])
    return _said(gap.high < 0, gap.low > -worth)


def large_gains_are_losses(rule, switched, control, worth):
    """beyond which any larger loss is excluded"""
    gap = rule(switched, control)
    return _said(gap.high < 0, abs(gap.low) < worth)
