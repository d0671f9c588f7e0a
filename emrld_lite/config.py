"""Everything that decides a run, in one frozen dataclass."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from .adapt import Adaptation
from .advantage import with_advantages
from .algorithms import ALGORITHMS, Algorithm
from .envs import ENVIRONMENTS, Environment, make
from .rollout import Rollout
from .trpo import TrustRegion
from .validation import known, lookup, positive_count, real_number


@dataclass(frozen=True)
class TrainConfig:
    """Everything that decides a run; the defaults are Table 2's. Raises InputError for bad values."""

    env: str = "point2d"
    """point2d, two_wheeled, half_cheetah or two_wheeled_drift."""
    algorithm: str = "emrld-ws"
    """Row of the comparison: emrld, emrld-ws, maml, meta-bc or gmps."""
    demos: str = "optimal"
    """optimal, suboptimal, or a demonstration file ending in .npz."""
    iterations: int = 150
    """Meta-iterations to run."""
    seed: int = 0
    """Seed of the policy's start and of every draw."""
    episodes: int = 20
    """Episodes a task, before and again after adaptation (Table 2, adapt batch size)."""
    discount: float = 0.95
    """gamma (Table 2)."""
    gae_lambda: float = 1.0
    """GAE's lambda, which Table 2 calls tau."""
    adapt_lr: float = 0.01
    """alpha, the adaptation's learning rate (Table 2)."""
    w_rl: float | None = None
    """Weight of RL in the adaptation; by default the algorithm's and the data's (Table 2)."""
    w_bc: float | None = None
    """Weight of cloning in the adaptation; by default the algorithm's (Table 2)."""
    meta_lr: float = 0.01
    """Adam's learning rate in the meta-update of meta-bc and gmps (Table 2)."""
    bc_reduction: str = "mean"
    """mean over the demonstration's steps (released code) or their sum (paper)."""
    second_order: bool = True
    """Whether the meta-gradient goes through the adaptation's gradient (paper) or stops at it."""
    normalise: bool = True
    """Whether each task's advantages are scaled to mean 0 and deviation 1."""
    reward_elsewhere: float = 0.0
    """What learning sees in place of a reward of zero (released code: 1e-5)."""
    learn_sigma: bool = True
    """Whether sigma is learned from 1 on (released code) or stays 1 (paper)."""
    network_start: str = "biased"
    """biased (biases and a small last layer) or xavier (released code: zero biases)."""
    reward: str = "sparse"
    """sparse (paper) or dense: minus the distance to the goal, for the cheetah its speed everywhere."""
    step_rule: str = "at-most"
    """Length of a Point2D step: at-most 0.1 (paper) or exact 0.1 (released code)."""
    trust_region: TrustRegion = field(default_factory=TrustRegion)
    """TRPO's step."""
    stop_at_return: float | None = None
    """End once the mean return after adaptation reaches this; by default run all iterations."""

    def __post_init__(self) -> None:
        known("environment", self.env, ENVIRONMENTS)
        known("algorithm", self.algorithm, ALGORITHMS)
        positive_count("iterations", self.iterations)
        positive_count("seed", self.seed, minimum=0)
        positive_count("episodes", self.episodes)
        real_number("discount", self.discount, 0.0, 1.0)
        real_number("gae_lambda", self.gae_lambda, 0.0, 1.0)
        real_number("meta_lr", self.meta_lr, minimum=1e-12)
        real_number("reward_elsewhere", self.reward_elsewhere)
        if self.stop_at_return is not None:
            real_number("stop_at_return", self.stop_at_return)
        known("network_start", self.network_start, ("biased", "xavier"))
        self.environment()
        self.adaptation("optimal")

    def environment(self) -> Environment:
        """Return the environment of the run."""
        options = {"step_rule": self.step_rule} if self.env == "point2d" else {}
        return make(self.env, reward=self.reward, **options)

    def row(self) -> Algorithm:
        """Return the algorithm's row of the comparison."""
        return lookup("algorithm", self.algorithm, ALGORITHMS)

    def adaptation(self, quality: str) -> Adaptation:
        """Return the adaptation for demonstrations of ``quality``."""
        chosen = self.row().adaptation(
            quality, self.adapt_lr, self.w_rl, self.w_bc, self.bc_reduction
        )
        return replace(chosen, second_order=self.second_order)

    def scored(self, rollout: Rollout) -> Rollout:
        """Return a rollout with the advantages that this run learns from."""
        rewards = rollout.rewards
        if self.reward_elsewhere:
            unpaid = (rewards == 0.0) * rollout.mask
            rollout = rollout._replace(rewards=rewards + self.reward_elsewhere * unpaid)
        scored = with_advantages(rollout, self.discount, self.gae_lambda, self.normalise)
        return scored._replace(rewards=rewards)
