"""Small problems that the tests share."""

import subprocess
import sys
from pathlib import Path

import jaxtyping
import matplotlib.pyplot as plt
import numpy as np
import pytest
import torch
from filelock import FileLock

from emrld_lite import demonstrations, policy
from emrld_lite.envs import make
from emrld_lite.rollout import Rollout

BOOK = Path(__file__).resolve().parent.parent / "notebooks/book.py"


@pytest.fixture(autouse=True)
def closed_figures():
    """Leave no figure of a test open for the next one."""
    yield
    plt.close("all")


def without_time(curve):
    """Return the records of a curve without the one field that no two runs share."""
    return [record._replace(seconds=0.0) for record in curve]


def random_params(seed, tasks=None, dtype=torch.float64, hidden=(5, 4), state_dim=2, action_dim=2):
    """Return small random parameters, one set or one per task, with biases and sigmas that differ."""
    random = torch.Generator().manual_seed(seed)
    params = policy.initialise(state_dim, action_dim, seed, hidden)
    leading = () if tasks is None else (tasks,)
    return {
        name: (value + 0.3 * torch.randn(*leading, *value.shape, generator=random)).to(dtype)
        for name, value in params.items()
    }


def random_rollout(seed, tasks=3, episodes=4, horizon=6, dtype=torch.float64):
    """Return a rollout of random numbers with ragged episodes, advantages included."""
    random = torch.Generator().manual_seed(seed)

    def normal(*shape):
        return torch.randn(*shape, generator=random).to(dtype)

    lengths = torch.randint(1, horizon + 1, (tasks, episodes), generator=random)
    lengths[0, 0] = horizon
    mask = (torch.arange(horizon) < lengths[..., None]).to(dtype)
    return Rollout(
        states=normal(tasks, episodes, horizon, 2) * mask[..., None],
        actions=normal(tasks, episodes, horizon, 2) * mask[..., None],
        rewards=normal(tasks, episodes, horizon) * mask,
        mask=mask,
        success=torch.zeros(tasks, episodes, dtype=torch.bool),
        advantages=normal(tasks, episodes, horizon) * mask,
    )


def random_demonstrations(seed, tasks=3, longest=5, dtype=torch.float64, quality="optimal"):
    """Return valid Point2D demonstrations of random states and actions with ragged lengths."""
    random = np.random.default_rng(seed)
    lengths = random.integers(1, longest + 1, tasks)
    lengths[0] = longest
    made = demonstrations.from_arrays(
        make("point2d").sample_tasks(tasks, random).numpy(),
        random.normal(size=(tasks, longest, 2)),
        random.normal(size=(tasks, longest, 2)),
        lengths,
        environment="point2d",
        quality=quality,
    )
    return made.map(lambda values: values.to(dtype))


@pytest.fixture(scope="session")
def book(tmp_path_factory, worker_id):
    """Return the folder of a book made from the committed notebooks, once for all who test it."""
    shared = tmp_path_factory.getbasetemp()
    if worker_id != "master":  # pytest-xdist gives each worker a folder in the shared one
        shared = shared.parent
    with FileLock(shared / "book.lock"):
        if not (shared / "book").exists():
            command = [sys.executable, BOOK, "--out", shared / "book"]
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return shared / "book"


@pytest.fixture
def shapes_unchecked():
    """Let wrong types through to the package, whose own refusals are then what is tested."""
    jaxtyping.config.update("jaxtyping_disable", True)
    yield
    jaxtyping.config.update("jaxtyping_disable", False)


@pytest.fixture(autouse=True)
def one_thread():
    """Run every test on one thread: small problems, and the same sums in the same order."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)
