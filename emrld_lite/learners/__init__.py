"""The meta-update: TRPO on D^val or Adam on D^dem, each differentiated through the adaptation."""

from .adam import LARGE_KL, UNBOUNDED, Adam, adapted_kl
from .base import Learner, TaskData, chunks, cloning_gradient, policies_after
from .trust_region import CloningTrpo, RlAndCloningTrpo, Trpo

LEARNERS = {
    "rl-trpo": Trpo,
    "cloning-adam": Adam,
    "cloning-trpo": CloningTrpo,
    "rl-and-cloning-trpo": RlAndCloningTrpo,
}

__all__ = [
    "LARGE_KL",
    "LEARNERS",
    "UNBOUNDED",
    "Adam",
    "CloningTrpo",
    "Learner",
    "RlAndCloningTrpo",
    "TaskData",
    "Trpo",
    "adapted_kl",
    "chunks",
    "cloning_gradient",
    "policies_after",
]
