"""Exact numbers, formulas, and the roots and signs of polynomials in the parameters."""
