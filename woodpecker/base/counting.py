"""Counts of the evaluations of a map."""

from __future__ import annotations

import threading

PHASES = 12  # in a return that counts as one evaluation; longer ones count in proportion


class Counter(threading.local):
    """The number of evaluations in each thread; copies start at zero."""

    evaluations = 0

    def __reduce__(self) -> tuple[type[Counter], tuple[()]]:
        return Counter, ()


def weight(phases: int) -> int:
    """As how many evaluations a return of so many phases counts."""
    return phases // PHASES or 1
