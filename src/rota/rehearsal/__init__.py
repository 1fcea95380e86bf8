"""Plans rehearsed: many runs in which robots fail, are slower or faster than planned, or fly in wind."""

from rota.rehearsal.many_runs import rehearse
from rota.rehearsal.outcome import DemandOutcome, Rehearsal, rehearsal_to_json
from rota.rehearsal.picture import draw_rehearsal
from rota.rehearsal.table import rehearsal_table

__all__ = ["DemandOutcome", "Rehearsal", "draw_rehearsal", "rehearsal_table", "rehearsal_to_json", "rehearse"]
