"""The book in a real browser, from a folder and without network: whole, legible, open to everyone."""

import re
from contextlib import contextmanager
from pathlib import Path

import pytest

from . import browser

NOTEBOOKS = Path(__file__).resolve().parent.parent / "notebooks"
STEMS = sorted(path.stem for path in NOTEBOOKS.glob("[0-9][0-9]_*.py"))
PHONE, LAPTOP, DESK = 375, 1000, 1440  # widths of windows, pixels
PAPER = 658  # pixels between the margins of an A4 page
HEIGHT = 900
UNFOLD = "document.querySelectorAll('details').forEach(one => one.open = true)"
# A formula is hundreds of boxes of one colour, a cell of code a hundred words of ten colours: axe-core
# would look at each for minutes. It sees a letter as large as the formula, and each colour once.
SHORTEN = """() => {
  window.whole = document.body.cloneNode(true);
  for (const formula of document.querySelectorAll(".katex")) {
    const box = formula.getBoundingClientRect();
    const width = Math.max(box.width, formula.scrollWidth);
    formula.textContent = "x";
    formula.style.cssText = `display: inline-block; width: ${width}px; height: ${box.height}px`;
  }
  const met = new Set();
  for (const word of document.querySelectorAll(".highlight span")) {
    if (met.has(word.className)) word.replaceWith(...word.childNodes);
    met.add(word.className);
  }
  document.body.normalize();
}"""
PROSE = """main => [main, ...main.querySelectorAll("*")].filter(one => !one.closest("pre, code, .katex"))
  .flatMap(one => [...one.childNodes]).filter(node => node.nodeType === Node.TEXT_NODE)
  .map(node => node.data).join(" ")"""
FAULTY = """<!DOCTYPE html><html lang="en"><title>Faulty</title>
<p style="color: #999999; width: 3000px">A pale and endless line</p>
<img src="https://example.org/picture.png">
<main>An unset formula, $\\theta$</main>"""
pytestmark = browser.needed


@pytest.fixture(scope="module")
def offline(chromium):
    """Return a context of the browser that has no network."""
    context = chromium.new_context(viewport={"width": DESK, "height": HEIGHT})
    context.set_offline(True)
    yield context
    context.close()


@contextmanager
def opened(context, path, query=""):
    """Hand out a page opened from a file, its scripts run and its fonts loaded; close it."""
    seen = browser.watched(context)
    seen.page.goto(path.as_uri() + query)
    seen.page.evaluate("document.fonts.ready.then(() => {})")
    yield seen
    seen.page.close()


@pytest.fixture(scope="module", params=["index", "search", *STEMS])
def seen(request, offline, book):
    """Return one page of the book after another, with everything unfolded."""
    query = "?query=gradient" if request.param == "search" else ""
    with opened(offline, book / f"{request.param}.html", query) as seen:
        seen.page.evaluate(UNFOLD)
        yield seen


@pytest.fixture
def page(seen):
    """Return the page in a wide window on a screen, in light colours."""
    show(seen.page, DESK)
    seen.page.emulate_media(media="screen", color_scheme="light")
    return seen.page


@pytest.fixture
def front(offline, book):
    """Return the front page as a reader opens it."""
    with opened(offline, book / "index.html") as seen:
        yield seen


@pytest.fixture
def faulty(offline, tmp_path):
    """Return a page that does what no page of the book should."""
    (tmp_path / "faulty.html").write_text(FAULTY, encoding="utf-8")
    with opened(offline, tmp_path / "faulty.html") as seen:
        yield seen


def show(page, width):
    """Show a page in a window of some width, and let it take in the new size."""
    page.set_viewport_size({"width": width, "height": HEIGHT})
    page.evaluate("new Promise(done => requestAnimationFrame(() => setTimeout(done)))")


def outside(seen):
    """Return the requests for anything that is not in the folder or in the page itself."""
    return [url for url in seen.requests if not url.startswith(("file:", "data:", "blob:"))]


def unset(page):
    """Return the dollars and commands that stand in the prose of a page, outside of code."""
    return re.findall(r"\$|\\[A-Za-z]+", page.locator("main").evaluate(PROSE))


