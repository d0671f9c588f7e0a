"""The running clock: how far into the notebook the reader is."""

from __future__ import annotations

from ..validation import InputError


class Clock:
    """Minutes that a notebook plans for its sections; raises InputError for a section it lacks.

    ``core`` is what one sitting needs, in order; ``further`` is read afterwards, or at home.
    """

    def __init__(self, core: dict[str, int], further: dict[str, int] | None = None) -> None:
        self.core, self.further = core, further or {}
        print(f"{len(core)} sections, planned for {sum(core.values())} minutes in all")
        if self.further:
            beyond = sum(self.further.values())
            print(f"further reading: {len(self.further)} sections, planned for {beyond} minutes")

    def at(self, section: str) -> None:
        """Print how many minutes lie behind the reader where ``section`` begins."""
        if section in self.further:
            print(f"{section}: {self.further[section]} min of further reading")
            return
        names = list(self.core)
        if section not in names:
            known = [*names, *self.further]
            raise InputError(f"section: expected one of {known}, got {section!r}")
        minutes = list(self.core.values())
        behind = sum(minutes[: names.index(section)])
        print(f"{section}: {self.core[section]} min; {behind} of {sum(minutes)} min behind you")
