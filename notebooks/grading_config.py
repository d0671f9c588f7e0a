"""The course folder's settings for nbgrader; notebooks/handout.py copies them there once."""

import os
import sys
from pathlib import Path

import emrld_lite

# nbgrader starts a program that lies beside Python, and looks for it as a shell would.
os.environ["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
sys.path.insert(0, str(Path(emrld_lite.__file__).resolve().parent.parent / "notebooks"))

from nbgrader.converters import Autograde, GenerateFeedback
from nbgrader.preprocessors import Execute, OverwriteCells

from build import BLANK
from grading import ExecuteNeeded, KeepHidden, PutBack

c = get_config()  # noqa: F821 - nbgrader gives this function to its settings

c.CourseDirectory.course_id = "emrld"
c.CourseDirectory.root = str(Path(__file__).resolve().parent)

c.ClearSolutions.code_stub = {"python": BLANK}
# Students may play with every cell: grading puts back the given ones and the grade cells.
c.LockCells.lock_readonly_cells = False
c.OverwriteCells.add_missing_cells = True
c.Autograde.sanitize_preprocessors = [
    PutBack if step is OverwriteCells else step
    for step in Autograde.sanitize_preprocessors.default_args[0]
]

# What no mark depends on is not run. For the whole notebook, minutes each, leave this line out.
c.Autograde.autograde_preprocessors = [
    ExecuteNeeded if step is Execute else step
    for step in Autograde.autograde_preprocessors.default_args[0]
]
c.Execute.timeout = 300  # seconds for a cell; an endless answer is ended by its check, after ten
# nbgrader takes a warning of a right answer for a failure, unless it is taken out first.
c.IgnorePattern.enabled = True
c.IgnorePattern.pattern = "(?s).*"
# The marks are read first, then hidden tests go: feedback shows cells and how they stopped.
c.GenerateFeedback.preprocessors = [
    *GenerateFeedback.preprocessors.default_args[0],
    KeepHidden,
]
