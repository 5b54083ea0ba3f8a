"""Why a run of the kernel stopped, in sentences."""

from __future__ import annotations

from enum import Enum

from woodpecker.motion import codes


class Status(Enum):
    """How a run ended; the value is a sentence.

    Examples
    --------
    >>> from woodpecker import Status
    >>> Status.FREE_FALL.value, Status.FREE_FALL.success
    ('free fall: the toy slides or falls along the pole for ever', False)
    """

    RETURNED = "the toy returned to the section"
    RETURNED_INDETERMINATE = (
        "the toy returned, but the contact laws leave the impulses of an impact open: "
        "the middle of all solutions was taken"
    )
    RETURNED_NO_SLOPE = "the toy returned, but no finite slope of the return map was found"
    TIME_REACHED = "the requested time was reached"
    FREE_FALL = "free fall: the toy slides or falls along the pole for ever"
    POLE_END = "free fall: the toy fell off the end of the pole"
    AT_REST = "the toy stays at rest on the pole"
    EVENT_LIMIT = "the event limit was reached before the toy returned"
    CONTACT_NO_SOLUTION = "a contact problem has no solution"
    CONTACT_AMBIGUOUS = "a contact problem has several solutions"
    NEVER_JAMS = "the sleeve cannot jam at any angle, mu_2 is too small: the toy never returns"
    OVERFLOW = "the motion leaves the numbers that double precision can hold"
    NO_IMAGE = "the map has no value at a point on the way"

    @property
    def success(self) -> bool:
        """Whether the run ended as asked."""
        return self in (Status.RETURNED, Status.RETURNED_INDETERMINATE, Status.TIME_REACHED)


# A status has the name of its code in the kernel; two of them have no code there.
_BY_CODE = {getattr(codes, each.name): each for each in Status if hasattr(codes, each.name)}


def status(code: int) -> Status:
    """Status of a kernel's return code."""
    return _BY_CODE[code]
