"""Proofs in ball arithmetic of what a computation has found; they need the extra ``proof``."""

from .proving import NotProved as NotProved
from .proving import check_certificate as check_certificate
from .proving import prove as prove
