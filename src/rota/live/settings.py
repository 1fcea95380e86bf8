"""What a watcher chooses."""

from __future__ import annotations

from dataclasses import dataclass

from rota.model.refusals import require, require_positive

LONGEST_SILENCE_S = 1e6


@dataclass(frozen=True, kw_only=True)
class WatchSettings:
    """When a robot counts as lost, off its route or low, and how often the fleet is simulated ahead.

    silent_s: a robot that is not heard for longer counts as lost. battery_low: 0 to 1; at or below it a battery is
    low. off_route_m: a robot farther from its planned route counts as off it; None: half of its sensor's reach, and no
    less than 0.5 m. forecast_s: seconds between two looks ahead. future_s: a report of a later moment than now is
    dropped beyond this.

    Raises MissionError for values out of range.
    """

    silent_s: float = 5.0
    battery_low: float = 0.25
    off_route_m: float | None = None
    forecast_s: float = 1.0
    future_s: float = 1.0

    def __post_init__(self) -> None:
        require_positive("silent_s", self.silent_s, LONGEST_SILENCE_S)
        require(0 <= self.battery_low <= 1, "battery_low", self.battery_low, "must be 0 to 1")
        if self.off_route_m is not None:
            require_positive("off_route_m", self.off_route_m)
        require_positive("forecast_s", self.forecast_s)
        require_positive("future_s", self.future_s)
