"""All methods but Siconos, each over the values of its knob, and how much is measured."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

from studies.peers.cases import CYCLE, DIGITS
from studies.peers.enclosed import Enclosed, first_return_enclosed
from studies.peers.kernel import Precise, first_return_kernel, first_return_mpmath
from studies.peers.moreau import SCHEMES, SOLVERS, first_return_moreau
from studies.peers.ode import first_return_ode
from studies.peers.peer import LostError, PeerReturn
from woodpecker import Toy

KERNEL, PLAIN, TWIN = "kernel, compiled", "kernel, plain Python", "kernel, mpmath"
PROVER = "ball arithmetic"
OURS = (KERNEL, PLAIN, TWIN, PROVER)
AnyReturn = PeerReturn | Precise | Enclosed


class Setting(NamedTuple):
    """A method with its knob turned to one value."""

    method: str  # a key of style.METHODS
    variant: str  # solver of the contact problem, or ""
    knob: str  # "rtol", "step" or "digits"
    value: float
    peer: Callable[[Toy, float], AnyReturn]

    @property
    def noise(self) -> float:
        """Relative size of the error to be expected of one return."""
        return 10.0**-self.value if self.knob == "digits" else self.value


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """How much is measured."""

    rtols: tuple[float, ...] = tuple(10.0**-k for k in range(3, 13))
    solvers: tuple[str, ...] = ("RK45", "DOP853", "Radau", "LSODA")
    steps: tuple[float, ...] = (1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6)
    siconos: tuple[float, ...] = (1e-3, 1e-4, 1e-5)
    digits: tuple[int, ...] = (10, DIGITS, 50)
    bits: tuple[int, ...] = (53, 64, 80, 96, 128)
    rounds: int = 4
    whole_map: bool = True  # also for the plain kernel
    patience: float = 0.5  # s; a setting slower than this on the cycle goes no further
    halvings: int = 9  # of the step, to fit orders of convergence


FAST = Plan(
    rtols=(1e-4, 1e-8),
    solvers=("RK45", "DOP853"),
    steps=(1e-4, 1e-5),
    siconos=(1e-3,),
    digits=(10,),
    bits=(128,),
    rounds=1,
    whole_map=False,
    patience=0.05,
    halvings=5,
)


def peers(plan: Plan) -> Iterator[Setting]:
    """All methods but the kernel itself, over their knobs."""
    for digits in plan.digits:
        yield Setting(TWIN, "", "digits", digits, partial(first_return_mpmath, digits=digits))
    for bits in plan.bits:
        yield Setting(PROVER, "", "bits", bits, partial(first_return_enclosed, bits=bits))
    for solver in plan.solvers:
        for rtol in plan.rtols:
            peer = partial(first_return_ode, method=solver, rtol=rtol, atol=1e-2 * rtol)
            yield Setting(solver, "", "rtol", rtol, peer)
    for scheme in SCHEMES:
        for way in SOLVERS:
            for step in plan.steps:
                peer = partial(first_return_moreau, step=step, scheme=scheme, solver=way)
                yield Setting(f"Moreau, {scheme}", way, "step", step, peer)


def warm(settings: Iterable[Setting]) -> None:
    """Compile what is compiled: the kernel, and the coarsest setting of every method, run once."""
    first_return_kernel(CYCLE.toy, CYCLE.phi_s)
    known: set[tuple[str, str]] = set()
    for setting in settings:
        if setting[:2] not in known:
            known.add(setting[:2])
            try:
                setting.peer(CYCLE.toy, CYCLE.phi_s)
            except LostError:
                continue
