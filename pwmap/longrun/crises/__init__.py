"""Attractors over one parameter: samples of it, where they change, and the crises in between."""
