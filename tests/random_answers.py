"""Random wrong answers to an exercise: small changes of its solution's syntax tree.

Each change is one slip of the pen: another operator, constant, comparison or axis, swapped arguments,
a slice that is off by one, a dropped term, a turned sign, a part left out, a detached tensor, a
gradient without its graph, an argument changed in place.
"""

from __future__ import annotations

import ast
import copy
import itertools
import random
from collections.abc import Iterator

OPERATORS = {
    ast.Add: [ast.Sub, ast.Mult],
    ast.Sub: [ast.Add, ast.Mult],
    ast.Mult: [ast.Div, ast.Add],
    ast.Div: [ast.Mult, ast.Sub],
    ast.Pow: [ast.Mult],
    ast.MatMult: [ast.Mult],
    ast.BitOr: [ast.BitAnd],
    ast.BitAnd: [ast.BitOr],
    ast.FloorDiv: [ast.Div, ast.Mult],
}
COMPARISONS = {
    ast.Gt: [ast.GtE, ast.Lt],
    ast.Lt: [ast.LtE, ast.Gt],
    ast.LtE: [ast.Lt, ast.Gt],
    ast.GtE: [ast.Gt, ast.Lt],
    ast.Eq: [ast.NotEq],
}
METHODS = {
    "sum": ["mean", "max"],
    "mean": ["sum", "max"],
    "min": ["max", "mean"],
    "max": ["min", "sum"],
    "exp": ["log", "abs"],
    "log": ["exp"],
    "sqrt": ["square", "abs"],
    "cos": ["sin"],
    "sin": ["cos"],
    "ceil": ["floor"],
    "cumprod": ["cumsum"],
    "norm": ["sum"],
    "abs": ["exp"],
}


def _expression_changes(node: ast.AST) -> Iterator[ast.AST]:
    """Yield what an expression may be replaced by."""
    if isinstance(node, ast.BinOp):
        for operator in OPERATORS.get(type(node.op), []):
            yield ast.BinOp(node.left, operator(), node.right)
        yield from (node.left, node.right)
        if isinstance(node.op, ast.Sub | ast.Div | ast.BitOr):
            yield ast.BinOp(node.right, node.op, node.left)
    elif isinstance(node, ast.UnaryOp):
        yield node.operand
    elif isinstance(node, ast.Constant) and isinstance(node.value, bool):
        yield ast.Constant(not node.value)
    elif isinstance(node, ast.Constant) and isinstance(node.value, int | float):
        for value in (node.value + 1, node.value - 1, 2 * node.value, -node.value):
            yield ast.Constant(value)
    elif isinstance(node, ast.Compare):
        for operator in COMPARISONS.get(type(node.ops[0]), []):
            yield ast.Compare(node.left, [operator()], node.comparators)
    elif isinstance(node, ast.IfExp):
        yield from (node.body, node.orelse)
    elif isinstance(node, ast.Call):
        yield from _call_changes(node)
    elif isinstance(node, ast.Subscript) or (isinstance(node, ast.Attribute) and node.attr == "T"):
        yield node.value
    if isinstance(node, ast.Name | ast.BinOp | ast.Call):
        yield ast.UnaryOp(ast.USub(), node)
        yield ast.Call(ast.Attribute(node, "detach", ast.Load()), [], [])
        yield ast.BinOp(ast.Constant(0.5), ast.Mult(), node)


def _call_changes(node: ast.Call) -> Iterator[ast.AST]:
    """Yield calls with another function, without an argument, or with two of them swapped."""
    if isinstance(node.func, ast.Attribute):
        for name in METHODS.get(node.func.attr, []):
            yield ast.Call(
                ast.Attribute(node.func.value, name, ast.Load()), node.args, node.keywords
            )
        yield node.func.value
    if len(node.args) > 1:
        yield ast.Call(node.func, [node.args[1], node.args[0], *node.args[2:]], node.keywords)
    if len(node.args) == 1:
        yield node.args[0]
    for place in range(len(node.keywords)):
        rest = node.keywords[:place] + node.keywords[place + 1 :]
        yield ast.Call(node.func, node.args, rest)
    if node.args:
        yield ast.Call(node.func, node.args[:-1], node.keywords)


def _slice_changes(node: ast.Slice) -> Iterator[ast.AST]:
    one = ast.Constant(1)
    for lower, upper in (
        (ast.BinOp(node.lower or ast.Constant(0), ast.Add(), one), node.upper),
        (node.lower, ast.BinOp(node.upper, ast.Sub(), one) if node.upper else ast.Constant(-1)),
        (None, node.upper),
        (node.lower, None),
    ):
        yield ast.Slice(lower, upper, node.step)


def _statement_changes(node: ast.stmt, arguments: list[str]) -> Iterator[list[ast.stmt]]:
    """Yield what a statement may be replaced by: nothing, or an argument changed before it."""
    if isinstance(node, ast.Assign | ast.AugAssign | ast.Break):
        yield [ast.Pass()]
    if isinstance(node, ast.Return):
        for name in arguments:
            for line in (f"{name} *= 2", f"{name} -= {name}.mean()", f"{name}.zero_()"):
                yield [*ast.parse(line).body, node]
            yield [*ast.parse(f"{name} = {name}.detach()").body, node]


def changed(source: str, name: str, count: int, seed: int) -> list[str]:
    """Return ``count`` sources, each the solution with one or (one in four) two random changes."""
    draw = random.Random(seed)
    single = itertools.islice(_changes(source, name, draw), count)
    found = list(dict.fromkeys(single))
    for place in range(0, len(found), 4):
        found[place] = next(_changes(found[place], name, draw))
    return found


def _changes(source: str, name: str, draw: random.Random) -> Iterator[str]:
    """Yield, in random order, the sources that one change makes, as far as they can be written."""
    tree = ast.parse(source)
    original = ast.unparse(tree)
    function = next(part for part in ast.walk(tree) if getattr(part, "name", "") == name)
    arguments = [argument.arg for argument in function.args.args]
    every = [
        (place, new)
        for place, node in enumerate(ast.walk(tree))
        for new in _node_changes(node, arguments)
    ]
    draw.shuffle(every)
    for place, new in every:
        text = _replaced(tree, place, new)
        if text and text != original:
            yield text


def _node_changes(node: ast.AST, arguments: list[str]) -> Iterator[ast.AST | list[ast.stmt]]:
    if isinstance(node, ast.Slice):
        yield from _slice_changes(node)
    elif isinstance(node, ast.stmt):
        yield from _statement_changes(node, arguments)
    else:
        yield from _expression_changes(node)


def _replaced(tree: ast.Module, place: int, new: ast.AST | list[ast.stmt]) -> str | None:
    """Return the source with the node at that place of the walk replaced."""
    changed_tree = copy.deepcopy(tree)
    target = list(ast.walk(changed_tree))[place]
    for parent in ast.walk(changed_tree):
        for field, value in ast.iter_fields(parent):
            if value is target:
                setattr(parent, field, new)
            elif isinstance(value, list) and any(part is target for part in value):
                spot = next(i for i, part in enumerate(value) if part is target)
                value[spot : spot + 1] = new if isinstance(new, list) else [new]
            else:
                continue
            try:
                text = ast.unparse(ast.fix_missing_locations(changed_tree))
                compile(text, "<random answer>", "exec")
            except (SyntaxError, ValueError, TypeError, AttributeError):
                return None
            return text
    return None
