"""The paper's Figures 9 to 12: the diagrams of P_1 and P_2, the maps near A and the local model."""

from pathlib import Path

import numpy as np
import pytest
from needs import NEEDS_NUMBA
from short_runs import ShortRun, is_picture, kept_run, short_run

from pwmap import Branch, BranchKind, Diagram, SpecialPoint
from studies import order_three
from studies.common import whole
from studies.figures import fig10_order_two as fig10
from studies.figures import fig11_maps_near_a as fig11
from studies.figures import fig12_local_model as fig12
from woodpecker import Toy, ToyPieces, shoot
from woodpecker.base.settings import Settings
from woodpecker.slices.slices import slices_at

pytestmark = NEEDS_NUMBA

A = (0.1119709145, -0.8847733440)  # eps_N1, phi_S; sign change and 30 digits
C = (0.1851269509, -0.7577872573)
SLOPE = -1.304911075  # of P_1 right of A
CYCLE_ENDS = ((0.17505760, -0.66792646), (0.18345841, -0.75778726))  # of period 2, between A and C
PHI_S = -0.52947197  # rad: the cycle at eps_N1 = 0.5
WINDOW = (-2.5, -0.24)  # rad


def flat(branch_id: str, order: int, x: list[float], eps_n1: float = 0.5) -> Branch:
    """A branch of fixed points at one parameter."""
    n = len(x)
    return Branch(
        id=branch_id, kind=BranchKind.FIXED_POINT, order=order, word="", ends=("EP1", "EP1"),
        parameter=np.full(n, eps_n1), x=np.array(x), multiplier=np.full(n, -0.8),
    )  # fmt: skip


def diagram_of(*branches: Branch) -> Diagram:
    return Diagram(
        parameter_name="eps_n1", x_name="phi_s", branches=branches,
        points=(SpecialPoint(id="EP1", kind="EP", parameter=0.5, x=0.0),),  # type: ignore[arg-type]
    )  # fmt: skip


# --- Figure 9 -------------------------------------------------------------------------------------


@pytest.mark.slow
def test_orbits_confirm_the_whole_diagram(tmp_path: Path) -> None:
    results = short_run("fig09_order_one", tmp_path)
    above = [found for found in results["collisions"] if found[3] > -1.2]  # rad: steep ones below
    kinds = sorted(kind for kind, *_ in above)
    assert kinds == ["BC", "BC", "FF"]  # B and the top of the island I1
    at = sorted(p for _, _, p, _ in above)
    assert at == pytest.approx([0.29152171, 0.34192345, 0.38834959], abs=5e-9)
    other = results["separate"]
    assert other["law"] == "separate"
    at = [
        p
        for kind, note, p, x in other["collisions"]
        if (kind, note, x > -1.2) == ("BC", "fold", True)
    ]
    assert at == pytest.approx([0.32103615], abs=5e-9)
    assert results["unexplained"] == []
    assert results["orbits"] + results["lost"] == 10 * 12
    for name in ("fig09.png", "fig09_laws.png"):
        assert is_picture(tmp_path / name)
    assert results["not_followed"] == []
    assert results["slices"] >= 8  # and more where these show something new
    fine, coarse = results["tables"]
    assert fine["parameters"] == coarse["parameters"] <= results["samples"]
    assert (fine["spacing"], coarse["spacing"]) == (1e-6, 2e-3)
    assert fine["evaluations"] == fine["parameters"] * 2_260_001  # 2.26 rad and both ends
    assert fine["ratio"] == pytest.approx(fine["evaluations"] / results["evaluations"])


# --- Figure 10 ------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def second(tmp_path_factory: pytest.TempPathFactory) -> ShortRun:
    return kept_run("fig10_order_two", tmp_path_factory)


@pytest.mark.slow
def test_fixed_points_of_order_two_pair_up(second: ShortRun) -> None:
    results, folder = second
    assert is_picture(folder / "fig10.png")
    assert results["odd"] == []
    assert results["unpaired"] == 0
    counts = [seen["fixed_points"] for seen in results["seen"]]
    assert len(counts) == fig10.FAST.slices
    assert counts[0] == 0  # left of where the cycle of period 2 begins
    assert max(counts) == 2
    for seen in results["seen"]:
        assert seen["unexplained"] == seen["missing"] == 0


def test_a_branch_without_its_partner_is_seen() -> None:
    """The fixed point of P_1 is its own partner; a branch beside it has none."""
    x = shoot(Toy(), PHI_S).phi_s
    assert fig10.unpaired(diagram_of(flat("F1", 2, [x] * 3)), fig10.FULL) == 0
    assert fig10.unpaired(diagram_of(flat("F1", 2, [x + 0.01] * 3)), fig10.FULL) == 1


