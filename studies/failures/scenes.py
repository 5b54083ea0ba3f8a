"""The scenes in which methods fail, each with its reference from the 30-digit program.

:mod:`studies.peers.reference_mpmath` shares no code with the packages. It starts from the same
doubles as the methods, so any difference is an error of the method alone. All scenes are under
Coulomb's law contact by contact, the only one that time stepping knows.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from decimal import Decimal
from functools import cache
from typing import NamedTuple

from mpmath import mp, mpf, nstr

from studies.common.laws import CONTACT_BY_CONTACT, SUMMED
from studies.common.places import SCALES
from studies.failures.judge import Truth
from studies.peers import reference_mpmath as reference
from studies.peers.cases import numbers
from woodpecker import Toy, ToyPieces, equilibrium, first_return, jam_limit, parameters
from woodpecker.slices import Border, BorderKind, borders_in

DIGITS = 30
STEP = 4e-3  # s, of the reference's Taylor series: longer ones are quicker, and change no digit
NOMINAL = -0.52947197  # rad, the stable cycle at eps_N1 = 0.5
# Around a jump or a grazing of P_1 at eps_N1 = 0.5 [rad], with no other one between them:
JUMP_C = (-0.760, -0.755)  # beak or sleeve first: the jump that point C lies on
JUMP_A = (-0.8855, -0.8840)  # the jump that A and B lie on
GRAZING = (-0.2779, -0.27786)  # the beak just misses the pole: a square root, no jump
TEN = tuple(10.0**-k for k in range(3, 15))
FEW = (1e-3, 1e-14)
MU = tuple(10.0**-k for k in range(6, 13, 2))  # distances from the jam's limit
SWING = 1e-2  # rad per unit of mu_2: start that far from the equilibrium, well inside the cone
SCALE = 1024.0  # a power of two: scaling by it makes no rounding error


class Start(NamedTuple):
    """One run: the toy, its start [rad], what should come out, and how far a border is."""

    toy: Toy
    phi_s: float
    truth: Truth
    distance: float = math.nan
    side: int = 0


class Scene(NamedTuple):
    """A row of the table."""

    name: str
    label: str
    why: str
    starts: tuple[Start, ...]
    border: Border | None = None


def scenes(fast: bool = False) -> tuple[Scene, ...]:
    """All scenes; with few distances, and without the slowest ones, if ``fast``."""
    toy, distances = CONTACT_BY_CONTACT, FEW if fast else TEN
    jump = "which of two impacts comes first decides between two motions"
    out = [
        _single("cycle", "stable cycle", "a motion without difficulties", toy, NOMINAL),
        around("jump A", "jump at $-0.884773$ rad", jump, JUMP_A, distances),
        around("grazing", "grazing at $-0.277882$ rad", "an impact vanishes with infinite slope",
               GRAZING, (1e-6,) if fast else distances),
        _single("chatter 0.009", r"chatter, $\varepsilon_{N1} = 0.009$",
                "bounces accumulate in finite time", toy.replace(eps_n1=0.009), -0.885),
    ]  # fmt: skip
    if not fast:
        out.insert(2, around("jump C", "jump at $-0.757787$ rad", jump, JUMP_C, distances))
        long = "a long fall: many free swings amplify every error"
        out += [
            _single("chatter 0.335", r"chatter, $\varepsilon_{N1} = 0.335$",
                    "the same with many bounces", toy.replace(eps_n1=0.335), -0.885),
            _single("dip left", "flank of a dip, $-1.2265$ rad", long, toy, -1.2265),
            _single("dip right", "flank of a dip, $-0.2663$ rad", long, toy, -0.2663),
        ]  # fmt: skip
    return (*out, *_contacts(toy, MU[:1] if fast else MU), *_scaled(toy, fast), open_impulse())


def _contacts(toy: Toy, distances: Sequence[float]) -> list[Scene]:
    """Scenes of one contact problem or one mode."""
    never = Start(toy, -0.05, Truth(None, "D2"))  # the gap is a (1 - cos): it touches, never closes
    return [
        jam(distances),
        Scene("grazes for ever", "grazes the pole for ever", "tangential once a period", (never,)),
        _single("hyperbolic", "upper edge slides up", "the mode's motion grows like exp(23 t)",
                toy.replace(eps_n1=0.3), -0.53),
        _single("eps 0", r"$\varepsilon_{N1} = 0$", "the beak stays on the pole",
                toy.replace(eps_n1=0.0), -0.6),
        _single("eps 1", r"$\varepsilon_{N1} = 1$", "the beak loses nothing",
                toy.replace(eps_n1=1.0), -0.6),
        _single("two contacts", "two contacts strike, one sticks",
                "friction decides in both phases of one impact", toy, -0.432),
    ]  # fmt: skip


def _scaled(toy: Toy, fast: bool) -> list[Scene]:
    """The stable cycle in other units: every angle must stay; all but the clock's if ``fast``."""
    same = "nothing may be scaled by hand"
    kinds: tuple[tuple[str, Callable[[Toy, float], Toy]], ...] = (
        ("masses", with_masses), ("lengths", with_lengths), ("clock", with_clock)
    )  # fmt: skip
    truth = exact(toy, NOMINAL)
    return [
        Scene(f"{name} {sign}{SCALE:.0f}", f"{name} {text} {SCALE:.0f}", same,
              (Start(change(toy, factor), NOMINAL, truth),))
        for name, change in kinds[: 2 if fast else 3]
        for sign, text, factor in (("/", "/", 1.0 / SCALE), ("x", r"$\times$", SCALE))
    ]  # fmt: skip


