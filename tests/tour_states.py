"""The states of the tour as data, for the page of the docs that shows them without a server.

``python tests/tour_page.py`` writes them into ``docs/_static/tour``, one script for each step, as a
page may load scripts even from a file; ``toy.js`` beside them is that of the explorer.
"""

import json
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt
from jinja2 import Environment, PackageLoader

from woodpecker import ExpansionFriction
from woodpecker.explore.branches import diagram
from woodpecker.explore.model import MapCurve, as_columns, curves, motion, orbit, settled
from woodpecker.explore.state import ORDERS, PageState
from woodpecker.explore.tour import TOUR, TourStep
from woodpecker.explore.toy_page import SHAPE, shapes
from woodpecker.plot.motions import PORTRAITS

Floats = npt.NDArray[np.float64]

DIGITS = 5  # of numbers that are drawn, behind the point
LEFT_OUT = 6e-4  # of what a curve extends over: a sample this close to the line of others
NEAR_A, LAWS = 8, 10  # steps that show several states
BRANCHES = ("diagram", "graph")  # views for which branches are drawn


def script(number: int) -> str:
    """What a page loads to have a step."""
    text = json.dumps(recorded(number), ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    return f"tour.take({number}, {text});\n"


def toy_script() -> str:
    """What draws the toy, with the shape of the bird in it."""
    loader = PackageLoader("woodpecker.explore", "files")
    return Environment(loader=loader).get_template("toy.js").render(shapes=shapes()) + "\n"


def recorded(number: int) -> dict[str, Any]:
    """All that is shown of a step."""
    step = TOUR[number - 1]
    return {
        "title": step.title, "figure": step.figure, "text": step.text,
        "link": step.state.query(), "views": step.views,
        "rate": PORTRAITS[step.state.portrait][1], "portrait": step.state.portrait,
        "states": [_state(label, state) for label, state in _states(number, step)],
        "diagram": _diagram(step.state) if set(step.views) & set(BRANCHES) else None,
    }  # fmt: skip


def _states(number: int, step: TourStep) -> Iterator[tuple[str, PageState]]:
    """The states among which a step can be switched, each with its label."""
    state = step.state
    if number == NEAR_A:
        yield from ((f"P{'₁₂₃₄'[j - 1]}", replace(state, order=j)) for j in ORDERS)
    elif number == LAWS:
        texts = {"separate": "contact by contact", "summed": "bounded by the sum"}
        for law, text in texts.items():
            friction = ExpansionFriction(law)
            yield text, replace(state, toy=state.toy.replace(expansion_friction=friction))
    else:
        yield f"P{'₁₂₃₄'[state.order - 1]}", state


def _state(label: str, wanted: PageState) -> dict[str, Any]:
    """The motion of a state, its word, and the map with what happens on it."""
    state, message = settled(wanted)
    *_, curve = curves(state, fine=True)
    now = motion(state)
    columns = as_columns(now)
    rows = _rows({name: np.asarray(column, dtype=float) for name, column in columns.items()})
    numbers = {name: value if np.isfinite(value) else None for name, value in now.numbers.items()}
    return {
        "label": label, "order": state.order, "eps_n1": state.toy.eps_n1,
        "law": str(state.toy.expansion_friction), "message": message or now.message,
        "numbers": numbers, "shape": {name: getattr(state.toy, name) for name in SHAPE},
        "motion": {
            name: rounded(column[rows]) if name != "closed" else column[rows].tolist()
            for name, column in columns.items()
        },
        "marks": [[m.symbol, round(1e3 * m.time, DIGITS), *m[2:]] for m in now.marks],
        "map": _map(curve, state), "cobweb": rounded(orbit(state)),
    }  # fmt: skip


def _map(curve: MapCurve, state: PageState) -> dict[str, Any]:
    """The curve in its parts, jumps, crossings of the diagonal, and fixed points."""
    ends = np.flatnonzero(np.isnan(curve.y))
    parts = []
    for part in np.split(np.column_stack([curve.x, curve.y]), ends):
        drawn = part[np.isfinite(part).all(axis=1)]
        kept = drawn[thinned(drawn / np.ptp(state.window))] if len(drawn) else drawn
        parts += [[rounded(kept[:, 0]), rounded(kept[:, 1])]] if len(kept) else []
    return {
        "window": list(state.window), "parts": parts,
        "jumps": rounded(curve.jumps), "crossings": rounded(curve.crossings),
        "fixed": rounded(curve.fixed), "stable": curve.stable.tolist(),
    }  # fmt: skip


def _diagram(state: PageState) -> dict[str, Any]:
    """Branches of the motion over eps_N1, and their special points."""
    *_, last = diagram(state)
    lines, points = last.tables["lines"], last.tables["points"]
    drawn = []
    for p, x, color, dash in zip(*(lines[n] for n in ("xs", "ys", "color", "dash")), strict=True):
        way = np.column_stack([p, x])
        kept = way[thinned(way)]
        drawn.append([color, dash, rounded(kept[:, 0]), rounded(kept[:, 1])])
    names = ("x", "y", "label", "marker", "color", "kind", "cause")
    marked = list(zip(*(points[name] for name in names), strict=True))
    return {"lines": drawn, "points": [[*map(_short, each)] for each in marked]}


def _rows(columns: dict[str, Floats]) -> npt.NDArray[np.int64]:
    """Samples of a motion that are kept: those that the others do not say, and all events."""
    size = {name: max(float(np.ptp(column)), 1e-12) for name, column in columns.items()}
    closed = columns["closed"]
    t = columns["t"]
    parts = np.column_stack([columns[n] / size[n] for n in columns if n != "closed"])
    events = np.flatnonzero((closed[1:] != closed[:-1]) | (t[1:] == t[:-1]))
    must = np.unique([0, *events, *(events + 1), len(t) - 1])
    kept = [start + thinned(parts[start : end + 1]) for start, end in pairwise(must)]
    found: npt.NDArray[np.int64] = np.unique(np.concatenate(kept))
    return found


def thinned(points: Floats) -> npt.NDArray[np.int64]:
    """Indices of the points (n, d) of a polyline that no line between others passes close by.

    Ramer, Douglas and Peucker: the farthest point from the line between two ends is kept, and both
    parts are looked at in the same way.
    """
    kept, parts = {0, len(points) - 1}, [(0, len(points) - 1)]
    while parts:
        first, last = parts.pop()
        if last - first < 2:
            continue
        along = points[last] - points[first]
        off = points[first + 1 : last] - points[first]
        share = off @ along / max(float(along @ along), 1e-300)
        away = np.linalg.norm(off - np.clip(share, 0.0, 1.0)[:, None] * along, axis=1)
        far = int(away.argmax())
        if away[far] > LEFT_OUT:
            middle = first + 1 + far
            kept.add(middle)
            parts += [(first, middle), (middle, last)]
    return np.array(sorted(kept), dtype=np.int64)


def rounded(values: npt.ArrayLike) -> Any:
    """Numbers as short as they can be drawn."""
    return np.round(np.asarray(values, dtype=float), DIGITS).tolist()


def _short(value: Any) -> Any:
    return round(value, DIGITS) if isinstance(value, float) else value
