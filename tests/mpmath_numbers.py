"""Numbers of mpmath as rational ones."""

from fractions import Fraction

from mpmath import mpf
from mpmath.libmp import to_rational


def rational(x: mpf) -> Fraction:
    """The rational number that it is."""
    return Fraction(*map(int, to_rational(x._mpf_)))
