"""The toy in Siconos, a general program for nonsmooth mechanics: its periods, errors and cost.

    python -m studies.peers.siconos_peer [--fast] [--out DIR]

Siconos [Acary2019] uses the Moreau-Jean scheme with Newton's impact law, as
:mod:`studies.peers.moreau` does (``theta``, 1/2), but shares no code with it: it gets the model as
numbers. Friction is Coulomb's contact by contact, so the toy must be one with
``expansion_friction="separate"``. Siconos comes with the system's Python (Debian: ``apt install
python3-siconos``), so :mod:`studies.peers.siconos_woodpecker` runs in a separate process. The
environment variable SICONOS_PYTHON names another interpreter. Without Siconos the study says so and
measures nothing.
"""

from __future__ import annotations

import json
import math
import os
import subprocess
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from studies.common.laws import CONTACT_BY_CONTACT
from studies.common.record import Results, command
from studies.peers.elsewhere import environment, why_not
from studies.peers.moreau import ENDED, LONGEST, LOST, word_of_states
from studies.peers.ode import IMAGE, PHI_S
from studies.peers.peer import LostError, PeerReturn, contact_by_contact
from woodpecker import Toy
from woodpecker.base.arrays import Floats
from woodpecker.mechanics.equations import (
    force_at_rest,
    force_per_stretch,
    gap_offsets,
    mass_matrix,
    normal_directions,
    tangential_directions,
)

PROGRAM = Path(__file__).with_name("siconos_woodpecker.py")  # no `siconos.py` may lie beside it
PYTHON = os.environ.get("SICONOS_PYTHON", "/usr/bin/python3")
Solver = Literal[
    "LEMKE", "NSGS"
]  # of Siconos, for friction in the plane; its ENUM and CPG fail here
TRANSIENT = 5  # cycles; the start lies on the exact cycle, the steps have one of their own
CYCLES = 12  # that are measured


class Run(NamedTuple):
    """What Siconos did from a start at rest on the section."""

    t: Floats  # s, shape (n,)
    q: Floats  # (y, phi_M, phi_S) [m, rad, rad], shape (n, 3)
    u: Floats  # their rates, shape (n, 3)
    returns: Floats  # t [s], y [m], phi_S [rad] at each return to the section, shape (m, 3)
    steps: int
    seconds: float  # of CPU in the time loop


def available() -> str:
    """Empty if Siconos can run, otherwise the sentence that says why not."""
    return why_not(PYTHON, "Siconos", "siconos.kernel, siconos.numerics")


def simulate_siconos(
    toy: Toy, phi_s: float, t_end: float, step: float, every: int = 1, solver: Solver = "LEMKE"
) -> Run:
    """Start at rest on the section and step until ``t_end``.

    Parameters
    ----------
    toy, phi_s
        The toy and the angle of the woodpecker at the start [rad].
    t_end, step
        Simulated time and step [s].
    every
        Keep the state of every so many steps; 0 keeps none, which is the way to measure time.
    solver
        Of the contact problems: Lemke's, or nonsmooth Gauss-Seidel.

    Raises
    ------
    ValueError
        If a number is out of range, or the toy is not under Coulomb's law contact by contact.
    LostError
        If Siconos is missing or fails; the sentence says why.
    """
    answer = _ask(_scene(toy, phi_s, t_end, step, solver) | {"samples": every})
    samples = np.array(answer["samples"]).reshape(-1, 7)
    return Run(
        t=samples[:, 0],
        q=samples[:, 1:4],
        u=samples[:, 4:],
        returns=np.array(answer["returns"]).reshape(-1, 3),
        steps=answer["steps"],
        seconds=answer["seconds"],
    )


def first_return_siconos(
    toy: Toy, phi_s: float, step: float = 2e-5, solver: Solver = "LEMKE"
) -> PeerReturn:
    """Start at rest on the section and step until phi_S has its next minimum while jammed.

    The word is read from the impulses of the steps, as :mod:`studies.peers.moreau` reads its own.
    Parameters and errors as for :func:`simulate_siconos`; LostError also if the toy does not
    return within three seconds.
    """
    scene = _scene(toy, phi_s, LONGEST, step, solver)
    answer = _ask(scene | {"returns": 1, "states": True})
    if not answer["returns"]:
        raise LostError(f"{LOST[ENDED]}; step {answer['steps']} of {step} s")
    t, y, image = answer["returns"][0]
    word = word_of_states(toy, np.array(answer["states"], dtype=np.int64))
    return PeerReturn(image, t, -y, word, answer["steps"])


