"""The course folder's settings for nbgrader; notebooks/handout.py copies them there once."""

import os
import sys
from pathlib import Path

import emrld_lite

# nbgrader starts a program that lies beside Python, and looks for it as a shell would.
os.environ["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
sys.path.insert(0, str(Path(emrld_lite.__file__).resolve().parent.parent / "notebooks"))

from build import BLANK, CELL_TIMEOUT
from grading import ExecuteNeeded
from nbgrader.converters import Autograde
from nbgrader.preprocessors import Execute

c = get_config()  # noqa: F821 - nbgrader gives this function to its settings

c.CourseDirectory.course_id = "emrld"
c.CourseDirectory.root = str(Path(__file__).resolve().parent)

c.ClearSolutions.code_stub = {"python": BLANK}
# Students may play with every cell: grading puts back the given ones, and a grade cell that is gone.
c.LockCells.lock_readonly_cells = False
c.OverwriteCells.add_missing_cells = True

# What no mark depends on is not run. For the whole notebook, minutes each, leave this line out.
c.Autograde.autograde_preprocessors = [
    ExecuteNeeded if step is Execute else step
    for step in Autograde.autograde_preprocessors.default_args[0]
]
c.Execute.timeout = CELL_TIMEOUT  # seconds for a cell; a check ends an endless answer after ten
# nbgrader takes a warning of a right answer for a failure, unless it is taken out first.
c.IgnorePattern.enabled = True
c.IgnorePattern.pattern = "(?s).*"
