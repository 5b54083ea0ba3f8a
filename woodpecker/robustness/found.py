"""Results of :func:`woodpecker.robustness.smallest_changes`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

from pwmap.diagrams.shown import counted
from woodpecker.mechanics.toy import Toy
from woodpecker.shooting import PeriodicOrbit


class Effect(Enum):
    """What a change of parameters does to a periodic motion.

    Examples
    --------
    >>> from woodpecker.robustness import Effect
    >>> [(effect.name, effect.value) for effect in Effect][:2]
    [('DESTROYED', 'destroyed'), ('DESTABILISED', 'unstable beyond')]
    """

    DESTROYED = "destroyed"
    DESTABILISED = "unstable beyond"
    KINKED = "another multiplier beyond"
    RELABELLED = "another word beyond"
    SPIKED = "unstable in a spike"
    OPEN = "not known beyond"


ENDS = (Effect.DESTROYED, Effect.DESTABILISED, Effect.OPEN)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SmallestChange:
    """The smallest change of parameters at which one condition holds, such as a fold.

    Attributes
    ----------
    effect, cause
        What happens to the motion, and a sentence on why.
    kind
        The code of the special point: LP, PD, BC, FF, FALL; ``word`` at any other border.
    size, changes
        Euclidean length of the scaled change, and the change of each parameter in percent of its
        value (of 1 if that is zero).
    toy, phi_s, word
        The toy there, x_0 of its motion on the section [rad], and the word of the motion before.
    stable
        Whether the motion is stable all the way; otherwise it has lost stability before.
    angle
        Sine of the angle between change and gradient, within the limits of the parameters: zero at
        a local minimum of the size.
    confirmed, evidence
        Whether shooting on both sides of the change confirms the effect, and what it found.

    Examples
    --------
    >>> from woodpecker import Toy, shoot
    >>> from woodpecker.robustness import smallest_changes
    >>> toy = Toy()
    >>> nearest = smallest_changes(toy, shoot(toy, -0.53), ["mu_2"]).nearest
    >>> nearest.effect.name, str(nearest.kind), f"{nearest.toy.mu_2:.9f}", nearest.confirmed
    ('DESTABILISED', 'PD', '0.289509232', True)
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
    """How far one parameter alone can change, up (direction 1) or down (-1).

    The motion ends at ``value``, a change by ``percent``; both are nan if no end was found. The
    other fields are those of :class:`SmallestChange`.

    Examples
    --------
    >>> from woodpecker import Toy, shoot
    >>> from woodpecker.robustness import smallest_changes
    >>> limits = smallest_changes(Toy(), shoot(Toy(), -0.53), ["mu_2"]).limits
    >>> [(limit.direction, round(limit.value, 9), str(limit.kind)) for limit in limits]
    [(-1, 0.289509232, 'PD'), (1, 0.315812983, 'PD')]
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
    """How far the parameters can change until a periodic motion ends.

    Attributes
    ----------
    orbit, limits
        The motion, and the limits of each parameter alone, down and up.
    critical
        Changes that destroy it, destabilise it or leave it unknown: confirmed first, then by size.
    harmless
        Changes of its word or multiplier, or to a spike of instability, in the same order.

    Examples
    --------
    >>> from woodpecker import Toy, shoot
    >>> from woodpecker.robustness import smallest_changes
    >>> toy = Toy()
    >>> found = smallest_changes(toy, shoot(toy, -0.53), ["mu_2"])
    >>> len(found.critical), str(found.nearest.kind), f"{100 * found.nearest.size:.4f} %"
    (2, 'PD', '3.4969 %')
    """

    orbit: PeriodicOrbit
    critical: tuple[SmallestChange, ...]
    harmless: tuple[SmallestChange, ...]
    limits: tuple[Limit, ...]

    def __repr__(self) -> str:
        first = self.nearest
        what = (
            "nothing confirmed" if first is None else f"{first.kind} at {100.0 * first.size:.4g} %"
        )
        cause = "" if first is None else f", {first.cause}"
        sizes = (
            counted(len(self.critical), "critical change"), f"{len(self.harmless)} harmless",
            counted(len(self.limits), "limit"),
        )  # fmt: skip
        return f"Robustness({what}{cause}; {', '.join(sizes)})"

    @property
    def nearest(self) -> SmallestChange | None:
        """The smallest confirmed change that ends the motion; None if there is none."""
        first = self.critical[0] if self.critical else None
        return first if first is not None and first.confirmed else None
