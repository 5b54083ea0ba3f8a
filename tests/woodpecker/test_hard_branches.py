"""Branches of the toy through accumulating borders, round corners, beside sharp folds and flips."""

from dataclasses import replace

import numpy as np
import pytest
from needs import NEEDS_NUMBA, NIGHTLY_TOY, SLOW_TOY

from pwmap.diagrams.diagram import BranchKind, PointKind, PointStatus
from studies.common.random_toys import random_toy
from studies.common.tabulated import compared
from woodpecker.base.settings import Settings
from woodpecker.diagrams import bifurcation_diagram, continuation
from woodpecker.engine.arrivals import LIMIT_LOST
from woodpecker.engine.curves import Stop
from woodpecker.engine.germs import beginnings, crossings_at
from woodpecker.engine.maps import ACCUMULATE
from woodpecker.engine.tracing import trace
from woodpecker.mechanics.toy import WINDOW, Toy
from woodpecker.search.accumulations import ENDLESS
from woodpecker.search.diagrams import connected, cycle_near
from woodpecker.search.search import Search
from woodpecker.search.tasks import Tasks, base_of
from woodpecker.shooting import shoot
from woodpecker.simulation.returns import first_return
from woodpecker.slices.orbits import to_engine
from woodpecker.slices.slices import slices_at
from woodpecker.toy_map import ToyPieces

START = -0.53  # rad, near the stable motion


@NIGHTLY_TOY
def test_through_infinitely_many_borders() -> None:
    """Above eps_n2 = 0.9615713796 the lower sleeve bounces N times until it stops sliding.

    N comes down from infinity: borders accumulate there. The branch goes through, to eps_n2 = 1,
    and comes from there the other way; both meet the same points.
    """
    up = continuation(Toy(), shoot(Toy(), START), "eps_n2")
    down_toy = Toy(eps_n2=0.999)
    down = continuation(down_toy, shoot(down_toy, -0.522), "eps_n2", span=(0.9, 1.0))
    ends = {p.parameter for p in up.points if p.kind is PointKind.EP}
    assert ends == {0.0, 1.0}
    assert all(point.status is PointStatus.LOCATED for point in up.points)
    inner = [
        sorted((p.kind, p.parameter) for p in d.points if p.kind is not PointKind.EP)
        for d in (up, down)
    ]
    assert [kind for kind, _ in inner[0]] == [kind for kind, _ in inner[1]]
    assert len(inner[0]) == 28  # 14 kinks at which it loses or gains stability, 14 flips between
    for (_, one), (_, other) in zip(*inner, strict=True):
        assert one == pytest.approx(other, abs=1e-12)
    marks = [
        float(branch.parameter[change.first])
        for branch in up.branches
        for change in branch.changes
        if change.cause.endswith(ACCUMULATE)
    ]
    # there are finitely many bounces above here
    assert marks == pytest.approx([0.9615713796], abs=2e-9)
    longest = max(len(word.word.split()) for branch in up.branches for word in branch.words)
    assert longest > 400
    last = max(up.branches, key=lambda branch: float(branch.parameter.max()))
    assert last.multiplier[-1] == pytest.approx(first_return(Toy(eps_n2=1.0), last.x[-1]).slope)


@NIGHTLY_TOY
def test_jumps_go_round_corners() -> None:
    """At mu_2 = 0.28322807 two borders of P_1 meet, and the one that crosses changes."""
    for law in ("summed", "separate"):
        toy = Toy(expansion_friction=law)
        found = continuation(toy, shoot(toy, START), "mu_2", span=(-1.0, 0.4))
        (start,) = (p for p in found.points if abs(p.parameter - 0.2840178344534795) < 1e-12)
        (jump,) = (
            branch for branch in map(found.branch, start.branches) if branch.kind is BranchKind.JUMP
        )
        other = found.point(next(end for end in jump.ends if end != start.id))
        assert other.kind is PointKind.FF
        assert other.parameter == pytest.approx(0.2822399954081972, abs=1e-12)
        assert any(abs(p - 0.2832280737670356) < 1e-12 for p in jump.parameter)
        for end in found.points:  # what is open lies where special points accumulate
            assert end.status is PointStatus.LOCATED or end.note in (ACCUMULATE, ENDLESS)
            if end.kind is PointKind.FALL:
                assert end.cause == LIMIT_LOST
                assert 0.0 < end.precision < 1e-6


