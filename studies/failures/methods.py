"""The methods that are compared, each as a function of toy and start that never raises."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from studies.failures.judge import Outcome
from studies.peers.moreau import first_return_moreau
from studies.peers.ode import first_return_ode
from studies.peers.peer import LostError, Peer, PeerReturn
from woodpecker import Status, Toy, first_return
from woodpecker.base.compiled import COMPILED

NEEDS_NUMBA = "needs numba: a hundred thousand steps in plain Python take minutes"
OPEN_IMPULSE = "I~"  # how a word marks an impact whose impulses are not unique


class Method(NamedTuple):
    """A column of the tables."""

    name: str
    look: str  # key of style.METHODS
    run: Callable[[Toy, float], Outcome]
    missing: str = ""  # why it cannot run here


def methods(fast: bool = False) -> tuple[Method, ...]:
    """All that can run here; without LSODA and the fine step of Moreau's scheme if ``fast``."""
    missing = "" if COMPILED else NEEDS_NUMBA
    columns = (
        Method("kernel", "kernel, compiled" if COMPILED else "kernel, plain Python", kernel),
        Method("DOP853, rtol 1e-10", "DOP853", ode("DOP853", 1e-10)),
        Method("LSODA, rtol 1e-8", "LSODA", ode("LSODA", 1e-8)),
        Method("Moreau, step 1e-5 s", "Moreau, theta", moreau(1e-5), missing),
        Method("Moreau, step 1e-6 s", "Moreau, theta", moreau(1e-6), missing),
    )
    return (*columns[:2], columns[3]) if fast else columns


def kernel(toy: Toy, phi_s: float) -> Outcome:
    """The project's own return."""
    with np.errstate(over="ignore", invalid="ignore"):  # compiled code is silent, plain is not:
        once = first_return(toy, phi_s)  # derivatives of a motion with 1000 events overflow
    if not once.status.success:
        decided = once.status in (Status.FREE_FALL, Status.POLE_END, Status.AT_REST)
        return Outcome(None, once.word, once.status.value, decided)
    indeterminate = once.status is Status.RETURNED_INDETERMINATE
    return Outcome(once.phi_s, once.word, once.status.value, open_impulse=indeterminate)


def followed(peer: Peer, toy: Toy, phi_s: float) -> Outcome:
    """What a peer finds, or why it is lost."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # solvers warn where they struggle: the image shows it
            once = peer(toy, phi_s)
    except (LostError, ValueError) as error:
        return Outcome(None, message=str(error))
    if not math.isfinite(once.phi_s):
        return Outcome(None, once.word, "the image is not finite")
    return Outcome(once.phi_s, once.word, "returned", open_impulse=OPEN_IMPULSE in once.word)


def ode(method: str, rtol: float) -> Callable[[Toy, float], Outcome]:
    """One of the solvers of ``solve_ivp``, at a relative tolerance."""

    def peer(toy: Toy, phi_s: float) -> PeerReturn:
        return first_return_ode(toy, phi_s, method, rtol, 1e-2 * rtol)

    return partial(followed, peer)


def moreau(step: float) -> Callable[[Toy, float], Outcome]:
    """Moreau's theta scheme with a direct solver, at a step [s]."""

    def peer(toy: Toy, phi_s: float) -> PeerReturn:
        return first_return_moreau(toy, phi_s, step, scheme="theta", solver="lcp")

    return partial(followed, peer)
