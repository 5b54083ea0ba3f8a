"""The smallest change of the toy's parameters that ends a periodic motion.

Changes are relative to each parameter's value; a restitution of zero changes upwards, absolutely.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np

from woodpecker.base.arrays import Floats
from woodpecker.base.checks import instance
from woodpecker.base.settings import Settings
from woodpecker.base.shown import shown
from woodpecker.mechanics.toy import WINDOW, Toy, known_parameter, parameters
from woodpecker.robustness.changes import FARTHEST, FLOOR, Space, on_line, space_of
from woodpecker.robustness.found import ENDS, Effect, Limit, Robustness, SmallestChange
from woodpecker.robustness.meeting import SPIKE, Key, LineEvent, met_along
from woodpecker.robustness.nearest import LEVEL, first_guesses, keep_smallest, nearest
from woodpecker.shooting import PeriodicOrbit, shoot
from woodpecker.slices.orbits import at_parameter, orbit_of

STEPPING = Settings(window=WINDOW, step=0.02, max_step=0.1)  # longer than for a picture: margins
# tell what lies between samples
LINE_LENGTH = 2.0  # length of a line, relative to the first-order distance of a condition
SHORT = 0.1  # limits of single parameters below this also start the search
MOST = 3  # conditions of each critical effect that are minimised,
MOST_HARMLESS = 1  # and of each harmless effect
ALIKE = 1e-5  # relative: closer changes are the same; a tenth of ``BESIDE``
BESIDE = SPIKE  # relative distance of toys on both sides of a change: far above rounding, far
# below the distance of two borders, and beyond a spike
NEAR = 0.02  # rad: motions farther apart are different; at a fold they move by about sqrt(BESIDE)
PERCENT = 100.0


def smallest_changes(
    toy: Toy,
    orbit: PeriodicOrbit,
    names: Sequence[str] | None = None,
    *,
    settings: Settings = STEPPING,
) -> Robustness:
    """How far the parameters of a toy can change until a stable periodic motion ends.

    Conditions are sought on straight lines from the toy: one that is closer only along a curved
    path is missed.

    Parameters
    ----------
    toy, orbit
        The toy, and a stable periodic motion of it, from :func:`woodpecker.shoot`.
    names
        The parameters that change; by default all but the length of the pole.
    settings
        Steps, window and tolerances; the span is replaced.

    Returns
    -------
    Robustness
        The smallest changes of all parameters together, and the limits of each alone.

    Raises
    ------
    ValueError, TypeError
        If the orbit did not converge, is not stable or belongs to another toy, or if ``names`` is
        empty or holds an unknown parameter.

    Examples
    --------
    >>> from woodpecker import Toy, shoot
    >>> from woodpecker.robustness import smallest_changes
    >>> toy = Toy()
    >>> found = smallest_changes(toy, shoot(toy, -0.53), ["mu_2"])
    >>> print(f"{100 * found.nearest.size:.4f} %, {found.nearest.cause}")
    3.4969 %, the multiplier is -1
    """
    instance("toy", toy, Toy)
    instance("settings", settings, Settings)
    wanted = _checked(toy, orbit, names)
    space = space_of(orbit, wanted, settings)
    seen = dict[Key, LineEvent]()
    single = tuple(_limits(orbit, wanted, settings))
    for guess in first_guesses(space):
        keep_smallest(
            met_along(space, guess, min(FARTHEST, LINE_LENGTH * float(np.linalg.norm(guess)))), seen
        )
    for each in single:
        if abs(each.percent) <= PERCENT * SHORT:
            axis = np.eye(len(wanted))[wanted.index(each.parameter)] * each.direction
            keep_smallest(met_along(space, axis, abs(each.percent) / PERCENT * (1.0 + LEVEL)), seen)
    found = _refined(space, seen)
    rows = sorted(_rows(orbit, space, found), key=lambda row: (not row.confirmed, row.size))
    harmless = [row for row in rows if row.effect not in ENDS]
    return Robustness(
        orbit=orbit, critical=tuple(row for row in rows if row.effect in ENDS),
        harmless=tuple(harmless), limits=single,
    )  # fmt: skip


def _checked(toy: Toy, orbit: PeriodicOrbit, names: Sequence[str] | None) -> tuple[str, ...]:
    instance("orbit", orbit, PeriodicOrbit)
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
    if isinstance(names, str) or not isinstance(names, Iterable):
        raise TypeError(f"names must be a list of parameters, got {shown(names)}")
    wanted = tuple(dict.fromkeys(known_parameter(name) for name in names))
    if not wanted or "pole" in wanted:
        raise ValueError(
            f"names must hold parameters of the toy other than the pole, got {tuple(names)!r}"
        )
    return wanted


def _refined(space: Space, seen: dict[Key, LineEvent]) -> list[tuple[LineEvent, float]]:
    """The conditions to report, each minimised, with its angle; without duplicates, by size."""
    done = dict[Key, tuple[LineEvent, float]]()
    while True:
        left = [met for key, met in seen.items() if key not in done and _counts(met, done)]
        if not left:
            break
        met = min(left, key=lambda each: each.size)
        done[met.key] = nearest(space, met, seen)
    found = list[tuple[LineEvent, float]]()
    for met, angle in sorted(done.values(), key=lambda each: each[0].size):
        if all(_differ(met, other) for other, _ in found):
            found.append((met, angle))
    return found


def _counts(met: LineEvent, done: Mapping[Key, object]) -> bool:
    if met.condition is None and met.effect not in ENDS:
        return False
    if not met.stable and met.effect is Effect.DESTABILISED:
        return False
    alike = sum(effect is met.effect for effect, _, _ in done)
    return alike < (MOST if met.effect in ENDS else MOST_HARMLESS)


def _differ(one: LineEvent, other: LineEvent) -> bool:
    apart = float(np.linalg.norm(one.u - other.u))
    return one.effect is not other.effect or apart > ALIKE * other.size


def _rows(
    orbit: PeriodicOrbit, space: Space, found: Sequence[tuple[LineEvent, float]]
) -> Iterator[SmallestChange]:
    """The rows to report, without harmless borders that exist at ``FLOOR`` but not at zero."""
    for met, angle in found:
        exact = _at_zero(orbit, space, met)
        if exact is not None:
            yield _row(*exact, met.effect, angle, space.names)
        elif met.effect in ENDS:
            yield _row(space, met, met.effect, angle, space.names)


def _at_zero(orbit: PeriodicOrbit, space: Space, met: LineEvent) -> tuple[Space, LineEvent] | None:
    """The condition with restitutions of exactly zero where u leaves them; None if not met."""
    zero = [k for k, name in enumerate(space.names) if getattr(orbit.toy, name) == 0.0]
    if not zero or (met.u[zero] > FLOOR).any() or len(zero) == len(space.names):
        return space, met
    kept = [name for k, name in enumerate(space.names) if k not in zero]
    exact = space_of(orbit, kept, space.settings)
    found = met_along(exact, np.delete(met.u, zero), met.size * (1.0 + ALIKE))
    near = [e for e in found if e.effect is met.effect and abs(e.size / met.size - 1.0) < ALIKE]
    return (exact, near[-1]) if near else None


def _row(
    own: Space, there: LineEvent, effect: Effect, angle: float, names: Sequence[str]
) -> SmallestChange:
    confirmed, evidence = _evidence(own, there)
    percents = dict(zip(own.names, (PERCENT * there.u).tolist(), strict=True))
    return SmallestChange(
        effect=effect, kind=there.kind, cause=there.cause, size=there.size,
        changes={name: percents.get(name, 0.0) for name in names},
        toy=own.toy_at(there.u), phi_s=float(there.orbit.x[0, 0]), word=there.orbit.word,
        stable=there.stable, angle=angle, confirmed=confirmed, evidence=evidence,
    )  # fmt: skip


def _evidence(space: Space, met: LineEvent) -> tuple[bool, str]:
    """Whether shooting on both sides of a change confirms the effect, and what it found."""
    there, found = met.orbit.x[:, 0], list[PeriodicOrbit]()
    before = _before(space, met)
    for part, guess in ((1.0 - BESIDE, before), (1.0 + BESIDE, 2.0 * there - before)):
        try:
            found.append(shoot(space.toy_at(part * met.u), guess.tolist(), len(there)))
        except ValueError as error:
            return False, f"at {part} of the change: {error}"
    near, goes_on = (each.success and abs(each.phi_s - float(there[0])) <= NEAR for each in found)
    said = f"before: {_said(found[0], near)}; beyond: {_said(found[1], goes_on)}"
    return near and _agrees(met.effect, found[0], found[1], goes_on), said


def _before(space: Space, met: LineEvent) -> Floats:
    """The points of the motion a little before a condition, by its pieces there."""
    line = space.line((1.0 - BESIDE) * met.u, met.u / met.size)
    pieces = [on_line(line, image) for image in met.orbit.images]
    found = at_parameter(orbit_of(pieces, met.orbit.x[:, 0], 0.0), space.settings)
    return met.orbit.x[:, 0] if found is None else found.x


def _said(orbit: PeriodicOrbit, near: bool) -> str:
    return f"multiplier {orbit.multiplier:.6g}" if near else "no such motion"


def _agrees(effect: Effect, before: PeriodicOrbit, after: PeriodicOrbit, there: bool) -> bool:
    match effect:
        case Effect.DESTROYED:
            return not there
        case Effect.DESTABILISED:
            return not there or before.stable is not after.stable
        case Effect.RELABELLED | Effect.KINKED:
            return there and before.word != after.word
        case Effect.SPIKED:
            return there and before.stable and after.stable
        case Effect.OPEN:
            return False


def _limits(orbit: PeriodicOrbit, names: Sequence[str], settings: Settings) -> Iterator[Limit]:
    for name in names:
        space = space_of(orbit, (name,), settings)
        for direction in (-1, 1):
            found = met_along(space, np.array([float(direction)]), past=False)
            yield _limit(space, direction, found)


def _limit(space: Space, direction: int, found: Sequence[LineEvent]) -> Limit:
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