def _scene(toy: Toy, phi_s: float, t_end: float, step: float, solver: Solver) -> dict[str, Any]:
    """The toy as numbers, K q = -h_1 (phi_S - phi_M)."""
    contact_by_contact(toy)
    if not (math.isfinite(phi_s) and phi_s < toy.phi_s_max):
        raise ValueError(f"phi_s must be finite and below {toy.phi_s_max:.6g}, got {phi_s}")
    if not 0.0 < step < t_end < math.inf:
        raise ValueError(f"expected 0 < step < t_end, got {step} and {t_end}")
    return {
        "mass": mass_matrix(toy),
        "stiffness": (-np.outer(force_per_stretch(toy), [0.0, -1.0, 1.0])).tolist(),
        "force": force_at_rest(toy),
        "normals": normal_directions(toy),
        "tangents": tangential_directions(toy),
        "offsets": gap_offsets(toy),
        "mu": [toy.mu_1, toy.mu_2, toy.mu_3],
        "eps": [toy.eps_n1, toy.eps_n2, toy.eps_n3],
        "q": [0.0, -toy.phi_m_max, phi_s],
        "step": step,
        "t_end": t_end,
        "theta": 0.5,
        "solver": solver,
        "returns": 0,
        "samples": 0,
        "states": False,
    }


def _ask(scene: dict[str, Any]) -> dict[str, Any]:
    """Run the program on a scene."""
    if reason := available():
        raise LostError(reason)
    ran = subprocess.run(
        [PYTHON, str(PROGRAM)],
        input=json.dumps(scene),
        env=environment(),
        capture_output=True,
        text=True,
    )
    if ran.returncode:
        raise LostError(f"Siconos failed: {ran.stderr.strip()[-200:]}")
    if "solver warning" in ran.stderr:
        raise LostError(f"Siconos did not solve every contact problem: {ran.stderr.strip()[-80:]}")
    answer: dict[str, Any] = json.loads(ran.stdout)
    return answer


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Period and cost of the stable cycle, and the error of one return, by step.

    Parameters
    ----------
    fast
        Take longer steps for the single returns.
    out
        Not used: there are no pictures.

    Returns
    -------
    dict
        ``cycle``, by step [s]: ``period_mean``, ``period_spread`` (standard deviation) [s] of
        ``cycles`` after a transient at eps_N1 = 0.5, and ``seconds_per_second``, CPU time per
        simulated time. ``return``: ``error`` of the image [rad], ``steps`` and ``word`` of one
        return of the nominal cycle, by step. Or ``skipped``, the sentence why not.
    """
    if reason := available():
        return {"skipped": reason}
    steps = (1e-4, 2e-5) if fast else (1e-3, 3e-4, 1e-4, 3e-5, 2e-5, 1e-5, 3e-6)
    returns = {}
    for step in steps:
        once = first_return_siconos(CONTACT_BY_CONTACT, PHI_S, step)
        error = abs(once.phi_s - float(IMAGE))
        returns[f"{step:.0e}"] = {"error": error, "steps": once.evaluations, "word": once.word}
    return {"cycle": {f"{step:.0e}": _cycle(step) for step in (1e-4, 2e-5)}, "return": returns}


def _cycle(step: float) -> Results:
    """Periods of the stable cycle and what a simulated second costs."""
    t_end = 0.15 * (TRANSIENT + CYCLES + 1)  # the period is 0.146 s
    run = simulate_siconos(CONTACT_BY_CONTACT, PHI_S, t_end, step, every=0)
    periods = np.diff(run.returns[:, 0])[TRANSIENT : TRANSIENT + CYCLES]
    return {
        "period_mean": float(periods.mean()),
        "period_spread": float(periods.std(ddof=1)),
        "cycles": len(periods),
        "seconds_per_second": run.seconds / t_end,
    }


if __name__ == "__main__":
    command(main, "peer_siconos")
