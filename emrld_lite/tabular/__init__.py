"""Theorem 1 as an experiment: finite MDPs solved exactly, the theorem line by line, exact EMRLD.

Reads in the order mdp, theorem, proof, families, emrld. Nothing here samples a trajectory.
"""

from .emrld import ExactIterate, ExactMetaRL, exact_meta_train
from .families import (
    LEFT_RIGHT,
    corridor_step,
    gridworld,
    many_families,
    mixed,
    random_family,
    slippery_pair,
)
from .mdp import TabularMDP, optimal_policy
from .proof import Claims, ProofLine, proof_lines
from .theorem import MetaStep, RelatedBounds, Theorem1, related_bounds, theorem_1

__all__ = [
    "LEFT_RIGHT",
    "Claims",
    "ExactIterate",
    "ExactMetaRL",
    "MetaStep",
    "ProofLine",
    "RelatedBounds",
    "TabularMDP",
    "Theorem1",
    "corridor_step",
    "exact_meta_train",
    "gridworld",
    "many_families",
    "mixed",
    "optimal_policy",
    "proof_lines",
    "random_family",
    "related_bounds",
    "slippery_pair",
    "theorem_1",
]
