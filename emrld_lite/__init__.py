"""EMRLD in one sitting: meta reinforcement learning with demonstrations, small enough to read.

Read the modules in the order the data flows through them::

    envs -> policy -> rollout -> advantage -> losses -> adapt -> trpo -> meta_update -> algorithms -> train

and then what surrounds the loop: ``demonstrations``, ``expert``,
``demonstrator``, ``evaluate``, ``runs``, ``plots``.
Tensor axes are always ``(task, episode, time, dim)``, in this order.

The paper is Rengarajan, Chaudhary, Kim, Kalathil and Shakkottai, "Enhanced Meta Reinforcement
Learning using Demonstrations in Sparse Reward Environments", NeurIPS 2022.
"""

__version__ = "0.1.0"
