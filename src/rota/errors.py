"""The errors Rota raises on purpose; everything else that escapes is a fault of ours."""

from __future__ import annotations


class RotaError(Exception):
    """Base of every error that Rota raises on purpose."""


class MissionError(RotaError, ValueError):
    """A mission that cannot be used: the message names the place, the value and what is allowed.

    ``faults`` holds one line per fault, since a reader wants them all at once.
    """

    def __init__(self, *faults: str) -> None:
        self.faults = faults
        super().__init__("\n".join(faults))


class ArgumentError(RotaError, TypeError):
    """An argument of another type than a function takes: the message names it, the value and what is needed."""


class PlanError(RotaError):
    """A plan (or plan file) that contradicts itself or its mission."""


class CheckpointError(RotaError):
    """A checkpoint (or its file) that contradicts itself, or belongs to another mission than the one given."""


class LinkError(RotaError):
    """A robot, or what carries messages to it, that cannot be reached, refuses, or does not do what was asked of it."""


class NoPlanFound(RotaError):  # noqa: N818 (it is an outcome, not a fault)
    """No plan that meets the demand was found; the message gives the reason and the proved bound.

    ``best`` is the best plan found all the same (a ``rota.Plan``), or None. ``facts``: what the planner knows beside
    it, as sentences. ``checkpoint``: of a run that ended before it came to rest (a
    ``rota.planning.checkpoint.Checkpoint``), or None. ``report``: the check's on the best plan (a
    ``rota.check.Report``); None where the search was stopped before the check came to its end.
    """

    def __init__(
        self,
        reason: str,
        best: object | None = None,
        checkpoint: object | None = None,
        facts: tuple[str, ...] = (),
        report: object | None = None,
    ) -> None:
        self.best = best
        self.checkpoint = checkpoint
        self.facts = facts
        self.report = report
        super().__init__(reason)