@SLOW_TOY
def test_a_crossing_does_not_go_back_on_the_border_by_which_it_came() -> None:
    """At h_S = 0.0206262652 borders meet in pairs: a crossing comes on one and leaves on another.

    Rounding lets it meet the corner again at its first step. It went back by the way it had come,
    and this part was drawn twice.
    """
    toy, parameter, *_ = random_toy(48)
    span, window = (0.0206, 0.02064), (-1.235, -1.205)
    found = bifurcation_diagram(
        toy, parameter, span, (1,), window, search=Search(slices=3), workers=1
    )
    table = compared(toy, found, 0.02062, 1, window, 4001)
    assert table["missing"] == table["double"] == table["unconfirmed"] == []
    assert (table["cycles"], table["jumps"], table["drawn_jumps"]) == (3, 6, 6)
    assert table["closer"] == 0


@SLOW_TOY
@pytest.mark.parametrize(("start", "guess"), [(0.2, -0.5878), (0.25, -0.5523), (0.29, -0.5344)])
def test_a_grazing_with_one_word_on_both_sides_is_seen_from_both(
    start: float, guess: float
) -> None:
    """At eps_N1 = 0.2285460700 and 0.1970010035 the lower sleeve grazes, beside thin instabilities.

    Beyond them the last contact comes at another time, in the same sequence of events; margins rise
    at both ends of a step over them, or fall at both, but are less in the end, or more.
    """
    toy, parameter, *_ = random_toy(79)
    there = toy.replace(**{parameter: start})
    found = continuation(there, shoot(there, guess), parameter, span=(0.19, 0.3))
    places = {
        kind: sorted(p.parameter for p in found.points if p.kind is kind and p.order == 1)
        for kind in (PointKind.BC, PointKind.PD)
    }
    assert places == {
        PointKind.BC: pytest.approx([0.19700100349, 0.22854607001], abs=1e-10),
        PointKind.PD: pytest.approx([0.19748241994, 0.22871003652], abs=1e-10),
    }


@NIGHTLY_TOY
def test_a_doubled_cycle_beside_a_sharp_flip_stays_doubled() -> None:
    """P_1 flips 3e-8 below its fold, the doubled cycle 1.2e-8 below that; its points are as close.

    Between its two flips the branch of P_2 is shorter than a step, and beyond the upper one there
    is none, but the cycle of P_1, passed twice, and its fold.
    """
    map_, p = ToyPieces(Toy()), 0.4125
    settings = Settings(span=(0.412, 0.4135), window=WINDOW)
    single = connected(map_, -1.30073, p, settings, orders=(1,))
    (flip,) = [point for point in single.points if point.kind is PointKind.PD]
    (fold,) = [point for point in single.points if point.kind is PointKind.LP]
    assert fold.parameter - flip.parameter == pytest.approx(2.75e-8, rel=1e-3)
    for guess in (-1.30072, -1.3007, -1.300735, -1.30074):  # the last bit does not decide
        again = connected(map_, guess, p, settings, orders=(1,))
        places = sorted((point.kind, point.parameter) for point in again.points)
        for (kind, place), point in zip(
            places, sorted(single.points, key=lambda each: (each.kind, each.parameter)), strict=True
        ):
            assert kind is point.kind
            assert place == pytest.approx(point.parameter, abs=1e-12)
    doubled = connected(map_, [-1.30075, -1.30071], p, settings, orders=(2,))
    assert len(doubled.branches) == 4  # two of P_2, each seen from both points of the cycle
    for one, other in (doubled.branches[:2], doubled.branches[2:]):
        apart = np.abs(one.x - other.x)
        assert apart[:-1].min() > 1e-12  # 1e-15 if it were the single one; at its end they are one
    flips = sorted(point.parameter for point in doubled.points if point.kind is PointKind.PD)
    # the multiplier at both is -1 to rounding, a few 1e-8 where it falls by 1 within 1e-8
    assert flips[0] == pytest.approx(0.413280988766, abs=1e-12)
    assert flips[-1] == pytest.approx(flip.parameter, abs=1e-12)
    assert not any(point.kind is PointKind.LP for point in doubled.points)