def with_masses(toy: Toy, factor: float) -> Toy:
    """Masses, inertias and stiffness times a factor: forces change, motions do not."""
    names = ("m_m", "j_m", "m_s", "j_s", "c_phi")
    return toy.replace(**{name: factor * getattr(toy, name) for name in names})


def with_lengths(toy: Toy, factor: float) -> Toy:
    """Lengths times a factor, masses and gravity kept: angles as functions of t / sqrt(factor)."""
    lengths = ("r_0", "r_m", "h_m", "l_m", "l_g", "h_s", "l_s", "c_phi")
    longer = {name: factor * getattr(toy, name) for name in lengths}
    return toy.replace(**longer, j_m=factor**2 * toy.j_m, j_s=factor**2 * toy.j_s)


def with_clock(toy: Toy, factor: float) -> Toy:
    """Time runs ``factor`` times as fast: gravity and stiffness grow with its square."""
    return toy.replace(g=factor**2 * toy.g, c_phi=factor**2 * toy.c_phi)


@cache
def exact(toy: Toy, phi_s: float, other: float = math.nan) -> Truth:
    """Image and word to 30 digits; the slope is the kernel's own.

    Raises
    ------
    ValueError
        If the reference is lost.
    """
    once = reference.first_return(phi_s, numbers(toy), DIGITS, step=STEP)
    if once.status != "returned":
        raise ValueError(f"the reference is lost from {phi_s}: {once.status}")
    with mp.workdps(2 * DIGITS):
        image = Decimal(nstr(once.phi_s, DIGITS + 10))
    return Truth(image, once.word, first_return(toy, phi_s).slope, other)


def _single(name: str, label: str, why: str, toy: Toy, phi_s: float) -> Scene:
    return Scene(name, label, why, (Start(toy, phi_s, exact(toy, phi_s)),))


def around(
    name: str, label: str, why: str, between: tuple[float, float], distances: Sequence[float]
) -> Scene:
    """Starts on both sides of a jump or a grazing of P_1, the root of a margin."""
    toy = CONTACT_BY_CONTACT
    (border,) = (
        each
        for each in borders_in(ToyPieces(toy), toy.eps_n1, between, SCALES)
        if each.kind(SCALES) in (BorderKind.JUMP, BorderKind.GRAZING)
    )
    jumps = border.kind(SCALES) is BorderKind.JUMP  # limits at a grazing agree, and tell nothing
    starts = []
    for distance in distances:
        for side, other in ((-1, border.outer.value), (1, border.inner.value)):
            phi_s = border.x + side * distance
            truth = exact(toy, phi_s, other if jumps else math.nan)
            starts.append(Start(toy, phi_s, truth, distance, side))
    return Scene(name, label, why, tuple(starts), border)


