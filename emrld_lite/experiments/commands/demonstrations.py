"""The command that makes demonstrations."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from tqdm import tqdm

from ... import demonstrations as demonstration_files
from ...config import EnvironmentName
from ...demonstrations import QualityName
from ...demonstrators import recipes
from ...demonstrators.expert import ExpertConfig, expert_config, save_expert
from ...envs import Environment, make
from ...envs.base import Tasks
from ...limits import check_memory, readable_bytes
from ...policy import Params
from ...storage import check_target
from ...validation import InputError, ends_in, positive_count, real_number, seed_number
from .. import budget, machine

LARGEST_NOISE = 10.0  # in units of the action's range, which is 2 wide


def demos(
    env: EnvironmentName,
    quality: QualityName,
    out: Path,
    seed: int = 0,
    expert_out: Path | None = None,
    threads: int = 1,
    tasks: int | None = None,
    noise: float | None = None,
    stop_at_success: float | None = None,
    largest_drift: float | None = None,
    paths: int = 1,
    cut: tuple[float, ...] = (),
) -> None:
    """Make demonstrations with a goal-conditioned expert, one per task; by default train it anew.

    Args:
        env: environment of the tasks
        quality: optimal, or suboptimal (partly trained, noisy, beginning or end cut off)
        out: demonstration file to write, .npz
        seed: seed of the expert and of the demonstrations
        expert_out: where to keep the expert's policy too, .safetensors
        threads: CPU threads; the same number makes the same bytes
        tasks: let the workbook's own expert demonstrate so many tasks drawn at random
        noise: standard deviation of the noise added to each action, in place of the quality's own
        stop_at_success: train the expert until it reaches so many of its goals (0 to 1), in place of the
            quality's own share
        largest_drift: let the workbook's own expert demonstrate training tasks that drift less
        paths: let the workbook's own expert show each task so often; noise alone tells them apart
        cut: let the workbook's own expert demonstrate, and cut each number of an action to this size (a size
            per number, 1 or more, inf for none)
    """
    machine.use_threads(threads)
    positive_count("paths", paths)
    config = expert_config(env, seed_number("seed", seed))
    recipe = recipes.recipe_for(env, quality)
    if noise is not None:
        recipe = replace(recipe, action_noise=real_number("noise", noise, 0.0, LARGEST_NOISE))
    if stop_at_success is not None:
        share = real_number("stop_at_success", stop_at_success, 0.0, 1.0)
        recipe = replace(recipe, success_at_stop=share)
    recipe = replace(recipe, cut=cut)
    world = make(env, **({} if largest_drift is None else {"largest_drift": largest_drift}))
    ends_in("out", check_target("out", out), ".npz")
    if tasks is not None or largest_drift is not None or paths > 1 or cut:
        for name, given in (("expert_out", expert_out), ("stop_at_success", stop_at_success)):
            if given is not None:
                raise InputError(
                    f"{name}: expected none with --tasks, --largest-drift, --paths or --cut, which train no "
                    "expert"
                )
        wanted = (
            world.training_tasks() if tasks is None else _drawn_tasks(world, tasks, seed, paths)
        )
        expert = recipes.load_or_train_expert(env, quality)
    else:
        if expert_out is not None:
            ends_in("expert_out", check_target("expert_out", expert_out), ".safetensors")
        wanted, expert = world.training_tasks(), _train_expert(config, quality, recipe)
    made = recipes.demonstrate(expert, env, wanted, quality, seed, recipe, paths)
    demonstration_files.save(out, made)
    if expert_out is not None:
        save_expert(expert_out, expert, config, quality)
    many = f" of {paths} trajectories each" if paths > 1 else ""
    print(f"{out}: {len(wanted)} {quality} demonstrations{many}. {made.maker}")


def _drawn_tasks(world: Environment, tasks: int, seed: int, paths: int) -> Tasks:
    """Return ``tasks`` test tasks; says so where their demonstrations will take much memory."""
    needed = budget.rollout_memory(world, positive_count("tasks", tasks), paths)
    check_memory(f"tasks: demonstrations of {tasks} tasks", needed)
    if needed > budget.NOTEWORTHY_BYTES:
        print(f"{tasks} demonstrations: about {readable_bytes(needed)} of memory", flush=True)
    return world.test_tasks(tasks, np.random.default_rng(seed))


def _train_expert(config: ExpertConfig, quality: str, recipe: recipes.Recipe) -> Params:
    """Return the policy of a newly trained expert, with a bar that shows its progress."""
    with tqdm(total=config.iterations, unit="iteration", desc=f"{config.env} {quality}") as bar:
        for iterate in recipes.train_to_quality(config, quality, recipe):
            bar.set_postfix_str(f"success {iterate.success:.2f}")
            bar.update()
    return iterate.params
