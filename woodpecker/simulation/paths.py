"""Paths of the toy: the events of a return, its smooth map, and the causes of its borders."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from woodpecker.base.arrays import Codes, Floats, Ints
from woodpecker.base.compiled import announce
from woodpecker.base.counting import weight
from woodpecker.mechanics.modes import CONTACT, EPS, LIMIT, NO_RATES, NORMAL, SECTION
from woodpecker.mechanics.toy import FAINT, INFINITESIMAL
from woodpecker.motion.codes import CLOSED, GUARD, MODE, PHASE_COLUMNS, RETURNED, STEP_COLUMNS
from woodpecker.simulation import calls, following, margins
from woodpecker.simulation.calls import EVENT_LIMIT
from woodpecker.simulation.status import Status, status
from woodpecker.simulation.words import word_of

DERIVATIVES = slice(margins.PER_START, margins.PER_PARAMETER + 1)  # rows of the notes
NAMES = ("the beak", "the lower sleeve", "the upper sleeve")  # contacts 1, 2, 3


class Path(NamedTuple):
    """The phases and events of one return to the section."""

    word: str
    steps: Ints  # (n, STEP_COLUMNS); of bounces that accumulate only the first
    times: Floats  # (n,) durations of the phases [s] at the start where it was found


def cause_of(path: Path, code: int) -> str:
    """Why a path ends where a margin of this code vanishes, as a sentence."""
    phase, rest = divmod(code, 1000)
    kind, item = divmod(rest, 100)
    fired = int(path.steps[phase, GUARD])
    if kind == margins.SPEED and item >= margins.SLOWEST:  # decides how the next phase begins
        phase, kind = phase + 1, margins.START
        leaves = path.steps[phase, MODE] == path.steps[phase - 1, MODE]
        item = fired if leaves else NORMAL + fired
    match kind:
        case margins.MEETING:
            return _at_once(item, fired)
        case margins.DIP:
            return f"{_says(item, GRAZES)} in phase {phase + 1}"
        case margins.EARLY:
            return f"{_says(item, FIRES)} before phase {phase + 1}"
        case margins.SPEED:
            return f"{_says(item, GRAZES)} at the end of phase {phase + 1}"
        case margins.START:
            return _says(item, STAYS)
        case margins.COMPRESSION:
            return f"{_only_just(item)} the compression"
        case margins.EXPANDING:
            return f"{_only_just(item)} the expansion"
        case margins.SWING:
            return "the sleeve jams exactly where the woodpecker turns round"
        case margins.LENGTH:
            return f"the toy only just reaches the end of the pole in phase {phase + 1}"
        case _:
            return f"the bounces of {NAMES[item]} only just come to an end"


def _only_just(item: int) -> str:
    """What happens at the border of a phase of an impact, of item 4 * contact + inequality."""
    contact, inequality = divmod(item % margins.OTHER_END, 4)
    what = {
        margins.NORMAL_SIDE: "only just takes part in",
        margins.ALONG: "stops sliding exactly at the end of",
        margins.CONE_PLUS: "only just sticks in",
        margins.CONE_MINUS: "only just sticks in",
    }[inequality]
    return f"{NAMES[contact]} {what}"


def _at_once(first: int, second: int) -> str:
    if second == SECTION:
        return f"{_says(first, FIRES)} exactly where the woodpecker turns round"
    verbs = VERBS[first // 3]
    if verbs == VERBS[second // 3]:
        one, other = sorted((first % 3, second % 3))
        return f"{NAMES[one]} and {NAMES[other]} {verbs[TOGETHER]} at once"
    return f"{_says(first, FIRES)} and {_says(second, FIRES)} at once"


FIRES, TOGETHER, GRAZES, STAYS = range(4)  # one fires, two do; one just does, or just does not
CONE = ("begins to slip", "begin to slip", "only just begins to slip", "only just sticks")
VERBS = (  # by the kind of a guard: gap, normal force, both bounds of friction, slip
    ("strikes", "strike", "grazes the pole", "only just leaves the pole"),
    ("detaches", "detach", "only just detaches", "only just stays at the pole"),
    CONE,
    CONE,
    ("stops", "stop", "only just stops", "only just begins to slide"),
)


def _says(guard: int, verb: int) -> str:
    """The contact of a guard, and what it does."""
    return f"{NAMES[guard % 3]} {VERBS[guard // 3][verb]}"


class PathReturn(NamedTuple):
    """The image under a return along a path, with derivatives and margins."""

    phi_s: float  # image [rad]
    period: float  # [s]
    drop: float  # distance fallen [m]
    slope: float  # derivative of the image in phi_S
    d_parameter: float  # and along the parameter
    margins: Floats  # (m,) positive where the toy follows the path
    gradients: Floats  # (m, 2) derivatives of the margins in both
    causes: Ints  # (m,) codes of the margins, ascending; see :func:`cause_of`
    times: Floats  # durations of the phases [s]


class Follower:
    """Finds paths of returns of one toy, and follows them; arguments as those of ``sweep``."""

    def __init__(
        self, numbers: Floats, change: Floats = NO_RATES, seed: Floats | None = None
    ) -> None:
        self.numbers, self.change = numbers, change
        self.faint: tuple[int, ...] = ()  # contacts (0-based) of infinitesimal restitution
        self._words: Codes = np.zeros((1, EVENT_LIMIT), dtype=np.int16)
        self._phases = np.zeros((EVENT_LIMIT + 1, PHASE_COLUMNS))
        self._steps = np.zeros((EVENT_LIMIT + 1, STEP_COLUMNS), dtype=np.int64)
        self._times = np.zeros(EVENT_LIMIT + 1)
        self._work = calls.make_work()
        room, route = self._work["room"], self._work["route"]
        self._z, self._states, self._counts = room["z"][0], room["states"][0], room["counts"][0]
        route["seeds"][0, 1] = (1.0, 0.0, 0.0) if seed is None else seed[0]
        self._end, self._slopes = route["z"][0], route["tangents"][0, :, 2]
        self._count = route["count"][0]
        self._notes = np.zeros((margins.NOTES, 0))
        self.evaluations = 0
        announce(calls.compute)

    def trace(self, phi_s: float) -> tuple[Status, Path, float]:
        """Status, path and image (nan if lost) of the return from the section at phi_S [rad]."""
        self.restore(FAINT)
        z, counts = self._z, self._counts
        z[:], counts[:], self._states[:] = 0.0, 0, (0, 1, 0)
        z[1], z[2] = -self.numbers[CONTACT + 1, LIMIT], phi_s
        code = calls.compute(
            calls.SEARCH, self.numbers, self.change, True, math.inf, calls.NO_STARTS, self._words,
            self._phases, self._steps, self._times, calls.NO_EVENTS, calls.NO_NOTES, self._work,
        )  # fmt: skip
        self.restore(INFINITESIMAL)
        symbols, phases, _ = counts.tolist()
        self.evaluations += weight(phases)
        text = word_of(self._words[0, :symbols].tobytes())
        path = _shortened(Path(text, self._steps[:phases].copy(), self._times[:phases].copy()))
        return status(code), path, float(z[2]) if code == RETURNED else math.nan

    def restore(self, eps: float) -> None:
        """Set the restitutions that are infinitesimal to a value."""
        for contact in self.faint:
            self.numbers[CONTACT + contact, EPS] = eps

    def follow(self, path: Path, phi_s: float, times: Floats | None = None) -> PathReturn | None:
        """The return from phi_S [rad] along a path, or None; ``times`` are those of a neighbour."""
        phases = len(path.steps)
        self.evaluations += weight(phases)
        times = (path.times if times is None else times).copy()
        if self._notes.shape[1] < margins.MOST * phases:
            self._notes = np.zeros((margins.NOTES, margins.MOST * phases))
        code = calls.follow(
            self.numbers, self.change, path.steps, times, phi_s, self._notes, self._work
        )
        if code != RETURNED:
            return None
        notes = self._notes[:, : self._count.item()].copy()
        fall, _, end, _, _, _, period = self._end.tolist()
        slope, d_parameter = self._slopes.tolist()
        return PathReturn(
            end, period, -fall, slope, d_parameter, notes[margins.MARGIN], notes[DERIVATIVES].T,
            notes[margins.CAUSE].astype(np.int64), times,
        )  # fmt: skip


def _shortened(path: Path) -> Path:
    """A path in which only the first of equal bounces that accumulate is left."""
    steps = path.steps
    last = [k - 1 for k in steps[:, CLOSED].nonzero()[0].tolist()]
    last = [k for k in last if following.bounce_repeats(steps, k)]
    if not last:
        return path
    kept = np.ones(len(steps), dtype=bool)
    same = (steps[1:] == steps[:-1]).all(axis=1)
    for k in last:
        while k > 0 and same[k - 1]:
            kept[k] = False
            k -= 1
    return Path(path.word, steps[kept], path.times[kept])