def jam(distances: Sequence[float]) -> Scene:
    """Start beside the equilibrium with mu_2 just above and just below what holds it."""
    held, starts = CONTACT_BY_CONTACT, []
    limit, rest = jam_limit(held), equilibrium(held).phi_s
    for distance in distances:
        phi_s = rest - SWING * distance
        for side in (1, -1):
            toy = held.replace(mu_2=limit + side * distance)
            slips = slips_at_once(toy, phi_s)
            truth = Truth(None, "S2", leaves=True) if slips else exact(toy, phi_s)
            starts.append(Start(toy, phi_s, truth, distance, side))
    why = "beyond the friction cone by one part in a million and less"
    return Scene("jam", r"jam limit, $\mu_2 = 0.285187 \pm \delta$", why, tuple(starts))


def slips_at_once(toy: Toy, phi_s: float) -> bool:
    """Whether the jammed sleeve gives way at rest, to 30 digits."""
    with mp.workdps(2 * DIGITS):
        run = _at_rest(toy, phi_s)
        run.settle([])
        return "S2" in run.word


def _at_rest(toy: Toy, phi_s: float) -> reference.Run:
    """The reference on the section, before its first contact problem."""
    model = reference.Model(
        p={name: mpf(getattr(toy, name)) for name in parameters() if name != "pole"},
        step=mpf(STEP),
        summed=toy.expansion_friction is SUMMED,
        zero=mpf(10) ** (-mpf(2 * DIGITS) / 3),
    )
    q = [mpf(0), -model.gap_0[1] / model.p["h_m"], mpf(phi_s)]
    jammed = (reference.Touch.OPEN, reference.Touch.STICK, reference.Touch.OPEN)
    return reference.Run(model, q, [mpf(0)] * 3, jammed)


def open_impulse() -> Scene:
    """An impact whose compression ends at rest: the images from both ends of what is possible."""
    toy, phi_s = CONTACT_BY_CONTACT, -0.513
    ends = (image_from_end(toy, phi_s, 0), image_from_end(toy, phi_s, 1))
    why = "compression ends at rest, the contact laws leave the impulses on a segment"
    start = Start(toy, phi_s, Truth(None, ends=ends))
    return Scene("open impulse", "impulses not determined", why, (start,))


def image_from_end(toy: Toy, phi_s: float, end: int) -> float:
    """Image if the impulses of the first undetermined impact lie at one end of their segment."""
    with mp.workdps(2 * DIGITS):
        run = _at_rest(toy, phi_s)
        run.settle([])
        returned = False
        while not returned:
            try:
                returned = run.step()
            except reference.Lost:
                _expand_from(run, end)
        return float(run.q[2])


def _expand_from(run: reference.Run, end: int) -> None:
    """Finish the impact of the beak on the closed upper contact that the reference refused."""
    model, hit = run.model, (0, 2)
    small = model.zero * max(abs(reference.dot(model.w_n[i], run.u)) for i in hit)
    u, ends = reference.impact_phase(model, hit, run.u, [mpf(0)] * 2, small)
    floor = [model.eps_n[i] * x for i, x in zip(hit, ends[end], strict=True)]
    u, _ = reference.impact_phase(model, hit, u, floor, small, model.summed)
    resting = [i for i in hit if abs(reference.dot(model.w_n[i], u)) <= 1000 * small]
    run.u, run.known = reference.halted(u, resting), {i: 2 if i in resting else 1 for i in hit}
    run.mode = reference.decide(model, run.q, run.u, resting, run.known)
    run.fresh = True
