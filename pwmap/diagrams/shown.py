"""Results as text of a line or two for a prompt, and as small tables for a notebook."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import MISSING, fields
from enum import Enum
from html import escape
from typing import Any

from pwmap.algebra.texts import text

ROWS = 24  # of a table in a notebook; the rest is counted
LONGEST = 60  # characters of a word that is shown


def changed(record: Any) -> str:
    """A record as the call that makes it, without arguments that have their default."""
    parts = []
    for each in fields(record):
        if each.init:
            usual = each.default_factory() if callable(each.default_factory) else each.default
            value = getattr(record, each.name)
            if usual is MISSING or value != usual:
                shown = value.value if isinstance(value, Enum) else value
                parts.append(f"{each.name}={shown!r}")
    return f"{type(record).__name__}({', '.join(parts)})"


def counted(number: int, noun: str) -> str:
    """``1 branch``, ``2 branches``."""
    plural = f"{noun}es" if noun.endswith(("ch", "s")) else f"{noun}s"
    return f"{number} {noun if number == 1 else plural}"


def listed(parts: Iterable[object]) -> str:
    """``a``, ``a and b``, ``a, b and c``."""
    *most, last = map(str, parts)
    return f"{', '.join(most)} and {last}" if most else last


def tally(values: Iterable[object]) -> str:
    """How often each value occurs, such as ``2 EP, 1 FF``, in the order of first occurrence."""
    return ", ".join(f"{number} {value}" for value, number in Counter(values).items())


def bracketed(interval: Any) -> str:
    """An interval of sympy with brackets, round at open ends; another set as sympy writes it."""
    if not hasattr(interval, "left_open"):
        return text(interval)
    left, right = "(" if interval.left_open else "[", ")" if interval.right_open else "]"
    return f"{left}{text(interval.start)}, {text(interval.end)}{right}"


def span(values: Any) -> str:
    """The least and the largest of some numbers, to six digits."""
    return f"{values.min():.6g} to {values.max():.6g}"


def brief(word: str, most: int = LONGEST) -> str:
    """A word, shortened at its end to at most ``most`` characters."""
    return word if len(word) <= most else f"{word[: most - 4].rstrip()} ..."


def table(caption: str, header: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """An HTML table without styles of its own; rows beyond :data:`ROWS` are counted."""
    lines = [_row("th", header), *(_row("td", row) for row in rows[:ROWS])]
    if len(rows) > ROWS:
        lines.append(f'<tr><td colspan="{len(header)}">and {len(rows) - ROWS} more</td></tr>')
    return f"<table><caption>{escape(caption)}</caption>{''.join(lines)}</table>"


def _row(tag: str, cells: Sequence[object]) -> str:
    return f"<tr>{''.join(f'<{tag}>{escape(text(cell))}</{tag}>' for cell in cells)}</tr>"
