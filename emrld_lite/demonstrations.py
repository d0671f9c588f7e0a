"""Demonstrations: one trajectory per task, or several, in a file that a stranger can make.

The file is an ``.npz`` without pickles; ``data/README.md`` documents it for people who bring their
own recordings.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, get_args

import numpy as np
import torch
from jaxtyping import Float, Int
from torch import Tensor

from . import archives, storage
from .envs import ENVIRONMENTS, Environment, make
from .validation import InputError, check_choice, shown

QualityName = Literal["optimal", "suboptimal"]
QUALITIES = get_args(QualityName)
ARRAYS = ("tasks", "states", "actions", "lengths", "environment", "quality", "maker", "seed")
SHIPPED = storage.DATA / "demonstrations"
LARGEST = {"states": 1000.0, "actions": 100.0}  # in size; no environment here comes near either


@dataclass(frozen=True)
class Demonstrations:
    """D^dem: one trajectory per task in the paper's data, here also several.

    Raises InputError for data that could not have come from its environment.
    """

    tasks: Float[Tensor, "task task_dim"]
    """Parameters of each task, such as its goal."""
    states: Float[Tensor, "task path time state"]
    """States; zero after the trajectory's end."""
    actions: Float[Tensor, "task path time action"]
    """Actions in the policy's units, before scaling."""
    mask: Float[Tensor, "task path time"]
    """1 where the trajectory has a step."""
    environment: str
    """Name of the environment, such as "point2d"."""
    quality: str
    """optimal or suboptimal; decides the default of w_rl."""
    maker: str = "unknown"
    """Who or what made the data."""
    seed: int = 0
    """Seed it was made with."""

    def lengths(self) -> Int[Tensor, " task"]:
        """Return the number of steps of each task's first trajectory."""
        return self.mask[:, 0].sum(-1).long()

    def fingerprint(self) -> str:
        """Return a hash of the content, the same wherever and under whichever name the file lies."""
        digest = hashlib.sha256(f"{self.environment} {self.quality}".encode())
        for values in (self.tasks, self.states, self.actions, self.mask):
            digest.update(str(tuple(values.shape)).encode())
            digest.update(values.cpu().numpy().astype("<f4").tobytes())
        return digest.hexdigest()

    def map(self, change: Callable[[Tensor], Tensor]) -> Demonstrations:
        """Return the same demonstrations with ``change`` applied to every tensor."""
        tensors = ("tasks", "states", "actions", "mask")
        return replace(self, **{name: change(getattr(self, name)) for name in tensors})

    def seen_in(self, environment: Environment) -> Demonstrations:
        """Return the same trajectories as a policy in ``environment`` would have seen them."""
        return replace(self, states=environment.observe(self.states))

    def take(self, tasks: slice) -> Demonstrations:
        """Return the demonstrations of some tasks."""
        return self.map(lambda values: values[tasks])

    def to(self, device: str) -> Demonstrations:
        """Return the same data on ``device``."""
        return self.map(lambda values: values.to(device))


def from_arrays(
    tasks: np.ndarray,
    states: np.ndarray,
    actions: np.ndarray,
    lengths: np.ndarray,
    environment: str,
    quality: str,
    maker: str = "unknown",
    seed: int = 0,
    source: str = "demonstrations",
) -> Demonstrations:
    """Check plain arrays and return them as Demonstrations.

    ``tasks`` is (task, task_dim), ``states`` (task, time, state), ``actions`` (task, time, action),
    ``lengths`` (task,) whole numbers; what lies after a trajectory's length is ignored. Several
    trajectories per task have one more axis after the first in the last three. Raises InputError
    naming ``source``, the field and the task.
    """
    family = make(check_choice(f"environment in {source}", environment, ENVIRONMENTS))
    check_choice(f"quality in {source}", quality, QUALITIES)
    time = _check_shapes(family, tasks, states, actions, lengths, source)
    if states.ndim == 3:
        states, actions, lengths = (values[:, None] for values in (states, actions, lengths))
    steps = np.arange(time) < lengths[..., None]  # (task, path, time)
    kept = {}
    for field, values in (("states", states), ("actions", actions)):
        taken = np.where(steps[..., None], values, 0.0)
        _check_numbers(taken, LARGEST[field], f"{source}: {field}")
        kept[field] = torch.from_numpy(taken.astype(np.float32))
    with np.errstate(over="ignore"):  # no task is as large as that, as the environment will say
        tasks = tasks.astype(np.float32)
    try:
        family.check_tasks(torch.from_numpy(tasks))
    except InputError as error:
        raise InputError(f"{source}: tasks: {error}") from None
    return Demonstrations(
        tasks=torch.from_numpy(tasks),
        **kept,
        mask=torch.from_numpy(steps).float(),
        environment=environment,
        quality=quality,
        maker=str(maker),
        seed=int(seed),
    )


