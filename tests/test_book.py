"""The book is whole, finds what it holds, asks nothing of the network, and reads well for everyone."""

import importlib
import json
import re
import sys
from itertools import pairwise
from pathlib import Path

import nbformat
import pytest
from bs4 import BeautifulSoup

NOTEBOOKS = Path(__file__).resolve().parent.parent / "notebooks"
STEMS = sorted(path.stem for path in NOTEBOOKS.glob("[0-9][0-9]_*.py"))
LOADING = {"src", "srcset", "poster", "data", "background", "action", "xlink:href"}
OUTSIDE = re.compile(r"\s*(?:[a-z][a-z0-9+.-]*:)?//", re.IGNORECASE)
LOADED_BY_SCRIPT = re.compile(
    r"(?<![\w.])(?:fetch|import|importScripts)\s*\(\s*[^\s)]|\b(?:XMLHttpRequest|WebSocket|EventSource|sendBeacon)\b"
)
NAMESPACES = {"http://www.w3.org/1998/Math/MathML", "http://www.w3.org/2000/svg"}
CONTRAST_AA = 4.5


@pytest.fixture(scope="module")
def module():
    """Return the book's module, imported as a script would find it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(NOTEBOOKS))
        for name in ("build", "book"):
            patch.delitem(sys.modules, name, raising=False)
        yield importlib.import_module("book")
        for name in ("build", "book"):
            sys.modules.pop(name, None)


@pytest.fixture(scope="module")
def pages(book):
    """Return every page, parsed, by its file name."""
    return {
        path.name: BeautifulSoup(path.read_text(encoding="utf-8"), "html.parser")
        for path in sorted(book.glob("*.html"))
    }


@pytest.fixture(scope="module")
def sections(book):
    """Return what the search looks through."""
    script = (book / "search_index.js").read_text(encoding="utf-8")
    return json.loads(script.removeprefix("const sections = ").removesuffix(";\n"))


def outside_of_page(soup):
    """Return the addresses outside the book that a browser would load for this page, unasked."""
    addresses = [
        str(value)
        for tag in soup.find_all(True)
        for name, value in tag.attrs.items()
        if name in LOADING or (name == "href" and tag.name in ("link", "base", "use", "image"))
    ]
    styles = [tag["style"] for tag in soup.find_all(style=True)]
    styles += [tag.get_text() for tag in soup.find_all("style")]
    scripts = [tag.get_text() for tag in soup.find_all("script")]
    found = [address for address in addresses if OUTSIDE.match(address)]
    found += [address for style in styles for address in outside_of_style(style)]
    found += [address for script in scripts for address in outside_of_script(script)]
    return found + [str(tag) for tag in soup.find_all(["iframe", "object", "embed"])]


def outside_of_style(style):
    """Return the addresses outside the book that a style sheet would load."""
    loaded = re.findall(r"url\(\s*[\"']?([^)\"']*)|@import\s+[\"']([^\"']*)", style)
    return [address for pair in loaded for address in pair if OUTSIDE.match(address)]


def outside_of_script(script):
    """Return what in a script names an outside address or could load one."""
    addresses = set(re.findall(r"https?://[\w./-]+", script)) - NAMESPACES
    return sorted(addresses) + LOADED_BY_SCRIPT.findall(script)


def test_every_notebook_has_a_page_and_one_after_the_other(pages):
    assert set(pages) == {"index.html", "search.html", *(f"{stem}.html" for stem in STEMS)}
    listed = [link["href"] for link in pages["index.html"].select("a.chapter")]
    assert listed == [f"{stem}.html" for stem in STEMS]
    for before, after in pairwise(listed):
        assert {link["href"] for link in pages[before].select("a[rel=next]")} == {after}
        assert {link["href"] for link in pages[after].select("a[rel=prev]")} == {before}
    assert not pages[listed[0]].select("a[rel=prev]") and not pages[listed[-1]].select(
        "a[rel=next]"
    )


def test_every_link_and_file_inside_the_book_is_there(book, pages, sections):
    for name, page in pages.items():
        links = [tag["href"] for tag in page.find_all(href=True)]
        files = [tag["src"] for tag in page.find_all(src=True)]
        for address in links + files + [page.form["action"]]:
            if re.match(r"(https?|data):", address):
                continue
            file, _, anchor = address.partition("#")
            assert (book / (file or name)).is_file(), f"{name} -> {address}"
            if anchor:
                assert pages[file or name].find(id=anchor), f"{name} -> {address}"
    for section in sections:
        file, _, anchor = section["address"].partition("#")
        assert pages[file].find(id=anchor), section["address"]
    style = (book / "katex/katex.min.css").read_text()
    for font in re.findall(r"url\((fonts/[^)]*\.woff2)\)", style):
        assert (book / "katex" / font).is_file()


def test_nothing_outside_is_loaded(book, pages):
    for name, page in pages.items():
        assert outside_of_page(page) == [], name
    for path in book.rglob("*.css"):
        assert outside_of_style(path.read_text(encoding="utf-8")) == [], path.name
    for path in book.rglob("*.js"):
        if path.name != "search_index.js":  # data, not a program
            assert outside_of_script(path.read_text(encoding="utf-8")) == [], path.name


@pytest.mark.parametrize(
    "html",
    [
        '<script src="https://cdn.example/x.js"></script>',
        '<link rel="stylesheet" href="//fonts.example/x.css">',
        '<img src="HTTP://example.org/x.png">',
        '<p style="background: url(https://example.org/x.png)">',
        '<style>@import "https://example.org/x.css";</style>',
        "<script>fetch('x')</script>",
        '<iframe src="x.html"></iframe>',
    ],
)
def test_an_outside_address_would_be_found(html):
    assert outside_of_page(BeautifulSoup(html, "html.parser"))


@pytest.mark.parametrize(
    ("words", "stem"),
    [("conjugate gradient", "05"), ("visitation", "04"), ("Algorithm 1", "06"), ("loiter", "02")],
)
def test_the_search_finds_the_page(sections, words, stem):
    def holds(section):
        text = f"{section['heading']} {section['text']}".lower()
        return all(word in text for word in words.lower().split())

    assert any(section["address"].startswith(stem) for section in sections if holds(section))


def test_the_search_does_not_tell_a_solution(sections):
    whole = " ".join(section["text"] for section in sections)
    assert "def adaptation_step" in whole and "raise NotImplementedError" in whole
    assert "loss = w_rl * rl_loss(theta) + w_bc * bc_loss(theta)" not in whole


def test_a_solution_is_folded_behind_its_exercise(pages):
    for stem in STEMS:
        source = (NOTEBOOKS / f"{stem}.py").read_text(encoding="utf-8")
        page = pages[f"{stem}.html"]
        exercises = page.select(".exercise")
        folded = page.select(".exercise > details.solution:not([open])")
        cells = [cell for cell in source.split("\n# %%") if "### BEGIN SOLUTION" in cell]
        assert len(exercises) == len(folded) == len(cells) > 0
        for exercise in exercises:
            assert "NotImplementedError" in exercise.find("pre").get_text()
        assert "SOLUTION" not in page.main.get_text()


def test_pages_are_built_for_everyone(pages):
    titles = [page.title.get_text() for page in pages.values()]
    assert len(set(titles)) == len(titles)
    for name, page in pages.items():
        assert page.html["lang"] == "en" and page.find("meta", attrs={"name": "viewport"})
        assert len(page.find_all("main")) == 1 and page.header and page.footer
        assert page.body.find("a")["href"] == f"#{page.main['id']}", "the skip link comes first"
        assert page.find("label", attrs={"for": page.find("input")["id"]})
        labels = [
            nav.get("aria-label") or nav.get("aria-labelledby") for nav in page.find_all("nav")
        ]
        assert all(labels) and len(set(labels)) == len(labels)
        identities = [tag["id"] for tag in page.find_all(id=True)]
        assert len(set(identities)) == len(identities), name
        for image in page.find_all("img"):
            assert len(image.get("alt", "")) > 20 and "No description" not in image["alt"], name
            assert int(image["width"]) > 0 and int(image["height"]) > 0


def test_headings_come_in_order(pages):
    for name, page in pages.items():
        levels = [int(heading.name[1]) for heading in page.find_all(re.compile("^h[1-6]$"))]
        assert levels[0] == 1 and levels.count(1) == 1, name
        assert all(after <= before + 1 for before, after in pairwise(levels))


def test_every_formula_arrives_as_it_was_written(module, pages):
    for stem in STEMS:
        notebook = nbformat.read(NOTEBOOKS / f"{stem}.ipynb", as_version=4)
        prose = [cell.source for cell in notebook.cells if cell.cell_type == "markdown"]
        page = pages[f"{stem}.html"]
        shown = " ".join(page.main.get_text().split())
        for source in prose:
            plain = re.sub(r"```.*?```|`[^`\n]*`", "", source, flags=re.DOTALL)
            for formula in module.FORMULA.findall(plain):
                assert " ".join(formula.split()) in shown, f"{stem}: {formula}"
        assert {"katex/katex.min.js", "page.js"} <= {tag["src"] for tag in page.find_all("script")}


def luminance(colour):
    """Return the relative luminance of a colour, as WCAG defines it."""
    parts = [int(colour[place : place + 2], 16) / 255 for place in (1, 3, 5)]
    linear = [
        part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts
    ]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def test_every_colour_of_text_has_contrast_in_light_and_dark(book):
    style = (book / "book.css").read_text(encoding="utf-8")
    blocks = re.findall(r":root \{(.*?)\}", style, re.DOTALL)
    assert len(blocks) == 2
    for block in blocks:
        colours = dict(re.findall(r"--([\w-]+): (#[0-9a-f]{6});", block))
        papers = [luminance(colours.pop("paper")), luminance(colours.pop("code-paper"))]
        colours.pop("line")  # never text
        for name, colour in colours.items():
            for paper in papers:
                dark, light = sorted([luminance(colour), paper])
                assert (light + 0.05) / (dark + 0.05) >= CONTRAST_AA, f"{name} {colour}"


def test_the_same_notebook_makes_the_same_bytes(module, book, tmp_path, monkeypatch):
    source = NOTEBOOKS / "06_emrld.py"
    again = module.stored(source)
    assert again.body in (book / "06_emrld.html").read_text(encoding="utf-8")
    monkeypatch.setattr(module, "stored", lambda _: again)
    monkeypatch.setattr(module, "sources", lambda _: [source])
    folders = [tmp_path / "one", tmp_path / "two"]
    files = []
    for folder in folders:
        module.write_book(folder)
        module.write_book(folder)  # over an older book
        found = sorted(file for file in folder.rglob("*") if file.is_file())
        files.append({str(file.relative_to(folder)): file.read_bytes() for file in found})
    assert files[0] == files[1] and (tmp_path / "one/katex/LICENSE").is_file()


def test_the_answers_to_a_guess_stay_folded_together(module):
    page = BeautifulSoup(
        '<p>guess</p><div class="cell reveal">4</div>\n<div class="reveal"><p>four</p></div>'
        '<p>next</p><div class="reveal">5</div>',
        "html.parser",
    )
    module.fold_answers(page)
    folds = page.find_all("details", class_="answer", open=False)
    assert [fold.get_text("|", strip=True) for fold in folds] == [
        f"{module.FOLDED}|4|four",
        f"{module.FOLDED}|5",
    ]


def test_a_notebook_that_is_run_for_the_book_shows_what_came_out(module, tmp_path, capsys):
    source = tmp_path / "00_fails.py"
    title = "# %% [markdown]\n# # A title\n#\n# Words.\n"
    cells = ("print(6 * 7)", "assert 70 < 69.9, 'not reached'", "print('the cell after')")
    source.write_text(title + "".join(f"\n# %%\n{cell}\n" for cell in cells))
    page = module.live(source)
    assert (page.title, page.address) == ("A title", "00_fails.html")
    assert all(words in page.body for words in ("42", "not reached", "the cell after"))
    assert "cell-002 failed here" in capsys.readouterr().out
    assert "run for this page" in page.origin
