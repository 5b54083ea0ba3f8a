"""What a prompt and a notebook show of results: a line or two, however much they hold."""

import pytest
from sympy import Piecewise, symbols

from pwmap import PiecewiseLinearMap, cycles, parameter_plane
from woodpecker import (
    Settings,
    Toy,
    from_sympy,
    return_map,
    shoot,
    simulate,
    slices_at,
)
from woodpecker.robustness import smallest_changes
from woodpecker.search.diagrams import cycle_near
from woodpecker.slices import borders_in

x, p = symbols("x p")
LINES = from_sympy(Piecewise((x / 2 + p, x < 0), (x / 3 + p - 1, True)), x, p, words=["L", "R"])
SETTINGS = Settings(span=(-1, 2), window=(-3, 3))
SKEW = PiecewiseLinearMap.from_sympy("Piecewise((a*x + 1, x <= 0), (b*x + 1, True))")


@pytest.mark.parametrize(
    ("found", "shown"),
    [
        (LINES.at(-1.0, 0.25), "Image(-0.25, slope=0.5, d_parameter=1, least margin 1, 'L')"),
        (LINES.at(float("nan"), 0.25), "Image('no piece of the map holds this point')"),
        (
            borders_in(LINES, 0.5, (-2, 2))[0],
            "Border(x=0, p=0.5: 'L' to 'R', jump -1, 'x = 0')",
        ),
        (
            cycle_near(LINES, -0.9, -0.5, SETTINGS),
            "Orbit(p=-0.5, x=-1, multiplier=0.5, 'L')",
        ),
        (
            slices_at(LINES, 0.5, (1,), SETTINGS)[0],
            "Slice(p=0.5, order 1: 0 cycles, 1 jump)",
        ),
        (
            cycles(SKEW, {"a": 2, "b": "-3/2"}, 6),
            "FoundCycles(9 cycles of period up to 6, 43 words looked at)",
        ),
        (
            parameter_plane(SKEW, "a", "b", ("1/4", "3/4"), (-5, "-1/2"), orders=(1, 2)),
            "ParameterPlane(a in [1/4, 3/4], b in [-5, -1/2]: 2 curves, 0 points, 1 strip)",
        ),
    ],
)
def test_a_result_in_a_line(found: object, shown: str) -> None:
    assert repr(found) == shown


def test_robustness_in_a_line() -> None:
    toy = Toy()
    assert repr(smallest_changes(toy, shoot(toy, -0.53), ["mu_2"])) == (
        "Robustness(PD at 3.497 %, the multiplier is -1; 2 critical changes, 0 harmless, 2 limits)"
    )


@pytest.mark.slow
def test_a_certificate_in_a_line() -> None:
    pytest.importorskip("flint")
    from woodpecker import prove

    shown = repr(prove(shoot(Toy(), -0.53)))
    assert shown.startswith("Certificate(orbit: 'The Woodpecker Toy (expansion friction summed)")
    assert len(shown) < 90


def test_tables_of_a_notebook() -> None:
    toy = Toy()
    map_, motion = return_map(toy, [-0.6, -0.5]), simulate(toy, -0.53, 0.1)
    for shown, rows in ((map_, len(map_)), (motion, len(motion.events))):
        table = shown._repr_html_()
        assert table.startswith(f"<table><caption>{type(shown).__name__}(")
        assert table.count("<tr>") == 1 + rows
    assert "<td>I3</td><td>impact</td>" in motion._repr_html_()
