"""Arrays that the views of any system draw, as :mod:`woodpecker.explore.model` for the toy."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import islice, pairwise
from typing import Any

import numpy as np

from pwmap import Diagram
from pwmap.diagrams.files import table_as_text
from pwmap.explore.diagrams import shown
from pwmap.explore.exports import Files, made, of_all_pages
from pwmap.explore.figures import Shown
from woodpecker.base.arrays import Floats
from woodpecker.explore.model import DrawnMotion, MapCurve, Mark, drawn, speeds_of
from woodpecker.explore.system_state import SystemState, from_query
from woodpecker.plot.curve import Link, MapSamples
from woodpecker.systems import (
    MotionEvent,
    SystemCycle,
    SystemMap,
    continuation,
    return_map,
    shoot,
    simulate,
)

FIRST, DOUBLED = 17, 4  # starts of a one-dimensional map, and how often the intervals are halved
SAMPLES = 400  # of a motion
INSTANT = 1e-9  # shortest time that is shown [s], of a motion that does not get far
BREAK = 0.05  # part of the height: a larger step between different words is a gap
AFTER = 60  # returns of the orbit on which guesses for a periodic motion are taken
LOOKED = 5  # returns between these guesses, the last of which is tried first
NEAR = 0.25  # part of the window: a periodic motion farther from the start is another one
BRANCHES = (1, 4, 16, 64)  # numbers of branches after which a growing diagram is shown
ORDERS = (1, 2)  # of a diagram
EVENTS = {
    "I": "impact", "D": "detachment", "S": "slip", "J": "stick", "R": "reversal of slip",
    "C": "impacts that accumulate",
}  # fmt: skip


def settled(state: SystemState) -> tuple[SystemState, str]:
    """The state with its start moved onto a periodic motion, and a message if none is near."""
    if not state.periodic:
        return state, ""
    near = shoot(state.map_, state.x, order=state.order)
    cycle = near if near.success else _on_orbit(state, (state.order,))
    if not cycle.success:
        return state, f"{near.message}; the start is kept"
    room = np.array([high - low for low, high in state.given.window])
    if near.success and (np.abs(cycle.x[0] - state.x) > NEAR * room).any():
        return state, "the nearest periodic motion is another one; the start is kept"
    message = "" if near.success else f"{near.message}; this one is where orbits go"
    return replace(state, x=tuple(cycle.x[0].tolist())), message


def _on_orbit(state: SystemState, orders: Sequence[int]) -> SystemCycle:
    """A periodic motion of one of some orders, sought from late points of the start's orbit."""
    # If no periodic motion attracts, one may lie near earlier points of the orbit.
    map_ = state.map_
    for x in _returns(replace(state, order=1), AFTER)[::-LOOKED]:
        for order in orders:
            cycle = shoot(map_, x, order=order)
            if cycle.success:
                return cycle
    return cycle


def curves(state: SystemState) -> Iterator[MapCurve]:
    """Yield P_order in the window, finer and finer; of a map of several coordinates, its cycle."""
    map_ = state.map_
    if map_.d > 1:
        yield _cycle(map_, state)
        return
    x, y, words = np.empty(0), np.empty(0), np.empty(0, dtype=object)
    starts = np.linspace(*state.given.window[0], FIRST)
    for _ in range(1 + DOUBLED):
        found, place = return_map(map_, starts, order=state.order), np.searchsorted(x, starts)
        x, y = np.insert(x, place, starts), np.insert(y, place, found.images[:, 0])
        words = np.insert(words, place, np.array(found.words, dtype=object))
        yield _curve(x, y, words, state.given.window[0][0])
        starts = 0.5 * (x[1:] + x[:-1])


def orbit(state: SystemState) -> Floats:
    """Orbit of the start under P_order, (steps + 1, d) or as far as it returns."""
    return np.array(_returns(state, state.steps))


def _returns(state: SystemState, most: int) -> list[Floats]:
    map_, found = state.map_, [np.array(state.x)]
    while len(found) <= most:
        after = return_map(map_, found[-1][None], order=state.order).images[0]
        if not np.isfinite(after).all():
            break
        found.append(after)
    return found


def motion(state: SystemState) -> DrawnMotion:
    """The motion over ``order`` returns, or as far as it returns; at least its start."""
    map_, n = state.map_, state.map_.system.n
    x, values = np.array(state.x), map_.embedding.values(map_.p)
    start = map_.embedding.state(x, values)[0]
    end, message, first = 0.0, "", float(start[-1])
    for run in islice(map_.orbit(x, map_.p), state.order):
        end += float(run.z[-1] - map_.embedding.state(x, values)[0][-1])
        message = "" if run.status.success else run.message
        x = run.point
    if message and not end:  # no motion begins there, as behind a wall
        q, u = (np.tile(part, (2, 1)) for part in (start[:n], start[n:-1]))
        t, closed = np.array([0.0, INSTANT]), np.zeros(2, dtype=np.int64)
        return DrawnMotion(t=t, q=q, u=u, closed=closed, marks=(), numbers={}, message=message)
    begin = dict(zip(map_.system.state, start.tolist(), strict=True))
    found = simulate(map_.system, begin, first + max(end, INSTANT), samples=SAMPLES)
    numbers = {"period": end, **_multipliers(map_, state)}
    return DrawnMotion(
        t=found.t - first, q=found.q, u=found.u, closed=np.zeros(len(found.t), dtype=np.int64),
        marks=tuple(_mark(map_, event, first) for event in found.events), numbers=numbers,
        message=message,
    )  # fmt: skip


