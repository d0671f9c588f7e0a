"""A look at the master twice a second: whether it is there, and who else publishes the commands."""

from __future__ import annotations

import threading
import time

from .errors import RobotError, TwoDrivers
from .ros import ask, master_uri

EVERY = 0.5  # seconds between two looks


class Watch:
    """Looks in a thread of its own, so that a slow network delays no control step.

    ``check`` raises MasterGone once no look has succeeded for ``patience`` seconds, and TwoDrivers
    while another living node publishes ``topic``. Without a topic only the master is looked after.
    """

    def __init__(self, own_name: str, topic: str | None, patience: float) -> None:
        self._own_name, self._topic, self._patience = own_name, topic, patience
        self._failing_since: float | None = None
        self._failure: RobotError | None = None
        self._others: list[str] = []
        self._closed = threading.Event()
        self._look()
        self.check()
        self._thread = threading.Thread(target=self._run, name="ros watch", daemon=True)
        self._thread.start()

    def check(self) -> None:
        """Raise what the last looks have found."""
        since, failure = self._failing_since, self._failure
        if since is not None and failure is not None:
            gone = time.monotonic() - since
            if gone >= self._patience:
                raise type(failure)(f"for {gone:.1f} s {failure}")
        if others := self._others:
            raise TwoDrivers(
                f"{self._topic}: expected no other publisher, found {', '.join(others)}; stop it, "
                "since two drivers would take turns at the wheels"
            )

    def close(self) -> None:
        """Stop looking."""
        self._closed.set()

    def _run(self) -> None:
        while not self._closed.wait(EVERY):
            self._look()

    def _look(self) -> None:
        try:
            self._others = [] if self._topic is None else self._other_publishers()
            if self._topic is None:
                ask(master_uri(), "getPid")
        except RobotError as error:
            self._failure = error
            if self._failing_since is None:
                self._failing_since = time.monotonic()
        else:
            self._failing_since = self._failure = None

    def _other_publishers(self) -> list[str]:
        """Return the living nodes, other than this one, that publish the topic."""
        publishers, _, _ = ask(master_uri(), "getSystemState")
        nodes = {node for topic, names in publishers if topic == self._topic for node in names}
        return sorted(node for node in nodes - {self._own_name} if self._lives(node))

    def _lives(self, node: str) -> bool:
        """Return whether a node answers; one that was killed stays in the master's books."""
        try:
            ask(ask(master_uri(), "lookupNode", node), "getPid")
        except RobotError:
            return False
        return True
