"""EMRLD in one sitting: meta reinforcement learning with demonstrations, small enough to read.

Read the modules in the order the data flows through them, which is the order of their imports::

    first_calls -> validation -> limits -> storage -> archives -> envs -> policy -> rollout ->
    advantage -> demonstrations -> losses -> adapt -> trpo -> learners -> algorithms -> config ->
    train -> evaluate

Around them stand five rooms: ``demonstrators`` (where demonstrations come from), ``robot`` (a
TurtleBot over ROS), ``experiments`` (runs made, stored, summed up and drawn), ``tabular`` (Theorem 1
in finite worlds) and ``classroom`` (the notebooks' checks and widgets); ``__main__`` is the command
line. Tensor axes are always ``(task, episode, time, dim)``, in this order.

The paper is Rengarajan, Chaudhary, Kim, Kalathil and Shakkottai, "Enhanced Meta Reinforcement
Learning using Demonstrations in Sparse Reward Environments", NeurIPS 2022.
"""

import gymnasium

__version__ = "0.1.0"

GYMNASIUM_IDS = {
    "point2d": "emrld_lite/Point2D-v0",
    "two_wheeled": "emrld_lite/TwoWheeled-v0",
    "half_cheetah": "emrld_lite/HalfCheetahForwardBackward-v0",
    "two_wheeled_drift": "emrld_lite/TwoWheeledDrift-v0",
    "two_wheeled_literal_drift": "emrld_lite/TwoWheeledLiteralDrift-v0",
    "turtlebot": "emrld_lite/TurtleBot-v0",
}

for _name, _id in GYMNASIUM_IDS.items():
    if _id not in gymnasium.registry:  # by an entry point in words, so that nothing is imported yet
        gymnasium.register(
            _id, entry_point="emrld_lite.envs:single_episode", kwargs={"name": _name}
        )

ROBOT_ID = (
    "emrld_lite/TurtleBotOverROS-v0"  # speaks to a robot, so it is none of the simulations above
)

if ROBOT_ID not in gymnasium.registry:
    gymnasium.register(
        ROBOT_ID, entry_point="emrld_lite.robot.driver:Driver", nondeterministic=True
    )
