"""Diagrams of the toy, searched in another process and shown while they grow."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Hashable, Iterator
from concurrent.futures import ThreadPoolExecutor, wait
from pathlib import Path

import numpy as np
import numpy.typing as npt

from pwmap import Diagram
from pwmap.explore.diagrams import shown
from pwmap.explore.figures import Shown
from woodpecker import (
    OrbitDiagram,
    PeriodicOrbit,
    Toy,
    ToyPieces,
    bifurcation_diagram,
    continuation,
    orbit_diagram,
    return_map,
    saved_diagram,
    shoot,
)
from woodpecker.explore.state import GUESS, PageState, home
from woodpecker.search import Stage
from woodpecker.slices import SettledOrbit

Floats = npt.NDArray[np.float64]

UPDATE_EVERY = 0.25  # s between the diagrams that are shown during a search
PLACES = {"A": (0.111, -0.884), "B": (0.29, -0.884), "C": (0.185, -0.757)}  # [Leine2001, Fig. 10]
SEARCHED = (-2.5, -0.24)  # window of phi_S [rad], left of the interval of fixed points
COLUMNS = 240  # values of the parameter in an orbit diagram
STARTS = (-0.53, -0.9)  # rad: near the paper's motion, and in the basins of others
TRIES = 9  # values of the parameter at which a motion is sought if the page has none


def key_of(state: PageState) -> Hashable:
    """All that the diagram of a state depends on; the toy's value of its parameter is not."""
    return *of_orbits(state), state.every, 1 if state.every else state.order


def of_orbits(state: PageState) -> tuple[Hashable, ...]:
    """All that the orbit diagram of a state depends on."""
    return home(state), state.over, state.span


def diagram(state: PageState) -> Iterator[Shown]:
    """Yield growing diagrams: of the motion's branches, or of all branches of some iterates."""
    stages, told = list[str](), 0
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(1) as thread:
        run = Path(folder) / "run.jsonl"
        search = thread.submit(_found, state, run, stages)
        while not search.done():
            wait([search], UPDATE_EVERY)
            if len(stages) > told and run.exists():
                told = len(stages)
                yield shown(_named(saved_diagram(run), state), stages[-1])
    yield shown(_named(search.result(), state))


def _found(state: PageState, run: Path, stages: list[str]) -> Diagram:
    def hear(stage: Stage) -> None:
        slices = f", slice {stage.slices}" if stage.slices else ""
        stages.append(f"P_{stage.order} at {stage.parameter:.4f}{slices}")

    parameter, span = state.over, state.span
    if state.every:
        return bifurcation_diagram(
            state.toy, parameter, span, state.every, SEARCHED, workers=1, progress=hear, run=run
        )
    orbit = start(state)
    return continuation(orbit.toy, orbit, parameter, span, progress=hear, run=run)


def start(state: PageState) -> PeriodicOrbit:
    """A periodic motion to follow: the paper's, the page's or another; ValueError without one."""
    low, high = state.span
    for toy, guess in _tries(state):
        if low <= getattr(toy, state.over) <= high and guess < toy.phi_s_max:
            orbit = shoot(toy, guess, state.order)
            if orbit.success and orbit.phi_s > SEARCHED[0]:  # the diagram can hold it
                return orbit
    raise ValueError(f"no periodic motion was found for {state.over} in {state.span}")


def _tries(state: PageState) -> Iterator[tuple[Toy, float]]:
    """Yield toys, each with a guess for its motion."""
    own, usual = (state.toy, state.phi_s), (home(state), GUESS)
    yield from (usual, own) if state.order == 1 else (own, usual)
    for value in np.linspace(*state.span, TRIES + 2)[1:-1].tolist():
        try:
            toy = state.toy.replace(**{state.over: value})
        except ValueError:
            continue
        yield from ((toy, guess) for guess in _guesses(toy))


def _guesses(toy: Toy) -> list[float]:
    x = np.linspace(*SEARCHED, 400)
    above = return_map(toy, x).phi_s - x
    with np.errstate(invalid="ignore"):
        at = np.flatnonzero(above[1:] * above[:-1] < 0.0)
    found: list[float] = (0.5 * (x[at] + x[at + 1])).tolist()
    return found


def _named(found: Diagram, state: PageState) -> Diagram:
    return found.named(PLACES) if state.over == "eps_n1" else found


def orbits(state: PageState) -> Iterator[tuple[Floats, Floats]]:
    """Yield points on which orbits settle, at more and more values of the parameter."""
    low, high = state.span
    values = np.linspace(low, high, COLUMNS)
    window = state.window[0], min(state.window[1], state.toy.phi_s_max)
    order = np.argsort([_bit_reversed(k) for k in range(COLUMNS)], kind="stable")
    map_ = ToyPieces(state.toy, state.over)
    waiting = list[SettledOrbit]()
    last = time.monotonic()
    for value in values[order].tolist():
        try:
            waiting += orbit_diagram(map_, [value], STARTS, window, transient=150, keep=48).orbits
        except ValueError:  # the toy cannot have this value
            continue
        if time.monotonic() - last > UPDATE_EVERY:
            yield OrbitDiagram(orbits=tuple(waiting), lost=0).points()
            waiting, last = [], time.monotonic()
    yield OrbitDiagram(orbits=tuple(waiting), lost=0).points()


def _bit_reversed(k: int) -> int:
    """The reversed bits of a number: in this order numbers fill an interval evenly."""
    return int(f"{k:08b}"[::-1], 2)
