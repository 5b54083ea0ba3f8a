"""Exact maps: the cost of composition, cycles, long runs and certificates."""
