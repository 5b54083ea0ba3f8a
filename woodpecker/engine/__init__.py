"""Orbits of piecewise-smooth maps of R^d, and curves of them in any number of parameters."""
