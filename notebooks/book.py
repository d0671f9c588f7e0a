"""Make the book: a static site of the executed notebooks, read from a folder, without any network.

    python notebooks/book.py                    write build/book; open build/book/index.html
    python notebooks/book.py --out elsewhere    write it there
    python notebooks/book.py --run 06           run one notebook now, and show it as it came out

Nothing else is run: the pages show the outputs that the committed notebooks hold. Where a notebook has an
exercise, the page shows it as the student gets it, with the solution folded behind it.
"""

from __future__ import annotations

import argparse
import base64
import json
import re
import shutil
import struct
from pathlib import Path
from typing import NamedTuple

import nbformat
from bs4 import BeautifulSoup, Tag
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup
from nbconvert import HTMLExporter
from nbconvert.preprocessors import ExtractOutputPreprocessor
from pygments import highlight
from pygments.formatters import HtmlFormatter
from pygments.lexers import PythonLexer

from build import FOLDED, HERE, NO_ALT, SOLUTION, blank, execute, read, sources, write

THEME = HERE / "book_theme"
ASSETS = ("book.css", "page.js", "search.js")  # KaTeX's folder comes along whole
MARKER = re.compile(r"^[ \t]*### (?:BEGIN|END) SOLUTION[ \t]*\n?", re.MULTILINE)
FORMULA = re.compile(r"\$\$.*?\$\$|\$[^$]+\$", re.DOTALL)
PLAIN = re.compile(r'<span class="(?:n|o|p|w)">([^<]*)</span>')  # names and signs have no colour
NOTEBOOK_LINK = re.compile(r"^(\d\d_\w+)\.ipynb(#.*)?$")


class Section(NamedTuple):
    """What lies under one heading: where it is, and the words that the search looks through."""

    address: str
    level: int
    heading: str
    text: str


class Chapter(NamedTuple):
    """One notebook as a page of the book."""

    name: str
    title: str
    opening: str  # the first paragraph
    origin: str  # where its outputs come from
    body: str
    sections: list[Section]
    figures: dict[str, bytes]

    @property
    def address(self) -> str:
        """Return the page's address inside the book."""
        return f"{self.name}.html"

    @property
    def contents(self) -> list[Section]:
        """Return the sections that a table of contents names."""
        return [section for section in self.sections if section.level == 2]


def prepared(notebook: nbformat.NotebookNode) -> nbformat.NotebookNode:
    """Return a notebook whose exercises carry their blank, and whose figures carry size and text."""
    for cell, exercise in zip(notebook.cells, blank(notebook).cells, strict=True):
        cell.metadata["reveals"] = "reveal" in cell.metadata.get("tags", [])
        if SOLUTION.search(cell.source):
            cell.metadata["exercise"] = exercise.source
            cell.source = MARKER.sub("", cell.source)
        for output in cell.get("outputs", []):
            if picture := output.get("data", {}).get("image/png"):
                width, height = png_size(base64.b64decode(picture))
                about = {"alt": NO_ALT} | output.metadata.get("image/png", {})
                output.metadata["image/png"] = about | {"width": width, "height": height}
    return notebook


def png_size(picture: bytes) -> tuple[int, int]:
    """Return width and height, in pixels, from the header of a PNG file."""
    return struct.unpack(">II", picture[16:24])


def highlighted(source: str) -> str:
    """Return code as HTML that marks only what the style sheet colours, which halves a page."""
    return PLAIN.sub(r"\1", highlight(source, PythonLexer(), HtmlFormatter()))


def exported(name: str, notebook: nbformat.NotebookNode) -> tuple[str, dict[str, bytes]]:
    """Return a notebook's cells as HTML, and the figures it shows by their file names."""
    exporter = HTMLExporter(template_name="classic", template_file=str(THEME / "cells.html.j2"))
    exporter.register_preprocessor(ExtractOutputPreprocessor(), enabled=True)
    exporter.register_filter("highlighted", highlighted)
    html, resources = exporter.from_notebook_node(
        notebook, resources={"unique_key": name, "output_files_dir": "figures"}
    )
    return html, resources["outputs"]


def fold_answers(soup: BeautifulSoup) -> None:
    """Put each run of cells that give a guess's answer behind one fold."""
    for cell in soup.select("div.reveal"):
        fold = cell.find_previous_sibling()
        if fold is None or "answer" not in fold.get("class", []):
            fold = soup.new_tag("details", attrs={"class": "answer"})
            summary = soup.new_tag("summary")
            summary.string = FOLDED
            fold.append(summary)
            cell.insert_before(fold)
        fold.append(cell.extract())


def improve(soup: BeautifulSoup) -> None:
    """Let links lead to pages, wide tables scroll in themselves, and heading marks say what they are."""
    for link in soup.find_all("a", href=NOTEBOOK_LINK):
        link["href"] = NOTEBOOK_LINK.sub(r"\1.html\2", link["href"])
    for mark in soup.select("a.anchor-link"):
        mark["aria-label"] = f"Link to: {heading_text(mark.parent)}"
    for header in soup.find_all(lambda tag: tag.name == "th" and not tag.get_text(strip=True)):
        header.name = "td"  # the empty corner of a table heads nothing
    for table in soup.find_all("table"):
        table.wrap(soup.new_tag("div", attrs={"class": "scroll"}))


