"""Attractors over one parameter: exact samples, and the crises at which they change."""
