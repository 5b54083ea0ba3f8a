"""How far is trouble: the smallest change of the toy's parameters that ends a periodic motion.

A change counts each parameter as part of its own value, and one that is zero as part of the range 1
of a restitution, upwards only. Along a straight line of changes the motion is followed exactly, so
the first trouble on it is known to rounding: it is destroyed, or becomes unstable, at a fold, a
flip or a border. The gradient of what vanishes there gives the direction in which it is nearer, and
so on, until change and gradient are parallel.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

from pwmap.diagrams.diagram import PointKind, PointStatus
from woodpecker.base.arrays import Floats
from woodpecker.mechanics.toy import Domain, Toy, description, known_parameter, parameters
from woodpecker.piecewise.borders import BorderKind
from woodpecker.piecewise.branch_points import Multiplier
from woodpecker.piecewise.curves import Curve
from woodpecker.piecewise.cycle_branches import Cycles
from woodpecker.piecewise.ends import End
from woodpecker.piecewise.orbits import (
    Closed,
    Condition,
    Coordinate,
    Margin,
    Orbit,
    jacobian,
    orbit_of,
    solve,
)
from woodpecker.piecewise.settings import Settings
from woodpecker.runs import WINDOW
from woodpecker.shooting import PeriodicOrbit, shoot
from woodpecker.toylines import LinePiece, ToyLine

FLOOR = 1e-9  # of a restitution that is zero: contacts that rest begin to bounce, and it is
# differentiable; what that changes is smaller still, and it is held at zero in the end
FARTHEST = 1.0  # largest change that is looked at: by as much as a parameter's own value
SEEDS = 16  # conditions, the nearest to first order, that are looked for
STEPS = 40  # towards the nearest place of a condition; about ten are usual
PARALLEL = 1e-8  # sine of the angle between change and gradient at which they are parallel: what is
# gained beyond is its square
PARTS = (2.0, 1.0, 0.5)  # of a turn towards the nearest place to first order that are tried
NEARLY = 1e-3  # such an angle below which the target is taken: sizes differ by its square only
SHORTEST = 2.0**-8  # part of it that is tried at last, where all lead to larger changes
LEVEL = 1e-10  # relative: changes are as small as each other, to what rounding leaves of a place
SHORT = 0.1  # changes of one parameter at the end of which more conditions are looked for
STEPPING = Settings(window=WINDOW, step=0.02, max_step=0.1)  # longer steps than for a picture: what
# lies between two of them is known from margins
WIDE = 2.0  # times the distance to first order up to which a condition is looked for
MOST = 3  # conditions of each effect whose nearest place is looked for, and of those that do no
MOST_HARMLESS = 1  # harm
ALIKE = 1e-5  # relative: places this close are one; ten times within ``BESIDE``
NEAR = (
    0.02  # rad: a motion farther from where it was lost is another one; at a fold it moves by the
)
# root of ``BESIDE``
PERCENT = 100.0
MANY = 64  # changes on a line after which it is left: words change without end there
LEAST = 1e-3  # part of its value that a parameter keeps at least
WORD = "word"  # the kind of a border that is no special point
BESIDE = (
    1e-4  # part of a change by which toys on both sides differ from it: far above what rounding
)
# makes of a border, far below the distance to the next one


class Effect(Enum):
    """What becomes of a periodic motion."""

    DESTROYED = "destroyed"
    DESTABILISED = "unstable beyond"
    KINKED = "another multiplier beyond"
    RELABELLED = "another word beyond"
    OPEN = "not known beyond"


Key = tuple[Effect, str, str]
"""The same for the same condition."""

ENDS = (Effect.DESTROYED, Effect.DESTABILISED, Effect.OPEN)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Trouble:
    """The smallest change of parameters that leads to one condition.

    Attributes
    ----------
    effect
        What becomes of the motion.
    kind
        The code of the special point: LP, PD, BC, FF, FALL; ``word`` at a border that is none.
    cause
        A sentence on what happens there.
    size
        Euclidean length of the scaled change.
    changes
        Change of each parameter, in percent of its value (of 1 if that is zero).
    toy, phi_s
        The toy there, and where its motion meets the section [rad].
    word
        Sequence of events before it.
    stable
        Whether the motion is stable up to there; it may be destroyed beyond a flip only.
    angle
        Sine of the angle between change and gradient, as far as the limits of the parameters leave
        them free: zero where no neighbouring change is smaller.
    confirmed
        Whether toys on both sides behave as the row says.
    evidence
        What was seen on both sides, in a sentence.
    """

    effect: Effect
    kind: str
    cause: str
    size: float
    changes: Mapping[str, float]
    toy: Toy
    phi_s: float
    word: str
    stable: bool
    angle: float
    confirmed: bool
    evidence: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Limit:
    """How far one parameter alone can be changed.

    Attributes
    ----------
    parameter, direction
        Its name, and 1 for up or -1 for down.
    value, percent
        Where the motion ends, and the change; nan if it does not as far as was looked.
    effect, kind, cause
        What happens there.
    """

    parameter: str
    direction: int
    value: float
    percent: float
    effect: Effect | None
    kind: str
    cause: str


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Robustness:
    """How far trouble is from a periodic motion.

    Attributes
    ----------
    orbit
        The motion.
    troubles
        What destroys or destabilises it, nearest first.
    harmless
        Borders on the way at which it only gets another word or multiplier, nearest first.
    limits
        Each parameter alone, down and up.
    """

    orbit: PeriodicOrbit
    troubles: tuple[Trouble, ...]
    harmless: tuple[Trouble, ...]
    limits: tuple[Limit, ...]

    @property
    def nearest(self) -> Trouble | None:
        """What is nearest of all that ends the motion; None if nothing is near."""
        return self.troubles[0] if self.troubles else None


@dataclass(frozen=True, slots=True, eq=False)
class _Space:
    """Changes of a toy, scaled, within the limits of its parameters."""

    toy: Toy
    points: Floats
    names: tuple[str, ...]
    sizes: Floats
    low: Floats
    high: Floats
    settings: Settings

    def toy_at(self, u: Floats) -> Toy:
        """The toy with a change."""
        values = zip(self.names, (self.sizes * u).tolist(), strict=True)
        return self.toy.replace(**{name: getattr(self.toy, name) + by for name, by in values})

    def line(self, u: Floats, direction: Floats) -> ToyLine:
        """The line from the toy with a change on."""
        rates = zip(self.names, (self.sizes * direction).tolist(), strict=True)
        return ToyLine(self.toy_at(u) if u.any() else self.toy, dict(rates))

    def projected(self, gradient: Floats, value: float) -> Floats:
        """The smallest change u with gradient . u = value, within the limits."""
        free = np.ones(len(gradient), dtype=bool)
        u = np.zeros(len(gradient))
        for _ in range(len(gradient)):
            square = float(gradient[free] @ gradient[free])
            rest = value - float(gradient[~free] @ u[~free])
            u[free] = gradient[free] * (rest / square) if square > 0.0 else 0.0
            outside = free & ((u < self.low) | (u > self.high))
            if not outside.any():
                break
            u[outside] = np.clip(u, self.low, self.high)[outside]
            free &= ~outside
        return u

    def reach(self, direction: Floats) -> float:
        """How far a line leads from the toy before a parameter leaves its limits."""
        with np.errstate(divide="ignore", invalid="ignore"):
            away = np.where(direction > 0.0, self.high, self.low) / direction
        away = away[direction != 0.0]
        return min(FARTHEST, float(away.min())) if len(away) else 0.0


def _space(orbit: PeriodicOrbit, names: Sequence[str], settings: Settings) -> _Space:
    """All changes of some parameters of the toy of an orbit."""
    toy = orbit.toy
    zero = [name for name in names if getattr(toy, name) == 0.0]
    at_floor = toy.replace(**dict.fromkeys(zero, FLOOR))
    sizes = np.array([abs(getattr(toy, name)) or 1.0 for name in names])
    high = np.full(len(names), math.inf)
    for k, name in enumerate(names):
        if description(name).domain is Domain.RESTITUTION:
            high[k] = (1.0 - getattr(at_floor, name)) / sizes[k]
    low = np.array([0.0 if name in zero else LEAST - 1.0 for name in names])
    points = np.array(orbit.points[: orbit.minimal_period])
    return _Space(at_floor, points, tuple(names), sizes, low, high, settings)


@dataclass(frozen=True, slots=True, eq=False)
class _Met:
    """A special point, or a change of word, on a line from the toy.

    Attributes
    ----------
    effect, kind, cause
        What it is.
    u
        The change.
    orbit
        The cycle there, with the pieces before it, seen along the line.
    condition
        What vanishes there; None where nothing is known that does.
    stable
        Whether the motion is stable up to there.
    """

    effect: Effect
    kind: str
    cause: str
    u: Floats
    orbit: Orbit
    condition: Condition | None
    stable: bool = True

    @property
    def size(self) -> float:
        """Length of the change."""
        return float(np.linalg.norm(self.u))

    @property
    def key(self) -> Key:
        """The same for the same condition."""
        return self.effect, self.kind, self.cause


def _met_along(
    space: _Space, direction: Floats, most: float = FARTHEST, *, past: bool = True
) -> list[_Met]:
    """Everything that a motion meets on a line, in order, until it is destroyed.

    Past a flip and whatever else only makes it unstable it is followed on, unless ``past`` is
    false.
    """
    direction = direction / np.linalg.norm(direction)
    reach = min(most, space.reach(direction))
    if not reach > 0.0:
        return []
    line = space.line(np.zeros(len(direction)), direction)
    settings = replace(space.settings, span=(0.0, reach))
    start = _cycle(line, space.points, settings)
    if start is None:
        return []
    cycles, found = Cycles(line, settings), list[_Met]()
    followed = cycles.through(start)
    while True:
        stable = not any(each.effect is Effect.DESTABILISED for each in found)
        read = _read(followed.curve, line, direction, settings)
        found += [replace(each, stable=stable) for each in read]
        ends = not found or found[-1].effect is not Effect.DESTABILISED
        if ends or not past or not followed.onward or len(found) > MANY:
            return found
        followed = cycles.ahead(followed.onward[0])


def _cycle(line: ToyLine, x: Floats, settings: Settings) -> Orbit | None:
    """The cycle at the beginning of a line."""
    start = Orbit(x, 0.0, tuple(line.at(float(each), 0.0) for each in x))
    if not start.defined:
        return None
    found = solve(start, (Closed(), Coordinate(-1, 0.0)), settings)
    return found.orbit if found.converged else None


def _read(curve: Curve, line: ToyLine, direction: Floats, settings: Settings) -> Iterator[_Met]:
    """What a branch meets, in order of the distance from the toy."""

    def met(k: int, effect: Effect, kind: str, cause: str) -> _Met:
        before = float(curve.parameter[k - 1])
        pieces = [line.at(float(each), before).piece for each in curve.points[k - 1]]
        orbit = orbit_of(pieces, curve.points[k], float(curve.parameter[k]))
        condition = _condition(orbit, kind, cause, settings)
        return _Met(effect, kind, cause, orbit.p * direction, orbit, condition)

    for mark in curve.marks:
        if mark.sample == 0:
            continue
        smooth = mark.kind is BorderKind.SMOOTH
        yield met(mark.sample, Effect.RELABELLED if smooth else Effect.KINKED, WORD, mark.cause)
    end = curve.ends[1]
    effect = _effect(end)
    if effect is not None and len(curve.points) > 1:
        yield met(len(curve.points) - 1, effect, end.kind.value, end.cause or end.note)


def _effect(end: End) -> Effect | None:
    """What a special point does to a stable motion; None where nothing does."""
    if end.kind is PointKind.EP:
        return Effect.OPEN if end.status is PointStatus.OPEN else None
    if end.collision is not None:  # with a jump, beyond which no cycle is its continuation
        return Effect.DESTROYED
    unstable = end.kind in (PointKind.PD, PointKind.BP) or end.note == "persistence"
    return Effect.DESTABILISED if unstable else Effect.DESTROYED


def _condition(orbit: Orbit, kind: str, cause: str, settings: Settings) -> Condition | None:
    """What vanishes at a special point."""
    if kind in (PointKind.LP.value, PointKind.PD.value):
        return _multiplier(1.0 if kind == PointKind.LP.value else -1.0, orbit, settings)
    best, found = math.inf, None
    for i, image in enumerate(orbit.images):
        for k, code in enumerate(image.causes.tolist()):
            size = abs(float(image.gradients[k, 0])) or 1.0
            away = abs(float(image.margins[k])) / size
            if away < best and image.piece.cause(code) == cause:
                best, found = away, Margin(i, code)
    return found


def _multiplier(value: float, orbit: Orbit, settings: Settings) -> Multiplier:
    """A value of the multiplier, whose derivatives are differences over parts of a change."""
    size, x = orbit.p or 1.0, float(orbit.x[0])
    near = replace(settings, span=(0.0, size), window=(x, x + size * settings.x_scale))
    return Multiplier(value, near, settings.nearest)


def _gradient(space: _Space, u: Floats, orbit: Orbit, condition: Condition) -> Floats:
    """Gradient of a condition along the cycles, scaled; its length counts for nothing.

    Cycle and condition are n + 1 equations for n points: the combination of them that does not
    depend on the points is one for the parameters alone. It is regular at a fold too.
    """
    lines = [space.line(u, unit) for unit in np.eye(len(u))]
    rows, ones = [], np.ones(len(orbit) + 1)
    for line in lines:
        pieces = [_carried(piece, line) for piece in orbit.pieces]
        rows.append(jacobian(orbit_of(pieces, orbit.x, 0.0), (Closed(), condition), ones))
    if not np.isfinite(rows).all():  # at a root of the map
        return np.full(len(u), math.nan)
    weights = np.linalg.svd(rows[0][:, :-1])[0][:, -1]
    gradient: Floats = np.array([float(weights @ row[:, -1]) for row in rows])
    return gradient


def _carried(piece: object, line: ToyLine) -> LinePiece:
    assert isinstance(piece, LinePiece)
    return LinePiece(line, piece.path)


def _nearest(space: _Space, seed: _Met, seen: dict[Key, _Met]) -> tuple[_Met, float]:
    """The smallest change at which a condition holds, from one at which it does.

    Whatever else is met on the way is kept in ``seen`` if it is nearer than what is known of it.

    Returns
    -------
    What is met there, and the sine of the angle between change and gradient.
    """
    best, least = seed, math.inf
    here = seed
    for _ in range(STEPS):
        if here.condition is None:
            break
        target = _target(space, here)
        if not np.isfinite(target).all():
            break
        angle = float(np.linalg.norm(target - here.u)) / here.size
        if here.size >= best.size and angle >= least:  # rounding decides
            break
        best, least = here, angle
        parts = PARTS if angle > NEARLY else PARTS[1:2]
        closer = _turned(space, here, target, parts, seen) if angle > PARALLEL else None
        if closer is None:
            break
        here = closer
    return best, least


def _target(space: _Space, here: _Met) -> Floats:
    """The smallest change at which a condition holds to first order."""
    assert here.condition is not None
    gradient = _gradient(space, here.u, here.orbit, here.condition)
    if not (np.isfinite(gradient).all() and gradient.any()):
        return np.full(len(gradient), math.nan)
    return space.projected(gradient, float(gradient @ here.u))


def _turned(
    space: _Space, here: _Met, target: Floats, parts: Sequence[float], seen: dict[Key, _Met]
) -> _Met | None:
    """The same condition at a smaller change, in the direction of the target or part of the way.

    Where the condition bends the target is too near or too far: twice and half of the way are
    tried, too, and the smallest change counts.
    """
    tried = [_same(space, here, here.u + part * (target - here.u), seen) for part in parts]
    found = [each for each in tried if each is not None]
    part = parts[-1]
    while not found and part > SHORTEST:
        part *= 0.5
        there = _same(space, here, here.u + part * (target - here.u), seen)
        found = [there] if there is not None else []
    return min(found, key=lambda each: each.size, default=None)


def _same(space: _Space, here: _Met, way: Floats, seen: dict[Key, _Met]) -> _Met | None:
    """The same condition in another direction, if the change is no larger there."""
    most = here.size * (1.0 + LEVEL)
    found = _met_along(space, np.clip(way, space.low, space.high), most)
    _keep(found, seen)
    return next((each for each in found if each.key == here.key and each.size <= most), None)


def _keep(found: Sequence[_Met], seen: dict[Key, _Met]) -> None:
    """Keep of each condition the nearest place."""
    for each in found:
        if each.key not in seen or each.size < seen[each.key].size:
            seen[each.key] = each


def _first_guesses(space: _Space) -> list[Floats]:
    """Where conditions hold to first order, the nearest first."""
    none = np.zeros(len(space.names))
    line = space.line(none, np.eye(len(none))[0])
    orbit = _cycle(line, space.points, replace(space.settings, span=(0.0, 1.0)))
    if orbit is None:
        return []
    settings = replace(space.settings, span=(0.0, 1.0))
    conditions: list[Condition] = [Multiplier(v, settings, settings.nearest) for v in (1.0, -1.0)]
    for i, image in enumerate(orbit.images):
        conditions += [Margin(i, code) for code in image.causes.tolist()]
    rows = _rows(space, none, orbit, conditions)
    found = []
    for condition, row in zip(conditions, rows, strict=True):
        u = space.projected(row, -condition.residual(orbit))
        if np.isfinite(u).all() and 0.0 < np.linalg.norm(u) < FARTHEST:
            found.append(u)
    return sorted(found, key=lambda u: float(np.linalg.norm(u)))[:SEEDS]


def _rows(space: _Space, u: Floats, orbit: Orbit, conditions: Sequence[Condition]) -> Floats:
    """Gradients (m, k) of conditions along the cycles that hang on the parameters smoothly."""
    n, columns = len(orbit), []
    ones = np.ones(n + 1)
    for unit in np.eye(len(u)):
        line = space.line(u, unit)
        there = orbit_of([_carried(piece, line) for piece in orbit.pieces], orbit.x, 0.0)
        matrix = jacobian(there, (Closed(), *conditions), ones)
        along = np.linalg.solve(matrix[:n, :n], -matrix[:n, n])
        columns.append(matrix[n:, n] + matrix[n:, :n] @ along)
    return np.array(columns).T


def robustness(
    toy: Toy,
    orbit: PeriodicOrbit,
    names: Sequence[str] | None = None,
    *,
    settings: Settings = STEPPING,
) -> Robustness:
    """How far the parameters of a toy can be changed until a stable periodic motion ends.

    Parameters
    ----------
    toy
        The toy.
    orbit
        A stable periodic motion of it, from :func:`woodpecker.shoot`.
    names
        The parameters that change, by default all but the length of the pole.
    settings
        Steps, window and tolerances; their span does not matter.

    Returns
    -------
    Robustness
        What destroys or destabilises the motion at the smallest change of all of these parameters
        together, which borders only give it another word or multiplier, and how far each parameter
        alone can be changed. Every row is the nearest place of its condition that straight lines
        from the toy lead to; one that is nearer along a bent way only is not found.

    Raises
    ------
    ValueError
        If the orbit did not converge, is not stable or is one of another toy, or no parameter is
        named.
    TypeError
        If a parameter is unknown.
    """
    wanted = _checked(toy, orbit, names)
    space = _space(orbit, wanted, settings)
    seen = dict[Key, _Met]()
    single = tuple(_limits(orbit, wanted, settings))
    for guess in _first_guesses(space):
        _keep(_met_along(space, guess, min(FARTHEST, WIDE * float(np.linalg.norm(guess)))), seen)
    for each in single:
        if abs(each.percent) <= PERCENT * SHORT:
            axis = np.eye(len(wanted))[wanted.index(each.parameter)] * each.direction
            _keep(_met_along(space, axis, abs(each.percent) / PERCENT * (1.0 + LEVEL)), seen)
    found = _refined(space, seen)
    rows = [_row(orbit, space, met, angle) for met, angle in found]
    harmless = [row for row in rows if row.effect not in ENDS]
    return Robustness(
        orbit=orbit, troubles=tuple(row for row in rows if row.effect in ENDS),
        harmless=tuple(harmless), limits=single,
    )  # fmt: skip


def _checked(toy: Toy, orbit: PeriodicOrbit, names: Sequence[str] | None) -> tuple[str, ...]:
    """The parameters that change."""
    if not orbit.success:
        raise ValueError(f"robustness needs a periodic motion, got one with: {orbit.message}")
    if orbit.toy != toy:
        raise ValueError("robustness needs an orbit of this toy, got one of another toy")
    if not orbit.stable:
        raise ValueError(
            f"robustness needs a stable motion, got one with multiplier {orbit.multiplier:.6g}"
        )
    if names is None:
        return tuple(name for name in parameters() if name != "pole")
    wanted = tuple(dict.fromkeys(known_parameter(name) for name in names))
    if not wanted or "pole" in wanted:
        raise ValueError(
            f"names must hold parameters of the toy other than the pole, got {tuple(names)!r}"
        )
    return wanted


def _refined(space: _Space, seen: dict[Key, _Met]) -> list[tuple[_Met, float]]:
    """The nearest place of every condition that ends a motion, and of the nearest that do not."""
    done = dict[Key, tuple[_Met, float]]()
    while True:
        left = [met for key, met in seen.items() if key not in done and _counts(met, done)]
        if not left:
            break
        met = min(left, key=lambda each: each.size)
        done[met.key] = _nearest(space, met, seen)
    found = list[tuple[_Met, float]]()
    for met, angle in sorted(done.values(), key=lambda each: each[0].size):
        if all(_differ(met, other) for other, _ in found):
            found.append((met, angle))
    return found


def _counts(met: _Met, done: Mapping[Key, object]) -> bool:
    """Whether a condition is worth its nearest place."""
    if met.condition is None and met.effect not in ENDS:
        return False
    if not met.stable and met.effect is Effect.DESTABILISED:
        return False
    alike = sum(effect is met.effect for effect, _, _ in done)
    return alike < (MOST if met.effect in ENDS else MOST_HARMLESS)


def _differ(one: _Met, other: _Met) -> bool:
    """Whether two places are not one that goes by two names."""
    apart = float(np.linalg.norm(one.u - other.u))
    return one.effect is not other.effect or apart > ALIKE * other.size


def _exact(orbit: PeriodicOrbit, space: _Space, met: _Met) -> tuple[_Space, _Met]:
    """The same place with restitutions that are zero, if the change leaves them there."""
    zero = [k for k, name in enumerate(space.names) if getattr(orbit.toy, name) == 0.0]
    if not zero or met.u[zero].any() or len(zero) == len(space.names):
        return space, met
    kept = [name for k, name in enumerate(space.names) if k not in zero]
    exact = _space(orbit, kept, space.settings)
    found = _met_along(exact, np.delete(met.u, zero), met.size * (1.0 + ALIKE))
    near = [e for e in found if e.effect is met.effect and abs(e.size / met.size - 1.0) < ALIKE]
    return (exact, near[-1]) if near else (space, met)


def _row(orbit: PeriodicOrbit, space: _Space, met: _Met, angle: float) -> Trouble:
    """What is reported of a place."""
    own, there = _exact(orbit, space, met)
    confirmed, evidence = _evidence(own, there)
    percents = dict(zip(own.names, (PERCENT * there.u).tolist(), strict=True))
    return Trouble(
        effect=met.effect, kind=met.kind, cause=there.cause, size=there.size,
        changes={name: percents.get(name, 0.0) for name in space.names},
        toy=own.toy_at(there.u), phi_s=float(there.orbit.x[0]), word=" | ".join(there.orbit.words),
        stable=there.stable, angle=angle, confirmed=confirmed, evidence=evidence,
    )  # fmt: skip


def _evidence(space: _Space, met: _Met) -> tuple[bool, str]:
    """What shooting finds on both sides of a place, and whether that is what it should be."""
    orbits = []
    for part in (1.0 - BESIDE, 1.0 + BESIDE):
        try:
            toy = space.toy_at(part * met.u)
            orbits.append(shoot(toy, float(met.orbit.x[0]), len(met.orbit)))
        except ValueError as error:
            return False, f"at {part} of the change: {error}"
    before, after = orbits
    x = float(met.orbit.x[0])
    here, there = (each.success and abs(each.phi_s - x) <= NEAR for each in orbits)
    said = f"before: {_said(before, here)}; beyond: {_said(after, there)}"
    return here and _agrees(met.effect, before, after, there), said


def _said(orbit: PeriodicOrbit, near: bool) -> str:
    """What shooting found, in a few words."""
    return f"multiplier {orbit.multiplier:.6g}" if near else "no such motion"


def _agrees(effect: Effect, before: PeriodicOrbit, after: PeriodicOrbit, there: bool) -> bool:
    """Whether motions before and beyond are those of an effect."""
    match effect:
        case Effect.DESTROYED:
            return not there
        case Effect.DESTABILISED:
            return not there or before.stable is not after.stable
        case Effect.RELABELLED | Effect.KINKED:
            return there and before.word != after.word
        case Effect.OPEN:
            return False


def _limits(orbit: PeriodicOrbit, names: Sequence[str], settings: Settings) -> Iterator[Limit]:
    """Each parameter alone, down and up, until the motion ends."""
    for name in names:
        space = _space(orbit, (name,), settings)
        for direction in (-1, 1):
            found = _met_along(space, np.array([float(direction)]), past=False)
            yield _limit(space, direction, found)


def _limit(space: _Space, direction: int, found: Sequence[_Met]) -> Limit:
    """What ends a motion as one parameter changes."""
    name = space.names[0]
    if not found or found[-1].effect not in ENDS:
        return Limit(
            parameter=name, direction=direction, value=math.nan, percent=math.nan, effect=None,
            kind="", cause="nothing as far as was looked",
        )  # fmt: skip
    met = found[-1]
    return Limit(
        parameter=name, direction=direction, value=float(getattr(space.toy_at(met.u), name)),
        percent=PERCENT * float(met.u[0]), effect=met.effect, kind=met.kind, cause=met.cause,
    )  # fmt: skip
