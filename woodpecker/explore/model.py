"""Arrays that the views draw, computed from the state of a page without a browser."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from pwmap.diagrams.shown import listed
from woodpecker import (
    Event,
    Return,
    Trajectory,
    first_return,
    return_map,
    shoot,
    simulate,
)
from woodpecker.explore.state import PageState
from woodpecker.mechanics.modes import OPEN, mode_states
from woodpecker.plot.curve import ON_IT, Link, MapSamples, refined
from woodpecker.simulation import Impulse

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

COARSE, FINE = 256, 1000  # starts of a map: while a slider moves (one chunk for one thread), and at
# rest
BUDGET = 60_000  # returns spent on steep places at rest
BREAK = 0.08  # part of the height: while a slider moves, a larger step of the map is a gap
SAMPLES = 320  # of a motion
FALLING = 0.4  # s that are shown of a motion that does not return
RETURNS_MOST = 6  # that are shown of a motion that is not periodic
NEAR = 0.08  # rad: a periodic motion farther from the start is taken to be another one
SAME = 1e-13  # rad: a start this close to a periodic motion is kept, and its link, to the last bit


@dataclass(frozen=True, slots=True, eq=False)
class MapCurve:
    """The arrays of a map, ready to be drawn."""

    x: Floats  # (n,) the curve, with nan at its gaps
    y: Floats
    jumps: Floats  # (m, 4) lines from (x, y) to (x, y)
    crossings: Floats  # (m, 4) jumps that cross the diagonal
    steep: Floats  # (m, 4) unresolved intervals
    fixed: Floats  # (k,) fixed points
    stable: Bools  # (k,) whether they attract


class Mark(NamedTuple):
    """An event of a motion, as texts for the strip of its word."""

    symbol: str
    time: float
    what: str
    contacts: tuple[int, ...]
    impulses: str
    velocities: str


@dataclass(frozen=True, slots=True, eq=False)
class DrawnMotion:
    """The arrays of a motion; events are sampled twice, before and after them."""

    t: Floats  # (n,) [s]
    q: Floats  # (n, 3) coordinates
    u: Floats  # (n, 3) velocities
    closed: Ints  # (n,) contacts that are closed from each time on: bits 1, 2 and 4
    marks: tuple[Mark, ...]  # the events
    numbers: dict[str, float]  # period, drop, multiplier, ...
    message: str  # empty if all is well


# --- The toy --------------------------------------------------------------------------------------


def settled(state: PageState) -> tuple[PageState, str]:
    """The state with its start moved onto a periodic motion, and a message if none is near."""
    toy = state.toy
    if state.phi_s >= toy.phi_s_max:
        state = replace(state, phi_s=toy.phi_s_max - 0.01)
    if not state.periodic:
        return state, ""
    orbit = shoot(toy, state.phi_s, state.order)
    if orbit.success and abs(orbit.phi_s - state.phi_s) <= NEAR:
        smaller = orbit.message if orbit.minimal_period < orbit.order else ""
        kept = abs(orbit.phi_s - state.phi_s) <= SAME
        return state if kept else replace(state, phi_s=orbit.phi_s), smaller
    why = orbit.message
    if orbit.success:
        why = f"the nearest periodic motion is another one, at {orbit.phi_s:.4f} rad"
    return state, f"{why}; the motion from {state.phi_s:.4f} rad is shown"


def curves(state: PageState, fine: bool = False) -> Iterator[MapCurve]:
    """Yield P_order with its fixed points; if ``fine``, finer and finer samples of it."""
    toy, order, (low, _) = state.toy, state.order, state.window
    x = state.starts(FINE if fine else COARSE)
    y = return_map(toy, x, order).phi_s

    def slope(starts: Floats) -> Floats:
        return return_map(toy, starts, order).slope

    search: Iterable[MapSamples] = [_coarse(x, y, low)]
    if fine:
        search = refined(
            lambda s: return_map(toy, s, order).phi_s, x, y, bottom=low, cost=order, budget=BUDGET
        )
    for k, curve in enumerate(search):
        if k and k % 8 == 0:
            yield drawn(curve, curve.crosses, slope)
    yield drawn(curve, curve.crosses, slope)


def orbit(state: PageState) -> Floats:
    """Orbit of the start under P_order, (steps + 1,) or as far as it returns."""
    found = [state.phi_s]
    for _ in range(state.steps):
        if not found[-1] < state.toy.phi_s_max:
            break
        after = first_return(state.toy, found[-1], state.order).phi_s
        if not math.isfinite(after):
            break
        found.append(after)
    return np.array(found)


def trajectory(state: PageState) -> tuple[Trajectory, Return]:
    """The motion over one period or, if it is not periodic, a few returns; and its return."""
    toy, order = state.toy, state.order
    count = order if state.periodic else max(order, min(state.steps, RETURNS_MOST))
    back = first_return(toy, state.phi_s, count)
    if not _lasts(back) and count > order:
        back = first_return(toy, state.phi_s, order)
    end = back.period if _lasts(back) else FALLING
    return simulate(toy, state.phi_s, end, samples=SAMPLES), back


def _lasts(back: Return) -> bool:
    return math.isfinite(back.period) and back.period > 0.0


def motion(state: PageState) -> DrawnMotion:
    """The motion of :func:`trajectory` as arrays to draw."""
    found, back = trajectory(state)
    numbers = {
        "period": back.period, "drop": back.drop if _lasts(back) else found.drop,
        "multiplier": back.slope, "phi_s": state.phi_s,
    }  # fmt: skip
    return DrawnMotion(
        t=found.t, q=found.q, u=found.u, closed=closed_bits(found),
        marks=tuple(map(_mark, found.events)), numbers=numbers,
        message="" if back.status.success else back.status.value,
    )  # fmt: skip


# --- Maps -----------------------------------------------------------------------------------------


def _coarse(x: Floats, y: Floats, low: float) -> MapSamples:
    """Samples of a map in which large steps are left open, without refinement."""
    top = y[np.isfinite(y)].max(initial=low)
    seen = np.clip(np.where(np.isfinite(y), y, low), low, top)
    steep = np.abs(np.diff(seen)) > BREAK * max(top - low, ON_IT)
    links = np.where(steep, Link.OPEN, Link.CURVE)
    return MapSamples(x=x, y=y, links=links, bottom=low, evaluations=0)


def drawn(
    curve: MapSamples, crosses: Bools, slope: Callable[[Floats], Floats] | None = None
) -> MapCurve:
    """The lines of a map and its fixed points, which attract where the slope is below 1 in size.

    ``crosses`` (n - 1,) tells which intervals have end values on both sides of the diagonal. The
    ``slope`` is that between samples by default.
    """
    x, y, links = curve.x, curve.y, curve.links
    pairs = np.column_stack([x[:-1], y[:-1], x[1:], y[1:]])
    jumps = links == Link.JUMP
    fixed, slopes = curve.fixed(crosses)
    if slope is not None and len(fixed):
        slopes = slope(fixed)
    steep = pairs[links == Link.OPEN]
    steep = np.where(np.isfinite(steep), steep, curve.bottom)  # no value: line to the lower edge
    with np.errstate(invalid="ignore"):
        stable = np.abs(slopes) < 1.0
    return MapCurve(
        *curve.line(), pairs[jumps & ~crosses], pairs[jumps & crosses], steep, fixed, stable
    )


# --- Motions --------------------------------------------------------------------------------------


def closed_bits(trajectory: Trajectory) -> Ints:
    """Contacts that are closed from each sample on, or struck at it, as bits 1, 2 and 4."""
    starts, modes = trajectory.phases[:, 6], trajectory.phases[:, 7].astype(int)
    bits = np.array([
        sum(1 << k for k, s in enumerate(mode_states(int(mode))) if s != OPEN)
        for mode in modes
    ], dtype=np.int64)  # fmt: skip
    row = np.clip(np.searchsorted(starts, trajectory.t, side="right") - 1, 0, None)
    found: Ints = bits[row]
    for event in trajectory.events:
        if event.impulses:
            found[trajectory.t == event.time] |= sum(1 << (k - 1) for k in event.contacts)
    return found


def _mark(event: Event) -> Mark:
    what = event.kind.name.lower().replace("_", " ")
    named = {1: "beak", 2: "lower edge", 3: "upper edge"}
    which = listed(named[k] for k in event.contacts)
    impulses = "; ".join(map(_impulse, event.impulses)) or "no impulse"
    speeds = speeds_of(("dy", "dφM", "dφS"), event.u_before, event.u_after)
    return Mark(event.symbol, event.time, f"{what}: {which}", event.contacts, impulses, speeds)


def speeds_of(names: Iterable[object], before: Iterable[float], after: Iterable[float]) -> str:
    """The velocities that an event has changed, before and after it, as text."""
    changes = zip(names, before, after, strict=True)
    return " ".join(f"{name} {a:.4g} → {b:.4g};" for name, a, b in changes if a != b)


def _impulse(impulse: Impulse) -> str:
    normal = 1e6 * impulse.normal_compression, 1e6 * impulse.normal_expansion
    along = 1e6 * impulse.tangential_compression, 1e6 * impulse.tangential_expansion
    return (
        f"contact {impulse.contact}: Λ_N {normal[0]:.4g} + {normal[1]:.4g}, "
        f"Λ_T {along[0]:.4g} + {along[1]:.4g} µN s"
    )


def as_columns(motion: DrawnMotion) -> dict[str, Any]:
    """A motion as columns for time histories and portraits, in ms, mm, rad, m/s and rad/s."""
    y, phi_m, phi_s = motion.q.T
    dy, dphi_m, dphi_s = motion.u.T
    return {
        "t": 1e3 * motion.t, "y": 1e3 * y, "phi_m": phi_m, "phi_s": phi_s, "dy": dy,
        "dphi_m": dphi_m, "dphi_s": dphi_s, "closed": motion.closed,
    }  # fmt: skip
