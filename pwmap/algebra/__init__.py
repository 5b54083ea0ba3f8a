"""Exact numbers, formulas, roots and signs of polynomials in the parameters."""