@pytest.mark.slow
def test_jump_crossings_of_order_two_are_single(second: ShortRun) -> None:
    """The jump branch of P_2 that starts at A is alone, and starts the cycle of period 2."""
    results, _ = second
    assert results["odd_jumps"]
    ((kind, note, eps_n1, phi_s),) = results["from_a"]
    assert (kind, note) == ("BC", "persistence")
    orbit = shoot(Toy(eps_n1=eps_n1 + 1e-6), phi_s, order=2)
    assert orbit.success
    assert max(orbit.points) == pytest.approx(phi_s, abs=1e-4)  # it moves by 8 rad per eps_N1


@pytest.mark.slow
def test_the_way_from_a_to_c_has_a_real_cycle_on_it(second: ShortRun) -> None:
    results, _ = second
    way = [fig10.Course(**course) for course in results["way"]]
    assert [stretch.kind for stretch in way] == ["jump", "fixed-point", "jump"]
    places = [way[0].begins, *(stretch.ends for stretch in way)]
    known = [A, *CYCLE_ENDS, C]
    assert np.array(places) == pytest.approx(np.array(known), abs=1e-8)
    (p, _), (q, _) = CYCLE_ENDS
    assert 0 < q - p < 1.0 / 94.0  # finer than the paper's 94 parameters, evenly spread


@pytest.mark.slow
def test_the_cycle_of_period_two_at_small_restitution() -> None:
    """Figure 10: its lower point dips to about -1.84 at 0.05, the upper one is near -0.86."""
    orbit = shoot(Toy(eps_n1=fig10.AT), -1.839, order=2)
    assert orbit.success
    assert sorted(orbit.points) == pytest.approx([-1.83895, -0.85635], abs=5e-6)
    assert orbit.stable


@pytest.mark.slow
def test_the_closed_loops_of_order_two() -> None:
    """Figure 10: loops around -1.0 to -1.2 over 0.44 to 0.86, partners near -0.28."""
    counts = []
    for eps_n1 in (0.43, 0.44, 0.5, 0.84, 0.86):
        (found,) = slices_at(ToyPieces(Toy()), eps_n1, (2,), Settings(window=WINDOW))
        turned = [cycle.rotated(k).x for cycle in found.cycles for k in range(2)]
        counts.append(sum(-1.2 < x < -0.97 and -0.295 < y < -0.28 for x, y in turned))
        on_the_loop = sum(-1.2 < x < -0.97 for x, _ in turned)
        assert on_the_loop == counts[-1]
    assert counts[0] == counts[-1] == 0
    assert min(counts[1:-1]) >= 2


@pytest.mark.slow
def test_samples_are_fixed_points(second: ShortRun) -> None:
    """No flank here is steeper than 100, so 1e-11 is far above rounding."""
    inside = second[0]["residuals"]
    assert inside["samples"] > 100
    assert inside["lost"] == inside["above"] == 0
    assert inside["largest"]["size"] < 1e-12


def test_a_wrong_sample_is_seen() -> None:
    """Off the cycle by 1e-6, P_1 is off by 1.84e-6: its slope there is -0.83916."""
    x = shoot(Toy(), PHI_S).phi_s
    branch = flat("F1", 1, [x, x + 1e-6, x])
    (off,) = whole.residuals(diagram_of(branch), fig10.FULL, ends=False)
    assert off.size == pytest.approx(1.83916e-6, rel=1e-4)  # curvature times 1e-6
    assert off.slope == pytest.approx(0.83916, rel=1e-4)
    assert off.rounding == pytest.approx(2.0**-52 * 0.52947 * 0.83916, rel=1e-4, abs=0.0)
    assert whole.summary([off])["above"] == whole.summary([off])["beyond_kernel"] == 1
    assert whole.summary(whole.residuals(diagram_of(branch), fig10.FULL, ends=True))["above"] == 0


# --- Order three ----------------------------------------------------------------------------------


@pytest.mark.slow
def test_order_three_in_a_part_without_cycles_of_period_three(tmp_path: Path) -> None:
    """Next to A P_3 has jump crossings, the one that starts there, and no cycle."""
    results = short_run("order_three", tmp_path)
    assert is_picture(tmp_path / "order_three.png")
    assert len(results["seen"]) == order_three.FAST.slices
    assert results["odd"] == []
    assert results["residuals"]["above"] == results["residuals"]["lost"] == 0
    for seen in results["seen"]:
        assert seen["fixed_points"] == seen["unexplained"] == 0
        assert seen["crossings"] == seen["drawn_crossings"]
    assert max(seen["crossings"] for seen in results["seen"]) > 0


