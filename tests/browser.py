"""A real browser for the tests: Debian's Chromium, or another, driven by Playwright, without network."""

from __future__ import annotations

import functools
import importlib.util
import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import pytest

if TYPE_CHECKING:
    from playwright.sync_api import Browser, BrowserContext, Page

PICTURES = Path(__file__).resolve().parent.parent / "build/browser"
PROGRAMS = ("chromium", "google-chrome", "google-chrome-stable")
PACKAGES = ("playwright", "axe_playwright_python")
PATIENCE = 60_000  # milliseconds, for whatever should come at once: machines are slow and shared
LEVELS = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa"]  # axe-core's names of A and AA


def program() -> str | None:
    """Return the browser to start: the one that EMRLD_BROWSER names, or the first that is installed."""
    named = [name] if (name := os.environ.get("EMRLD_BROWSER")) else PROGRAMS
    return next(filter(None, map(shutil.which, named)), None)


@functools.cache
def missing() -> str:
    """Return what keeps the browser tests from running and how to get it, or nothing."""
    if absent := [name for name in PACKAGES if importlib.util.find_spec(name) is None]:
        return f"NO BROWSER TEST WAS RUN: {' and '.join(absent)} cannot be imported; make setup"
    if program() is None:
        return (
            "NO BROWSER TEST WAS RUN: no Chromium or Chrome was found; on Debian"
            " `apt-get install chromium`, elsewhere let EMRLD_BROWSER name the program"
        )
    return ""


needed = pytest.mark.skipif(bool(missing()), reason=missing())


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Say aloud at the end, once, that no browser test was run and why."""
    skipped = terminalreporter.stats.get("skipped", [])
    if missing() and any(missing() in str(report.longrepr) for report in skipped):
        terminalreporter.write_line(missing(), yellow=True, bold=True)


class Seen(NamedTuple):
    """A page of the browser, and what it asked for or complained of while it was open."""

    page: Page
    requests: list[str]
    errors: list[str]

    def picture(self, name: str, **options) -> None:
        """Keep a picture of the window as build/browser/NAME.png."""
        self.page.screenshot(path=PICTURES / f"{name}.png", **options)


def watched(context: BrowserContext) -> Seen:
    """Return a new page of a context, watched from its first request on."""
    seen = Seen(context.new_page(), [], [])
    seen.page.set_default_timeout(PATIENCE)
    seen.page.on("request", lambda request: seen.requests.append(request.url))
    seen.page.on("pageerror", lambda error: seen.errors.append(str(error)))
    seen.page.on(
        "console",
        lambda message: message.type == "error" and seen.errors.append(message.text),
    )
    return seen


def violations(page: Page) -> list[str]:
    """Return what on a page breaks axe-core's rules of levels A and AA, one line per rule."""
    from axe_playwright_python.sync_playwright import Axe  # noqa: PLC0415 - may be missing

    options = {"runOnly": {"type": "tag", "values": LEVELS}, "resultTypes": ["violations"]}
    found = Axe().run(page, options=options).response["violations"]
    return [
        f"{rule['id']}: {rule['help']}: {[node['target'] for node in rule['nodes'][:5]]}"
        for rule in found
    ]


@pytest.fixture(scope="module")
def chromium() -> Iterator[Browser]:
    """Start the browser for the tests of one file, and stop it: its event loop is in others' way."""
    from playwright.sync_api import expect, sync_playwright  # noqa: PLC0415 - may be missing

    expect.set_options(timeout=PATIENCE)
    PICTURES.mkdir(parents=True, exist_ok=True)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program(), timeout=PATIENCE)
        yield browser
        browser.close()
