"""Shared by several tests of the toy: plain words, runs of the kernel, other processes."""

import math
import os
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from woodpecker.base.arrays import Codes, Floats, Ints
from woodpecker.mechanics.modes import (
    CHANGE,
    CONTACT,
    EPS,
    SHAPE,
    STEP,
    Numbers,
    fill,
    model,
    parameters_of,
)
from woodpecker.mechanics.toy import RESTITUTIONS, Toy
from woodpecker.motion.codes import EVENT_COLUMNS, NO_PATH, PHASE_COLUMNS
from woodpecker.simulation import calls
from woodpecker.simulation.words import word

ROOT = Path(__file__).parents[1]


def plain(text: str) -> str:
    """A word without the letters that tell the phases of an impact apart."""
    return re.sub(r"(\d)(?:e\d+|[sfr-]+)", r"\1", text)


def in_another_process(code: str, *, timeout: float, **environment: str) -> str:
    """What a piece of code prints; TimeoutExpired if it hangs."""
    path = os.pathsep.join([str(ROOT), str(ROOT / "tests")])
    return subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        capture_output=True,
        text=True,
        check=True,
        timeout=timeout,
        cwd=ROOT,
        env=os.environ | {"PYTHONPATH": path} | environment,
    ).stdout


@dataclass(frozen=True, kw_only=True)
class Run:
    """What :func:`woodpecker.simulation.calls.run` leaves behind."""

    code: int
    z: Floats
    states: Ints
    word: str
    phases: Floats
    events: Floats


def run(
    toy: Toy,
    z: npt.ArrayLike,
    states: tuple[int, int, int],
    *,
    to_section: bool = False,
    t_end: float = math.inf,
    limit: int = 200,
) -> Run:
    """Follow the toy from any state z = (y, phi_M, phi_S, dy, dphi_M, dphi_S, t)."""
    state: Floats = np.array(z, dtype=float)
    modes: Ints = np.array(states, dtype=np.int64)
    codes: Codes = np.zeros(limit, dtype=np.int16)
    counts: Ints = np.zeros(3, dtype=np.int64)
    phases = np.zeros((limit + 1, PHASE_COLUMNS))
    events = np.zeros((limit, EVENT_COLUMNS))
    code = calls.run(
        model(toy), state, modes, to_section, t_end,
        codes, phases, NO_PATH, events, counts,
    )  # fmt: skip
    return Run(
        code=code,
        z=state,
        states=modes,
        word=word(codes[: min(counts[0], limit)].tolist()),
        phases=phases[: counts[1]],
        events=events[: counts[2]],
    )


def change(toy: Toy, parameter: str) -> Floats:
    """Derivative of the numbers of :func:`model` in a parameter of the toy, shape CHANGE."""
    numbers, rates, values = np.full(SHAPE, np.nan), np.zeros(CHANGE), parameters_of(toy)
    if parameter in Numbers._fields:
        values[Numbers._fields.index(parameter)] += 1j * STEP
    with np.errstate(all="ignore"):
        fill(values.tolist(), numbers, rates)
    if parameter in RESTITUTIONS:
        rates[CONTACT + RESTITUTIONS.index(parameter), EPS] = 1.0
    return rates
