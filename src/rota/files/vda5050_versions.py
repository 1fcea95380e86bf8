"""The versions of VDA 5050 that are spoken, 2.0, 2.1 and 3.0, and what differs between them in what a master sends."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from rota.errors import PlanError

Json = dict[str, Any]

SPOKEN = "2.0, 2.1 and 3.0"
_VERSION = re.compile(r"([23])\.(\d{1,4})(\.\d{1,4})?")
TRIGGERED = "waitForTrigger"  # version 3.0, section 6.2.3.1
_NAME = re.compile(r"[A-Za-z0-9_.-]{1,100}")


@dataclass(frozen=True, kw_only=True)
class Protocol:
    """One version; ``version`` as a vehicle writes it, which may take no other spelling."""

    version: str = "2.1.0"

    @property
    def is_3(self) -> bool:
        """Whether it is of major version 3."""
        return self.version.startswith("3.")

    @property
    def level(self) -> str:
        """The second level of its topics."""
        return f"v{self.version.partition('.')[0]}"

    @property
    def speed_key(self) -> str:
        """What an edge's speed limit is called."""
        return "maximumSpeed" if self.is_3 else "maxSpeed"

    @property
    def instant_blocking(self) -> str:
        """The blocking type of actions that pause, go on or cancel."""
        return "NONE" if self.is_3 else "HARD"

    def instant_actions(self, actions: list[Json]) -> Json:
        """The part of a message instantActions that holds the actions.

        Version 2.0 has them as ``actions`` in its schema and as ``instantActions`` in its text: vehicles read either.
        """
        either = {"instantActions": actions} if self.version.startswith("2.0") else {}
        return {"actions": actions, **either}


def protocol_of(version: str) -> Protocol | None:
    """The protocol that a vehicle's ``version`` names; None for those that are not spoken."""
    return Protocol(version=version) if _VERSION.fullmatch(version) else None


@dataclass(frozen=True, kw_only=True)
class WaitAction:
    """The action by which a vehicle waits at a node: for ``parameter`` seconds, or (None) until it is triggered.

    ``whole``: it takes whole seconds only.
    """

    name: str
    parameter: str | None
    whole: bool = False

    def action(self, action_id: str, wait_s: float) -> Json:
        """The action of a node at which to wait for so many seconds."""
        key, value = self.parameter, float(int(wait_s)) if self.whole else wait_s
        if key is None:
            parameters: list[Json] = [{"key": "triggerType", "value": ["FLEET_CONTROL"]}]
        else:
            parameters = [{"key": key, "value": int(value) if self.whole else value}]
        return {
            "actionType": self.name,
            "actionId": action_id,
            "blockingType": "HARD",
            "actionParameters": parameters,
        }


VERSION_2_1 = Protocol()
TIMED_WAIT = WaitAction(name="wait", parameter="duration")


def wait_action_given(text: str, where: str) -> WaitAction:
    """``NAME:PARAMETER``, an action that waits for a parameter's seconds, or ``NAME``, one that waits for a trigger.

    Raises PlanError for other text, which names ``where``.
    """
    name, colon, parameter = text.partition(":")
    if not _NAME.fullmatch(name) or (colon and not _NAME.fullmatch(parameter)):
        raise PlanError(
            f"{where}: {text!r} is not allowed; NAME:PARAMETER is needed, such as wait:duration, or the NAME of an"
            f" action that waits for a trigger, such as {TRIGGERED}"
        )
    return WaitAction(name=name, parameter=parameter if colon else None)