def excess(page):
    """Return by how many pixels a page is wider than its window."""
    return page.evaluate("document.documentElement.scrollWidth - window.innerWidth")


def test_a_page_asks_for_its_own_files_alone(seen):
    assert any(url.endswith("/book.css") for url in seen.requests)
    assert outside(seen) == []
    assert seen.errors == []


def test_every_formula_is_set(page):
    assert page.locator(".katex-error").count() == 0
    assert unset(page) == []


@pytest.mark.parametrize("width", [PHONE, LAPTOP, DESK])
def test_no_page_is_wider_than_its_window(page, width):
    show(page, width)
    assert excess(page) <= 0


@pytest.mark.parametrize(("scheme", "width"), [("light", DESK), ("dark", PHONE)])
def test_no_rule_of_accessibility_is_broken(page, scheme, width):
    page.emulate_media(color_scheme=scheme)
    show(page, width)
    page.evaluate(SHORTEN)
    try:
        assert browser.violations(page) == []
    finally:
        page.evaluate("() => document.body.replaceWith(window.whole)")


def test_paper_shows_the_text_without_the_navigation(page):
    page.emulate_media(media="print")
    show(page, PAPER)
    assert excess(page) <= 0
    assert page.locator("main").is_visible()
    for hidden in page.locator("header, nav.sections, nav.turn").all():
        assert not hidden.is_visible()


def test_a_fault_of_each_kind_would_be_seen(faulty):
    broken = {line.partition(":")[0] for line in browser.violations(faulty.page)}
    assert {"color-contrast", "image-alt"} <= broken
    assert outside(faulty) == ["https://example.org/picture.png"]
    assert excess(faulty.page) > 1000
    assert unset(faulty.page) == ["$", "\\theta", "$"]


def test_dark_mode_is_dark(front):
    front.page.emulate_media(color_scheme="dark")
    paper = front.page.evaluate("getComputedStyle(document.body).backgroundColor")
    assert max(int(part) for part in re.findall(r"\d+", paper)) < 64
    front.picture("book-dark")


def test_the_search_finds_a_word_and_leads_to_it(front):
    from playwright.sync_api import expect  # noqa: PLC0415 - may be missing

    page = front.page
    page.get_by_role("searchbox").fill("conjugate gradient")
    page.keyboard.press("Enter")
    expect(page.get_by_role("status")).to_contain_text("conjugate gradient")
    first = page.locator("#found a").first
    front.picture("book-search")
    address, heading = first.get_attribute("href"), first.inner_text().split(" › ")[-1]
    first.click()
    expect(page).to_have_url(re.compile(re.escape(address.partition("#")[0])))
    expect(page.get_by_role("heading", name=heading).first).to_be_in_viewport()
    assert outside(front) == []


def test_the_keyboard_alone_reaches_the_text_and_a_folded_solution(offline, book):
    exercise = ".exercise details.solution"
    with opened(offline, book / f"{STEMS[0]}.html") as seen:
        keyboard = seen.page.keyboard
        keyboard.press("Tab")
        keyboard.press("Enter")
        assert seen.page.evaluate("document.activeElement.id") == "text", (
            "the skip link comes first"
        )
        for _ in range(200):
            keyboard.press("Tab")
            if seen.page.evaluate(f"document.activeElement.matches('{exercise} > summary')"):
                break
        assert not seen.page.locator(f"{exercise} pre").first.is_visible()
        keyboard.press("Enter")
        assert seen.page.locator(f"{exercise} pre").first.is_visible()
        seen.picture("book-solution")


def test_pictures_of_a_page_on_a_phone_and_on_paper_are_kept(offline, book):
    with opened(offline, book / f"{STEMS[0]}.html") as seen:
        show(seen.page, PHONE)
        seen.picture("book-phone")
        seen.page.pdf(path=browser.PICTURES / "book-paper.pdf", prefer_css_page_size=True)
    assert (browser.PICTURES / "book-paper.pdf").read_bytes().startswith(b"%PDF")
