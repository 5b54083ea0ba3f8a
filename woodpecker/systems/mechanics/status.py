"""The ways in which motions end."""

from __future__ import annotations

from enum import Enum


class MotionStatus(Enum):
    """How a motion ended; the value is the sentence a user reads."""

    RETURNED = "the system returned to the section"
    RETURNED_INDETERMINATE = (
        "the system returned, but the contact laws leave the impulses of an impact open: "
        "the middle of all solutions was taken"
    )
    TIME_REACHED = "the requested time was reached"
    AT_REST = "the system stays at rest: contacts hold all of it"
    HORIZON = "no return within the longest time of the section"
    STEPS_LIMIT = "no event within as many steps as allowed"
    EVENT_LIMIT = "the event limit was reached"
    NO_SOLUTION = "a contact problem has no solution"
    NOT_FOUND = "a contact problem of many contacts may have a solution, but none was found"
    AMBIGUOUS = "a contact problem has several solutions"
    OVERFLOW = "the motion leaves the numbers that double precision can hold"
    NO_FORCE = "a force has no finite value, as the root of a negative number has none"
    NO_SLOPE = "a derivative of a force is infinite, as that of a root at its zero"
    ENDLESS = "impacts follow each other in no time, and lose no speed"
    INSIDE = "the start lies inside a contact, or moves into the one that it has just left"
    PASSED = (
        "rounding has carried the system through a contact: impacts accumulate in turns, or times "
        "are far shorter than those asked for"
    )

    @property
    def success(self) -> bool:
        """Whether the motion ended as asked."""
        return self in (
            MotionStatus.RETURNED, MotionStatus.RETURNED_INDETERMINATE, MotionStatus.TIME_REACHED,
        )  # fmt: skip


class StoppedError(ValueError):
    """A motion cannot go on; its status, and a sentence that may say more."""

    def __init__(self, status: MotionStatus, detail: str = "") -> None:
        super().__init__(detail or status.value)
        self.status = status
