DESIGN = {
    "switch": {"bc_reduction": "sum"},
    "expected": "lower",
    "seeds": (0, 1, 2),
    "iterations": 25,
}


def two_switches():
    """two settings change at once"""
    return {**DESIGN, "switch": {"bc_reduction": "sum", "adapt_lr": 0.001}}


def one_seed():
    """three are the fewest"""
    return {**DESIGN, "seeds": (0,)}


def the_same_seed():
    """the same seed twice"""
    return {**DESIGN, "seeds": (0, 0, 0)}


def all_night():
    """plan 240 at most"""
    return {**DESIGN, "seeds": range(10), "iterations": 60}


def too_short():
    """plan 10 to 60 iterations"""
    return {**DESIGN, "iterations": 2}


def another_algorithm():
    """several things at once"""
    return {**DESIGN, "switch": {"algorithm": "maml"}}


def other_data():
    """two things would change"""
    return {**DESIGN, "switch": {"demos": "suboptimal"}}


def the_seed_as_switch():
    """they are no switch"""
    return {**DESIGN, "switch": {"seed": 3}}


def nothing_changed():
    """in the control as well"""
    return {**DESIGN, "switch": {"w_rl": 0.2}}


def unknown_setting():
    """there is no setting"""
    return {**DESIGN, "switch": {"alpha": 0.1}}


def impossible_value():
    """cannot be used"""
    return {**DESIGN, "switch": {"discount": 2.0}}


def no_prediction():
    """expected is one of"""
    return {**DESIGN, "expected": "better"}


def no_switch():
    """a dict with one setting"""
    return {**DESIGN, "switch": {}}


def keys_missing():
    """a dict with the keys"""
    return {"switch": {"bc_reduction": "sum"}}


def of_another_robot():
    """no effect on Point2D"""
    return {**DESIGN, "switch": {"heading": False}}


def of_another_optimiser():
    """Adam makes no step here"""
    return {**DESIGN, "switch": {"meta_lr": 0.1}}
