"""Check certificates of piecewise-linear maps from nothing but their files.

Only the standard library is used, and no other part of the package. A map is given by affine pieces
over one parameter, and its iterates are composed anew. All is decided by signs of polynomials in
the parameter, at a number or on an open interval without roots: what holds at one value holds on
all of it.
"""

from pwmap.checking.certificate import check, check_certificate
from pwmap.checking.refusing import Refused

__all__ = ["Refused", "check", "check_certificate"]
