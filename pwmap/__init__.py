"""Exact analysis of piecewise-linear discontinuous maps; diagrams and their graphs."""
