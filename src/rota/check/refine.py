"""Pieces in doubt are cut smaller until they are shown met, shown not met, seen by nobody, or as fine as is asked."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from rota.check.arrays import Flags, Floats, Ints
from rota.check.findings import Findings, together
from rota.check.pieces import Pieces, point_pieces, quarter
from rota.check.revisits import Sights, passing_gaps, piece_gaps, swath_cuts
from rota.check.tolerances import INSIDE, ROUNDING, SPOT_M

IsSeeable = Callable[[Pieces, Ints], Flags]

MOST_PIECES = 600_000
MOST_TOGETHER = 250_000  # pieces that are refined together; more are refined in parts of this many
SAMPLED_MET = 200
# where no sample is unmet, at most so many pieces are cut smaller than finest_m, down to SPOT_M; the last cut is free
MOST_FINER = 2_000


def refine(
    sights: Sights,
    pieces: Pieces,
    owners: Ints,
    limits_s: Floats,
    is_seeable: IsSeeable,
    *,
    finest_m: float,
    coarse_m: float,
    few: int,
    on_the_way: Callable[[], None] | None = None,
) -> list[Findings]:
    """Judge pieces, cutting those in doubt, and sum up for each demand.

    owners: (n,) index of each piece's demand into limits_s (demands,), seconds. finest_m: smaller pieces are cut
    only where all of each that was looked at is met.
    is_seeable(k pieces, demands (k,)): whether a body can stand where it sees any of a piece, or that demand asks
    nothing of its middle, so that other ground is not held against a piece; several threads ask it.

    Pieces of a demand that is already violated are cut to ``coarse_m`` only, unless they are at most ``few``; with a
    ``few`` greater than 0 those in doubt are then cut as if nothing were violated, so that all is told at once. When
    more than 600,000 pieces would be open at once, all are left undecided as they are. Very many pieces are refined in
    parts, each by itself, so that memory and work for one piece do not grow with their number. on_the_way: called for
    each round of cutting, by several threads; what it raises ends all.
    """

    def part(first: int) -> list[Findings]:
        """Findings (demands,) on pieces that are refined together, from the first on."""
        chosen = np.arange(first, min(first + MOST_TOGETHER, len(pieces)))
        still_open, own = pieces.choose(chosen), owners[chosen]
        findings = [Findings() for _ in limits_s]
        while len(still_open):
            if on_the_way is not None:
                on_the_way()
            gaps = piece_gaps(sights, still_open, limits_s[own])
            met = gaps.gaps_s <= limits_s[own]
            _note_met(findings, sights, still_open.choose(met), own[met], gaps.gaps_s[met], gaps.firsts_s[met])
            left = np.flatnonzero(~met)
            level = _Level(sights, still_open.choose(left), own[left], gaps.gaps_s[left], gaps.firsts_s[left], limits_s)
            level.note_samples(findings, is_seeable, finest_m)
            chosen = level.settle(findings, is_seeable, finest_m, coarse_m, few)
            parts = level.pieces.choose(chosen)
            still_open, parents = quarter(parts, swath_cuts(sights, parts), 2 * sights.slack_m)
            own = level.owners[chosen][parents]
        return findings

    if len(pieces) <= MOST_TOGETHER:
        return part(0)
    with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
        return [together(parts) for parts in zip(*pool.map(part, range(0, len(pieces), MOST_TOGETHER)), strict=True)]


def _note_met(
    findings: list[Findings], sights: Sights, pieces: Pieces, owners: Ints, gaps_s: Floats, firsts_s: Floats
) -> None:
    """Note pieces that are shown met: bounds of their gaps from above, and samples at the worst of them from below."""
    for k in np.unique(owners):
        own = np.flatnonzero(owners == k)
        findings[k].upper_s = max(findings[k].upper_s, float(gaps_s[own].max()))
        findings[k].first_s = max(findings[k].first_s, float(firsts_s[own].max()))
        worst = own[np.argsort(-gaps_s[own], kind="stable")[:SAMPLED_MET]]
        samples = piece_gaps(sights, point_pieces(pieces.choose(worst).centres_m()), np.zeros(len(worst)))
        known = samples.gaps_s[samples.exact & np.isfinite(samples.gaps_s)]
        findings[k].lower_s = max(findings[k].lower_s, float(known.max(initial=0.0)))


class _Level:
    """The pieces of one round that were not shown met, with what their middles see.

    bad, unseen, hidden: (n,) flags of the middles: shown unmet, seen by no robot, and not to be seen by anybody.
    """

    def __init__(
        self, sights: Sights, pieces: Pieces, owners: Ints, uppers_s: Floats, firsts_s: Floats, limits_s: Floats
    ) -> None:
        self.sights, self.pieces, self.owners, self.limits_s = sights, pieces, owners, limits_s[owners]
        self.uppers_s, self.firsts_s = uppers_s, firsts_s
        self.middles = pieces.centres_m()
        self.areas_m2 = pieces.areas_m2()
        self.sizes_m = pieces.sizes_m()
        samples = piece_gaps(sights, point_pieces(self.middles), self.limits_s)
        self.gaps_s, self.begins_s, self.middle_firsts_s = samples.gaps_s, samples.begins_s, samples.firsts_s
        self.bad = samples.exact & (self.gaps_s > self.limits_s)
        self.unseen = np.isinf(self.gaps_s)
        self.hidden = np.zeros(len(pieces), bool)

    def note_samples(self, findings: list[Findings], is_seeable: IsSeeable, finest_m: float) -> None:
        """Find the middles that nobody can see, and the worst of the others for each demand."""
        unseen = np.flatnonzero(self.unseen)
        self.hidden[unseen] = ~is_seeable(point_pieces(self.middles[unseen]), self.owners[unseen])
        # the finest piece round a place at the rim of all that can be seen may be excluded: it speaks, not the place
        unseen = unseen[~self.hidden[unseen]]
        square = finest_m / 2 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        round_m = (self.middles[unseen][:, None] + square).reshape(-1, 2)
        inside = is_seeable(point_pieces(round_m), np.repeat(self.owners[unseen], 4)).reshape(-1, 4).all(axis=1)
        self.bad[unseen[~inside]] = False
        counted = ~self.hidden & (self.bad | np.isfinite(self.gaps_s))
        for k in np.unique(self.owners[counted]):
            own = np.flatnonzero(counted & (self.owners == k))
            worst = own[np.argmax(self.gaps_s[own])]
            if self.bad[own].any():
                findings[k].shown.append(self.middles[own[self.bad[own]]])
            if self.bad[worst]:
                self._note_worst(findings[k], self.gaps_s[worst], self.begins_s[worst], self.middles[worst])
            else:
                findings[k].lower_s = max(findings[k].lower_s, float(self.gaps_s[worst]))

    def settle(
        self, findings: list[Findings], is_seeable: IsSeeable, finest_m: float, coarse_m: float, few: int
    ) -> Ints:
        """Sum up the pieces that need no further cut; returns the indices of those that do."""
        violated = np.array([f.worst_place_m is not None for f in findings])[self.owners]
        finest = self.sizes_m <= finest_m * (1 + ROUNDING)
        out = np.zeros(len(self.pieces), bool)
        out[self.hidden] = self._wholly_hidden(np.flatnonzero(self.hidden), is_seeable)
        passed = self._meets_in_passing(findings, np.flatnonzero(finest & ~out & ~self.bad))
        in_doubt = np.flatnonzero(finest & ~out & ~passed)
        out[in_doubt] = self.hidden[in_doubt]
        asked = in_doubt[~out[in_doubt]]
        out[asked] = self._partly_hidden(asked, is_seeable)
        self._note_corners(findings, np.flatnonzero(finest & ~out & ~passed & ~self.bad))
        coarse = violated & (self.sizes_m <= coarse_m) & ~self.hidden & ~out & ~finest
        done = ~out & (finest | (coarse & (np.count_nonzero(coarse) > few)))
        # all that was looked at is met, but no one view takes in the whole piece: its parts may be seen one by one
        told = ~violated | (few > 0)
        parts = np.flatnonzero(done & finest & ~passed & ~self.bad & told & (self.sizes_m > SPOT_M))
        # a strip that no view takes in across has twice as many parts with every cut, and stays in doubt unless these
        # are spots after the next one
        done[parts if len(parts) <= MOST_FINER else parts[self.sizes_m[parts] <= 2 * SPOT_M]] = False
        passed |= self._spots(findings, np.flatnonzero(done & ~passed & ~self.hidden & (self.sizes_m <= SPOT_M)))
        ask = np.flatnonzero(self.bad & ~self.hidden & ~out & ~done)
        done[ask] = self._corners_bad(ask)
        still = np.flatnonzero(~out & ~done)
        if 4 * len(still) > MOST_PIECES:
            done[still] = True
            still = still[:0]
        self._note_excluded(findings, np.flatnonzero(out))
        self._note_unmet(findings, np.flatnonzero(done & ~passed))
        return still

    def _inner_corners(self, index: Ints) -> tuple[Floats, Ints]:
        """Corners (c, 2) of some pieces, a little inwards, and for each the place in ``index`` of its piece, (c,)."""
        chosen = self.pieces.choose(index)
        owner = chosen.owners()
        middles = self.middles[index][owner]
        return middles + INSIDE * (chosen.corners_m - middles), owner

    def _wholly_hidden(self, index: Ints, is_seeable: IsSeeable) -> Flags:
        """Which pieces nobody can see any of: (k,) flags for the pieces ``index`` (k,)."""
        return ~is_seeable(self.pieces.choose(index), self.owners[index])

    def _meets_in_passing(self, findings: list[Findings], index: Ints) -> Flags:
        """Which of all pieces are met since robots see each of their points as they pass: of those in ``index``."""
        passed = np.zeros(len(self.pieces), bool)
        gaps = passing_gaps(self.sights, self.pieces.choose(index), self.limits_s[index])
        met = gaps.gaps_s <= self.limits_s[index]
        passed[index[met]] = True
        _note_met(
            findings, self.sights, self.pieces.choose(index[met]), self.owners[index[met]],
            gaps.gaps_s[met], gaps.firsts_s[met],
        )  # fmt: skip
        return passed

    def _spots(self, findings: list[Findings], index: Ints) -> Flags:
        """Which of all pieces are too small to be cut, and met since their middles are: of those in ``index``."""
        met = index[self.gaps_s[index] <= self.limits_s[index]]
        passed = np.zeros(len(self.pieces), bool)
        passed[met] = True
        for k in np.unique(self.owners[met]):
            own = met[self.owners[met] == k]
            findings[k].upper_s = max(findings[k].upper_s, float(self.gaps_s[own].max()))
            findings[k].first_s = max(findings[k].first_s, float(self.middle_firsts_s[own].max()))
        return passed

    def _partly_hidden(self, index: Ints, is_seeable: IsSeeable) -> Flags:
        """Which pieces, or ground beside them, have a corner that nobody can see: (k,) flags for ``index``, (k,).

        One corner of each piece is asked at a time, since the first of them decides most pieces of a ragged floor.
        """
        hidden = np.zeros(len(index), bool)
        if not len(index):
            return hidden
        corners, owner = self._inner_corners(index)
        # and as far again outside, in the same demand: what of it is seen only from the very edge of the standing
        # ground, beside what is never seen, is no fair demand
        beyond = corners + (corners - self.middles[index][owner])
        number = np.arange(len(owner)) - np.searchsorted(owner, owner)  # of a corner in its piece
        for points in (beyond, corners):
            for k in range(number.max() + 1):
                asked = np.flatnonzero((number == k) & ~hidden[owner])
                gaps_s = piece_gaps(self.sights, point_pieces(points[asked]), np.zeros(len(asked))).gaps_s
                never = asked[np.isinf(gaps_s)]
                hidden[owner[never]] = ~is_seeable(point_pieces(points[never]), self.owners[index[owner[never]]])
        return hidden

    def _note_corners(self, findings: list[Findings], index: Ints) -> None:
        """Judge the corners of pieces too fine to be cut whose middles were met."""
        if not len(index):
            return
        corners, owner = self._inner_corners(index)
        samples = piece_gaps(self.sights, point_pieces(corners), self.limits_s[index][owner])
        over = samples.exact & (samples.gaps_s > self.limits_s[index][owner])
        for row in np.flatnonzero(over):
            piece = index[owner[row]]
            self.bad[piece] = True
            findings[self.owners[piece]].shown.append(corners[row : row + 1])
            self._note_worst(findings[self.owners[piece]], samples.gaps_s[row], samples.begins_s[row], corners[row])

    def _note_worst(self, findings: Findings, gap_s: float, begin_s: float, place_m: Floats) -> None:
        """Note a gap that is too long, and its place if it is the worst so far."""
        findings.lower_s = max(findings.lower_s, float(gap_s))
        if findings.worst_place_m is None or gap_s > findings.worst_s:
            findings.worst_s, findings.worst_begin_s = float(gap_s), float(begin_s)
            findings.worst_place_m = (float(place_m[0]), float(place_m[1]))

    def _corners_bad(self, index: Ints) -> Flags:
        """Whether all corners of pieces with a bad middle are bad too: no cut would tell more."""
        bad = np.ones(len(index), bool)
        if len(index):
            corners, owner = self._inner_corners(index)
            samples = piece_gaps(self.sights, point_pieces(corners), self.limits_s[index][owner])
            same = (samples.gaps_s > self.limits_s[index][owner]) & (
                np.isinf(samples.gaps_s) == self.unseen[index][owner]
            )
            np.logical_and.at(bad, owner, same)
        return bad

    def _note_excluded(self, findings: list[Findings], index: Ints) -> None:
        """Note the pieces ``index`` (k,) as seen by nobody."""
        rows = np.column_stack([self.middles, self.areas_m2, self.sizes_m])[index]
        for k in np.unique(self.owners[index]):
            own = rows[self.owners[index] == k]
            findings[k].excluded_area_m2 += float(own[:, 2].sum())
            findings[k].excluded.append(own)

    def _note_unmet(self, findings: list[Findings], index: Ints) -> None:
        """Note the pieces ``index`` (k,) as not shown met."""
        for k in np.unique(self.owners[index]):
            own = index[self.owners[index] == k]
            findings[k].upper_s = max(findings[k].upper_s, float(self.uppers_s[own].max()))
            findings[k].first_s = max(findings[k].first_s, float(self.firsts_s[own].max()))
            findings[k].undecided_cells += int((~self.bad[own] | self.hidden[own]).sum())
            findings[k].unseen_area_m2 += float(self.areas_m2[own][self.unseen[own] & ~self.hidden[own]].sum())
            findings[k].unmet += [self.pieces.choose(own).corners_m, self.middles[own]]
