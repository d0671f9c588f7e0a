import numpy as np


def spread_of_everything(table):
    """good and bad *seeds*"""
    return table.std()


def spread_over_seeds(table):
    """good and bad *seeds*"""
    return table.mean(1).std()


def best_less_worst(table):
    """good and bad *seeds*"""
    return table.max() - table.min()


def spread_within_a_seed(table):
    """Not yet"""
    return (table - table.mean(1, keepdims=True)).std()


def mean(table):
    """the same for every table"""
    return table.mean()


def nothing(table):
    """the same for every table"""
    return 0.0


def turned_round(table):
    """turn it round"""
    return -table.mean(0).std()


def best_task(table):
    """at another level of return"""
    return table.mean(0).max() + 3 * table.mean(0).std()


def first_seed(table):
    """Not yet"""
    return table[0].std()


def neighbours(table):
    """the order of tasks and seeds means nothing"""
    means = table.mean(0)
    return abs(means[0] - means[-1]) + 10 * means.std() + abs(means[1] - means[0])


def centred_in_place(table):
    """you changed `table` in place"""
    table -= table.mean(1, keepdims=True)
    return table.mean(0).std()


def one_per_task(table):
    """a single number"""
    return table.mean(0)


def worst_task(table):
    """at another level of return"""
    return -table.mean(0).min()
