"""The paper's Figures 4 to 8, the sensitivities and the table of its numbers."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from needs import NEEDS_NUMBA, SLOW_TOY
from short_runs import is_picture, kept_run, short_run

from studies import paper_numbers, sensitivities
from studies.common import motion
from studies.figures import fig08_return_map as fig08
from studies.figures import fig08_vertices as vertices
from woodpecker import Toy, ToyPieces, equilibrium, shoot, simulate
from woodpecker.slices import nearest_border

PERIOD, PHI_S = 0.14597607, -0.52947197  # s, rad: the independent programs' values, to 8 digits
NOMINAL = "S2 D2 I3 D3 I1 I3 D3 I2 D2 I2 J2"
EIGHT = 5e-9  # half a unit of the eighth digit
SIX = 5e-7  # s; half a unit of the sixth digit of the event times
LENGTHS = ("r_0", "r_m", "h_m", "l_m", "l_g", "h_s", "l_s")


@pytest.mark.slow
def test_time_history(tmp_path: Path) -> None:
    results = short_run("fig04_time_history", tmp_path)
    assert is_picture(tmp_path / "fig04.png")
    assert results["period"] == pytest.approx(PERIOD, abs=EIGHT)
    assert results["drop"] == pytest.approx(0.0194454, abs=5e-8)
    assert results["extremes"]["phi_m"] == pytest.approx((-0.0006 / 0.0058, 0.0006 / 0.0058))
    assert results["extremes"]["phi_s"] == pytest.approx((PHI_S, 0.12), abs=EIGHT)
    assert [symbol for symbol, _ in results["events"]] == NOMINAL.split()


@pytest.mark.slow
def test_phase_portraits(tmp_path: Path) -> None:
    bird = short_run("fig05_phase_woodpecker", tmp_path)
    rest = short_run("fig06_phase_others", tmp_path)
    assert is_picture(tmp_path / "fig05.png")
    assert is_picture(tmp_path / "fig06.png")
    assert bird["phi_s"] == pytest.approx((PHI_S, 0.12), abs=EIGHT)
    assert bird["beak_restitution"] == pytest.approx(0.5, abs=1e-14)  # eps_N1, contact 1 alone
    assert rest["phi_m"] == pytest.approx((-0.0006 / 0.0058, 0.0006 / 0.0058))
    assert rest["dy"][0] < -0.3 < 0.0 < rest["dy"][1]  # it falls, and is thrown up once


@pytest.mark.slow
def test_frames(tmp_path: Path) -> None:
    results = short_run("fig07_frames", tmp_path)
    assert is_picture(tmp_path / "fig07.png")
    numbers, symbols, times = zip(*results["frames"], strict=True)
    assert numbers == tuple(range(1, 9))
    assert symbols == ("S2", "D2", "I3", "I1", "I3", "D3", "I2", "J2")
    known = (0.028410, 0.034231, 0.045120, 0.048221, 0.048801, 0.050656, 0.085944, 0.134793)
    assert times == pytest.approx(known, abs=SIX)
    assert results["second_impact"] == pytest.approx(0.088673, abs=SIX)


def test_frames_refuse_another_motion() -> None:
    _, nominal = motion.cycle()
    with pytest.raises(ValueError, match="no S2 for frame 1"):
        motion.frames(simulate(Toy(), -0.23, 0.01))
    assert len(motion.frames(nominal)) == 8


@SLOW_TOY
def test_return_map(tmp_path: Path) -> None:
    results = short_run("fig08_return_map", tmp_path)
    assert is_picture(tmp_path / "fig08.png")
    dips = [dip["phi_s"] for dip in results["dips"]]
    assert dips == pytest.approx([-1.224778184, -0.265942701], abs=5e-10)
    for dip in results["dips"]:  # P_1 ~ -c / sqrt(distance); the fit over six decades is 0.5 % off
        assert dip["left_power"] == pytest.approx(-0.5, abs=0.005)
        assert dip["right_log"] > 0.2
        assert dip["deepest"] < -1e6
    jumps = np.array(results["jumps"])
    for known in (-0.757787, -2.349291):
        assert np.abs(jumps[:, 0] - known).min() < 5e-7
    assert np.all(np.abs(jumps[:, 1] - jumps[:, 2]) > fig08.SEEN)
    assert len(jumps) == 20
    assert results["causes"] == ["the beak and the upper sleeve strike at once"]
    (stable,) = [(x, slope) for x, slope in results["fixed_points"] if abs(slope) < 1.0]
    assert stable == pytest.approx((PHI_S, -0.83916), abs=5e-6)


@NEEDS_NUMBA
@pytest.mark.parametrize(("law", "seen"), [("summed", False), ("separate", True)])
def test_the_jump_of_a_and_b_hardly_shows_in_figure_8(law: Any, seen: bool) -> None:
    """The paper names two jumps of its Figure 8, and not the one on which A and B lie."""
    toy = Toy(expansion_friction=law)
    jump = nearest_border(ToyPieces(toy), -0.8855, toy.eps_n1, 1e-3)
    assert jump is not None
    assert jump.x == pytest.approx(-0.8847733440, abs=1e-10)
    assert bool(fig08.seen([jump])) is seen


@pytest.fixture(scope="module")
def figure_8(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    results, folder = kept_run("fig08_vertices", tmp_path_factory)
    assert is_picture(folder / "fig08_vertices.png")
    return results


@SLOW_TOY
def test_the_sum_gives_figure_8_to_its_resolution(figure_8: dict[str, Any]) -> None:
    """3e-4 is half a unit of the graphic upwards; rounding alone leaves a quarter in the median."""
    summed, separate = figure_8["laws"]["summed"], figure_8["laws"]["separate"]
    for kind in ("double", "single"):
        assert summed[kind]["vertical"]["0.5"] < 3e-4
        assert summed[kind]["to_curve"]["0.9"] < 3e-4
        assert summed[kind]["within"] > 0.96 * summed[kind]["count"]
    assert summed["double"]["off"] == 0
    assert summed["single"] == separate["single"]  # the laws differ in double impacts only
    assert summed["double"]["count"] == separate["double"]["count"] == 228
    assert separate["double"]["vertical"]["0.5"] == pytest.approx(1.97e-2, rel=0.01)
    assert separate["double"]["off"] > 200
    assert separate["double"]["within"] < 10


@SLOW_TOY
def test_every_vertex_of_figure_8_is_counted(figure_8: dict[str, Any]) -> None:
    counts = [figure_8["laws"]["summed"][kind]["count"] for kind in ("double", "single", "jammed")]
    line = figure_8["line"]
    assert sum(counts) + line["count"] == figure_8["vertices"] == 909
    assert line["from_jammed"] < 1.0 * max(figure_8["unit"])  # the straight line, and no motion
    assert 0 < line["lost"] < line["count"]
    assert len(figure_8["off_at"]) == 2
    for x, _ in figure_8["off_at"]:  # beside the centre of dip 1
        assert x == pytest.approx(-1.224778, abs=0.01)
    assert figure_8["fixed_point"] == pytest.approx(PHI_S, abs=2.0 * figure_8["unit"][0])


def test_the_distance_to_a_curve_is_measured_across_it() -> None:
    """On a piece of slope m a point h above the map is h / sqrt(1 + m^2) away."""
    toy, x, h = Toy(), np.array([-0.53]), 1e-4
    once = vertices.return_map(toy, x)
    (distance,) = vertices.distances(toy, x, once.phi_s + h)
    slope = once.slope[0]
    assert distance == pytest.approx(h / np.hypot(1.0, slope), rel=1e-3)  # curvature 14 times h


@NEEDS_NUMBA
def test_ends_of_the_return_map() -> None:
    """The band of centres is the mirror image of the starts that stay jammed."""
    toy = Toy()
    ends, rest = fig08.ends(toy), equilibrium(toy).phi_s
    assert ends.band[1] == rest
    assert ends.band[0] == pytest.approx(2.0 * rest - ends.slides_from, abs=1e-14)
    assert ends.slides_from == pytest.approx(cone(toy), abs=1e-14)
    assert ends.falls_from == pytest.approx(-toy.phi_m_max, abs=1e-15)  # no spring force there
    assert ends.falls_to == pytest.approx(0.0097, abs=5e-5)


def cone(toy: Toy) -> float:
    """Angle where lambda_T2 = mu_2 lambda_N2 at rest on the jammed sleeve [Leine2001, Eqs. 6-10].

    With only phi_S free: phi_S'' = (h_3)/(J_S + m_S l_G^2), and the first two rows give the forces.
    """
    m, inertia = toy.m_s, toy.j_s + toy.m_s * toy.l_g**2

    def excess(phi_s: float) -> float:
        d = phi_s + toy.phi_m_max
        acceleration = (-toy.c_phi * d - m * toy.g * toy.l_g) / inertia
        tangential = m * toy.l_g * acceleration + toy.g * (m + toy.m_m)
        moment = m * toy.l_m * toy.l_g * acceleration - toy.c_phi * d + m * toy.g * toy.l_m
        return tangential - toy.mu_2 * (moment - toy.r_m * tangential) / toy.h_m

    low, high = excess(-0.3), excess(-0.1)  # it is linear in phi_S
    return -0.3 - 0.2 * low / (high - low)


@SLOW_TOY
def test_sensitivities(tmp_path: Path) -> None:
    results = short_run("sensitivities", tmp_path)
    assert is_picture(tmp_path / "sensitivities.png")
    assert results["largest_spread"] < 1e-5  # two steps, a factor of ten apart
    assert results["skipped"] == {"pole": "is infinite"}
    loose = results["unsettled"]
    assert loose["after"] == pytest.approx(loose["minima"][1], abs=2e-4)  # read off to 1e-4
    assert loose["beats"] == pytest.approx(0.14576182, abs=EIGHT)
    assert 0.0 < loose["explains"] < 0.5  # it is not all of the difference
    assert loose["start"] < loose["minima"][0] < PHI_S < loose["next"]
    found = results["sensitivities"]
    # Units of mass, length and time are free: T follows the unit of time, phi_S none of them. The
    # differences are good to 1e-7, see ``largest_spread``.
    for quantity, per_time in (("period", 1.0), ("phi_s", 0.0)):
        rate = {name: each[quantity] for name, each in found.items()}
        inertia, length = rate["j_m"] + rate["j_s"], sum(rate[name] for name in LENGTHS)
        mass = rate["m_m"] + rate["m_s"] + inertia + rate["c_phi"]
        assert mass == pytest.approx(0.0, abs=1e-6)
        assert length + 2.0 * inertia + rate["g"] + 2.0 * rate["c_phi"] == pytest.approx(
            0.0, abs=1e-6
        )
        assert -2.0 * rate["g"] - 2.0 * rate["c_phi"] == pytest.approx(per_time, abs=1e-6)


def test_an_explanation_gives_the_period_of_the_paper() -> None:
    orbit = shoot(Toy(), PHI_S)
    found = sensitivities.explanation(orbit, "l_s", -4.03)
    changed = shoot(Toy(l_s=found.value), PHI_S)
    assert changed.period == pytest.approx(0.1452, abs=1e-12)
    assert changed.phi_s == found.phi_s
    assert found.rounds_to_data
    spring = sensitivities.explanation(orbit, "c_phi", -0.395)
    assert set(spring.contradicts) == {"equilibrium", "eigenfrequency"}


def test_the_unit_of_the_last_digit() -> None:
    units = [sensitivities.unit(text) for text in ("0.1034", "-2.35", "5.0e-9", "1")]
    assert units == pytest.approx([1e-4, 1e-2, 1e-10, 1.0], rel=1e-12)


@SLOW_TOY
def test_paper_numbers(tmp_path: Path) -> None:
    results = short_run("paper_numbers", tmp_path)
    rows: dict[str, dict[str, Any]] = {row["quantity"]: row for row in results["rows"]}
    assert rows["period T [s]"]["ours"] == pytest.approx(PERIOD, abs=EIGHT)
    assert rows["period T [s]"]["relative_difference"] == pytest.approx(0.005345, abs=5e-7)
    assert rows["frequency without contact [Hz]"]["ours"] == pytest.approx(72.9085, abs=5e-5)
    assert set(results["differing"]) == {
        "period T [s]",
        "the same with M as printed [Hz]",
        "right end of P_1 on a straight line [rad]",
    }
    left_out = [row for row in results["rows"] if row["ours"] is None]
    assert len(left_out) == results["skipped"] == 11
    for kind in ("stable fixed points of P_1", "unstable fixed points of P_1"):
        row = rows[f"{kind} beside A"]  # Figure 11
        assert (row["ours"], row["separate"]) == (1, 0)
    assert rows["jump crossings of P_2 beside A"]["ours"] == 1
    assert rows["impacts of the lower edge"]["ours"] == 2
    assert all(row["remark"] == paper_numbers.HEAVY for row in left_out)


def test_the_last_digit_decides() -> None:
    row = paper_numbers.Row
    assert row("x", "0.53", 0.539, "").agrees
    assert row("x", "0.53", 0.541, "").agrees is False
    assert row("n", "1", 2.0, "").agrees is False
    assert row("n", "1", None, "").agrees is None
    assert row("x", "-2.0", -1.0, "").relative_difference == 0.5


@SLOW_TOY
def test_the_points_of_figure_10() -> None:
    found = {law: paper_numbers.between_a_and_b(law) for law in paper_numbers.LAWS}
    rows = {row.quantity: row for row in paper_numbers.special_points(found)}
    at = {name[0]: row for name, row in rows.items() if name[1] == "," and "eps_N1" in name}
    assert {name: row.ours for name, row in at.items()} == pytest.approx(
        {"A": 0.11197091446, "B": 0.29152171189, "C": 0.18512695093}, abs=5e-10
    )
    other = {"A": 0.0421643309, "B": 0.3210361465}
    assert {name: at[name].separate for name in other} == pytest.approx(other, abs=5e-10)
    assert at["C"].separate is None  # the same
    slope = rows["slope a of P_1 right of A"]
    assert (slope.ours, slope.separate) == pytest.approx((1.30491108, 1.26515078), abs=5e-8)
    stable = rows["stable branch from B, its other end: eps_N1"]
    assert stable.ours == pytest.approx(0.04532574, abs=5e-9)
    assert stable.separate == pytest.approx(0.3148, abs=5e-5)  # a flip next to B
    leads = rows["P_2 jump branch from A leads to C (1)"]
    assert (leads.ours, leads.separate) == (1.0, 0.0)
    assert all(row.agrees is not False for row in rows.values())
