"""The error of a search that has lost one of its processes."""

from __future__ import annotations


class WorkerLostError(RuntimeError):
    """A process ended before its task was done, perhaps for lack of memory."""
