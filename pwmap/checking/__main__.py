"""The program ``python -m pwmap.checking certificate.json ...``."""

import io
import sys

from pwmap.checking import Refused, check_certificate


def main(names: list[str]) -> int:
    """Check files; the exit status is 1 if one of them is refused, 2 if none is given."""
    for stream in (sys.stdout, sys.stderr):  # a name may hold what a terminal cannot show
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    if not names:
        sys.stderr.write("usage: python -m pwmap.checking certificate.json ...\n")
        return 2
    refused = 0
    for name in names:
        try:
            sys.stdout.write(f"{name}: {check_certificate(name)}\n")
        except Refused as refusal:
            refused += 1
            sys.stderr.write(f"{name} is refused: {refusal}\n")
    return min(refused, 1)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
