RIGHT = {1: ("P", "Q"), 2: ("W", "T"), 3: ("R", "V"), 4: None, 5: ("P", "S")}


def maml_on_optimal_data():
    """question 1: P and T differ in w_rl as well"""
    return {**RIGHT, 1: ("P", "T")}


def meta_bc():
    """question 3: R and U differ in optimiser and iterations as well"""
    return {**RIGHT, 3: ("R", "U")}


def adam():
    """do not differ in what is asked for"""
    return {**RIGHT, 3: ("V", "U")}


def fixed_sigma_beside():
    """question 4: W and X differ in sigma as well"""
    return {**RIGHT, 4: ("W", "X")}


def other_data():
    """question 4: P and S do not answer it for sub-optimal data"""
    return {**RIGHT, 4: ("P", "S")}


def across_data():
    """question 2: W and Q differ in data and w_rl as well"""
    return {**RIGHT, 2: ("W", "Q")}


def gives_up():
    """question 2: there is a pair"""
    return {**RIGHT, 2: None}


def the_same_twice():
    """do not differ at all"""
    return {**RIGHT, 5: ("P", "P")}


def without_control():
    """the names of two trainings"""
    return {**RIGHT, 1: ("Q",)}


def one_question_less():
    """the questions 1, 2, 3, 4, 5"""
    return {number: RIGHT[number] for number in (1, 2, 3)}