@SLOW_TOY
def test_a_border_right_before_the_flip_that_ends_a_doubled_branch() -> None:
    """The cycle of P_2 meets a border where its points are 2.5e-8 apart, 3e-8 before P_1 flips.

    Beyond it the branch goes on; an orbit 1e-6 from the border is the cycle of P_1, passed twice.
    """
    settings = Settings(span=(0.3001, 0.3021), window=WINDOW)
    start, p = [-1.46590769798, -1.46580830841], 0.300233852927
    diagram = connected(ToyPieces(Toy()), start, p, settings, orders=(1, 2))
    places = {
        (point.kind, point.order): point.parameter
        for point in diagram.points
        if point.kind is not PointKind.EP
    }
    # both multipliers fall by 1 within 1e-9 of the parameter: a flip is as sharp as that
    assert places == {
        (PointKind.PD, 2): pytest.approx(0.302079956152, abs=1e-12),
        (PointKind.PD, 1): pytest.approx(0.302079956588, abs=1e-12),
        (PointKind.LP, 1): pytest.approx(0.302079957504, abs=1e-12),
    }
    (flip,) = [q for q in diagram.points if q.kind is PointKind.PD and q.order == 1]
    assert sorted(diagram.branch(name).order for name in flip.branches) == [1, 1, 2, 2]


@SLOW_TOY
def test_folds_side_by_side() -> None:
    """Branches with slopes of 1e3 to 1e6 run 5e-5 of the window beside each other.

    A sample on the neighbour has much the same tangent. Flips in the tip of a sharp fold may be one
    point with it.
    """
    toy = Toy(eps_n1=0.18274692486568977)
    found = continuation(toy, shoot(toy, -2.053406062136754), "eps_n1", span=(0.16, 0.19))
    assert all(point.status is PointStatus.LOCATED for point in found.points)
    folds = [point.parameter for point in found.points if point.kind is PointKind.LP]
    tips = [
        point
        for point in found.points
        if point.kind is PointKind.PD and min(abs(point.parameter - p) for p in folds) < 1e-11
    ]
    assert len(found.branches) - len(tips) == 24


@SLOW_TOY
def test_infinitely_many_fold_flips() -> None:
    """mu_2: each return of a chain goes round a motion without a return once more than the last.

    With a span and a window that resolve seven points on either side their distances shrink by
    0.15445, 0.15785, 0.15841, 0.15852, 0.15851 on the left and by 0.17331, 0.19478, 0.20018,
    0.20155, 0.20188 on the right; the rest of that series leads to the limit asserted here, with
    1e-14 in mu_2 and 1e-12 rad left of it. Four points tell the limit to 1 % of the rest.
    """
    found = continuation(Toy(), shoot(Toy(), START), "mu_2", span=(0.2, 0.5))
    assert len(found.branches) == 29
    (limit,) = [point for point in found.points if point.status is PointStatus.OPEN]
    assert limit.kind is PointKind.EP
    assert "infinitely many fold-flip points accumulate" in limit.cause
    assert limit.parameter == pytest.approx(0.282434518307155, abs=6e-12)
    assert limit.x == pytest.approx(-0.4446071627814, abs=2e-9)
    assert limit.precision == pytest.approx(6.0e-10, rel=0.01)
    (last,) = (found.branch(name) for name in limit.branches)
    assert np.abs(last.parameter[[0, -1]] - limit.parameter).min() <= limit.precision


