"""What the runs of every study have in common: settings, seeds, records, and what is told while they are made."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

from rota_studies.records import Records

AnySettings = TypeVar("AnySettings")


class StudyStopped(Exception):  # noqa: N818 (no fault: somebody asked for it)
    """The study was asked to stop before its end; nothing is written of it."""


class StudyRuns(Generic[AnySettings]):
    """Runs that are made where the records have none.

    seed: the first of all seeds. tell: called with what is being done. should_stop: asked before every run; True raises
    StudyStopped.
    """

    def __init__(
        self,
        settings: AnySettings,
        *,
        seed: int = 0,
        tell: Callable[[str], None] = lambda doing: None,
        should_stop: Callable[[], bool] = lambda: False,
        records: Records | None = None,
    ) -> None:
        self.settings = settings
        self.seed = seed
        self.tell = tell
        self.should_stop = should_stop
        self.records = Records() if records is None else records

    def now(self, doing: str) -> None:
        """Tell what is being done next; raise StudyStopped when somebody asked for it."""
        self.stop_if_asked()
        self.tell(doing)

    def stop_if_asked(self) -> None:
        """Raise StudyStopped when somebody asked for it."""
        if self.should_stop():
            raise StudyStopped
