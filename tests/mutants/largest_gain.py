import math


def times_the_step(delay_steps, time_step):
    """divide by the time step"""
    return 2 * math.sin(math.pi / (2 * (2 * delay_steps + 1)))


def multiplies(delay_steps, time_step):
    """do not multiply"""
    return 2 * math.sin(math.pi / (2 * (2 * delay_steps + 1))) * time_step


def quickest(delay_steps, time_step):
    """settles fastest"""
    return math.sin(math.pi / (2 * (2 * delay_steps + 1))) / time_step


def no_delay(delay_steps, time_step):
    """the delay is missing"""
    return 2 / time_step


def one_step_less(delay_steps, time_step):
    """one step less"""
    return 2 * math.sin(math.pi / (2 * max(1, 2 * delay_steps - 1))) / time_step


def one_step_more(delay_steps, time_step):
    """one step more"""
    return 2 * math.sin(math.pi / (2 * (2 * delay_steps + 3))) / time_step


def continuous_time(delay_steps, time_step):
    """limit of small steps"""
    return math.pi / (2 * delay_steps * time_step) if delay_steps else 2 / time_step


def grows(delay_steps, time_step):
    """lets the error grow"""
    return 2.4 * math.sin(math.pi / (2 * (2 * delay_steps + 1))) / time_step
