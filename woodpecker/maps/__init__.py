"""Piecewise-smooth maps of the line: from formulas, functions or pieces, and their iterates."""