@SLOW_TOY
def test_a_crossing_whose_words_are_dense_reaches_its_end() -> None:
    """A leap over words that follow each other within 1e-4 of the span is longer than what is left.

    From the fold-flip of P_2 at 0.6768693913711 the crossing leads down to where one of its limits
    meets the diagonal.
    """
    base = base_of(ToyPieces(Toy()), Settings(span=(0.012, 1.0), window=WINDOW))
    x, p = np.array([[-1.1085130067290503]]), np.array([0.6768693913710906])
    (down,) = (each for each in beginnings(base, x, p, (2,)) if each.is_crossing)
    found = trace(down, (2,))
    assert found.stop is Stop.SHARE
    assert found.arrival.orbit.p[0] == pytest.approx(0.670591962749412, abs=1e-12)
    assert len(found.samples) < 1000


@NIGHTLY_TOY
def test_where_borders_accumulate_a_crossing_may_meet_its_border_with_another_point() -> None:
    """Such a crossing of P_3 has other unknowns, and is not the one that was followed.

    All that a slice shows at eps_n1 = 0.36081 is drawn.
    """
    span, p = (0.3607, 0.3609), 0.36081
    found = bifurcation_diagram(Toy(), "eps_n1", span, (3,), search=Search(slices=1))
    (shown,) = slices_at(ToyPieces(Toy()), p, (3,), Settings(span=span, window=WINDOW))
    drawn = {kind: [hit.x for hit in found.at(p) if hit.branch.kind is kind] for kind in BranchKind}
    assert (len(shown.cycles), len(shown.jumps)) == (8, 21)
    for cycle in shown.cycles:
        assert min(abs(x - y) for x in drawn[BranchKind.FIXED_POINT] for y in cycle.x) < 1e-5
    for jump in shown.jumps:
        assert min(abs(x - jump.head.x[0]) for x in drawn[BranchKind.JUMP]) < 1e-5


@NEEDS_NUMBA
@pytest.mark.parametrize("start", [0.07, 0.2, 0.23, 0.25])
def test_where_two_solutions_of_a_path_meet_a_branch_does_not_come_back(start: float) -> None:
    """Where the beak only just grazes the pole, one event has two times that become one.

    The branch goes on there, from one end of the span to the other, wherever it is entered.
    """
    toy = Toy(
        eps_n1=start, m_m=0.000302613, j_m=4.1541e-09, m_s=0.00438165, j_s=6.43855e-07, g=8.5365,
        r_0=0.00250311, r_m=0.00307273, h_m=0.0059039, l_m=0.0100169, l_g=0.0150256, h_s=0.0197169,
        l_s=0.0197342, c_phi=0.00628881, mu_1=0.304632, mu_2=0.30831, mu_3=0.322786,
    )  # fmt: skip
    diagram = continuation(toy, shoot(toy, -0.4757), "eps_n1", span=(0.06, 0.36))
    (branch,) = diagram.branches
    assert (branch.parameter[0], branch.parameter[-1]) == (0.06, 0.36)
    assert (np.diff(branch.parameter) > 0.0).all()


