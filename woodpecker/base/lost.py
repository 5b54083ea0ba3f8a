"""What a search says that has lost one of its processes."""

from __future__ import annotations


class WorkerLostError(RuntimeError):
    """A process ended before its task was done, for want of memory perhaps."""
