"""What a prompt and a notebook show of results: a line or two, however much they hold."""

import math

import pytest
from maps import everything

from pwmap import PiecewiseLinearMap, cycles, parameter_plane
from woodpecker import (
    ExpansionFriction,
    FormulaMap,
    FormulaPiece,
    Settings,
    Smooth,
    Toy,
    return_map,
    shoot,
    simulate,
    slices_at,
)
from woodpecker.examples import two_lines
from woodpecker.robustness import smallest_changes
from woodpecker.search.diagrams import cycle_near
from woodpecker.slices import borders_in

LINES = two_lines()
SETTINGS = Settings(span=(-1, 2), window=(-3, 3))
SKEW = PiecewiseLinearMap.from_sympy("Piecewise((a*x + 1, x <= 0), (b*x + 1, True))")


@pytest.mark.parametrize(
    ("found", "shown"),
    [
        (LINES.at(-1.0, 0.25), "Image(-0.25, slope=0.5, d_parameter=1, least margin 1, 'L')"),
        (LINES.at(float("nan"), 0.25), "Image('no piece of the map holds this point')"),
        (borders_in(LINES, 0.5, (-2, 2))[0], "Border(x=0, p=0.5: 'L' to 'R', jump -1, 'x = 0')"),
        (cycle_near(LINES, -0.9, -0.5, SETTINGS), "Orbit(p=-0.5, x=-1, multiplier=0.5, 'L')"),
        (slices_at(LINES, 0.5, (1,), SETTINGS)[0], "Slice(p=0.5, order 1: 0 cycles, 1 jump)"),
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


def test_tables_of_a_notebook() -> None:
    toy = Toy()
    map_, motion = return_map(toy, [-0.6, -0.5]), simulate(toy, -0.53, 0.1)
    for shown, rows in ((map_, len(map_)), (motion, len(motion.events))):
        table = shown._repr_html_()
        assert table.startswith(f"<table><caption>{type(shown).__name__}(")
        assert table.count("<tr>") == 1 + rows
    assert "<td>I3</td><td>impact</td>" in motion._repr_html_()


# --- Of the toy, and of maps of one's own ---------------------------------------------------------


def test_toys_and_settings_show_what_is_not_the_default() -> None:
    toy = Toy(eps_n1=0.3, pole=1.5, expansion_friction="separate")
    assert repr(Toy()) == "Toy()"
    assert repr(toy) == "Toy(eps_n1=0.3, pole=1.5, expansion_friction='separate')"
    assert eval(repr(toy)) == toy
    assert eval(repr(toy)).expansion_friction is ExpansionFriction.SEPARATE
    settings = Settings(span=(-1.0, 1.0), window=(-math.inf, 2.0), max_step=0.02)
    assert repr(settings) == "Settings(span=(-1.0, 1.0), window=(-inf, 2.0))"
    assert repr(Settings()) == "Settings()"


def test_motions() -> None:
    orbit = shoot(Toy(), -0.53)
    assert repr(orbit) == (
        "PeriodicOrbit(order=1, phi_s=-0.5294719671, period=0.14597607, drop=0.019445379, "
        "multiplier=-0.839156, word='S2 D2 I3 D3 I1 I3 D3 I2 D2 I2 J2')"
    )
    assert "<td>drop [mm]</td><td>19.445379</td>" in orbit._repr_html_()
    assert "message='the sleeve stays jammed" in repr(shoot(Toy(), -0.23))
    assert repr(simulate(Toy(), -0.53, 0.15)) == (
        "Trajectory(t_end=0.15, drop=0.01931, 1019 samples, 11 events "
        "'S2 D2 I3 D3 I1 I3 D3 I2 D2 I2 J2', 'the requested time was reached')"
    )
    assert repr(return_map(Toy(), [-0.5, -0.6, -0.7])) == (
        "ReturnMap(3 starts from -0.7 to -0.5, 3 words: 3 returned)"
    )
    assert repr(return_map(Toy(), [])) == "ReturnMap(0 starts, 0 words: )"


@pytest.mark.slow
def test_maps_of_ones_own() -> None:
    low = FormulaPiece("low", Smooth(lambda x, p: p - 2.0), {"x is 0": Smooth(lambda x, p: -x)})
    map_ = FormulaMap([low, FormulaPiece("high", Smooth(lambda x, p: p - 1.25 * x))])
    assert repr(map_) == "FormulaMap('low', 'high')"
    assert repr(low) == "FormulaPiece('low', borders: x is 0)"
    assert "<td>high</td><td>none</td>" in map_._repr_html_()
    settings = Settings(span=(-0.5, 1.5), window=(-3.0, 3.0))
    lines = repr(everything(map_, settings)).splitlines()
    assert lines[0] == "Found(Diagram(x over p: 3 branches in [-0.5, 1.5], 5 special points"
    assert lines[-1].endswith("evaluations)")
