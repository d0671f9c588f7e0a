RIGHT = {
    "A": ("flat", "in bounds"),
    "B": ("climbing", "in bounds"),
    "C": ("flat", "broke down"),
    "D": ("climbing", "broke down"),
}


def a_is_steep():
    """A, above: it does not climb"""
    return {**RIGHT, "A": ("climbing", "in bounds")}


def b_is_low():
    """B, above: it does climb"""
    return {**RIGHT, "B": ("flat", "in bounds")}


def c_is_flat_and_well():
    """C, below: some updates"""
    return {**RIGHT, "C": ("flat", "in bounds")}


def d_is_noisy():
    """D, above: it does climb"""
    return {**RIGHT, "D": ("flat", "broke down")}


def above_the_dashes():
    """B, below: no update"""
    return {**RIGHT, "B": ("climbing", "broke down")}


def one_missing():
    """the keys A, B, C, D"""
    return {name: RIGHT[name] for name in "ABC"}


def one_word():
    """a pair of words"""
    return {name: words[0] for name, words in RIGHT.items()}


def other_words():
    """expected "flat" or "climbing\""""
    return {**RIGHT, "A": ("rising", "in bounds")}


def turned_round():
    """expected "flat" or "climbing\""""
    return {name: words[::-1] for name, words in RIGHT.items()}
