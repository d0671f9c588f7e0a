import math


def adds_up(rate, confidence):
    """do not add up"""
    return math.ceil(confidence / rate)


def mean_waiting_time(rate, confidence):
    """mean waiting time"""
    return math.ceil(1 / rate)


def wrong_tail(rate, confidence):
    """take 1 - confidence"""
    return math.ceil(math.log(confidence) / math.log(1 - rate))


def not_whole(rate, confidence):
    """round up"""
    return math.log(1 - confidence) / math.log(1 - rate)


def next_whole(rate, confidence):
    """one too many"""
    return int(math.log(1 - confidence) / math.log(1 - rate)) + 1


def upside_down(rate, confidence):
    """upside down"""
    return math.ceil(math.log(1 - rate) / math.log(1 - confidence))
