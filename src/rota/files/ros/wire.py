"""Poses as the bytes of ROS messages, thousands at once; each message is what a ROS serialiser makes of it.

``nav_msgs/Path``, ``geometry_msgs/PoseStamped`` and ``tf2_msgs/TFMessage`` with one transform. ROS 2 writes CDR (OMG
DDS-XTypes 1.3, Section 7.4.3, little-endian XCDR1): numbers begin at a multiple of their size, texts end with a zero.
ROS 1 neither aligns nor ends them so, and its headers begin with a number of their own, here 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from rota.errors import PlanError
from rota.files.ros.names import MAP_FRAME, body_frame
from rota.files.ros.poses import Track

Generation = Literal[1, 2]
Stamps = NDArray[np.int64]

NS_PER_S = 10**9
MOST_SECONDS = {1: 2**32 - 1, 2: 2**31 - 1}  # ROS 1 counts them without a sign
CDR_LITTLE_ENDIAN = b"\x00\x01\x00\x00"
TRANSFORMS_KIND = "tf2_msgs/msg/TFMessage"
POSE = ("x", "y", "z", "qx", "qy", "qz", "qw")


@dataclass(frozen=True, kw_only=True)
class Messages:
    """Messages of one topic in the order of stamps_ns (n,), nanoseconds since 1970: ``size`` bytes each of ``data``.

    latched: the topic keeps its last message for who comes later (transient local).
    """

    topic: str
    kind: str
    stamps_ns: Stamps
    data: bytes
    size: int
    latched: bool = False


def stamps_ns(track: Track, start: datetime, generation: Generation) -> Stamps:
    """A track's times (n,) in nanoseconds since 1970, the plan's 0 at ``start``; PlanError where ROS ends counting."""
    start_us = (start - datetime(1970, 1, 1, tzinfo=UTC)) // timedelta(microseconds=1)
    first_s, last_s = start_us / 1e6, start_us / 1e6 + float(track.times_s[-1])
    if first_s < 0 or last_s >= MOST_SECONDS[generation]:
        raise PlanError(
            f"robot {track.namespace}: its times run from {first_s:.0f} s to {last_s:.0f} s after 1970; ROS"
            f" {generation} counts from 0 to {MOST_SECONDS[generation]}; name another start"
        )
    return start_us * 1000 + np.round(track.times_s * NS_PER_S).astype(np.int64)


def pose_messages(track: Track, stamps: Stamps, generation: Generation) -> Messages:
    """A PoseStamped for each pose of a track."""
    layout = _Layout(generation).header().numbers("<f8", POSE)
    return Messages(
        topic=f"/{track.namespace}/pose",
        kind="geometry_msgs/msg/PoseStamped",
        stamps_ns=stamps,
        data=layout.fill(track, stamps),
        size=layout.size,
    )


def transform_messages(track: Track, stamps: Stamps, generation: Generation) -> Messages:
    """A TFMessage for each pose of a track; of a robot that stands still one for ever, on /tf_static."""
    layout = _Layout(generation).constant("<u4", 1).header().text(body_frame(track.namespace)).numbers("<f8", POSE)
    told = slice(0, 1 if track.still else None)
    return Messages(
        topic="/tf_static" if track.still else "/tf",
        kind=TRANSFORMS_KIND,
        stamps_ns=stamps[told],
        data=layout.fill(track, stamps[told], told),
        size=layout.size,
        latched=track.still,
    )


def path_message(track: Track, stamps: Stamps, generation: Generation) -> Messages:
    """The Path of a track, told at its first time; each of its poses has its own time."""
    front = _Layout(generation).header().constant("<u4", len(stamps))
    parts = [front.fill(track, stamps[:1])]
    # from the second pose on all begin at a multiple of 8 bytes
    for some in (slice(0, 1), slice(1, None)):
        layout = _Layout(generation, lead=b"", at=sum(map(len, parts)) - len(front.lead)).header().numbers("<f8", POSE)
        parts.append(layout.fill(track, stamps[some], some))
    data = b"".join(parts)
    return Messages(
        topic=f"/{track.namespace}/path",
        kind="nav_msgs/msg/Path",
        stamps_ns=stamps[:1],
        data=data,
        size=len(data),
        latched=True,
    )


class _Layout:
    """Where the fields of one message lie, built in their order, and the bytes of many of that kind.

    at: how far the first byte lies from where the alignment is counted from; lead: bytes before that.
    """

    def __init__(self, generation: Generation, *, lead: bytes | None = None, at: int = 0) -> None:
        self.generation = generation
        self.lead = (CDR_LITTLE_ENDIAN if generation == 2 else b"") if lead is None else lead
        self.size = len(self.lead)
        self._at = at - self.size
        self._fields: list[tuple[str, str, int]] = []
        self._constants: list[tuple[int, bytes]] = [(0, self.lead)] if self.lead else []

    def header(self) -> _Layout:
        """A std_msgs/Header on the map."""
        if self.generation == 1:
            self.constant("<u4", 0)
        return self.numbers("<u4", ("s", "ns")).text(MAP_FRAME)

    def text(self, text: str) -> _Layout:
        """A text, the same in all messages."""
        letters = text.encode() + (b"\0" if self.generation == 2 else b"")
        self.constant("<u4", len(letters))
        return self._add_constant(letters)

    def constant(self, code: str, value: int) -> _Layout:
        """A number, the same in all messages."""
        kind = np.dtype(code)
        self._align(kind.itemsize)
        return self._add_constant(kind.type(value).tobytes())

    def numbers(self, code: str, names: Sequence[str]) -> _Layout:
        """Numbers that differ."""
        for name in names:
            self._align(np.dtype(code).itemsize)
            self._fields.append((name, code, self.size))
            self.size += np.dtype(code).itemsize
        return self

    def fill(self, track: Track, stamps: Stamps, some: slice = slice(None)) -> bytes:
        """The bytes of a message for each of the stamps, which belong to ``some`` of the track's poses."""
        columns: dict[str, Any] = {"s": stamps // NS_PER_S, "ns": stamps % NS_PER_S}
        columns |= {"x": track.positions_m[some, 0], "y": track.positions_m[some, 1], "z": track.positions_m[some, 2]}
        yaws = track.yaws_rad[some]
        columns |= {"qx": 0.0, "qy": 0.0, "qz": np.sin(yaws / 2), "qw": np.cos(yaws / 2)}
        raw = np.zeros((len(stamps), self.size), np.uint8)
        for offset, letters in self._constants:
            raw[:, offset : offset + len(letters)] = np.frombuffer(letters, np.uint8)
        names, codes, offsets = zip(*self._fields, strict=True)
        kind = np.dtype({"names": names, "formats": codes, "offsets": offsets, "itemsize": self.size})
        records = raw.reshape(-1).view(kind)
        for name in names:
            records[name] = columns[name]
        return raw.tobytes()

    def _add_constant(self, letters: bytes) -> _Layout:
        self._constants.append((self.size, letters))
        self.size += len(letters)
        return self

    def _align(self, size: int) -> None:
        if self.generation == 2:
            self.size += -(self._at + self.size) % size