def diagram(state: SystemState) -> Iterator[Shown]:
    """Yield diagrams of the branches connected with the motion, with more and more of them."""
    state, _ = settled(state)
    own = state.map_
    map_ = SystemMap(own.system, own.section, [state.over])
    cycle = shoot(map_, state.x, order=state.order)
    if not cycle.success:
        cycle = _on_orbit(state, (state.order, *ORDERS))
    orders = tuple(sorted({*ORDERS, state.order, 2 * state.order}))
    for most in BRANCHES:
        found = continuation(
            map_, cycle, state.span, state.given.window, orders=orders, max_branches=most
        )
        if not found.left:
            break
        yield shown(found.diagram, f"branches so far: {len(found.diagram.branches)}")
    yield shown(found.diagram)


def _multipliers(map_: SystemMap, state: SystemState) -> dict[str, float]:
    """The largest multiplier if the motion is periodic, or the modulus of a complex pair."""
    cycle = shoot(map_, state.x, order=state.order) if state.periodic else None
    if cycle is None or not cycle.success:
        return {}
    largest = cycle.multipliers[0]
    return {"multiplier": float(largest.real if largest.imag == 0.0 else abs(largest))}


def _cycle(map_: SystemMap, state: SystemState) -> MapCurve:
    none, lines = np.empty(0), np.empty((0, 4))
    cycle = shoot(map_, state.x, order=state.order)
    fixed = cycle.x if cycle.success and state.periodic else np.empty((0, map_.d))
    stable = np.full(len(fixed), cycle.stable)
    return MapCurve(none, none, lines, lines, lines, fixed, stable)


def _mark(map_: SystemMap, event: MotionEvent, first: float) -> Mark:
    # digits that follow a letter are no contacts, but say how an impact went: I~1e17+2e26+3
    contacts = tuple(int(k) for k in re.findall(r"(?<![a-z\d])\d+", event.symbol))
    names = [c.name for c in map_.system.contacts]
    which = " and ".join(names[k - 1] for k in contacts if 1 <= k <= len(names))
    told = []
    for k in contacts if event.impulses.size else ():
        (cn, ct), (en, et) = event.impulses[0, :, k - 1], event.impulses[1, :, k - 1]
        told.append(f"contact {k}: Λ_N {cn:.4g} + {en:.4g}, Λ_T {ct:.4g} + {et:.4g} N s")
    speeds = speeds_of(map_.system.u, event.before, event.after)
    return Mark(
        event.symbol, event.time - first,
        f"{EVENTS.get(event.symbol[0], 'event')}: {which}", contacts,
        "; ".join(told) or "no impulse", speeds,
    )  # fmt: skip


def _curve(x: Floats, y: Floats, words: Any, bottom: float) -> MapCurve:
    """The lines of a map, with gaps where its word changes and its value jumps."""
    height = float(np.ptp(y[np.isfinite(y)])) if np.isfinite(y).any() else 0.0
    other = np.array([a != b for a, b in pairwise(words)])
    with np.errstate(invalid="ignore"):
        far = np.abs(np.diff(y)) > BREAK * height
    links = np.where(other & far, Link.OPEN, Link.CURVE)
    above = y - x  # exactly zero where a symmetric motion starts on a sample: counted once below
    with np.errstate(invalid="ignore"):
        crosses = (above[1:] * above[:-1] <= 0.0) & (above[:-1] != 0.0)
    return drawn(MapSamples(x=x, y=y, links=links, bottom=bottom, evaluations=0), crosses)


# --- Jobs in other processes ----------------------------------------------------------------------


def answers(state: SystemState) -> Iterator[Any]:
    """Yield all that a page shows of a state, the fast results first."""
    state, message = settled(state)
    yield state, message
    yield motion(state)
    yield orbit(state)
    yield from curves(state)


# --- Files ----------------------------------------------------------------------------------------


def _diagram(state: SystemState) -> Diagram:
    *_, last = diagram(state)
    return last.diagram


def _events_table(state: SystemState) -> str:
    rows = [(m.time, m.symbol, m.what, m.impulses, m.velocities) for m in motion(state).marks]
    return table_as_text(("t", "event", "what", "impulses", "velocities"), rows)


def _motion_table(state: SystemState) -> str:
    drawn, system = motion(state), state.given.map_.system
    header = ("t", *map(str, system.q), *map(str, system.u))
    return table_as_text(header, np.column_stack([drawn.t, drawn.q, drawn.u]).tolist())


FILES: Files = {
    "motion.csv": ("the motion (CSV)", _motion_table),
    "events.csv": ("its events (CSV)", _events_table),
    **of_all_pages(_diagram),
}


def export(path: str, name: str, query: str) -> Iterator[tuple[str, bytes]]:
    """Yield one of :data:`FILES` for the state of a link; ValueError for an unknown name."""
    yield from made(name, from_query(path, query), FILES)
