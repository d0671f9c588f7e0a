def no_control(control, changes):
    """nothing to compare with"""
    return {name: control | change for name, change in changes.items()}


def piling_up(control, changes):
    """you changed `control` in place"""
    runs = {"control": control}
    for name, change in changes.items():
        control.update(change)
        runs[name] = dict(control)
    return runs


def all_at_once(control, changes):
    """more than one thing changes"""
    everything = dict(control)
    for change in changes.values():
        everything |= change
    return {"control": control} | dict.fromkeys(changes, everything)


def change_alone(control, changes):
    """needs all settings"""
    return {"control": control} | changes


def control_on_top(control, changes):
    """put the change on top"""
    return {"control": control} | {name: change | control for name, change in changes.items()}


def drops_new_settings(control, changes):
    """what the control leaves open"""
    runs = {"control": control}
    for name, change in changes.items():
        runs[name] = {key: change.get(key, value) for key, value in control.items()}
    return runs
