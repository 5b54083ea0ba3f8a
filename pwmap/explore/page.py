"""The page: a form of controls, places for views, and letters between browser and server.

A *wish* names what to do; nothing in it is executed, and it is answered before the next one.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar
from urllib.parse import quote

import numpy as np
import numpy.typing as npt
from bokeh.core.properties import Any as Any_
from bokeh.core.properties import String
from bokeh.document import Document
from bokeh.model import DataModel
from jinja2 import Environment, FileSystemLoader, select_autoescape

from pwmap.explore.figures import Table
from pwmap.plot.palette import PERIODS

FOLDER = Path(__file__).parent / "files"
LONGEST = 20_000  # characters of a wish
PARAMETERS = "1:parameters"  # a group of controls; groups are sorted by their numbers
S = TypeVar("S")


class Letter(DataModel):  # type: ignore[misc]
    """A message as JSON: a wish of the user, or an answer that the page shows, with numbers."""

    text = String(default="")
    numbers = Any_(default=None)


def control(name: str, low: float, high: float, default: str, **more: Any) -> dict[str, Any]:
    """A slider with a field, which takes any value, for the template and the script of a page.

    ``more`` may have a ``label`` as HTML, a ``meaning``, a ``unit``, a ``step``, the ``group``
    it stands in, and whether the field is ``exact``.
    """
    usual = {"label": name, "meaning": f"parameter {name}", "unit": "-", "group": PARAMETERS}
    ends = {"low": low, "high": high, "step": (high - low) / 1000.0}
    return {"name": name, "default": default, "exact": False, **usual, **ends, **more}


def packed(tables: Mapping[str, Table]) -> tuple[dict[str, Table], npt.NDArray[np.float64]]:
    """Tables with each array replaced by its place in one array of all numbers, and that array."""
    told, parts, size = dict[str, Table](), [np.empty(0)], 0
    for name, columns in tables.items():
        told[name] = {}
        for column, values in columns.items():
            if isinstance(values, np.ndarray):
                parts.append(values.astype(float))
                told[name][column] = {"at": size, "n": values.size}
                size += values.size
            else:
                told[name][column] = list(values)
    return told, np.concatenate(parts)


def asked(document: Document, read: Callable[[str], S], initial: S) -> tuple[S, str]:
    """The state that the link of a page asks for, and a sentence if the link is not understood."""
    context: Any = document.session_context
    given = context.request.arguments if context is not None else {}
    text = "&".join(
        f"{quote(key)}={quote(value.decode(errors='replace'), safe=',/.-')}"
        for key, values in given.items() for value in values if not key.startswith("bokeh-")
    )  # fmt: skip
    try:
        return (read(text) if text else initial), ""
    except (ValueError, TypeError) as error:
        return initial, f"The link was not understood: {error}"


@lru_cache
def environment(folder: Path) -> Environment:
    """The templates of a folder, which may extend those of :data:`FOLDER`."""
    loader = FileSystemLoader([str(FOLDER), str(folder)])
    made = Environment(loader=loader, autoescape=select_autoescape(default=True))
    made.globals["periods"] = PERIODS
    return made


def in_words(error: Exception) -> str:
    """The sentence of an error, for the user."""
    if isinstance(error, KeyError):
        return f"unknown: {str(error)[:200]}"
    return str(error)[:500] or type(error).__name__


def read_wish(text: str) -> dict[str, Any]:
    """A wish from its text; ValueError unless it is one."""
    if len(text) > LONGEST:
        raise ValueError(f"a wish has at most {LONGEST} characters")
    asked = json.loads(text)
    if not isinstance(asked, dict) or not isinstance(asked.get("do"), str) or "n" not in asked:
        raise ValueError("a wish names what to do")
    return asked
