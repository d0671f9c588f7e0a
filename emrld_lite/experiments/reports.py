"""What the command line prints and tabulates about a run and an evaluation."""

from __future__ import annotations

from pathlib import Path

import torch

from ..evaluate import AdaptationCurve
from ..learners import LARGE_KL, UNBOUNDED
from ..rollout import Rollout, episode_returns
from ..train import Iterate
from .runs import Run


def print_run(out: Path, run: Run, last: Iterate | None) -> None:
    """Print how the run went, and the last iteration's return on every training task."""
    if last is None:
        print(f"{out}: already complete, {len(run.curve)} iterations")
        return
    goals = run.load_demonstrations().tasks
    print(table("training tasks, last iteration", goals, last.before, last.after))
    record = run.curve[-1]
    notes = [row.note for row in run.curve if row.note]
    idle = [note for note in notes if not note.endswith(UNBOUNDED)]
    print(
        f"{out}: {len(run.curve)} iterations, {record.seconds:.1f} s, mean return "
        f"{record.return_before:.1f} before adaptation, {record.return_after:.1f} after; "
        f"{len(idle)} iterations without an update"
    )
    for note in sorted(set(idle)):
        print(f"  {idle.count(note)} x {note}")
    if large := len(notes) - len(idle):
        print(f"{large} iterations with a KL above {LARGE_KL:g} nats: {UNBOUNDED}")
    if "log_sigma" in run.meta_params:
        sigma = run.meta_params["log_sigma"].exp()
        print(f"sigma {sigma.min():.2g} to {sigma.max():.2g} at the end, 1 at the beginning")


def table(title: str, tasks: torch.Tensor, before: Rollout, after: Rollout) -> str:
    """Return a text table, a row per task: return before and after adaptation, and success after."""
    lines = [f"{title:>30} {'before':>9} {'after':>9} {'success':>9}"]
    returns = (episode_returns(before).mean(-1), episode_returns(after).mean(-1))
    success = after.success.float().mean(-1)
    for task in range(len(tasks)):
        name = f"{task}  {task_label(tasks[task])}"
        lines.append(
            f"{name:>30} {returns[0][task]:9.1f} {returns[1][task]:9.1f} {success[task]:9.2f}"
        )
    means = " ".join(f"{values.mean():9.1f}" for values in returns)
    lines.append(f"{'mean':>30} {means} {success.mean():9.2f}")
    return "\n".join(lines)


def task_label(task: torch.Tensor) -> str:
    """Return a task's numbers as text."""
    return "(" + ", ".join(f"{value:.2f}" for value in task.tolist()) + ")"


def print_evaluation(stored: Run, curve: AdaptationCurve, tasks: torch.Tensor) -> None:
    """Print the unseen tasks' returns before and after one step, and the mean after each step."""
    if len(curve.rollouts) > 1:
        print(table("unseen tasks, one step", tasks, curve.rollouts[0], curve.rollouts[1]))
    for step, rollout in enumerate(curve.rollouts):
        returns = episode_returns(rollout).mean(-1)
        print(
            f"after {step} steps: mean return {returns.mean():.1f} (tasks {returns.min():.1f} to "
            f"{returns.max():.1f}), success {rollout.success.float().mean():.2f}"
        )
    if stored.curve:
        trained = stored.curve[-1].return_after
        print(f"training tasks, last iteration: mean return {trained:.1f} after one step")
