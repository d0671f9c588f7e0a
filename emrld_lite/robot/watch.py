"""A look at the master twice a second: whether it is there, and whether two publish what one should."""

from __future__ import annotations

import threading
import time

from .errors import RobotError, TwoDrivers, TwoRobots
from .ros import ask, master_uri

EVERY = 0.5  # seconds between two looks


class Watch:
    """Looks in a thread of its own, so that a slow network delays no control step.

    ``check`` raises MasterGone once no look has succeeded for ``patience`` seconds; while another
    living node publishes ``commands``, TwoDrivers, and while several publish ``odometry``, TwoRobots.
    Without topics only the master is looked after.
    """

    def __init__(
        self,
        own_name: str,
        patience: float,
        commands: str | None = None,
        odometry: str | None = None,
    ) -> None:
        self._own_name, self._patience = own_name, patience
        self._commands, self._odometry = commands, odometry
        self._failure: tuple[float, RobotError] | None = None  # since when, and the latest
        self._clash: RobotError | None = None
        self._closed = threading.Event()
        self._look()
        self.check()
        threading.Thread(target=self._run, name="ros watch", daemon=True).start()

    def check(self) -> None:
        """Raise what the last looks have found."""
        if failure := self._failure:
            gone = time.monotonic() - failure[0]
            if gone >= self._patience:
                raise type(failure[1])(f"for {gone:.1f} s {failure[1]}")
        if clash := self._clash:
            raise type(clash)(str(clash))

    def close(self) -> None:
        """Stop looking."""
        self._closed.set()

    def _run(self) -> None:
        while not self._closed.wait(EVERY):
            self._look()

    def _look(self) -> None:
        try:
            self._clash = self._find_clash(ask(master_uri(), "getSystemState")[0])
            self._failure = None
        except RobotError as error:
            since = time.monotonic() if self._failure is None else self._failure[0]
            self._failure = (since, error)

    def _find_clash(self, publishers: list[tuple[str, list[str]]]) -> RobotError | None:
        """Return the error of two publishers where there should be one."""
        nodes = {topic: set(names) for topic, names in publishers}
        others = self._living(nodes.get(self._commands, set()) - {self._own_name})
        if others:
            return TwoDrivers(
                f"{self._commands}: expected no other publisher, found {', '.join(others)}; stop it, "
                "since two drivers would take turns at the wheels"
            )
        robots = nodes.get(self._odometry, set())
        robots = self._living(robots) if len(robots) > 1 else []
        if len(robots) > 1:
            return TwoRobots(f"{self._odometry}: expected one robot, found {', '.join(robots)}")
        return None

    def _living(self, nodes: set[str]) -> list[str]:
        """Return the nodes that answer; one that was killed stays in the master's books."""
        return sorted(node for node in nodes if self._lives(node))

    def _lives(self, node: str) -> bool:
        try:
            ask(ask(master_uri(), "lookupNode", node), "getPid")
        except RobotError:
            return False
        return True
