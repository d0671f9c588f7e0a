"""JupyterLab as a user meets it: a server of one's own, a notebook in the browser, its cells run."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import nbformat
from jupyter_server.serverapp import list_running_servers

from . import browser

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Locator

TOKEN = "only-for-this-test"
START = 120  # seconds that a server or a kernel may take
RUN = 600_000  # milliseconds that the cells of a notebook may take
# The status bar's words. The notebook's own indicator says "idle" before it has a kernel, too, and
# cells that are run then are lost: JupyterLab forgets them, or asks for a kernel.
CONNECTED = re.compile(r" \| Idle$")
SETTINGS = {
    "@jupyterlab/apputils-extension:notification": {"fetchNews": "false", "checkForUpdates": False}
}


@contextmanager
def server(folder: Path, home: Path) -> Iterator[str]:
    """Serve a folder on the loopback, whatever the settings of the user; hand out the address."""
    (home / "config/labconfig").mkdir(parents=True)
    overrides = home / "config/labconfig/default_setting_overrides.json"
    overrides.write_text(json.dumps(SETTINGS))
    folders = {
        "HOME": home,
        "IPYTHONDIR": home / "ipython",
        "JUPYTER_CONFIG_DIR": home / "config",
        "JUPYTER_DATA_DIR": home / "data",
        "JUPYTER_RUNTIME_DIR": home / "runtime",
        "JUPYTERLAB_SETTINGS_DIR": home / "settings",
        "JUPYTERLAB_WORKSPACES_DIR": home / "workspaces",
    }
    command = [sys.executable, "-m", "jupyterlab", "--no-browser", "--allow-root"]
    command += ["--ServerApp.ip=127.0.0.1", "--ServerApp.port=0", f"--ServerApp.root_dir={folder}"]
    variables = os.environ | {name: str(path) for name, path in folders.items()}
    with (home / "log").open("w") as log:
        process = subprocess.Popen(
            command, env=variables | {"JUPYTER_TOKEN": TOKEN}, stdout=log, stderr=log
        )
    try:
        yield address(process, home)
    finally:
        process.terminate()  # shuts the kernels down too
        process.wait(START)


def address(process: subprocess.Popen, home: Path) -> str:
    """Return where the server listens, as soon as it does."""
    deadline = time.monotonic() + START
    while not (found := list(list_running_servers(str(home / "runtime")))):
        if process.poll() is not None or time.monotonic() > deadline:
            raise AssertionError(f"JupyterLab did not start:\n{(home / 'log').read_text()}")
        time.sleep(0.1)
    return found[0]["url"]


class Lab:
    """One notebook in JupyterLab, on a new page of the browser."""

    def __init__(self, chromium: Browser, url: str, path: Path) -> None:
        """Open a notebook that lies in the server's folder; return when its cells and kernel are there."""
        from playwright.sync_api import expect  # noqa: PLC0415 - may be missing

        self.expect, self.path = expect, path
        self.context = chromium.new_context(viewport={"width": 1400, "height": 900})
        self.seen = browser.watched(self.context)
        self.page = self.seen.page
        self.page.goto(f"{url}lab/tree/{path.name}?reset&token={TOKEN}")
        self.cells = self.page.locator(".jp-Notebook .jp-Cell")
        self.idle = self.page.locator('.jp-Notebook-ExecutionIndicator[data-status="idle"]')
        outputs = self.page.locator(".jp-OutputArea-output")
        self.failures = outputs.filter(has_text="Traceback (most recent call last)")
        expect(self.cells).to_have_count(len(self.saved().cells))
        expect(self.page.get_by_role("button", name=CONNECTED)).to_be_visible(timeout=START * 1000)

    def saved(self) -> nbformat.NotebookNode:
        """Return the notebook as it lies in the folder."""
        return nbformat.read(self.path, as_version=4)

    def choose(self, entry: str) -> None:
        """Choose an entry of the Run menu."""
        self.page.get_by_role("menuitem", name="Run", exact=True).click()
        self.page.get_by_role("menuitem", name=entry, exact=True).click()

    def run_all(self) -> None:
        """Run every cell and wait for the last, or for the first that fails."""
        self.choose("Run All Cells")
        codes = self.page.locator(".jp-Notebook .jp-CodeCell")
        self.wait_for(codes.last)

    def run(self, cell: Locator, text: str | None = None) -> None:
        """Click into a cell of code, write a text in place of its own, run it and wait for its end."""
        before = self.prompt(cell).text_content()
        cell.locator(".cm-content").click()
        if text is not None:
            self.page.keyboard.press("ControlOrMeta+a")
            self.page.keyboard.insert_text(text)
        self.page.keyboard.press("Shift+Enter")
        self.wait_for(cell, before)

    def prompt(self, cell: Locator) -> Locator:
        """Return the number in front of a cell of code, which tells whether it has run."""
        return cell.locator(".jp-InputArea .jp-InputPrompt")

    def wait_for(self, cell: Locator, before: str = "[ ]:") -> None:
        """Wait until a cell has run and the kernel has nothing more to do, or a cell has failed."""
        run = re.compile(rf"^(?!{re.escape(before)})\[\d+\]:$")
        ended = self.prompt(cell).filter(has_text=run).or_(self.failures)
        self.expect(ended.first).to_be_attached(timeout=RUN)
        self.expect(self.idle).to_be_visible()

    def save(self) -> None:
        """Save the notebook and wait until it lies in the folder."""
        self.page.keyboard.press("ControlOrMeta+s")
        self.expect(self.page.locator(".lm-DockPanel-tabBar .jp-mod-dirty")).to_have_count(0)