@NEEDS_NUMBA
@pytest.mark.parametrize(
    ("number", "p", "x", "ahead", "kind", "end", "most"),
    [
        # It crept on from a corner, by 2000 of the shortest steps there are, as a sample with the
        # corner's own parameter told no direction.
        (69, 0.0025087947632299558, -1.345734922994746, 1.0, "LP", 0.00250941582717, 150),
        # Borders accumulate where the lower sleeve only just stays at the pole: from a crossing
        # that was to meet one of them right ahead it came back along itself.
        (69, 0.002504, -1.3532349143440836, 1.0, "LP", 0.00250343029462253, 150),
        # At a corner it took another crossing for its own, a part of 5e-5 of the window away, and
        # went round and round on borders of eight bounces and of ten.
        (51, 0.020014548802252202, -0.520112953993576, -1.0, "BC", 0.01944875679438, 150),
        # Beyond a border with a root it goes on tangentially to that: it went along the border
        # itself, until it turned and came back, and was drawn twice.
        (98, 0.014762536224614865, -1.2668308596547462, -1.0, "LP", 0.0147453426687712, 150),
        (98, 0.014787519503097498, -1.2761245136042163, -1.0, "LP", 0.014774251746132753, 150),
    ],
)
def test_round_corners_a_crossing_comes_to_its_end(
    number: int, p: float, x: float, ahead: float, kind: str, end: float, most: int
) -> None:
    """Where two borders meet it goes on along one that comes to the corner."""
    drawn = random_toy(number)
    settings = Settings(span=drawn.span, window=drawn.window)
    base = base_of(ToyPieces(drawn.toy, drawn.parameter), settings)
    (crossing,) = crossings_at(base, np.array([[x]]), np.array([p]), 1)
    start = crossing.curve.start(crossing.sample.orbit, np.array([0.0, ahead]))
    found = trace(replace(crossing, sample=start), (1,))
    assert (found.arrival.kind, found.arrival.status) == (PointKind[kind], PointStatus.LOCATED)
    assert found.arrival.orbit.p[0] == pytest.approx(end, abs=1e-13)
    assert len(found.samples) < most


# --- Branches of the toy that are hard to follow: where a margin dips, where a limit ends ---------


DIGITS = 1e-10  # of the places that are written here


@NIGHTLY_TOY
@pytest.mark.parametrize(
    ("p", "x"), [(0.14, -2.42089938), (0.165, -1.89591451), (0.3, -1.11014887)]
)
def test_a_margin_that_dips_below_zero_does_not_turn_a_branch_round(p: float, x: float) -> None:
    """The upper arm of the island, from the window's end to its collision, wherever it is entered.

    Within a step the beak's margins vanish, come back and vanish again: the branch was turned round
    where one came back (0.14553785, 0.14830486, 0.15757030, depending on where steps fell).
    """
    settings = Settings(span=(0.012, 1.0), window=(-2.5, -0.24))
    map_ = ToyPieces(Toy())
    start = to_engine(cycle_near(map_, [x], p, settings))
    curve = Tasks.of_line(map_, settings).cycle(start).curve
    ends = sorted((end.p, float(end.x[0, 0]), end.kind) for end in curve.ends)
    assert [kind for *_, kind in ends] == [PointKind.EP, PointKind.FF]
    assert [(p, x) for p, x, _ in ends] == [
        pytest.approx((0.1376285067, -2.5), abs=DIGITS),
        pytest.approx((0.3883495889, -0.8847733440), abs=DIGITS),
    ]
    way = np.sign(curve.parameter[-1] - curve.parameter[0])
    # where two borders lie closer than orbits are told apart a sample may lie a little behind
    assert (way * np.diff(curve.parameter)).min() > -settings.same * settings.p_scale


@SLOW_TOY
def test_a_jump_of_the_second_iterate_whose_limit_ends_in_a_root() -> None:
    """Beyond that root the next return has no value: no sample there, and the branch goes on."""
    settings = Settings(span=(0.012, 0.3), window=(-2.5, -0.24))
    map_ = ToyPieces(Toy())
    (found,) = slices_at(map_, 0.2539190149, (2,), settings)
    jump = min(found.jumps, key=lambda jump: abs(jump.head.x[0] + 2.2666708))
    curve = Tasks.of_line(map_, settings).jump(jump).curve
    first, last = sorted(curve.ends, key=lambda end: end.p)
    assert first.status is last.status is PointStatus.LOCATED
    assert min(curve.parameter) == first.p < 0.2532
    assert max(curve.parameter) == last.p > 0.26  # the root lies at 0.2539199558
    assert np.isfinite(curve.x).all()
