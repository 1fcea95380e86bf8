"""One figure of the study: its pictures, its caption, what the paper says and what we find, and its tables."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

from rota.papers.tables import Table


class Picture(NamedTuple):
    """A PNG file by its name, what it shows in words, and its bytes."""

    file: str
    shows: str
    png: bytes


class Verdict(NamedTuple):
    """What became of a claim of the paper: where it stands there, how it came out here, and why."""

    claim: str
    place: str
    outcome: Literal["holds", "bettered", "does not hold", "cannot be told"]
    why: str


@dataclass(frozen=True, kw_only=True)
class Section:
    """One figure of the paper beside ours. The texts are Markdown; ``caption`` stands below the pictures.

    paper: what the paper says. ours: what we find; it takes its numbers from the run. extra: the paper has no such
    figure. verdicts: on the paper's claims that the figure is evidence for.
    """

    figure: int
    heading: str
    pictures: tuple[Picture, ...]
    caption: str
    paper: str
    ours: str
    tables: tuple[Table, ...] = ()
    extra: bool = False
    verdicts: tuple[Verdict, ...] = ()

    @property
    def markdown(self) -> str:
        """The section under a heading of the second level."""
        parts = [f"## {'Extra figure' if self.extra else 'Figure'} {self.figure}: {self.heading}"]
        parts += [f"![{picture.shows}]({picture.file})" for picture in self.pictures]
        parts += [f"*{self.caption}*", f"**The paper.** {self.paper}", f"**Here.** {self.ours}"]
        return "\n\n".join([*parts, *(table.markdown for table in self.tables)])
