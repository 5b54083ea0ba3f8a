"""Check certificates of piecewise-linear maps from nothing but their files.

Only the standard library is used, and no other part of the package. A map is given by affine pieces
over one parameter, and its iterates are composed anew. Signs of polynomials in the parameter decide
everything, at a number or on an open interval without roots, on all of which they are the same.
"""

from pwmap.checking.certificate import check, check_certificate
from pwmap.checking.refusing import Refused

__all__ = ["Refused", "check", "check_certificate"]
