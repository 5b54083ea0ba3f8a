"""Index sets: what follows from the states of all contacts alone.

A mode is the state of every contact. Where closed contacts are redundant, as those of three feet in
the plane, the motion is unique but the forces are not: contacts that others keep closed are idle,
without a force, and of those that others keep from slipping some have friction at its bound.

A guard is a function of the state that is positive as long as the mode lasts.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from woodpecker.base.arrays import Floats, Ints

# states of a contact; SLIDE_UP: its slip is positive; REDUNDANT: closed because others are, without
# a force; EDGE_UP: it sticks because others do, with the friction of SLIDE_UP
OPEN, STICK, SLIDE_UP, SLIDE_DOWN, REDUNDANT, EDGE_UP, EDGE_DOWN = range(7)
GAP, NORMAL, CONE_UP, CONE_DOWN, SLIP = range(5)  # kinds of guards: kind * m + contact
SECTION = 5  # kind of the guard 5 m of a section, which is one more slip

# the order up to which time derivatives of guards are known
KNOWN = {GAP: 3, NORMAL: 1, CONE_UP: 1, CONE_DOWN: 1, SLIP: 2, SECTION: 2}

Mode = tuple[int, ...]


class IndexSets:
    """The index sets of a mode, for n coordinates and contacts with some friction and slips.

    Contacts ``touching`` are not open, those ``held`` do not slip, those ``closed`` have a normal
    force. Contacts that stick with the same slip are a team, the first of which is ``stuck``. One
    that slides has lambda_T = ``sign`` mu lambda_N. A section, if there is one, ``counts`` while
    certain contacts stick. ``places`` are those of guards among compiled numbers.
    """

    def __init__(
        self, n: int, friction: tuple[bool, ...], slips: tuple[int, ...],
        section: tuple[int, ...] | None, mode: Mode,
    ) -> None:  # fmt: skip
        self.m, self.friction, self.slips, self.mode = len(mode), friction, slips, mode
        every = range(self.m)
        self.touching = frozenset(i for i in every if mode[i] != OPEN)
        self.held = frozenset(i for i in every if mode[i] in (STICK, EDGE_UP, EDGE_DOWN))
        self.closed: Ints = np.array(
            [i for i in every if mode[i] not in (OPEN, REDUNDANT)], dtype=int
        )
        self.teams = [
            [k for k in every if mode[k] == STICK and slips[k] == slips[i]] for i in every
        ]
        stuck = [i for i in every if mode[i] == STICK and self.teams[i][0] == i]
        self.stuck: Ints = np.array(stuck, dtype=int)
        self.sign: Floats = np.array([0.0, 0.0, -1.0, 1.0, 0.0, -1.0, 1.0])[np.array(mode)]
        self.counts = section is not None and all(mode[i] == STICK for i in section)
        self.places, place = dict[int, int](), n + 2 * self.m
        for guard in self._guards() + [SECTION * self.m] * self.counts:
            self.places[guard] = place
            place += KNOWN[guard // self.m] + 1

    def _guards(self) -> list[int]:
        """Gaps of open contacts, forces of closed ones, slips of sliding ones."""
        # The force of a contact that sticks cannot vanish before a cone is reached. In a team it
        # can, as the guards of the first one are the cone of all.
        m, found = self.m, list[int]()
        for i, state in enumerate(self.mode):
            if state == OPEN:
                found.append(GAP * m + i)
            elif state == STICK:
                if self.teams[i][0] == i:
                    found += [CONE_UP * m + i, CONE_DOWN * m + i]
                if len(self.teams[i]) > 1:
                    found.append(NORMAL * m + i)
            elif state != REDUNDANT:
                found.append(NORMAL * m + i)
                if self.friction[i] and state in (SLIDE_UP, SLIDE_DOWN):
                    found.append(SLIP * m + i)
        return found

    def kinematic(self, guard: int) -> tuple[int, int, float]:
        """Kind, contact and sign of a guard; that of a section is one more slip, the m-th."""
        kind, i = divmod(guard, self.m)
        if kind == SECTION:
            return SLIP, self.m, 1.0
        return kind, i, -1.0 if kind == SLIP and self.mode[i] != SLIDE_UP else 1.0


@dataclass(frozen=True, slots=True)
class ContactState:
    """What an event leaves: the contacts that touch, and what is exactly zero."""

    closed: frozenset[int]  # contacts with zero gap and zero gap rate
    held: frozenset[int] = frozenset()  # those of them whose slip is exactly zero
    leaving: frozenset[int] = frozenset()  # contacts with zero gap that open at once
    fired: frozenset[int] = frozenset()  # guards of forces or slips that have just become zero
    before: Mode = ()  # the mode that has ended: what slides in it keeps its direction

    def order(self, sets: IndexSets, guard: int) -> int:
        """How many derivatives of a guard, from its value on, are exactly zero.

        At a detachment the gap has no acceleration yet; at a slip start the slip has none, because
        lambda_T = +mu lambda_N at the edge of the cone is just the force of negative slip.
        """
        m, slips = sets.m, sets.slips
        kind, i = divmod(guard, m)
        if kind == GAP:
            if i in self.closed:
                return 3 if NORMAL * m + i in self.fired else 2
            return 1 if i in self.leaving else 0
        if kind == NORMAL:
            return 1 if guard in self.fired else 0
        edges = {each // m for each in self.fired if slips[each % m] == slips[i]}
        if kind != SLIP:
            return 1 if kind in edges else 0
        if i not in self.held:
            return 0
        return 2 if (CONE_UP if sets.mode[i] == SLIDE_DOWN else CONE_DOWN) in edges else 1


@lru_cache(maxsize=1024)
def watched(sets: IndexSets, touch: ContactState) -> list[tuple[int, int]]:
    """Guards of closed contacts that may be zero after an event, each with its order."""
    found = list[tuple[int, int]]()
    for guard in sets.places:
        kind, i = divmod(guard, sets.m)
        if kind != SECTION and i in touch.closed and (kind != SLIP or i in touch.held):
            found.append((guard, touch.order(sets, guard)))
    return found
