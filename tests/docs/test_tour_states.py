"""What the page of the tour without a server has recorded is what the explorer shows today.

``python tests/tour_page.py`` records it anew.
"""

import json
from typing import Any

import numpy as np
import pytest
import tour_page

pytest.importorskip("bokeh")

import tour_states

FOLDER = (tour_page.DOCS / tour_page.LIVE).parent
STEPS = range(1, 11)
HALF = 0.5 * 10.0**-tour_states.DIGITS  # numbers are rounded


def kept(number: int) -> dict[str, Any]:
    text = (FOLDER / f"{number:02d}.js").read_text(encoding="utf-8")
    head, tail = f"tour.take({number}, ", ");\n"
    assert text.startswith(head)
    assert text.endswith(tail)
    found: dict[str, Any] = json.loads(text[len(head) : -len(tail)])
    return found


def test_the_toy_is_drawn_as_in_the_explorer() -> None:
    text = (FOLDER / "toy.js").read_text(encoding="utf-8")
    assert text == tour_states.toy_script()
    assert "{{" not in text  # nothing is left to be filled in


@pytest.mark.parametrize("number", STEPS)
def test_a_step_weighs_little(number: int) -> None:
    assert (FOLDER / f"{number:02d}.js").stat().st_size < 100_000


@pytest.mark.slow
@pytest.mark.parametrize("number", STEPS)
def test_what_is_recorded_is_what_is_shown_today(number: int) -> None:
    """Words, numbers and events; curves where they meet the diagonal, and special points."""
    old, new = kept(number), json.loads(json.dumps(tour_states.recorded(number)))
    assert [state["label"] for state in old["states"]] == [each["label"] for each in new["states"]]
    for name in ("title", "figure", "text", "link", "views", "rate"):
        assert old[name] == new[name]
    for was, now in zip(old["states"], new["states"], strict=True):
        assert [mark[0] for mark in was["marks"]] == [mark[0] for mark in now["marks"]]
        assert was["message"] == now["message"]
        assert now["numbers"] == pytest.approx(was["numbers"], rel=1e-6)  # as they are written
        times = [[mark[1] for mark in each["marks"]] for each in (was, now)]
        assert times[1] == pytest.approx(times[0], abs=2.0 * HALF)
        assert now["map"]["fixed"] == pytest.approx(was["map"]["fixed"], abs=1e-3)  # of a chord
        assert now["motion"]["phi_s"][-1] == pytest.approx(was["motion"]["phi_s"][-1], abs=4 * HALF)
    if old["diagram"] is not None:
        ends = [np.array([each[:2] for each in o["diagram"]["points"]]) for o in (old, new)]
        assert ends[1] == pytest.approx(ends[0], abs=4.0 * HALF)
        looks = [[line[:2] for line in o["diagram"]["lines"]] for o in (old, new)]  # colour, dash
        assert looks[1] == looks[0]


def test_a_polyline_is_thinned_to_what_is_seen() -> None:
    """Chords of a parabola are h^2 / 4 too high in their middles, for spans h, and up to 5^(1/2)
    times less away from it; halving them makes at most twice as many as are needed."""
    x = np.linspace(0.0, 1.0, 1001)
    kept_rows = tour_states.thinned(np.column_stack([x, x**2]))
    off = np.abs(np.interp(x, x[kept_rows], x[kept_rows] ** 2) - x**2).max()
    steep = np.sqrt(5.0)
    assert off <= steep * tour_states.LEFT_OUT
    fewest = 0.5 / np.sqrt(steep * tour_states.LEFT_OUT)
    assert fewest <= len(kept_rows) <= 2.0 * steep * fewest
    corner = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.5, 1.0]])
    assert tour_states.thinned(corner).tolist() == [0, 1, 2, 3]
