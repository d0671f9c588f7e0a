import dataclasses

from emrld_lite import adapt as adaptation


def cold(meta_params, drive, demonstration, rule, score):
    """the meta-policy drove them"""
    return adaptation.adapt(meta_params, score(drive(meta_params, 5)), demonstration, rule)


def warmed_twice(meta_params, drive, demonstration, rule, score):
    """warmed twice"""
    start = adaptation.warm_start(meta_params, demonstration, rule)
    return adaptation.adapt(start, score(drive(start, 5)), demonstration, rule)


def twenty(meta_params, drive, demonstration, rule, score):
    """drives 5 trajectories"""
    start = adaptation.warm_start(meta_params, demonstration, rule)
    return adaptation.adapt(meta_params, score(drive(start, 20)), demonstration, rule)


def one_by_one(meta_params, drive, demonstration, rule, score):
    """at once"""
    start = adaptation.warm_start(meta_params, demonstration, rule)
    trials = [drive(start, 1) for _ in range(5)]
    return adaptation.adapt(meta_params, score(trials[-1]), demonstration, rule)


def never_drives(meta_params, drive, demonstration, rule, score):
    """never moved"""
    return adaptation.warm_start(meta_params, demonstration, rule)


def no_step(meta_params, drive, demonstration, rule, score):
    """one adaptation step is missing"""
    start = adaptation.warm_start(meta_params, demonstration, dataclasses.replace(rule, warm_start=True))
    drive(adaptation.warm_start(meta_params, demonstration, rule), 5)
    return start if rule.warm_start else meta_params


def unscored(meta_params, drive, demonstration, rule, score):
    """score"""
    start = adaptation.warm_start(meta_params, demonstration, rule)
    return adaptation.adapt(meta_params, drive(start, 5), demonstration, rule)


def only_clones(meta_params, drive, demonstration, rule, score):
    """cloning alone"""
    trial = score(drive(adaptation.warm_start(meta_params, demonstration, rule), 5))
    return adaptation.adapt(meta_params, trial, demonstration, dataclasses.replace(rule, w_rl=0.0))


def two_steps(meta_params, drive, demonstration, rule, score):
    """two adaptation steps"""
    trial = score(drive(adaptation.warm_start(meta_params, demonstration, rule), 5))
    once = adaptation.adapt(meta_params, trial, demonstration, rule)
    return adaptation.adapt(once, trial, demonstration, rule)
