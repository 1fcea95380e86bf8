"""What a rehearsal came to: types, and JSON."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np

from rota.model.arrays import Floats, Ints
from rota.rehearsal.charging import ChargingOutcome
from rota.rehearsal.conditions import Conditions
from rota.rehearsal.estimates import Estimate


@dataclass(frozen=True, kw_only=True)
class DemandOutcome:
    """What became of one demand over all runs.

    available: the share of its ground and of the time that was within its period. late_s: by how much the worst place
    of a run was later than the period, 0 where none was; its mean over the runs. worst_gap_s: the longest time that any
    place was unseen in any run, which was run worst_run and at worst_place_m. on_time: the share of runs in which no
    place was late. places: how many were looked at.
    """

    name: str
    period_s: float
    demand: Literal["every_point", "visit"]
    places: int
    available: Estimate
    late_s: Estimate
    worst_gap_s: float
    worst_run: int
    worst_place_m: tuple[float, float]
    on_time: Estimate


@dataclass(frozen=True, kw_only=True)
class ContactOutcome:
    """Whether bodies touched; robots drive on as if they had not.

    driving: the share of runs in which two did that both drove. standing: in which one did that drove and one that had
    failed. first: of the first such run who, when and where, in words; None where there is none.
    """

    driving: Estimate
    standing: Estimate
    first: str | None


@dataclass(frozen=True, kw_only=True, eq=False)
class Rehearsal:
    """What became of a plan in many runs.

    relieve_nobody: robots that charge for which nobody holds a post, nor waits when they are late, by the plan.
    available: over all that is asked, by area; a zone to visit counts as all of its ground. failed: how many robots of
    a run did. contacts: None where no two ways come so near each other that bodies can touch. charging: batteries and
    chargers, None where there are none. takeovers: how many plans took over in a run, None where none were asked for;
    refusal: why one was not found, in the first run in which that was so. parts_h: (b + 1,) the
    borders of the parts of the time, hours from when a run is looked at. parts_available: (d, runs, b) for each demand.
    parts_weights: (d,) shares of all ground. places_m: (n, 2) the places that were looked at, places_demand: (n,) of
    which demand each is, places_available: (n,) the share of the time that each was within its period. Zones to visit
    have one each.
    """

    conditions: Conditions
    seed: int
    runs: int
    robots: int
    relieve_nobody: int
    available: Estimate
    failed: Estimate
    demands: tuple[DemandOutcome, ...]
    contacts: ContactOutcome | None
    charging: ChargingOutcome | None
    takeovers: Estimate | None
    refusal: str | None
    parts_h: Floats
    parts_available: Floats
    parts_weights: Floats
    places_m: Floats
    places_demand: Ints
    places_available: Floats

    def __repr__(self) -> str:
        return f"<Rehearsal of {self.robots} robots, {self.runs} runs: available {self.available.mean:.4f}>"

    @property
    def over_time(self) -> Floats:
        """(runs, b) the share of all that is asked that was within its period, in each run and part of the time."""
        return np.asarray(np.tensordot(self.parts_weights, self.parts_available, 1))


def rehearsal_to_json(made: Rehearsal) -> dict[str, Any]:
    """The rehearsal as JSON values; bounds of intervals are null for a single run."""
    return {
        "rota_rehearsal": 1,
        "seed": made.seed,
        "runs": made.runs,
        "robots": made.robots,
        "relieve_nobody": made.relieve_nobody,
        "conditions": asdict(made.conditions),
        "places": len(made.places_m),
        "available": made.available._asdict(),
        "failed_robots": made.failed._asdict(),
        "contacts": None if made.contacts is None else _contacts_to_json(made.contacts),
        "takeovers": None if made.takeovers is None else made.takeovers._asdict(),
        "not_replanned": made.refusal,
        "charging": None if made.charging is None else _charging_to_json(made.charging),
        "demands": [
            {
                "name": each.name,
                "period_s": each.period_s,
                "demand": each.demand,
                "places": each.places,
                "available": each.available._asdict(),
                "late_s": each.late_s._asdict(),
                "on_time": each.on_time._asdict(),
                "worst_gap_s": each.worst_gap_s,
                "worst_run": each.worst_run,
                "worst_place_m": list(each.worst_place_m),
            }
            for each in made.demands
        ],
        "over_time": [
            {"from_h": float(low), "to_h": float(high), "available": float(share)}
            for low, high, share in zip(made.parts_h[:-1], made.parts_h[1:], made.over_time.mean(axis=0), strict=True)
        ],
    }


def _contacts_to_json(contacts: ContactOutcome) -> dict[str, Any]:
    driving, standing = contacts.driving._asdict(), contacts.standing._asdict()
    return {"runs_driving": driving, "runs_with_failed": standing, "first": contacts.first}


def _charging_to_json(charging: ChargingOutcome) -> dict[str, Any]:
    """Batteries, reliefs and chargers as JSON values."""
    return {
        "least_to_spare_s": None if charging.spare_s is None else charging.spare_s._asdict(),
        "runs_below_reserve": charging.below._asdict(),
        "runs_not_waited": charging.hurried._asdict(),
        "runs_too_full": charging.crowded._asdict(),
        "reliefs": charging.reliefs._asdict(),
        "first_not_waited": charging.first_hurry,
        "first_too_full": charging.first_crowd,
        "robots": [
            {
                "name": each.robot,
                "reserve_s": each.reserve_s,
                "least_s": each.least_s._asdict(),
                "runs_below_reserve": each.below._asdict(),
                "worst_s": each.worst_s,
                "worst_run": each.worst_run,
                "worst_at_s": each.worst_at_s,
            }
            for each in charging.robots
        ],
    }
