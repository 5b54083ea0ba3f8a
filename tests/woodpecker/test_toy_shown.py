"""Reprs of results of the toy and of maps of one's own: a line or two."""

import math

import pytest
from maps import everything

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
)


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