def heading_text(heading: Tag) -> str:
    """Return the words of a heading without the mark that links to it."""
    return heading.get_text().removesuffix("¶").strip()


def sections_of(name: str, soup: BeautifulSoup) -> list[Section]:
    """Return the sections of a page, in order."""
    headings = soup.find_all(re.compile("^h[1-6]$"))
    return [
        Section(
            address=f"{name}.html#{heading['id']}",
            level=int(heading.name[1]),
            heading=heading_text(heading),
            text=text_below(heading, following),
        )
        for heading, following in zip(headings, [*headings[1:], None], strict=True)
    ]


def left_out(element: Tag) -> bool:
    """Say whether the search passes over an element, since it has a field of its own or stays folded."""
    return bool(re.fullmatch("h[1-6]", element.name)) or "solution" in element.get("class", [])


def text_below(heading: Tag, following: Tag | None) -> str:
    """Return the words from a heading to the next, with a mark in place of each formula."""
    words = []
    for element in heading.next_elements:
        if element is following:
            break
        if isinstance(element, str) and not any(map(left_out, element.parents)):
            words.append(element)
    return " ".join(FORMULA.sub("…", " ".join(words)).split())


def chapter(name: str, notebook: nbformat.NotebookNode, origin: str) -> Chapter:
    """Return the page of one executed notebook."""
    html, figures = exported(name, prepared(notebook))
    soup = BeautifulSoup(html, "html.parser")
    improve(soup)
    fold_answers(soup)
    title, opening = heading_text(soup.h1), soup.p.get_text()
    return Chapter(name, title, opening, origin, str(soup), sections_of(name, soup), figures)


def stored(source: Path) -> Chapter:
    """Return the page of a notebook with the outputs that it was committed with."""
    notebook = nbformat.read(source.with_suffix(".ipynb"), as_version=4)
    return chapter(source.stem, notebook, "the outputs stored in it")


def live(source: Path) -> Chapter:
    """Run a notebook and return its page; a cell that fails costs its own output, not the page."""
    notebook = execute(read(source), past_errors=True)
    for cell in notebook.cells:
        for output in cell.get("outputs", []):
            if output.output_type == "error":
                print(
                    f"{cell['id']} failed here, the page shows how: {output.ename} {output.evalue}"
                )
    return chapter(source.stem, notebook, "what came out when it was run for this page")


def search_index(chapters: list[Chapter]) -> str:
    """Return a script that holds every section: a page opened from a folder may load no other file."""
    entries = [
        {
            "address": section.address,
            "chapter": chapter.title,
            "heading": section.heading,
            "text": section.text,
        }
        for chapter in chapters
        for section in chapter.sections
    ]
    lines = ",\n".join(json.dumps(entry, ensure_ascii=False) for entry in entries)
    return f"const sections = [\n{lines}\n];\n"


def write_pages(chapters: list[Chapter], out: Path) -> None:
    """Write the front page, the page of every chapter, and the search."""
    environment = Environment(
        loader=FileSystemLoader(THEME), autoescape=True, undefined=StrictUndefined
    )
    shared = {"chapters": chapters, "chapter": None}
    for name in ("index", "search"):
        write(out / f"{name}.html", environment.get_template(f"{name}.html.j2").render(shared))
    template = environment.get_template("chapter.html.j2")
    around = zip(chapters, [None, *chapters], [*chapters[1:], None], strict=False)
    for this, before, after in around:
        html = template.render(
            shared, chapter=this, body=Markup(this.body), previous=before, next=after
        )
        write(out / this.address, html)


def write_book(out: Path, run: Path | None = None) -> list[Chapter]:
    """Write the whole book into a folder and return its chapters; the notebook ``run`` is run for it."""
    chapters = [live(source) if source == run else stored(source) for source in sources([])]
    out.mkdir(parents=True, exist_ok=True)
    shutil.rmtree(out / "figures", ignore_errors=True)
    (out / "figures").mkdir()
    write_pages(chapters, out)
    write(out / "search_index.js", search_index(chapters))
    for asset in ASSETS:
        shutil.copyfile(THEME / asset, out / asset)
    shutil.copytree(THEME / "katex", out / "katex", dirs_exist_ok=True)
    for this in chapters:
        for file, content in this.figures.items():
            (out / file).write_bytes(content)
    return chapters


def main() -> None:
    """Read the command line and write the book."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("build/book"), help="folder of the book")
    parser.add_argument(
        "--run", metavar="NAME", help="a notebook to run now, in place of its outputs"
    )
    options = parser.parse_args()
    run = sources([options.run])[0] if options.run else None
    chapters = write_book(options.out, run)
    first = "index" if run is None else run.stem
    print(f"{len(chapters)} chapters; open {options.out / first}.html")


if __name__ == "__main__":
    main()
