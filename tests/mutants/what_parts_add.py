import numpy as np

PLACES = {"RL": 0, "cloning": 1, "warm start": 2}


def _without(full, place):
    setting = list(full)
    setting[place] = False if place == 2 else 0.0
    return tuple(setting)


def _returns(run, setting, seeds):
    return np.array([run(*setting, seed) for seed in seeds])


def _drops(run, full, seeds):
    whole = _returns(run, full, seeds)
    return {
        part: whole - _returns(run, _without(full, place), seeds) for part, place in PLACES.items()
    }


def deviation(run, full, seeds):
    """standard deviation of the differences"""
    return {part: (d.mean(), d.std(ddof=1)) for part, d in _drops(run, full, seeds).items()}


def numpys_deviation(run, full, seeds):
    """seeds less one"""
    drops = _drops(run, full, seeds)
    return {part: (d.mean(), d.std() / len(seeds) ** 0.5) for part, d in drops.items()}


def sign(run, full, seeds):
    """the sign is turned"""
    drops = _drops(run, full, seeds)
    return {part: (-d.mean(), d.std(ddof=1) / len(seeds) ** 0.5) for part, d in drops.items()}


def unpaired(run, full, seeds):
    """share their seeds' luck"""
    whole, answer = _returns(run, full, seeds), {}
    for part, place in PLACES.items():
        less = _returns(run, _without(full, place), seeds)
        error = ((whole.var(ddof=1) + less.var(ddof=1)) / len(seeds)) ** 0.5
        answer[part] = (whole.mean() - less.mean(), error)
    return answer


def fresh_seeds(run, full, seeds):
    """the seeds that you are given"""
    whole, answer = _returns(run, full, seeds), {}
    for part, place in PLACES.items():
        drops = whole - _returns(run, _without(full, place), [seed + 100 for seed in seeds])
        answer[part] = (drops.mean(), drops.std(ddof=1) / len(seeds) ** 0.5)
    return answer


def no_demonstration_at_all(run, full, seeds):
    """the warm start stays"""
    whole, answer = _returns(run, full, seeds), {}
    for part, place in PLACES.items():
        setting = (full[0], 0.0, False) if part == "cloning" else _without(full, place)
        drops = whole - _returns(run, setting, seeds)
        answer[part] = (drops.mean(), drops.std(ddof=1) / len(seeds) ** 0.5)
    return answer


def each_part_alone(run, full, seeds):
    """what each part gives on its own"""
    nothing, answer = _returns(run, (0.0, 0.0, False), seeds), {}
    _returns(run, full, seeds)
    for part, place in PLACES.items():
        setting = [0.0, 0.0, False]
        setting[place] = full[place]
        drops = _returns(run, setting, seeds) - nothing
        answer[part] = (drops.mean(), drops.std(ddof=1) / len(seeds) ** 0.5)
    return answer


def one_seed(run, full, seeds):
    """with every seed"""
    whole = run(*full, seeds[0])
    return {
        part: (whole - run(*_without(full, place), seeds[0]), 0.0)
        for part, place in PLACES.items()
    }


def halved(run, full, seeds):
    """its weight then is 0"""
    whole, answer = _returns(run, full, seeds), {}
    for part, place in PLACES.items():
        setting = list(full)
        setting[place] = False if place == 2 else full[place] / 2
        drops = whole - _returns(run, setting, seeds)
        answer[part] = (drops.mean(), drops.std(ddof=1) / len(seeds) ** 0.5)
    return answer


def nothing_to_compare(run, full, seeds):
    """nothing to compare with"""
    answer = {}
    for part, place in PLACES.items():
        less = _returns(run, _without(full, place), seeds)
        answer[part] = (less.mean(), less.std(ddof=1) / len(seeds) ** 0.5)
    return answer


def other_names(run, full, seeds):
    """expected a dict"""
    drops = _drops(run, full, seeds)
    return {place: (drops[part].mean(), 0.0) for part, place in PLACES.items()}
