"""One figure of the study: its pictures, its caption, what the paper says and what we find, and its tables."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from rota_studies.panels.study_picture import WIDTH, Panel, PictureForm, study_picture
from rota_studies.tables import Table
from rota_studies.verdict import Verdict


@dataclass(frozen=True)
class Picture:
    """A PNG file by its name, what it shows in words, and the panels that it is drawn from, when it is asked for."""

    file: str
    shows: str
    panels: tuple[Panel, ...]
    columns: int = 2
    width: float = WIDTH

    @cached_property
    def png(self) -> bytes:
        """The file."""
        return self.drawn("png")

    def drawn(self, form: PictureForm) -> bytes:
        """The picture as the bytes of a png, svg or pdf file."""
        return study_picture(self.panels, columns=self.columns, width=self.width, form=form)


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