# --- Figure 11 ------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def maps(tmp_path_factory: pytest.TempPathFactory) -> ShortRun:
    return kept_run("fig11_maps_near_a", tmp_path_factory)


@pytest.mark.slow
def test_the_map_rises_through_the_diagonal_at_a(maps: ShortRun) -> None:
    results, folder = maps
    assert is_picture(folder / "fig11.png")
    below, at, above, _ = (gap for _, _, gap in results["gap"])
    assert below < -0.04 < 0.06 < above
    assert abs(at) < 1e-9  # A has ten digits, and the limit rises by 5 rad per unit of eps_N1


@pytest.mark.slow
def test_what_starts_at_a(maps: ShortRun) -> None:
    """The stable fixed point alone below A; above it another, and a crossing of P_1 and of P_2."""
    scenes = {(e["law"], e["eps_n1"], e["order"]): e for e in maps[0]["scenes"]}
    for order in (1, 2):
        assert scenes["summed", 0.105, order]["stable"] == 1
        assert scenes["summed", 0.105, order]["unstable"] == 0
        assert scenes["summed", 0.105, order]["crossings"] == []
    one, two = (scenes["summed", fig11.PAPER, order] for order in (1, 2))
    for (x, slope), (again, squared) in zip(one["fixed_points"], two["fixed_points"], strict=True):
        assert again == pytest.approx(x, abs=1e-13)  # both by brentq, to 1e-15 over a slope of 0.25
        assert squared == pytest.approx(slope**2, rel=1e-10)
    ((jump, *_),), ((preimage, *_),) = one["crossings"], two["crossings"]
    assert jump == pytest.approx(A[1], abs=1e-9)
    image = ToyPieces(Toy()).at(preimage, fig11.PAPER).value
    assert image == pytest.approx(jump, abs=1e-13)  # P_1 leads back to its jump


@pytest.mark.slow
def test_figure_11_follows_from_the_sum_only(maps: ShortRun) -> None:
    paper = maps[0]["paper"]
    assert paper["summed"] == paper["drawn"]
    assert paper["separate"]["stable"] == paper["separate"]["unstable"] == 0
    ((*_, there),) = [
        [x for x, *_ in e["crossings"]]
        for e in maps[0]["scenes"]
        if (e["law"], e["order"]) == ("separate", 1)
    ]
    assert there == pytest.approx(C[1], abs=1e-9)  # where its fixed point went


# --- Figure 12 ------------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_toy_agrees_with_its_local_model(tmp_path: Path) -> None:
    """Slopes of preimages of the jump, x* (1 - m**(1 - j)) [Leine2001, Eq. 15 for j = 2]."""
    results = short_run("fig12_local_model", tmp_path)
    assert is_picture(tmp_path / "fig12.png")
    assert results["a"]["eps_n1"] == pytest.approx(A[0], abs=1e-10)
    assert results["a"]["slope"] == pytest.approx(SLOPE, abs=1e-8)
    fixed = results["agreements"]["fixed-point of P_1"]["predicted"]
    for j in range(1, 5):
        jump = results["agreements"][f"jump of P_{j}"]
        expected = fixed * (1.0 - SLOPE ** (1 - j))
        assert jump["predicted"] == pytest.approx(expected, rel=1e-8, abs=1e-12)
    # The third order shows: c q**3 is up to a tenth of c q**2 at the largest distance
    found = results["agreements"]
    powers = {name: each["power"] for name, each in found.items() if each["power"]}
    assert len(powers) == 4
    assert powers.pop("jump of P_4") > 1.65  # its c is a hundred times less: c q**3 and more
    assert list(powers.values()) == pytest.approx([results["expected_power"]] * 3, abs=0.35)
    assert found["jump of P_4"]["errors"][0] < 0.1 * found["jump of P_3"]["errors"][0]
    assert results["largest_relative_error"] < 1e-4  # q times curvatures of some tens
    other = results["separate"]
    assert other["slope"] == pytest.approx(-1.265150782, abs=1e-8)
    assert other["predicted"]["jump of P_2"] == pytest.approx(11.4001, abs=5e-5)
    assert (results["branches"], results["points"]) == (5, 6)


def test_the_papers_figure_12() -> None:
    """Fixed points r / (1 + a) and r - 2, jumps 0 and r / a [Leine2001, Eqs. 14 and 15]."""
    hits = {round(hit.x, 9) for hit in fig12.papers_diagram().at(1.0)}
    assert hits == {round(1.0 / 2.25, 9), -1.0, 0.0, 0.8}
