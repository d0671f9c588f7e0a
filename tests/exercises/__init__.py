"""Every exercise as a question: random inputs, and right answers in other styles than the solution's.

One module per notebook: ``QUESTIONS`` draws an exercise's inputs; a function ``exercise__style`` is a right
answer in that style, which the check must accept. An exercise without one right answer (a counterexample, a
simulation, a design) stands in ``MANY_ANSWERS`` in place of QUESTIONS: mutants alone test its check.
"""

from __future__ import annotations

import importlib
import inspect
import pkgutil

from .draw import Draw, Questions, same

_NOTEBOOKS = [
    importlib.import_module(f"{__name__}.{module.name}")
    for module in pkgutil.iter_modules(__path__)
    if module.name.startswith("notebook_")
]
QUESTIONS: Questions = {
    name: question for notebook in _NOTEBOOKS for name, question in notebook.QUESTIONS.items()
}
MANY_ANSWERS = {name for notebook in _NOTEBOOKS for name in getattr(notebook, "MANY_ANSWERS", ())}
RIGHT_ANSWERS = [
    (name, function)
    for notebook in _NOTEBOOKS
    for name, function in inspect.getmembers(notebook, inspect.isfunction)
    if "__" in name and function.__module__ == notebook.__name__
]

__all__ = ["MANY_ANSWERS", "QUESTIONS", "RIGHT_ANSWERS", "Draw", "same"]
