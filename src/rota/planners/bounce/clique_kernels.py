# mypy: disable-error-code="no-any-return,return-value"
"""Compiled loops that count sets of nodes without conflicts: how many teams go their rounds without a contact.

Sets are bits in rows of uint64 words. Polynomials have a variable for each kind of node, packed in one index; the
coefficient of a monomial counts the sets whose nodes of each kind its exponents count, modulo ``prime`` (0: modulo
2 ** 64).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rota.compiled.kernel import allocation_free, always_inline
from rota.planners.bounce.arrays import Ints, Longs

Words = NDArray[np.uint64]

ONE = np.uint64(1)


class Graph(NamedTuple):
    """Nodes of a graph of conflicts; each stands for ``weight`` (v,) uint64 nodes, no two of which go together.

    conflict: (v, w) uint64 bits of the nodes that do not go with it, itself included. kind: (v,) int32. stride: (k,)
    int32, the packed index of each variable. total: (d, d) int32, the packed index of a product; -1: beyond the wanted.
    """

    conflict: Words
    weight: Words
    kind: Ints
    stride: Ints
    total: Ints


class Room(NamedTuple):
    """What the count writes to: sets (depth, w), polynomials (2, depth, d), and a table of sets counted before.

    known: (size, w) sets; known_for: (size,) int32, up to how many nodes their polynomial holds, 0: none; worth:
    (size, d) polynomials. calls: (1,), how many sets may be looked at; below 0: the count was given up.
    """

    sets: Words
    scratch: Words
    polynomials: NDArray[np.uint64]
    known: Words
    known_for: Ints
    worth: Words
    calls: Longs


@always_inline
def ones(word: np.uint64) -> int:
    """How many bits are set."""
    word = word - ((word >> ONE) & np.uint64(0x5555555555555555))
    word = (word & np.uint64(0x3333333333333333)) + ((word >> np.uint64(2)) & np.uint64(0x3333333333333333))
    word = (word + (word >> np.uint64(4))) & np.uint64(0x0F0F0F0F0F0F0F0F)
    return np.int64((word * np.uint64(0x0101010101010101)) >> np.uint64(56))


@always_inline
def lowest(word: np.uint64) -> int:
    """The number of the lowest bit that is set."""
    return ones((word & (~word + ONE)) - ONE)


@always_inline
def modulo(value: np.uint64, prime: np.uint64) -> np.uint64:
    """The value modulo the prime."""
    return value % prime if prime != 0 else value


@allocation_free
def times(total: Ints, poly: Words, other: Words, product: Words, prime: np.uint64) -> None:
    """poly *= other. product: scratch."""
    d = len(poly)
    for a in range(d):
        product[a] = 0
    for a in range(d):
        if poly[a] != 0:
            for b in range(d):
                c = total[a, b]
                if c >= 0 and other[b] != 0:
                    product[c] = modulo(product[c] + modulo(poly[a] * other[b], prime), prime)
    for a in range(d):
        poly[a] = product[a]


@allocation_free
def add_node(total: Ints, poly: Words, weight: np.uint64, stride: int, prime: np.uint64) -> None:
    """poly *= 1 + weight * variable."""
    for a in range(len(poly) - 1, -1, -1):
        c = total[a, stride]
        if c >= 0:
            poly[c] = modulo(poly[c] + modulo(weight * poly[a], prime), prime)


@allocation_free
def add_pairs(graph: Graph, members: Words, poly: Words, prime: np.uint64) -> None:
    """poly = 1 + all single members + all pairs of them without conflict."""
    words = len(members)
    for a in range(len(poly)):
        poly[a] = 0
    poly[0] = 1
    for k in range(words):
        rest = members[k]
        while rest != 0:
            v = 64 * k + lowest(rest)
            rest &= rest - ONE
            stride = graph.stride[graph.kind[v]]
            poly[stride] = modulo(poly[stride] + graph.weight[v], prime)
            for j in range(k, words):
                beside = members[j] & ~graph.conflict[v, j]
                if j == k:
                    beside &= rest
                while beside != 0:
                    u = 64 * j + lowest(beside)
                    beside &= beside - ONE
                    c = graph.total[stride, graph.stride[graph.kind[u]]]
                    if c >= 0:
                        poly[c] = modulo(poly[c] + modulo(graph.weight[v] * graph.weight[u], prime), prime)


@allocation_free
def hash_of(members: Words, size: int) -> int:
    """A place in the table of sets."""
    value = np.uint64(0x9E3779B97F4A7C15)
    for k in range(len(members)):
        value = (value ^ members[k]) * np.uint64(0xFF51AFD7ED558CCD)
        value ^= value >> np.uint64(32)
    return np.int64(value & np.uint64(size - 1))


@allocation_free
def strip_isolated(graph: Graph, members: Words, poly: Words, prime: np.uint64) -> int:
    """Move members without conflicts into the polynomial; returns the member with most conflicts, -1: none is left."""
    best, most = -1, 0
    for k in range(len(members)):
        rest = members[k]
        while rest != 0:
            v = 64 * k + lowest(rest)
            rest &= rest - ONE
            degree = -1
            for j in range(len(members)):
                degree += ones(graph.conflict[v, j] & members[j])
            if degree == 0:
                members[k] &= ~(ONE << np.uint64(v - 64 * k))
                add_node(graph.total, poly, graph.weight[v], graph.stride[graph.kind[v]], prime)
            elif degree > most:
                best, most = v, degree
    return best


@allocation_free
def is_connected(graph: Graph, members: Words, v: int, part: Words, fresh: Words) -> bool:
    """Fill ``part`` with the members joined with v by conflicts; returns whether these are all members."""
    words = len(members)
    for k in range(words):
        part[k] = 0
        fresh[k] = 0
    fresh[v // 64] = ONE << np.uint64(v % 64)
    growing = True
    while growing:
        growing = False
        for k in range(words):
            if fresh[k] != 0:
                growing = True
                u = 64 * k + lowest(fresh[k])
                fresh[k] &= fresh[k] - ONE
                part[k] |= ONE << np.uint64(u - 64 * k)
                for j in range(words):
                    fresh[j] |= graph.conflict[u, j] & members[j] & ~part[j]
                break
    same = True
    for k in range(words):
        same = same and part[k] == members[k]
    return same


@allocation_free
def count_sets(graph: Graph, room: Room, depth: int, most: int, prime: np.uint64) -> None:
    """Count the sets of at most ``most`` nodes without conflict in room.sets[depth], into room.polynomials[0, depth].

    The set is emptied. Parts that no conflict joins are counted apart and multiplied. Otherwise the node with most
    conflicts is left out, or taken and its conflicts left out. Sets counted before are looked up.
    """
    members, poly, other = room.sets[depth], room.polynomials[0, depth], room.polynomials[1, depth]
    words, d = len(members), len(poly)
    room.calls[0] -= 1
    if room.calls[0] < 0:
        return
    if most == 2:
        add_pairs(graph, members, poly, prime)
        return
    for a in range(d):
        poly[a] = 0
    poly[0] = 1
    while most > 0:
        v = strip_isolated(graph, members, poly, prime)
        if v < 0:
            return
        below, product = room.sets[depth + 1], room.scratch[depth]
        if not is_connected(graph, members, v, below, room.sets[depth + 2]):
            for k in range(words):
                members[k] &= ~below[k]
            count_sets(graph, room, depth + 1, most, prime)
            times(graph.total, poly, room.polynomials[0, depth + 1], product, prime)
            continue
        place = hash_of(members, len(room.known_for))
        is_known = room.known_for[place] >= most
        for k in range(words):
            is_known = is_known and room.known[place, k] == members[k]
        if is_known:
            times(graph.total, poly, room.worth[place], product, prime)
            return
        below[v // 64] &= ~(ONE << np.uint64(v % 64))
        count_sets(graph, room, depth + 1, most, prime)
        for a in range(d):
            other[a] = room.polynomials[0, depth + 1, a]
        for k in range(words):
            below[k] = members[k] & ~graph.conflict[v, k]
        count_sets(graph, room, depth + 1, most - 1, prime)
        stride = graph.stride[graph.kind[v]]
        for a in range(d):
            c = graph.total[a, stride]
            if c >= 0:
                gain = modulo(graph.weight[v] * room.polynomials[0, depth + 1, a], prime)
                other[c] = modulo(other[c] + gain, prime)
        place = hash_of(members, len(room.known_for))
        room.known_for[place] = most
        for k in range(words):
            room.known[place, k] = members[k]
        for a in range(d):
            room.worth[place, a] = other[a]
        times(graph.total, poly, other, product, prime)
        return
