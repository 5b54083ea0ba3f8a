"""Returns to thirty digits, computed by an independent program and kept in a file.

`python tests/thirty_digits.py` writes the file again; a slow test recomputes its content.
"""

import csv
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Self

from mpmath import mp, mpf, nstr

from studies.peers import reference_mpmath

DIGITS = 30
FILE = Path(__file__).with_suffix(".csv")
LAWS = ("summed", "separate")
EVEN = (0.3, 0.3, 0.3)

# (phi_S, eps_N1, mu): jams and swings, hyperbolic modes (upper sleeve sliding up, words with R3),
# impacts at two contacts in every way the two laws let them stick and slide, sticking impacts,
# chatter (C1), both sides of jumps and the points A, B, C.
STATES = [
    *((phi_s, eps_n1, EVEN) for phi_s, eps_n1 in (
        (-0.35, 0.5), (-0.42, 0.75), (-0.43, 0.02), (-0.48, 0.8), (-0.52, 0.13),
        (-0.52947197, 0.5), (-0.66, 0.95), (-0.7577, 0.1851), (-0.7579, 0.1851), (-0.8, 0.125),
        (-0.8173, 0.0169), (-0.8847, 0.0422), (-0.88475, 0.11197), (-0.88478, 0.11197),
        (-0.885, 0.335), (-0.8849, 0.0105), (-0.95, 0.05), (-1.0, 0.31), (-1.1, 0.9),
        (-1.22, 0.5), (-1.2848, 0.6157), (-1.3431, 0.9342), (-1.4728, 0.3458), (-1.56, 0.43),
        (-1.58, 0.56), (-1.765, 0.1367), (-2.1086, 0.1469), (-2.228, 0.2814), (-2.349, 0.5),
        (-2.3495, 0.5),
    )),
    (-0.4309, 0.9623, (0.38, 0.35, 0.54)),
    (-0.4334, 0.1749, (0.51, 0.346, 0.53)),
    (-0.4368, 0.1319, (0.556, 0.319, 0.3286)),
    (-0.8333, 0.594, (0.4, 0.54, 0.42)),
    (-1.1189, 0.0655, (0.6, 0.4, 0.59)),
    (-1.2142, 0.1028, (0.48, 0.46, 0.456)),
]  # fmt: skip


@dataclass(frozen=True)
class Case:
    """Where a return starts, and of which toy."""

    law: str
    phi_s: float
    eps_n1: float
    mu_1: float
    mu_2: float
    mu_3: float

    def changes(self) -> dict[str, Any]:
        """What differs from the paper's data."""
        fields = asdict(self)
        return {"expansion_friction": fields.pop("law")} | {
            name: value for name, value in fields.items() if name != "phi_s"
        }

    def return_to_thirty_digits(self) -> reference_mpmath.Return:
        """Computed anew."""
        toy = {**reference_mpmath.PAPER, **self.changes()}
        return reference_mpmath.first_return(self.phi_s, toy, DIGITS)


CASES = [Case(law, phi_s, eps_n1, *mu) for law in LAWS for phi_s, eps_n1, mu in STATES]


@dataclass(frozen=True)
class Kept:
    """The word of a return, its image phi_S [rad], its duration [s] and how far it falls [m]."""

    word: str
    image: str
    period: str
    drop: str

    @classmethod
    def of(cls, exact: reference_mpmath.Return) -> Self:
        """Written to thirty digits."""
        assert exact.status == "returned"
        numbers = (
            nstr(number, DIGITS, strip_zeros=False)
            for number in (exact.phi_s, exact.period, exact.drop)
        )
        return cls(exact.word, *numbers)

    def numbers(self) -> tuple[mpf, mpf, mpf]:
        """Image, period and drop."""
        with mp.workdps(DIGITS + 5):
            return mpf(self.image), mpf(self.period), mpf(self.drop)


def read() -> dict[Case, Kept]:
    """What the file holds."""
    with FILE.open(newline="", encoding="utf-8") as file:
        return {
            Case(row["law"], *(float(row[name]) for name in list(row)[1:6])): Kept(
                **{name: row[name] for name in ("word", "image", "period", "drop")}
            )
            for row in csv.DictReader(file)
        }


def write(cases: Iterable[Case]) -> None:
    """Compute the returns and keep them."""
    rows = [asdict(case) | asdict(Kept.of(case.return_to_thirty_digits())) for case in cases]
    with FILE.open("w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
        table.writeheader()
        table.writerows(rows)


if __name__ == "__main__":
    write(CASES)
