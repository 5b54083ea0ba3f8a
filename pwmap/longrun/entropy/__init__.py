"""Topological entropy, the growth rate of laps, and parameter intervals where it is constant."""
