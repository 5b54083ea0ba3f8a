"""Settings of the search for regions of two parameters."""

from __future__ import annotations

from dataclasses import dataclass

CHECKS = 60  # random places: if all agree, at most 5 % of the rectangle is wrong, see `Survey`


@dataclass(frozen=True, slots=True, kw_only=True)
class Survey:
    """Settings of the search for regions; distances are fractions of the spans.

    Attributes
    ----------
    checks
        Number of random places at which cycles are counted; if all n agree, less than 3/n of the
        rectangle is wrong, with a probability of 95 %.
    curves
        Largest number of curves that are followed.
    finest
        Distance to which two places that disagree are narrowed before a diagram is computed.
    beside, thin
        Places closer to a border than ``beside`` are not compared, since curves are straight
        between samples; faces thinner than ``thin`` are not examined and join a neighbour.
    samples
        Largest number of samples of a curve in each direction.
    starts, transient, keep
        Numbers of orbits, of their iterates that are discarded, and of those that are kept.
    seed
        Seed of the random places.

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
        from woodpecker.base.checks import number, whole  # help pages need no numpy

        for name in ("checks", "curves", "samples", "starts", "transient", "keep", "seed"):
            least = int(name != "seed")
            object.__setattr__(self, name, whole(name, getattr(self, name), least))
        for name in ("finest", "beside", "thin"):
            object.__setattr__(self, name, number(name, getattr(self, name)))
            if not 0.0 < getattr(self, name) < 1.0:
                raise ValueError(f"{name} must lie in (0, 1), got {getattr(self, name)}")
