"""The running clock: how far into the notebook the reader is."""

from __future__ import annotations

from ..validation import InputError


class Clock:
    """Minutes that a notebook plans for its sections; raises InputError for a section it lacks."""

    def __init__(self, sections: dict[str, int]) -> None:
        self.sections = sections
        print(f"{len(sections)} sections, about {sum(sections.values())} minutes in all")

    def at(self, section: str) -> None:
        """Print how many minutes lie behind the reader where ``section`` begins."""
        names = list(self.sections)
        if section not in names:
            raise InputError(f"section: expected one of {names}, got {section!r}")
        minutes = list(self.sections.values())
        behind = sum(minutes[: names.index(section)])
        print(f"{section}: {self.sections[section]} min; {behind} of {sum(minutes)} min behind you")
