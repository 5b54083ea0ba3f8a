"""Check certificates of piecewise-linear maps from nothing but their files.

Only the standard library is used, and no other part of the package, so that a reader can follow
every step: a map is given by affine pieces whose coefficients are polynomials in one parameter, or
numbers; its iterates are composed anew. All that this takes is the sign of a polynomial in the
parameter, at a number or on an open interval where it has no root. So what is found at one value
holds on the whole interval.
"""

from pwmap.checking.certificate import check, check_certificate
from pwmap.checking.refusing import Refused

__all__ = ["Refused", "check", "check_certificate"]
