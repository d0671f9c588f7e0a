"""Wrong answers to notebook 05's `conjugate_gradient`; each docstring is the sentence the check must say."""

import torch


def _solve(product, target, iterations, beta):
    solution, residual, direction = torch.zeros_like(target), target.clone(), target.clone()
    for _ in range(iterations):
        if not residual.any():
            break
        image = product(direction)
        squared = residual @ residual
        length = squared / (direction @ image)
        solution = solution + length * direction
        updated = residual - length * image
        direction = updated + beta(updated, residual) * direction
        residual = updated
    return solution


def steepest_descent(product, target, iterations):
    """the directions are not conjugate"""
    return _solve(product, target, iterations, lambda new, old: 0.0)


def upside_down(product, target, iterations):
    """the directions are not conjugate"""
    return _solve(product, target, iterations, lambda new, old: (old @ old) / (new @ new))


def changes_its_input(product, target, iterations):
    """you changed `target` in place"""
    solution, residual, direction = torch.zeros_like(target), target, target.clone()
    for _ in range(iterations):
        image = product(direction)
        squared = residual @ residual
        length = squared / (direction @ image)
        solution = solution + length * direction
        residual -= length * image
        direction = residual + (residual @ residual) / squared * direction
    return solution


def fixed_length(product, target, iterations):
    """the first step is off"""
    solution = torch.zeros_like(target)
    for _ in range(iterations):
        solution = solution + 0.1 * (target - product(solution))
    return solution


def divides_zero_by_zero(product, target, iterations):
    """Stop when the residual is zero"""
    solution, residual, direction = torch.zeros_like(target), target.clone(), target.clone()
    for _ in range(iterations):
        image = product(direction)
        squared = residual @ residual
        length = squared / (direction @ image)
        solution = solution + length * direction
        residual = residual - length * image
        direction = residual + (residual @ residual) / squared * direction
    return solution


def asks_too_often(product, target, iterations):
    """3 iterations need 3 products"""
    for _ in range(iterations):
        product(target)
    return _solve(product, target, iterations, lambda new, old: (new @ new) / (old @ old))


def _solved(product, target, iterations, restart=99, enough=0.0, sign=-1.0):
    x, r, p = torch.zeros_like(target), target.clone(), target.clone()
    for step in range(iterations):
        if r.norm() <= enough:
            break
        image = product(p)
        length = (r @ r) / (p @ image)
        x, new = x + length * p, r + sign * length * image
        p = new + (0 if (step + 1) % restart == 0 else (new @ new) / (r @ r)) * p
        r = new
    return x


def ends_early(product, target, iterations):
    """you stop too early"""
    return _solved(product, target, iterations, enough=0.1)


def restarts(product, target, iterations):
    """in every iteration"""
    return _solved(product, target, iterations, restart=3)


def one_too_many(product, target, iterations):
    """one iteration too many"""
    return _solved(product, target, iterations + 1)


def one_too_few(product, target, iterations):
    """one iteration too few"""
    return _solved(product, target, iterations - 1)


def residual_turned(product, target, iterations):
    """the residual grows"""
    return _solved(product, target, iterations, sign=1.0)


def still_the_suspect(product, target, iterations):
    """the first direction is lost"""
    return _with_shared_memory(product, target, iterations, target.clone())


def a_copy_in_the_wrong_place(product, target, iterations):
    """the first direction is lost"""
    residual = target.clone()
    return _with_shared_memory(product, target.clone(), iterations, residual)


def _with_shared_memory(product, target, iterations, residual):
    solution, direction = torch.zeros_like(target), residual
    squared = target @ target
    for _ in range(iterations):
        if squared == 0:
            break
        image = product(direction)
        length = squared / (direction @ image)
        solution += length * direction
        residual -= length * image
        previous, squared = squared, residual @ residual
        direction = residual + squared / previous * direction
    return solution


def residual_shares_the_target(product, target, iterations):
    """you changed `target` in place"""
    return _with_shared_memory(product, target, iterations, target)
