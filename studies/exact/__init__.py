"""Exact maps: what composition, cycles, long runs and certificates cost."""
