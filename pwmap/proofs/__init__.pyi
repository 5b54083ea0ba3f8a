"""Certificates of what pwmap found, and their checker."""

from .certificates import Refused as Refused
from .certificates import check_certificate as check_certificate
from .certificates import prove as prove
from .document import Certificate as Certificate
