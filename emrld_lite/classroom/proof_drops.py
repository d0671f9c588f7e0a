"""What each inequality of the proof of Theorem 1 gives away, and how its lines are called in a lesson."""

from __future__ import annotations

from collections.abc import Sequence

from torch import Tensor

from ..tabular import ProofLine

# the five inequalities of the proof, in the order in which the truth comes down to the printed bound
DROPS = {
    "a_absolute_demo": "absolute values (demonstrator)",
    "b_demo": "Hölder (demonstrator)",
    "a_assumption": "minimum for an average",
    "a_absolute_old": "absolute values (old policy)",
    "b_old": "Hölder (old policy)",
}
MOVES = {
    "objective": "1  J by visits",
    "lemma_1": "2  Lemma 1",
    "meta_definition": "3  definition of J_meta",
    "meta_linearity": "3  linearity",
    "meta_lemma": "3  Lemma 1 per task",
    "meta_joint": "3  (meta-PDL)",
    "add_and_subtract": "4  add and subtract",
    "inter": "4  (inter)",
    "second_term": "5  four sums",
    "a_assumption": "6  Assumption 1",
    "a_zero": "6  A averages to 0",
    "a_absolute_demo": "6  absolute values, new",
    "a_absolute_old": "6  absolute values, old",
    "a": "6  step (a)",
    "b_demo": "7  Hölder, demonstrator",
    "b_old": "7  Hölder, old policy",
    "b": "7  step (b)",
    "theorem": "8  Theorem 1",
}


def drops(lines: Sequence[ProofLine]) -> dict[str, Tensor]:
    """Return by how much each inequality of the proof lies below its better side, per discounted step.

    Their sum is (1 - gamma) times the improvement less the printed bound, whatever the family.
    """
    by_name = {line.name: line for line in lines}
    gaps = {name: by_name[name].left - by_name[name].right for name in DROPS}
    return {name: -gap if by_name[name].relation == "<=" else gap for name, gap in gaps.items()}
