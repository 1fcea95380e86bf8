"""Plan files made wrong in many ways: values, lists and bytes changed at random, from one seed."""

from __future__ import annotations

import copy
import json
import random
from typing import Any

Json = Any

NUMBERS = (
    0, -0.0, 1, -1, 2, 0.5, 1e-3, 1e-9, 1e-12, 1e-300, 5e-324, 1e3, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e12, 1e15,
    1e18, 1e40, 1e155, 1e300, 1.7e308, 2**31, 2**53 + 1, 2**63, 2**64, 10**30, 10**400, float("inf"), float("nan"),
)  # fmt: skip
OTHERS: tuple[Json, ...] = (
    None,
    True,
    False,
    "",
    "0",
    "area",
    "\ud800",
    "\x00",
    "disc",
    [],
    {},
    [[]],
    [0],
    [0, 0],
    "x" * 300,
)


def mutated(document: Json, rng: random.Random) -> bytes:
    """The text of a plan file after one to four changes; one in ten is changed in its bytes besides."""
    document = copy.deepcopy(document)
    for _ in range(rng.choice((1, 1, 1, 2, 3, 4))):
        rng.choice(CHANGES)(document, rng)
    text = json.dumps(document).encode("utf-8", "surrogatepass")
    return _spoiled(text, rng) if rng.random() < 0.1 else text


def _places(node: Json, found: list[tuple[Json, Any]]) -> list[tuple[Json, Any]]:
    """Every place of a document: what holds it, and its key or index there."""
    keys = node.keys() if isinstance(node, dict) else range(len(node)) if isinstance(node, list) else ()
    for key in keys:
        found.append((node, key))
        _places(node[key], found)
    return found


def _one_place(document: Json, rng: random.Random, wanted: type | tuple[type, ...]) -> tuple[Json, Any] | None:
    places = [place for place in _places(document, []) if isinstance(place[0][place[1]], wanted)]
    # numbers of long lists would take all the changes otherwise
    few = [place for place in places if isinstance(place[0], dict)]
    return rng.choice(few if few and rng.random() < 0.5 else places) if places else None


def _set_number(document: Json, rng: random.Random) -> None:
    """A number becomes another: an extreme, itself with the other sign, or scaled."""
    if place := _one_place(document, rng, (int, float)):
        holder, key = place
        value = float(holder[key]) if abs(holder[key]) < 1e300 else 1.0
        factor = rng.choice((1 + 1e-9, 1 + 1e-6, 0.999, 1.001, -1, 2, 1e-3, 1e3, 1e6, 1e12))
        holder[key] = rng.choice((rng.choice(NUMBERS), value * factor, value + rng.choice((1e-9, 1e-6, 1, -1, 1e6))))


def _set_other(document: Json, rng: random.Random) -> None:
    """Any value becomes one of another kind, or of another place."""
    if place := _one_place(document, rng, (int, float, str, list, dict, type(None))):
        holder, key = place
        other = _one_place(document, rng, (int, float, str, list, dict, type(None)))
        swap = copy.deepcopy(other[0][other[1]]) if other else None
        holder[key] = swap if rng.random() < 0.5 else rng.choice(OTHERS)


def _cut(document: Json, rng: random.Random) -> None:
    """An entry goes."""
    if place := _one_place(document, rng, (int, float, str, list, dict, type(None))):
        del place[0][place[1]]


def _reorder(document: Json, rng: random.Random) -> None:
    """A list is shuffled, turned round, repeated or shortened."""
    if place := _one_place(document, rng, list):
        entries = place[0][place[1]]
        rng.choice((
            lambda: rng.shuffle(entries),
            entries.reverse,
            lambda: entries.extend(copy.deepcopy(entries) * rng.choice((1, 5))),
            lambda: entries.__delitem__(slice(rng.randrange(len(entries) + 1), None)),
        ))()  # fmt: skip


def _move_robot(document: Json, rng: random.Random) -> None:
    """One robot's places, or its times, shifted, scaled, put in one point, or a position given another length."""
    robots = document.get("robots") if isinstance(document, dict) else None
    if not isinstance(robots, list) or not robots:
        return
    robot = rng.choice(robots)
    try:
        what, by = rng.randrange(5), rng.choice((1e-7, 0.1, 1, 10, 1e5, 1e6, 1e7, 1e9, 1e30))
        if what == 0:
            robot["positions_m"] = [[x + by for x in at] for at in robot["positions_m"]]
        elif what == 1:
            robot["positions_m"] = [[x * by for x in at] for at in robot["positions_m"]]
        elif what == 2:
            robot["times_s"] = [t * by for t in robot["times_s"]]
            robot["loop_start_s"] *= by
        elif what == 3:
            robot["positions_m"] = [[*at, by] for at in robot["positions_m"]]
        else:
            robot["positions_m"] = [robot["positions_m"][0]] * len(robot["positions_m"])
    except (TypeError, KeyError, IndexError, OverflowError):
        return  # an earlier change has left nothing to move


def _scale_all(document: Json, rng: random.Random) -> None:
    """Every number of a part of the document times one factor."""
    place = _one_place(document, rng, (list, dict))
    if place is None:
        return
    by = rng.choice((1e-12, 1e-6, 1e-3, 0.5, 3, 1e3, 1e5, 1e7))

    def scaled(node: Json) -> Json:
        if isinstance(node, dict):
            return {key: scaled(value) for key, value in node.items()}
        if isinstance(node, list):
            return [scaled(value) for value in node]
        number = isinstance(node, float) or (isinstance(node, int) and not isinstance(node, bool) and abs(node) < 1e300)
        return node * by if number else node

    place[0][place[1]] = scaled(place[0][place[1]])


CHANGES = (_set_number, _set_number, _set_number, _set_other, _cut, _reorder, _move_robot, _move_robot, _scale_all)


def _spoiled(text: bytes, rng: random.Random) -> bytes:
    """Bytes changed, cut out or cut off."""
    at = rng.randrange(len(text))
    kind = rng.randrange(4)
    if kind == 0:
        return text[:at]
    if kind == 1:
        return text[:at] + bytes([rng.randrange(256)]) + text[at + 1 :]
    if kind == 2:
        return text[:at] + rng.choice((b"9" * 5000, b"e999", b"-", b"[" * 3000, b"\xff")) + text[at:]
    return text[:at] + text[at + rng.randrange(1, 9) :]
