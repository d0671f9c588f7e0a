"""The commands: what each option means, checks before anything starts, what is printed at the end."""

from .demonstrations import demos
from .measuring import bench, evaluate, figures
from .robots import robot_drive, robot_node, robot_study
from .training import lottery, sweep, train

COMMANDS = (
    *(demos, train, evaluate, sweep, figures, bench, lottery),
    *(robot_node, robot_drive, robot_study),
)
