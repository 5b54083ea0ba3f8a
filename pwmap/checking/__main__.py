"""The program ``python -m pwmap.checking certificate.json ...``."""

import sys

from pwmap.checking import Refused, check_certificate

try:
    for name in sys.argv[1:]:
        sys.stdout.write(f"{name}: {check_certificate(name)}\n")
except Refused as refusal:
    sys.exit(f"refused: {refusal}")
