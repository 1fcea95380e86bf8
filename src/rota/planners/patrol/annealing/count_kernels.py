"""Compiled counts of how many legs see each sample, 64 samples at once.

A row of ``Tours.times_seen`` is a word of 64 samples. Each of its numbers has one binary digit of all their counts: a
run of samples is counted by a few operations on whole words, and so is the question which of them only one leg sees.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from rota.compiled.bits import trailing_zeros
from rota.compiled.kernel import always_inline, noinline
from rota.planners.patrol.annealing.state import Count, Tours
from rota.planners.patrol.ground.sample_kernels import Index, Samples


class _Word(NamedTuple):
    """A word of 64 samples: the binary digits of a place in it, its last place, and words in which none or all are."""

    DIGITS: Any = Index(6)
    LAST: Any = Index(63)
    NONE: Any = Index(0)
    ALL: Any = Index(2**64 - 1)


Word = _Word()


class _Digit(NamedTuple):
    """Places in a row of Tours.times_seen: the lowest digits, then which samples have any of the digits that follow."""

    ONES: int = 0
    TWOS: int = 1
    FOURS: int = 2
    MORE: int = 3


Digit = _Digit()


def words_for(samples: int, legs: int) -> tuple[int, int]:
    """Rows and columns of ``Tours.times_seen`` for so many samples, none of which more than so many legs see."""
    return samples // 64 + 1, 1 + max(4, legs.bit_length())


@always_inline
def lowest(bits: Any) -> Any:
    """The place of the lowest bit that is set; some are."""
    return trailing_zeros(bits)


@always_inline
def within(first: Any, end: Any, word: Any) -> Any:
    """The samples from ``first`` to before ``end`` in this word, which has some of them, as the bits of a number."""
    bits = Word.ALL
    if word == first >> Word.DIGITS:
        bits &= Word.ALL << (first & Word.LAST)
    if word == (end - Index(1)) >> Word.DIGITS:
        bits &= Word.ALL >> (Word.LAST - ((end - Index(1)) & Word.LAST))
    return bits


@noinline
def count_leg(slot: int, step: int, s: Samples, t: Tours) -> None:
    """Count a leg's samples once more (step 1) or once less (step -1); keep the list of the unseen."""
    runs, digits = t.seen[slot], t.times_seen
    down = Word.NONE if step > 0 else Word.ALL
    for j in range(Index(0), Index(t.seen_n[slot]), Index(2)):
        first, end = Index(runs[j]), Index(runs[j + Index(1)])
        for word in range(first >> Word.DIGITS, ((end - Index(1)) >> Word.DIGITS) + Index(1)):
            bits = within(first, end, word)
            ones, twos, fours = digits[word, Digit.ONES], digits[word, Digit.TWOS], digits[word, Digit.FOURS]
            to_twos = bits & (ones ^ down)
            to_fours = to_twos & (twos ^ down)
            further = to_fours & (fours ^ down)
            before = ones | twos | fours | digits[word, Digit.MORE]
            ones, twos, fours = ones ^ bits, twos ^ to_twos, fours ^ to_fours
            digits[word, Digit.ONES], digits[word, Digit.TWOS], digits[word, Digit.FOURS] = ones, twos, fours
            if further != Word.NONE:
                carry_further(further, down, word, digits)
            turned = bits & ~(before if step > 0 else ones | twos | fours | digits[word, Digit.MORE])
            if turned != Word.NONE:
                turn_seen(turned, word << Word.DIGITS, step, s, t)


@noinline
def carry_further(carried: Any, down: Any, word: Any, digits: Any) -> None:
    """Carry to the digits of eight and more, or borrow from them (``down``: all bits); few samples have any."""
    more = Word.NONE
    for digit in range(Index(Digit.MORE) + Index(1), Index(digits.shape[1])):
        now = digits[word, digit]
        digits[word, digit] = now ^ carried
        carried &= now ^ down
        more |= digits[word, digit]
    digits[word, Digit.MORE] = more


@noinline
def turn_seen(turned: Any, first: Any, step: int, s: Samples, t: Tours) -> None:
    """Take these samples of the word that begins with ``first`` off the list of the unseen (step 1), or add them."""
    while turned != Word.NONE:
        i = np.int64(first + lowest(turned))
        turned &= turned - Index(1)
        if step > 0:
            t.ints[Count.UNSEEN] -= 1
            back = t.unseen_item[t.ints[Count.UNSEEN]]
            t.unseen_item[t.unseen_place[i]] = back
            t.unseen_place[back] = t.unseen_place[i]
            t.unseen_in[t.bucket_of_sample[i]] -= 1
            t.unseen[0] -= s.weight[i]
        else:
            t.unseen_item[t.ints[Count.UNSEEN]] = i
            t.unseen_place[i] = t.ints[Count.UNSEEN]
            t.ints[Count.UNSEEN] += 1
            t.unseen_in[t.bucket_of_sample[i]] += 1
            t.unseen[0] += s.weight[i]


@always_inline
def bits_seen_once(first: Any, end: Any, word: Any, digits: Any) -> Any:
    """Those of the samples from ``first`` to before ``end`` in this word that one leg sees, as the bits of a number."""
    more = digits[word, Digit.TWOS] | digits[word, Digit.FOURS] | digits[word, Digit.MORE]
    return within(first, end, word) & digits[word, Digit.ONES] & ~more