def _check_numbers(values: np.ndarray, largest: float, where: str) -> None:
    """Raise InputError, naming the place, unless all values are finite and at most ``largest``."""
    sizes = np.abs(values).max(-1)  # (task, path, time)
    wrong = ~(sizes <= largest)  # so that nan is wrong too
    if wrong.any():
        task, path, step = (int(index) for index in np.argwhere(wrong)[0])
        trouble = "a value that is not finite"
        if np.isfinite(sizes[task, path, step]):
            trouble = f"expected at most {largest:g} in size, got {sizes[task, path, step]:g}"
        which = f", path {path}" if sizes.shape[1] > 1 else ""
        raise InputError(f"{where}: {trouble}, task {task}{which}, step {step}")


def _check_shapes(
    family: Environment,
    tasks: np.ndarray,
    states: np.ndarray,
    actions: np.ndarray,
    lengths: np.ndarray,
    source: str,
) -> int:
    """Return the longest time if every array is numeric and fits the environment; else raise InputError."""
    if states.ndim not in (3, 4) or 0 in states.shape:
        raise InputError(
            f"{source}: states: expected (task, time, state), or (task, path, time, state), "
            f"got {states.shape}"
        )
    *paths, time = states.shape[:-1]  # task, or task and path
    expected = {
        "tasks": (tasks, (paths[0], family.task_dim)),
        "states": (states, (*paths, time, family.state_dim)),
        "actions": (actions, (*paths, time, family.action_dim)),
        "lengths": (lengths, tuple(paths)),
    }
    for field, (values, shape) in expected.items():
        if values.shape != shape:
            raise InputError(
                f"{source}: {field}: expected shape {shape} for {family.name}, got {values.shape}"
            )
        wanted, kinds = ("integer", "iu") if field == "lengths" else ("floating", "f")
        if values.dtype.kind not in kinds:  # a kind of its own: durations are integers to numpy
            raise InputError(
                f"{source}: {field}: expected {wanted} numbers, got dtype {values.dtype}"
            )
    wrong = (lengths < 1) | (lengths > time)
    if wrong.any():
        place = tuple(int(index) for index in np.argwhere(wrong)[0])
        which = f"task {place[0]}" + "".join(f", path {path}" for path in place[1:])
        raise InputError(
            f"{source}: lengths: expected 1 to {time} steps, got {int(lengths[place])} for {which}"
        )
    return time


def save(path: Path, demonstrations: Demonstrations) -> None:
    """Write the documented file, whole or not at all; the same data make the same bytes."""
    lengths = demonstrations.mask.sum(-1).long()  # (task, path)
    trajectories = (demonstrations.states, demonstrations.actions, lengths)
    if lengths.shape[1] == 1:  # the simpler file: no axis for paths
        trajectories = tuple(values[:, 0] for values in trajectories)
    states, actions, lengths = (values.numpy() for values in trajectories)
    archives.write_arrays(
        path,
        {
            "tasks": demonstrations.tasks.numpy(),
            "states": states,
            "actions": actions,
            "lengths": lengths,
            "environment": np.array(demonstrations.environment),
            "quality": np.array(demonstrations.quality),
            "maker": np.array(demonstrations.maker),
            "seed": np.array(demonstrations.seed),
        },
    )


def load(path: Path, environment: str | None = None) -> Demonstrations:
    """Read the documented file; with ``environment``, insist on it.

    Raises InputError for a file that is missing, damaged, foreign, or of another environment.
    """
    arrays = archives.read_arrays(path, "demonstration file", ARRAYS)
    for name in ("environment", "quality", "maker", "seed"):
        wanted = "iu" if name == "seed" else "U"
        if arrays[name].shape != () or arrays[name].dtype.kind not in wanted:
            expected = "one whole number" if name == "seed" else "one text"
            raise InputError(f"{path}: {name}: expected {expected}, got {shown(arrays[name])}")
    words = {name: str(arrays[name]) for name in ("environment", "quality", "maker")}
    if environment is not None and words["environment"] != environment:
        raise InputError(
            f"{path}: environment: expected {environment!r}, got {shown(words['environment'])}"
        )
    return from_arrays(
        *(arrays[name] for name in ("tasks", "states", "actions", "lengths")),
        **words,
        seed=int(arrays["seed"]),
        source=str(path),
    )


def load_demonstrations(source: str, environment: str) -> Demonstrations:
    """Return the demonstrations that ``optimal``, ``suboptimal`` or a file name stands for.

    The commands of the stored runs ran in the workbook's folder, so a relative name that leads nowhere from
    here is looked up there.
    """
    if source in QUALITIES:
        return load(SHIPPED / f"{environment}-{source}.npz", environment)
    if not source.endswith(".npz"):
        check_choice("demonstrations (a quality, or a file ending in .npz)", source, QUALITIES)
    path, in_the_workbook = Path(source), storage.DATA.parent / source
    if not path.exists() and in_the_workbook.exists():
        path = in_the_workbook
    return load(path, environment)
