"""The command ``woodpecker robustness``: the smallest changes of the toy that end its motion."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import woodpecker
from pwmap.cli.results import Writers, results_in, table_in
from pwmap.cli.screen import TableFormat, option, show, table
from woodpecker.cli.options import GUESS, Near, Out, motion
from woodpecker.cli.toys import parameter_of
from woodpecker.mechanics.toy import Toy

FILES = ("robustness.csv", "limits.csv")
SHOWN = 5  # number of largest changes that are printed of a row; the table on disk has all
LIMITED = ("parameter", "direction", "value", "percent", "kind", "what")
LOCATED = ("effect", "kind", "cause", "size", "stable", "confirmed", "evidence", "phi_s", "word")


def robustness(
    toy: Toy,
    phi_s: Near = GUESS,
    parameters: Annotated[
        str | None,
        option("Parameters that change, such as eps_n1,mu_2; by default all but the pole."),
    ] = None,
    format_: TableFormat = None,
    out: Out = Path("out"),
) -> None:
    """Find the smallest change of the toy that ends its periodic motion, and each parameter's own.

    Example: woodpecker robustness --eps-n1 0.5 --out results
    """
    names = None if parameters is None else [parameter_of(each) for each in parameters.split(",")]
    with results_in(out) as results:
        found = woodpecker.robustness.smallest_changes(toy, motion(toy, phi_s), names)
        results.write(_tables(found))
        header = ("what", "size", "largest changes", "confirmed", "evidence")
        changes = map(_critical, (*found.critical, *found.harmless))
        limits = table(
            ("parameter", "change", "value", "what"), map(_limit, found.limits),
            "One parameter at a time",
        )  # fmt: skip
        show(table(header, changes, "All parameters at once"), limits)


def _tables(found: woodpecker.robustness.Robustness) -> Writers:
    rows = (*found.critical, *found.harmless)
    names = list(rows[0].changes) if rows else []
    changes = (
        (
            row.effect.value, row.kind, row.cause, row.size, row.stable, row.confirmed,
            row.evidence, row.phi_s, row.word, *(row.changes[name] for name in names),
        )
        for row in rows
    )  # fmt: skip
    limits = (
        (each.parameter, each.direction, each.value, each.percent, each.kind, _what(each))
        for each in found.limits
    )
    return {
        FILES[0]: table_in((*LOCATED, *(f"{name} [%]" for name in names)), changes),
        FILES[1]: table_in(LIMITED, limits),
    }


def _critical(row: woodpecker.robustness.SmallestChange) -> tuple[str, ...]:
    already = "" if row.stable else "; unstable before"
    what = f"{row.effect.value} ({row.kind}): {row.cause}{already}"
    ordered = sorted(row.changes.items(), key=lambda item: -abs(item[1]))
    largest = ", ".join(f"{name} {value:+.3g} %" for name, value in ordered[:SHOWN])
    seen = "yes" if row.confirmed else "open"
    return what, f"{100.0 * row.size:.4g} %", largest, seen, row.evidence


def _limit(each: woodpecker.robustness.Limit) -> tuple[str, ...]:
    if math.isfinite(each.percent):
        return each.parameter, f"{each.percent:+.4g} %", f"{each.value:.8g}", _what(each)
    return each.parameter, "up" if each.direction > 0 else "down", "", each.cause


def _what(each: woodpecker.robustness.Limit) -> str:
    return each.cause if each.effect is None else f"{each.effect.value}: {each.cause}"
