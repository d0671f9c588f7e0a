"""Everything that decides a run, in one frozen dataclass."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Literal, get_args

from .adapt import Adaptation
from .advantage import Score
from .algorithms import ALGORITHMS, Algorithm
from .envs import Environment, family, make
from .envs.base import PaidSide, Reward, Start
from .envs.point2d import Point2D, StepRule
from .learners import LEARNERS, Adam, Learner, RlAndCloningTrpo, Trpo
from .losses import Reduction
from .policy import NETWORK_START, LogDensity, NetworkStart, Params, initialise
from .trpo import TrustRegion
from .validation import (
    InputError,
    check_choice,
    lookup,
    positive_count,
    real_number,
    seed_number,
    shown,
    text,
    true_or_false,
)

EnvironmentName = Literal[
    "point2d", "two_wheeled", "half_cheetah", "two_wheeled_drift", "two_wheeled_literal_drift"
]
MOST_ROUNDS = 1000  # of the trust region's loops: halved so often, a step is zero
AlgorithmName = Literal["emrld", "emrld-ws", "maml", "meta-bc", "gmps"]
MetaUpdate = Literal["rl-trpo", "cloning-adam", "cloning-trpo", "rl-and-cloning-trpo"]


@dataclass(frozen=True)
class TrainConfig:
    """Everything that decides a run; the defaults are Table 1's. Raises InputError for bad values."""

    env: EnvironmentName = "point2d"
    """Environment of the tasks."""
    algorithm: AlgorithmName = "emrld-ws"
    """Row of the comparison."""
    demos: str = "optimal"
    """optimal, suboptimal, or a demonstration file ending in .npz."""
    iterations: int = 150
    """Meta-iterations to run."""
    seed: int = 0
    """Seed of the policy's start and of every draw."""
    episodes: int = 20
    """Episodes per task, before and again after adaptation (Table 1, adapt batch size)."""
    started_episodes: int | None = None
    """Episodes started per task, of which only as many as count are kept, those that end first (released
    code: 30); by default all are kept."""
    discount: float = Score.discount
    """gamma (Table 1)."""
    gae_lambda: float = Score.gae_lambda
    """GAE's lambda, which Table 1 calls tau."""
    adapt_lr: float = Adaptation.adapt_lr
    """alpha, the adaptation's learning rate (Table 1)."""
    w_rl: float | None = None
    """Weight of RL in the adaptation; by default the algorithm's and the data's (Table 1)."""
    w_bc: float | None = None
    """Weight of cloning in the adaptation; by default the algorithm's (Table 1)."""
    meta_update: MetaUpdate | None = None
    """The meta-update's loss and optimiser; by default the algorithm's. No algorithm of the paper clones by
    TRPO."""
    meta_w_bc: float = 1.0
    """Weight of cloning beside RL, whose weight is 1, in the meta-update rl-and-cloning-trpo (ours: the paper
    tried that without saying its weight)."""
    meta_momentum: float = 0.5
    """Share of earlier iterations in the gradient along which TRPO steps (ours; the paper's is 0)."""
    meta_lr: float = 0.01
    """Adam's learning rate in the meta-update of meta-bc and gmps (Table 1)."""
    max_grad_norm: float | None = None
    """Length to which Adam's meta-gradient is clipped where it is longer (ours); by default it is not."""
    bc_reduction: Reduction = Adaptation.bc_reduction
    """Mean over the demonstration's steps (released code) or their sum (paper)."""
    log_density: LogDensity = Adaptation.log_density
    """In the adaptation's losses: averaged over the action's dimensions (released code) or joint (paper)."""
    second_order: bool = Adaptation.second_order
    """Whether the meta-gradient goes through the adaptation's gradient (paper) or stops at it."""
    normalise: bool = Score.normalise
    """Whether each task's advantages are scaled to mean 0 and deviation 1."""
    reward_elsewhere: float = Score.reward_elsewhere
    """What learning sees in place of a reward of zero (released code: 1e-5)."""
    learn_sigma: bool = True
    """Whether sigma is learned from 1 on (released code) or stays 1 (paper)."""
    network_start: NetworkStart = NETWORK_START
    """Biases and a small last layer (biased), or the released code's zero biases (xavier)."""
    reward: Reward = Environment.reward
    """sparse (paper) or dense: minus the distance to the goal, for the cheetah its speed everywhere."""
    step_rule: StepRule = Point2D.step_rule
    """Length of a Point2D step: at-most 0.1 (paper) or exact 0.1 (released code)."""
    heading: bool = True
    """Whether a policy in TwoWheeled, with or without drift, sees the heading (paper: a state in R^2)."""
    start: Start = "rest"
    """How the cheetah's episodes begin: at rest, or at random (released code)."""
    paid_side: PaidSide = "both"
    """The cheetah is paid, or punished, beyond two metres either way (appendix B), or only in the correct
    direction (section 4.1)."""
    trust_region: TrustRegion = field(default_factory=TrustRegion)
    """TRPO's step."""
    stop_at_return: float | None = None
    """End once the mean return after adaptation reaches this; by default run all iterations."""

    def __post_init__(self) -> None:
        check_choice("environment", self.env, get_args(EnvironmentName))
        check_choice("network_start", self.network_start, get_args(NetworkStart))
        check_choice("reward", self.reward, get_args(Reward))
        check_choice("step rule", self.step_rule, get_args(StepRule))
        check_choice("start", self.start, get_args(Start))
        check_choice("paid side", self.paid_side, get_args(PaidSide))
        check_choice("algorithm", self.algorithm, ALGORITHMS)
        if self.meta_update is not None:
            check_choice("meta_update", self.meta_update, get_args(MetaUpdate))
        text("demos", self.demos)
        for name in ("second_order", "normalise", "learn_sigma", "heading"):
            true_or_false(name, getattr(self, name))
        positive_count("iterations", self.iterations)
        seed_number("seed", self.seed)
        positive_count("episodes", self.episodes)
        if self.started_episodes is not None:
            positive_count("started_episodes", self.started_episodes, minimum=self.episodes)
        real_number("meta_w_bc", self.meta_w_bc, minimum=0.0)
        if self.meta_w_bc != 1.0 and self.meta_update != "rl-and-cloning-trpo":
            raise InputError(
                f"meta_w_bc: expected 1.0, got {self.meta_w_bc}: only the meta-update rl-and-cloning-trpo "
                f"reads it, and this one is {self.meta_update or 'the algorithm’s own'}"
            )
        real_number("meta_momentum", self.meta_momentum, 0.0, 0.99)
        real_number("meta_lr", self.meta_lr, minimum=1e-12)
        self._check_clipping()
        if self.stop_at_return is not None:
            real_number("stop_at_return", self.stop_at_return)
        self._check_trust_region()
        self.environment()
        self.adaptation("optimal")
        self.score()

    def _check_clipping(self) -> None:
        """Raise InputError for a bound that is none, or that no update would read."""
        if self.max_grad_norm is None:
            return
        real_number("max_grad_norm", self.max_grad_norm, minimum=1e-12)
        if not issubclass(self.learner_type(), Adam):
            raise InputError(
                f"max_grad_norm: expected None, got {self.max_grad_norm}: only a meta-update by Adam reads "
                f"it, and {self.algorithm} updates by {self.meta_update or 'TRPO'}"
            )

    def _check_trust_region(self) -> None:
        """Raise InputError for a region that is none, or whose loops would not end in a lifetime."""
        if not isinstance(self.trust_region, TrustRegion):
            raise InputError(f"trust_region: expected a region, got {shown(self.trust_region)}")
        true_or_false("aliased_cg", self.trust_region.aliased_cg)
        positive_count("cg_iterations", self.trust_region.cg_iterations, maximum=MOST_ROUNDS)
        positive_count("backtracks", self.trust_region.backtracks, maximum=MOST_ROUNDS)

    def environment(self) -> Environment:
        """Return the environment of the run."""
        own = {option.name for option in fields(family(self.env))}
        settings = {setting.name: getattr(self, setting.name) for setting in fields(self)}
        return make(self.env, **{name: settings[name] for name in own & set(settings)})

    def comparison_row(self) -> Algorithm:
        """Return the algorithm's row of the comparison."""
        return lookup("algorithm", self.algorithm, ALGORITHMS)

    def adaptation(self, quality: str) -> Adaptation:
        """Return the adaptation for demonstrations of ``quality``."""
        settings = ("w_rl", "w_bc", "adapt_lr", "bc_reduction", "log_density", "second_order")
        chosen = {name: getattr(self, name) for name in settings}
        return self.comparison_row().adaptation(quality, **chosen)

    def score(self) -> Score:
        """Return what turns rewards into the advantages that this run learns from."""
        return Score(self.discount, self.gae_lambda, self.normalise, self.reward_elsewhere)

    def initial_policy(self) -> Params:
        """Return the meta-policy before any training."""
        environment = self.environment()
        return initialise(
            environment.state_dim,
            environment.action_dim,
            self.seed,
            learn_sigma=self.learn_sigma,
            start=self.network_start,
        )

    def learner_type(self) -> type[Learner]:
        """Return what makes the meta-update: the algorithm's, unless ``meta_update`` says another."""
        if self.meta_update is None:
            return self.comparison_row().learner
        return LEARNERS[self.meta_update]

    def learner(self, theta: Params) -> Learner:
        """Return what changes the meta-policy ``theta``, with nothing learned yet."""
        chosen = self.learner_type()
        if chosen is RlAndCloningTrpo:
            return chosen(theta, self.trust_region, self.meta_momentum, self.meta_w_bc)
        if issubclass(chosen, Trpo):
            return chosen(theta, self.trust_region, self.meta_momentum)
        return Adam(theta, self.meta_lr, self.max_grad_norm)
