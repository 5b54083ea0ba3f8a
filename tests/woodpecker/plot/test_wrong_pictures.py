"""What cannot be drawn, or not there: a sentence that names it, no AttributeError of matplotlib."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest

import pwmap.plot
from pwmap import PiecewiseLinearMap, bifurcation_diagram
from woodpecker import Toy, return_map, simulate
from woodpecker.plot import drawing, figures, motions, plane, regions

LONG: Any = pwmap.plot  # wrong kinds are the point here
TOY_IS: Any = drawing
FIGURES: Any = figures
MOTIONS: Any = motions
PLANE: Any = plane
REGIONS: Any = regions
TOY = Toy()
LINES = PiecewiseLinearMap.from_sympy("Piecewise((p + x/2, x <= 0), (p - 1 + x/3, True))")
FOUND = bifurcation_diagram(LINES, "p", (-1, 2), orders=(1,))
MOTION = simulate(TOY, -0.53, 0.02, samples=11)
RETURNS = return_map(TOY, np.linspace(-0.55, -0.5, 5))

WRONG: dict[str, tuple[Callable[[], object], str]] = {
    "number for axes": (lambda: LONG.plot_diagram(FOUND, 3), "^ax must be axes of .*, got 3$"),
    "figure for axes": (lambda: LONG.plot_diagram(FOUND, plt.figure()), "^ax must .*got <Figure"),
    "span for axes": (lambda: LONG.plot_map(LINES.at({"p": 1}), (0, 1)), r"got \(0, 1\)$"),
    "styles": (lambda: LONG.plot_diagram(FOUND, styles=[1]), r"^styles must be .*, got \[1\]$"),
    "plane": (lambda: LONG.plot_plane(3), r"^plane must be pwmap\.plane\.ParameterPlane, got 3$"),
    "attractors": (lambda: LONG.plot_attractors(3, LINES), "^found must be .*AttractorDiagram, go"),
    "long run": (lambda: LONG.plot_long_run(FOUND, FOUND, LINES), "^found must be .*got Diagram"),
    "entropy": (lambda: LONG.plot_entropy(3, "p", (0, 1)), "^expected a PiecewiseLinearMap"),
    "density": (lambda: LONG.plot_density(3), r"^found must be pwmap\.longrun\.Dynamics, got 3$"),
    "kneading": (lambda: LONG.plot_kneading(3), "^seen must be .*Dynamics, got 3$"),
    "returns": (lambda: FIGURES.plot_return_map(RETURNS, TOY), "^toy must be .*Toy, got ReturnMap"),
    "curve": (lambda: FIGURES.plot_curve(RETURNS), "^curve must be .*MapSamples, got ReturnMap"),
    "model": (lambda: FIGURES.plot_local(FOUND, FOUND), "^model must be .*LocalModel, got Diagram"),
    "histories": (lambda: MOTIONS.plot_time_history(TOY), "^trajectory must be .*, got Toy"),
    "portrait": (lambda: MOTIONS.plot_phase_portrait(TOY, "y", "dy"), "^trajectory must be"),
    "one of three": (lambda: MOTIONS.plot_time_history(MOTION, plt.gca()),
                     "^axes must be 3 axes of matplotlib, got <Axes"),
    "two of three": (lambda: MOTIONS.plot_phase_portraits(MOTION, list(plt.subplots(1, 2)[1])),
                     r"^axes must be 3 axes of matplotlib, got \[<Axes"),
    "list of curves": (lambda: PLANE.plot_curves([3]), r"^curves must be a mapping .*got \[3\]$"),
    "curves": (lambda: PLANE.plot_curves({"A": 3}), r"^curve must be woodpecker\.Curve, got 3$"),
    "regions": (lambda: REGIONS.plot_regions("x"), "^regions must be .*Regions, got 'x'$"),
    "toy": (lambda: TOY_IS.draw_toy(MOTION, (0, 0, 0)), "^toy must be .*Toy, got Trajectory"),
    "frames": (lambda: TOY_IS.draw_frames(TOY, [0.0], ["x"]), "^trajectory must be"),
    "film": (lambda: TOY_IS.animate(TOY, "x.gif"), "^trajectory must be .*Trajectory, got Toy"),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_what_cannot_be_drawn_is_named(name: str) -> None:
    call, sentence = WRONG[name]
    with pytest.raises(TypeError, match=sentence):
        call()
    plt.close("all")


def test_coordinates_of_the_toy_are_three() -> None:
    with pytest.raises(ValueError, match=r"^q must be y, phi_M and phi_S, of shape \(3,\), got"):
        drawing.draw_toy(TOY, (0.0, -0.1))


def test_a_film_has_a_path_or_its_text(tmp_path: Path) -> None:
    text = str(tmp_path / "toy.gif")
    assert drawing.animate(MOTION, text, slow=5.0, fps=10.0) == Path(text)
    assert Path(text).stat().st_size > 1000


@pytest.mark.parametrize(
    ("starts", "of", "drawn", "sentence"),
    [
        ((-0.5, -0.6, -0.55), 1, 1, "^returns must have two or more ascending starts, got Return"),
        ((-0.55,), 1, 1, "^returns must have two or more ascending starts, got ReturnMap.1 start"),
        ((), 1, 1, "^returns must have two or more ascending starts, got ReturnMap.0 starts"),
        ((-0.55, -0.5), 2, 1, "^returns must be of order 1, got some of order 2$"),
        ((-0.23, -0.225), 3, 2, "^returns must be of order 2, got some of order 3$"),  # no events
    ],
)
def test_returns_that_are_no_map_of_this_order(
    starts: tuple[float, ...], of: int, drawn: int, sentence: str
) -> None:
    """Starts that do not ascend were refined without end; orders were mixed in one picture."""
    with pytest.raises(ValueError, match=sentence):
        FIGURES.plot_return_map(TOY, return_map(TOY, np.array(starts), of), order=drawn)
    plt.close("all")


def test_frames_at_times_of_an_array() -> None:
    drawn = TOY_IS.draw_frames(MOTION, np.array([0.0, 0.01]), ["at rest", "later"])
    assert len(drawn.axes) == 2
    plt.close("all")
