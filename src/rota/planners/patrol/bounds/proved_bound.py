"""What a proof says: a number of robots, and the reason in one sentence."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class ProvedBound:
    """No plan with fewer than ``robots`` exists; ``reason`` says why, to go on after "... robots at least:"."""

    robots: int
    reason: str


def max_of(proofs: Iterable[ProvedBound]) -> ProvedBound:
    """The first of the proofs that prove the most."""
    return max(proofs, key=lambda proof: proof.robots)
