"""Settings of the search for regions."""

from __future__ import annotations

from dataclasses import dataclass

CHECKS = 60  # random places that agree: at most 5 % of the rectangle is wrong, see below


@dataclass(frozen=True, slots=True, kw_only=True)
class Survey:
    """Settings of the search for regions; lengths are parts of the spans.

    Attributes
    ----------
    checks
        Random places at which cycles are counted; if all n agree, less than 3/n of the rectangle is
        wrong, with a probability of 95 %.
    curves
        Curves that are followed at most.
    finest
        Distance of two places that disagree from which on a diagram is computed between them.
    beside, thin
        Places closer to a border are not compared, as curves are straight between samples; narrower
        faces are not examined, and belong to a neighbour.
    samples
        Samples of a curve, each way.
    starts, transient, keep
        Numbers of orbits, of their iterates that are discarded, and of those that are kept.
    seed
        Of the random places.

    Examples
    --------
    >>> from woodpecker.regions import Survey
    >>> survey = Survey(checks=20, seed=1)  # 20 random places; the same each time
    >>> survey.checks
    20
    """

    checks: int = CHECKS
    curves: int = 100
    finest: float = 2.0**-11
    beside: float = 2.0**-9
    thin: float = 2.0**-9
    samples: int = 1500
    starts: int = 24
    transient: int = 400
    keep: int = 128
    seed: int = 1

    def __post_init__(self) -> None:
        from woodpecker.base.checks import number, whole  # a page of help needs no numpy

        for name in ("checks", "curves", "samples", "starts", "transient", "keep", "seed"):
            least = int(name != "seed")
            object.__setattr__(self, name, whole(name, getattr(self, name), least))
        for name in ("finest", "beside", "thin"):
            object.__setattr__(self, name, number(name, getattr(self, name)))
            if not 0.0 < getattr(self, name) < 1.0:
                raise ValueError(f"{name} must lie in (0, 1), got {getattr(self, name)}")
