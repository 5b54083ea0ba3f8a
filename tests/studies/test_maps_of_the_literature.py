"""Three maps of the literature: what the engine computes is published, or follows from it."""

from pathlib import Path

import numpy as np
import pytest
from short_runs import short_run

from studies.maps import boost as map_boost
from studies.maps import bouncing as map_bouncing
from studies.maps import grazing as map_grazing
from woodpecker.base.settings import Settings
from woodpecker.maps.derivatives import check_derivatives

LOCATED = 1e-12  # of a special point, relative


# --- The square-root map --------------------------------------------------------------------------


def test_the_square_root_map(tmp_path: Path) -> None:
    """Flips and grazings of the closed form, and the three published cases of period adding."""
    grazing = short_run("map_grazing", tmp_path)
    assert grazing["windows"] == 12
    assert grazing["largest_error"] < LOCATED
    assert grazing["two_impacts_error"] < 1e-10  # from the doubled branch, whose fold is flat there
    assert grazing["neighbours_overlap"] == {"overlap": True, "alternate": False, "none": False}
    assert grazing["attract"] == {"overlap": True, "alternate": True, "none": False}
    assert grazing["searched_missing"] == grazing["searched_others"] == 0


def test_the_closed_form_of_the_square_root_map_itself() -> None:
    """At its flip a maximal cycle has the multiplier -1; at its grazing its point is 0."""
    for alpha in (0.2, 0.5, 0.8):
        map_ = map_grazing.square_root_map(alpha)
        for m in (2, 3, 4):
            at, a = map_grazing.flip(alpha, m), alpha ** (m - 1)
            x = [(0.5 * a) ** 2]
            while len(x) <= m:
                x.append(map_.piece("R" if len(x) == 1 else "L").at(x[-1], at).value)
            assert x[m] == pytest.approx(x[0], abs=1e-15)
            x = [map_grazing.grazing(alpha, m)]  # the image of 0 is rho
            while len(x) < m:
                x.append(map_.at(x[-1], x[0]).value)
            assert x[-1] == pytest.approx(0.0, abs=1e-15)
        check_derivatives(map_, [(-0.5, 0.3), (0.4, 0.3)])


# --- The converter --------------------------------------------------------------------------------


def test_the_converter(tmp_path: Path) -> None:
    """It flips at its critical gain; a duty ratio that saturates is no special point."""
    boost = short_run("map_boost", tmp_path)
    assert boost["kappa_c"] == pytest.approx(0.08, abs=5e-4)
    assert boost["first_flip_error"] < LOCATED * 0.23  # of the span
    assert boost["special_points"] == 3
    assert boost["largest_difference"] < LOCATED
    assert boost["miscounted"] == 0
    assert boost["saturation_is_smooth"]
    assert boost["border_collisions"] == 0
    assert boost["saturation_error"] < LOCATED


def test_the_many_digits_and_the_map_are_one() -> None:
    map_ = map_boost.boost_map()
    for kappa in (0.05, 0.2):
        for v in (17.5, 22.0, 25.0, 26.0, 40.0):
            assert map_.at(v, kappa).value == pytest.approx(
                float(map_boost.step(v, kappa)), rel=1e-14
            )
    check_derivatives(map_, [(v, 0.2) for v in (18.0, 22.0, 25.0, 40.0)])


# --- The ball -------------------------------------------------------------------------------------


def test_the_ball(tmp_path: Path) -> None:
    """It stops to wait without a bifurcation and flips where that of no restitution does."""
    bouncing = short_run("map_bouncing", tmp_path)
    assert bouncing["stops_waiting"] == pytest.approx(np.sqrt(1.0 + np.pi**2), abs=1e-15)
    assert bouncing["stops_waiting_error"] < LOCATED
    assert bouncing["borders_are_smooth"]
    assert bouncing["flip"] == pytest.approx(np.sqrt(4.0 + np.pi**2), abs=1e-15)
    assert bouncing["flip_error"] < LOCATED
    assert bouncing["pair_waits_error"] < LOCATED
    assert bouncing["others"] == 0
    assert bouncing["miscounted"] == 0
    assert bouncing["attractors_and_missing"] == [9, 0]


def test_flights_end_where_the_ball_meets_the_table() -> None:
    """The height of the ball over the table, not divided by t^2, vanishes; nothing is before it."""
    for g in (1.5, 3.0, 4.4):
        for phi in np.linspace(map_bouncing.begin(g), np.pi - map_bouncing.begin(g) - 0.1, 9):
            t, by_phi, by_g = map_bouncing.flight(float(phi), g)
            times = np.linspace(0.02 * t, t, 50)
            height = np.sin(phi) + np.cos(phi) * times - times**2 / (2.0 * g) - np.sin(phi + times)
            assert abs(height[-1]) < 1e-14
            assert height[:-1].min() > 0.0
            h = 1e-5
            beside = [map_bouncing.flight(float(phi) + s, g)[0] for s in (-h, h)]
            assert by_phi == pytest.approx((beside[1] - beside[0]) / (2.0 * h), rel=1e-7, abs=1e-7)
            beside = [map_bouncing.flight(float(phi), g + s)[0] for s in (-h, h)]
            assert by_g == pytest.approx((beside[1] - beside[0]) / (2.0 * h), rel=1e-7, abs=1e-7)


def test_the_settings_of_the_studies_are_the_default_ones() -> None:
    """Nothing is tuned but the span and the window."""
    default = Settings()
    for settings in (map_boost.SETTINGS, map_bouncing.SETTINGS):
        for name in Settings.__dataclass_fields__:
            if name not in ("span", "window"):
                assert getattr(settings, name) == getattr(default, name)
