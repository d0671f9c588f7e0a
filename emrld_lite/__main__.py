"""The command line: ``python -m emrld_lite --help``."""

from __future__ import annotations

import contextlib
import functools
import io
import re
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from types import FrameType
from typing import Any

DESCRIPTION = """EMRLD: meta reinforcement learning with demonstrations.

demos makes demonstrations, train meta-trains on them and stores the run, evaluate adapts a stored
run to unseen tasks, sweep makes the runs of a grid, figures draws the stored runs, bench measures
the cost, lottery trains under other seeds and as on other processors; robot-node simulates a
TurtleBot on ROS, robot-drive drives it, or a real one, and robot-study drives it with every stored
run. Every command explains its options with --help."""
REFUSED = 2
INTERRUPTED, TERMINATED = 130, 143  # a shell's exit codes for Ctrl-C and for kill
NO_MEMORY = "allocate memory"  # in what torch says where there is none left


def main(arguments: list[str] | None = None) -> None:
    """Run the command line.

    A refused input, an unwritable file or want of memory exits with 2 and one line on stderr;
    Ctrl-C and ``kill`` exit with their codes and a line that says how to go on.
    """
    with _exit_codes():
        # the heavy imports last seconds, in which Ctrl-C and kill must be heard too
        from .experiments import commands  # noqa: PLC0415

        if hasattr(sys.stdout, "reconfigure"):  # a file's name need not be printable
            sys.stdout.reconfigure(errors="backslashreplace")
        _parse(commands.COMMANDS, arguments)()


@contextlib.contextmanager
def _exit_codes() -> Iterator[None]:
    """Turn what may stop a command into its exit code and one line on stderr."""
    stopped_by = INTERRUPTED

    def terminate(number: int, frame: FrameType | None) -> None:
        nonlocal stopped_by
        stopped_by = TERMINATED
        raise KeyboardInterrupt

    in_charge = threading.current_thread() is threading.main_thread()
    before = signal.signal(signal.SIGTERM, terminate) if in_charge else None
    try:
        from .validation import InputError  # heavy: it loads torch  # noqa: PLC0415

        yield
    except KeyboardInterrupt as stop:  # first: InputError may not be there yet
        _leave(stopped_by, "; ".join(["stopped", *map(str, stop.args)]))
    except (InputError, OSError, MemoryError) as error:
        _leave(REFUSED, f"error: {error or 'not enough memory'}")
    except RuntimeError as error:
        if NO_MEMORY not in str(error):
            raise
        _leave(REFUSED, f"error: not enough memory: {error}")
    finally:
        if in_charge:
            signal.signal(signal.SIGTERM, before)


def _leave(code: int, message: str) -> None:
    """Print one line on stderr and exit."""
    print(" ".join(message.split()), file=sys.stderr)
    sys.exit(code)


def _parse(
    commands: tuple[Callable[..., None], ...], arguments: list[str] | None
) -> Callable[[], None]:
    """Return the command that ``arguments`` ask for, with its options; wrong ones raise InputError."""
    import tyro  # noqa: PLC0415

    from .validation import InputError  # noqa: PLC0415

    def asked(command: Callable[..., None]) -> Callable[..., Any]:
        @functools.wraps(command)
        def later(*values: Any, **options: Any) -> Callable[[], None]:
            return functools.partial(command, *values, **options)

        return later

    said = io.StringIO()
    try:
        with contextlib.redirect_stderr(said):
            return tyro.extras.subcommand_cli_from_dict(
                {command.__name__.replace("_", "-"): asked(command) for command in commands},
                prog="python -m emrld_lite",
                description=DESCRIPTION,
                args=arguments,
                config=(tyro.conf.FlagCreatePairsOff,),
            )
    except SystemExit as stop:
        if stop.code != REFUSED:
            raise
        raise InputError(_unboxed(said.getvalue())) from None


def _unboxed(text: str) -> str:
    """Return what tyro says in a box without the box, its title and its own names."""
    lines = [line for line in text.splitlines() if not line.startswith(("\u256d", "\u2570"))]
    plain = re.sub("[\u2500-\u257f]+", " ", " ".join(lines))
    return re.sub(r"Error parsing __tyro-dummy-inner__[\w.]*: ", "", plain)


if __name__ == "__main__":
    main()
