"""How long a robot's battery lasts and how long it takes to fill. SI units, frozen."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from rota.model.field_values import check_fields
from rota.model.fields import field_of, fields_of
from rota.model.limits import DURATION, LONGEST_S, MOMENT
from rota.model.refusals import require

_TIME: dict[str, Any] = {"most": LONGEST_S, "written": DURATION, "newer": True, "spared": True}


@dataclass(frozen=True, kw_only=True)
class BatteryLimits:
    """What a battery holds, told in seconds of driving; None: no limit is known.

    A full battery lasts for ``endurance_s`` of driving, or ``standing_endurance_s`` of standing. Charging from empty to
    full takes ``recharge_s``, and less in proportion to what was used. ``reserve_s`` of driving are never used. Each
    time that a robot leaves a charger, or begins in the air, ``departure_s`` are used at once, landing included. A stay
    at a charger begins with ``landing_s`` of landing and ends with ``climbing_s`` of climbing, in which nothing is
    charged. One with a ``standing_endurance_s`` of 0 moves wherever it is not on a charger.
    """

    endurance_s: float | None = field_of(
        None, "of driving with a full battery; null: it never runs low", title="endurance", above=0, **_TIME
    )
    standing_endurance_s: float | None = field_of(
        None, "of standing or hovering with a full battery; 0: it cannot, as a wing; null: as of driving",
        title="endurance standing", least=0, **_TIME | {"written": MOMENT},
    )  # fmt: skip
    recharge_s: float | None = field_of(
        None, "to charge it from empty to full; null: where batteries are swapped", title="recharging", above=0, **_TIME
    )
    reserve_s: float = field_of(
        0.0, "of driving that must always be left", title="reserve", least=0, most=LONGEST_S, empty=True, newer=True,
        spared=True,
    )  # fmt: skip
    takeoff_s: float = field_of(
        0.0, "of driving that each departure from a charger costs, with its climb and its landing; 0: what standing or"
        " hovering for climbing_s and landing_s takes",
        title="take-off and landing", least=0, most=LONGEST_S, empty=True, newer=True, spared=True,
    )  # fmt: skip
    landing_s: float = field_of(
        0.0, "that it takes to land, with which each stay at a charger begins: nothing is charged in it",
        title="landing", least=0, most=LONGEST_S, empty=True, newer=True, spared=True,
    )  # fmt: skip
    climbing_s: float = field_of(
        0.0, "that it takes to take off and climb, with which each stay at a charger ends: nothing is charged in it",
        title="climbing", least=0, most=LONGEST_S, empty=True, newer=True, spared=True,
    )  # fmt: skip

    def __post_init__(self) -> None:
        check_fields(self)
        for name, allowed in battery_faults(vars(self)):
            require(False, name, getattr(self, name), allowed)

    @property
    def usable_s(self) -> float:
        """Seconds of driving between leaving a charger with a full battery and the reserve."""
        return float("inf") if self.endurance_s is None else self.endurance_s - self.reserve_s - self.departure_s

    @property
    def departure_s(self) -> float:
        """Seconds of driving that each departure takes, its landing included: as told, or as hovering meanwhile."""
        return self.takeoff_s or self.grounding_s * self.standing_uses

    @property
    def grounding_s(self) -> float:
        """Seconds of each stay at a charger in which nothing is charged: it lands, and it climbs."""
        return self.landing_s + self.climbing_s

    @property
    def can_stand(self) -> bool:
        """Whether the robot can stand or hover where no charger is."""
        return self.standing_endurance_s != 0

    @property
    def standing_uses(self) -> float:
        """Seconds of driving that a second of standing takes; of a robot that cannot stand 1."""
        if self.endurance_s is None:
            return 1.0
        return self.endurance_s / (self.standing_endurance_s or self.endurance_s)


BATTERY_FIELDS = tuple(item.name for item in fields_of(BatteryLimits))
BATTERY_KEYS = (*BATTERY_FIELDS, "battery")  # of mission files, which may have data sheets' figures


def battery_faults(values: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Values that contradict each other: the field at fault, and what is allowed."""
    endurance_s, standing_s = values["endurance_s"], values["standing_endurance_s"]
    if endurance_s is None:
        for name in BATTERY_FIELDS[1:]:
            if values[name] or (name == "standing_endurance_s" and standing_s == 0):
                yield name, "needs endurance_s: without one, batteries never run low"
    elif standing_s is not None and 0 < standing_s < DURATION[0]:
        yield "standing_endurance_s", f"must be 0 or at least {DURATION[0]:g}"
    elif (reserve_s := values["reserve_s"] or 0) >= endurance_s:
        yield "reserve_s", f"must be less than endurance_s, {endurance_s:.6g}"
    elif (values["takeoff_s"] or 0) >= endurance_s - reserve_s:
        yield "takeoff_s", f"must be less than what endurance_s leaves beside reserve_s, {endurance_s - reserve_s:.6g}"
    elif not values["takeoff_s"]:
        grounding_s = (values["landing_s"] or 0) + (values["climbing_s"] or 0)
        if (takes_s := grounding_s * (endurance_s / standing_s if standing_s else 1)) >= endurance_s - reserve_s:
            yield (
                "landing_s" if values["landing_s"] else "climbing_s",
                f"must be less: hovering while it climbs and lands takes {takes_s:.6g} s of driving, and endurance_s"
                f" leaves {endurance_s - reserve_s:.6g} beside reserve_s; or give takeoff_s",
            )


ENDLESS = BatteryLimits()
