"""ROS 1, where it is installed: its modules, a master that answers, and this process as a node.

Debian's packages lie outside a virtual environment; their folder is appended to Python's path, behind
everything that is installed here.
"""

from __future__ import annotations

import atexit
import functools
import http.client
import logging
import os
import sys
import xmlrpc.client
from pathlib import Path
from typing import Any, NamedTuple

from .errors import MasterGone, RobotError, RosMissing

DEBIAN = Path("/usr/lib/python3/dist-packages")
PACKAGES = "python3-rospy python3-rosmaster python3-nav-msgs python3-geometry-msgs"
DEFAULT_MASTER = "http://localhost:11311"
ANSWER = 2.0  # seconds that a master or a node may take to answer


class Ros(NamedTuple):
    """What of ROS is used here."""

    rospy: Any
    Odometry: Any
    Twist: Any


@functools.cache
def find_ros() -> Ros:
    """Return the modules of ROS 1; raises RosMissing, which says what to install."""
    try:
        return _import_ros()
    except ModuleNotFoundError as error:
        missing = error
    if DEBIAN.is_dir() and str(DEBIAN) not in sys.path:
        sys.path.append(str(DEBIAN))
        try:
            return _import_ros()
        except ModuleNotFoundError as error:
            missing = error
            sys.path.remove(str(DEBIAN))
    raise RosMissing(
        f"driving over ROS needs ROS 1, and its module {missing.name} is not here. On Debian 12: "
        f"apt-get install {PACKAGES}; elsewhere see environment.md. Everything else works without it"
    )


def _import_ros() -> Ros:
    usual = logging.getLoggerClass()
    try:
        import rospy  # noqa: PLC0415
        from geometry_msgs.msg import Twist  # noqa: PLC0415
        from nav_msgs.msg import Odometry  # noqa: PLC0415
    finally:
        logging.setLoggerClass(usual)  # ROS sets its own, for all loggers of the program
    return Ros(rospy, Odometry, Twist)


def join(name: str) -> Ros:
    """Make this process a ROS node, once; raises MasterGone where no master answers.

    Neither the signal handlers nor the logging of the program are touched.
    """
    ros = find_ros()
    if ros.rospy.core.is_shutdown_requested():
        raise RobotError("this program has left ROS, which takes it only once: start it anew")
    if not ros.rospy.core.is_initialized():
        ask(master_uri(), "getPid")  # without a master, init_node would wait for ever
        ros.rospy.core.configure_logging = lambda *_: (
            None
        )  # else it redirects all logging to a file
        ros.rospy.init_node(name, argv=sys.argv[:1], anonymous=True, disable_signals=True)
        atexit.register(ros.rospy.signal_shutdown, "the program ends")
    return ros


def master_uri() -> str:
    """Return the address of the master."""
    return os.environ.get("ROS_MASTER_URI", DEFAULT_MASTER)


class _Patient(xmlrpc.client.Transport):
    """A connection that gives up; the standard library's waits for ever."""

    def make_connection(self, host: Any) -> http.client.HTTPConnection:
        connection = super().make_connection(host)
        connection.timeout = ANSWER
        return connection


def ask(uri: str, method: str, *arguments: Any) -> Any:
    """Return what the master, or a node, at ``uri`` answers; raises MasterGone where none does."""
    try:
        with xmlrpc.client.ServerProxy(uri, _Patient()) as server:
            code, said, answer = getattr(server, method)("/emrld_lite", *arguments)
    except (OSError, http.client.HTTPException, xmlrpc.client.Error, ValueError) as error:
        raise MasterGone(
            f"no ROS master answers at {uri} ({error}): start one with rosmaster --core, or roscore, "
            "and let ROS_MASTER_URI name it"
        ) from error
    if code != 1:
        raise RobotError(f"{uri}: {method} failed: {said}")
    return answer
