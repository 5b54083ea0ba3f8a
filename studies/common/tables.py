"""Numbers and tables for pages: digits, units, and typographic signs."""

from __future__ import annotations

import re
from collections.abc import Sequence


def number(value: float, digits: int = 2) -> str:
    """A number with some significant digits, in powers of ten only if it is far from one."""
    if value != 0.0 and not 1e-3 <= abs(value) < 1e6:
        mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
        return minus(f"{mantissa}e{int(exponent)}")
    if abs(value) >= 10 ** (digits - 1):
        return minus(f"{value:.0f}")
    return minus(f"{float(f'{value:.{digits - 1}e}'):g}")


def fixed(value: float, decimals: int = 4) -> str:
    """A number with so many decimals."""
    return minus(f"{value:.{decimals}f}")


def minus(text: str) -> str:
    """The minus sign of print, but in exponents."""
    return re.sub(r"^-", "−", text)


def seconds(value: float) -> str:
    """A time in the unit that suits it, with three digits."""
    for scale, unit in ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs")):
        if value >= scale:
            return f"{number(value / scale, 3)} {unit}"
    return f"{number(value / 1e-9, 3)} ns"


def rows(header: Sequence[str], lines: Sequence[Sequence[str]]) -> str:
    """A table."""
    table = [header, ["---"] * len(header), *lines]
    return "\n".join("| " + " | ".join(line) + " |" for line in table)


def pretty(text: str) -> str:
    """Names of quantities as the paper writes them."""
    for plain, nice in (
        ("phi_S", "φ_S"), ("phi_M", "φ_M"), ("eps_N1", "ε_N1"), ("mu_2", "μ_2"), ("c_phi", "c_φ"),
        ("|", "\\|"),
    ):  # fmt: skip
        text = text.replace(plain, nice)
    return text


def shortest(value: float, paper_text: str) -> str:
    """A value with some digits more than the paper prints."""
    if value == int(value) and "." not in paper_text:
        return minus(f"{value:.0f}")
    decimals = len(paper_text.partition(".")[2])
    if abs(value) < 1e-3:
        return number(value, 3)
    return (
        minus(f"{float(f'{value:.{max(decimals + 4, 6)}g}'):g}")
        if abs(value) >= 1e3
        else minus(f"{value:.{decimals + 4}f}".rstrip("0").rstrip("."))
    )
