"""Check certificates of piecewise-linear maps from their files alone.

Only the standard library is used, and no other part of the package. A map is given by affine pieces
over one parameter, and its iterates are composed anew. All decisions are signs of polynomials in
the parameter, at a number or on an open interval that holds no roots of theirs.
"""

from pwmap.checking.certificate import check, check_certificate
from pwmap.checking.refusing import Refused

__all__ = ["Refused", "check", "check_certificate"]
