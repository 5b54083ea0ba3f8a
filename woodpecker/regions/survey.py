"""How regions of the plane are looked for."""

from __future__ import annotations

from dataclasses import dataclass

CHECKS = 60  # places without a contradiction: at most 5 % of the rectangle is wrong, as said below


@dataclass(frozen=True, slots=True, kw_only=True)
class Survey:
    """How to look for regions.

    Attributes
    ----------
    checks
        Random places at which cycles are counted; if none of n disagrees, what is wrong takes less
        than 3/n of the rectangle, with a probability of 95 %.
    curves
        How many curves are followed at most.
    finest
        Part of the spans between two places that disagree, from which on a diagram looks for what
        lies between.
    beside
        Part of the spans: places closer to a border are not compared, for curves are drawn as
        straight lines between their samples.
    thin
        Part of the spans: faces that are narrower are not looked at, and belong to a neighbour.
    samples
        Of a curve, each way.
    starts, transient, keep
        Orbits that show attractors: how many, how many iterates are cut, and how many are kept.
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
