def mean_return(scores, returns):
    """mean return"""
    return returns.mean()


def by_length(scores, returns):
    """has its square"""
    lengths = scores.norm(dim=1)
    return (lengths * returns).sum() / lengths.sum()


def not_normalised(scores, returns):
    """weights do not add up to one"""
    return (scores.square().sum(1) * returns).mean()


def turned(scores, returns):
    """sign is turned"""
    squared = scores.square().sum(1)
    return -(squared * returns).sum() / squared.sum()


def per_parameter(scores, returns):
    """one number"""
    squared = scores.square()
    return (squared * returns[:, None]).sum(0) / squared.sum(0)


def centred_in_place(scores, returns):
    """you changed `returns` in place"""
    squared = scores.square().sum(1)
    mean = returns.mean().item()
    returns -= mean
    return mean + (squared * returns).sum() / squared.sum()
