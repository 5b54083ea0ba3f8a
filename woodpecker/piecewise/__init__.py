"""Piecewise-smooth maps of the line: borders, orbits, branches."""
