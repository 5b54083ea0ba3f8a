"""Codes, columns and the workspace of a run, shared by all files of the event loop."""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

import numpy as np

from woodpecker.base.arrays import Ints
from woodpecker.mechanics.contact_problems import PAIR_ROOM

# An integer that is no literal: numba would compile a function anew for each literal argument.
typed = cast("Callable[[int], int]", np.int64)

# Why a run stopped; for positive codes there is no image.
RETURNED_NO_SLOPE = -1
RETURNED, TIME_REACHED, FREE_FALL, POLE_END, AT_REST = 0, 1, 2, 3, 4
EVENT_LIMIT, CONTACT_NO_SOLUTION, CONTACT_AMBIGUOUS, OVERFLOW, NEVER_JAMS = 5, 6, 7, 8, 9

# Event codes: 8 * kind + bit mask of the contacts + 64 * (marks of an impact, see impacts.MARKS).
IMPACT, DETACH, SLIP_START, STICK_START, REVERSAL, CHATTER_END, INDETERMINATE_IMPACT = range(7)

CHATTER = 1e-9  # relative size of a bounce below which the rest of its geometric series is summed:
# the neglected second order is its square, below rounding
PAIR_ENDED = 1e-15  # remaining time of impacts at two contacts in turns, as an angle of the free
# swing, below which they have ended: the rest changes velocities by about this fraction
UNNAMED = 1e-7  # the same, below which the word does not name them: they have infinitely many
# orders, which change images by less than Settings.jump

PHASE_COLUMNS = 8  # z and the mode at the start of a smooth phase
EVENT_COLUMNS = 16  # t, code, u before, u after, impulses of both phases (beak N, T, sleeve N, T)

STEP_COLUMNS = 8  # of a row of a path: what an event decides, and the phase after it. Columns:
MODE, GUARD, STRUCK, FIRST, OTHER, SECOND, CLOSED, STUCK = range(8)
# MODE of the phase; GUARD that ends it; STRUCK, mask of the contacts that take part in an impact
# (0: none); FIRST and OTHER, index combinations of its compression (both ends of the segment, if
# it is indeterminate); SECOND, that of its expansion (-1: none); CLOSED, mask of the contacts at
# which impacts have accumulated; STUCK, mask of the contacts whose slip is exactly zero

NO_PATH: Ints = np.zeros((0, STEP_COLUMNS), dtype=np.int64)

ROOM = np.dtype(
    (
        np.record,
        [
            ("z", "f8", (7,)),  # the state
            ("states", "i8", (3,)),  # of the contacts
            ("counts", "i8", (3,)),  # of symbols, phases and events
            ("slips", "i8", (3,)),  # signs of the tangential velocities
            ("stopped", "i8", (3,)),  # nonzero where the last impact stopped the slip, in any phase
            ("gaps", "f8", (3,)),  # of the contacts, over their lever arms
            ("work", "f8", (7,)),  # scratch space for a state
            ("event", "f8", (EVENT_COLUMNS,)),
            ("bounce", "i8", (3,)),  # the last: contact, symbols; symbols before unnamed impacts
            ("mark", "f8", (8,)),  # the state after it, and the speed of the gap
            ("closed", "i8", (3,)),  # nonzero for contacts that touch and stay
            ("before", "i8", (3,)),  # states before an event
            ("touching", "i8", (2,)),  # contacts with zero gap
            ("choice", "i8", (3,)),  # index combinations of an impact
            ("case", "i8", (2,)),  # the last one of each contact
            ("marks", "i8", (2,)),  # see impacts.MARKS
            ("impulses", "f8", (2, 4)),
            ("trial", "i8", (3,)),  # states that are tried
            ("decided", "i8", (STEP_COLUMNS,)),  # what an event decides, see STEP_COLUMNS
            ("pair", PAIR_ROOM),
        ],
    )
)
"""Workspace of a run, made once: see :data:`woodpecker.mechanics.contact_problems.PAIR_ROOM`."""

Room = np.record  # of ROOM
