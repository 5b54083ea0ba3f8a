"""Solutions between the samples of a diagram, to the last digits."""

import math

import numpy as np
import pytest
import sympy
from needs import NEEDS_NUMBA, NIGHTLY_TOY, SLOW_TOY

from pwmap.diagrams.diagram import BranchKind, Diagram
from woodpecker.base.settings import Settings
from woodpecker.branches import solutions
from woodpecker.diagrams import bifurcation_diagram, continuation
from woodpecker.maps.symbolic import from_sympy
from woodpecker.mechanics.toy import Toy
from woodpecker.search.search import Search
from woodpecker.shooting import shoot
from woodpecker.simulation.returns import first_return

TOY = Toy()


@pytest.fixture(scope="module")
def diagram() -> Diagram:
    return continuation(TOY, shoot(TOY, -0.53), span=(0.1, 0.7))


@NIGHTLY_TOY
def test_each_branch_is_met_exactly(diagram: Diagram) -> None:
    """Straight lines are off by some 1e-5; solutions by the rounding of a return."""
    furthest = 0.0
    for value in np.random.default_rng(11).uniform(0.1, 0.7, 25).tolist():
        met = [hit for hit in diagram.at(value) if hit.branch.kind is BranchKind.FIXED_POINT]
        found = solutions(TOY, diagram, value)
        assert [one.branch.id for one in found] == [hit.branch.id for hit in met]
        for (branch, orbit), hit in zip(found, met, strict=True):
            assert orbit.success, (value, orbit.message)
            back = first_return(TOY.replace(eps_n1=value), orbit.phi_s)
            # rounding of a return of slope m is some 20 spacings of doubles times m
            assert back.phi_s == pytest.approx(orbit.phi_s, abs=1e-14 * (1.0 + abs(back.slope)))
            assert orbit.word in {stretch.word for stretch in branch.words}
            assert orbit.multiplier == pytest.approx(hit.multiplier, abs=0.02)
            furthest = max(furthest, abs(orbit.phi_s - hit.x))
    assert 1e-6 < furthest < 1e-3


@SLOW_TOY
def test_a_branch_is_solved_for_up_to_its_ends(diagram: Diagram) -> None:
    """On a border the map takes either piece: the solution keeps that of its own branch."""
    ended = 0
    for point in diagram.points:
        for branch, orbit in solutions(TOY, diagram, point.parameter):
            if point.id not in branch.ends:
                continue
            k = -branch.ends.index(point.id)
            assert orbit.success, (point.id, orbit.message)
            assert orbit.phi_s == pytest.approx(branch.x[k], abs=1e-13)
            assert orbit.multiplier == pytest.approx(branch.multiplier[k], abs=1e-6)
            ended += 1
    assert ended == sum(len(b.ends) for b in diagram.branches if b.kind is BranchKind.FIXED_POINT)
    a = diagram.point("FF2")  # studies/results/proofs/A.json has its slope proved
    steepest = min(orbit.multiplier for _, orbit in solutions(TOY, diagram, a.parameter))
    assert steepest == pytest.approx(-1.304911075142, abs=1e-9)


@NEEDS_NUMBA
def test_another_motion_than_that_of_the_branch_is_none_of_its_solutions(diagram: Diagram) -> None:
    """A toy that is not the diagram's has its motions elsewhere: they lie on no branch here."""
    other = solutions(TOY.replace(mu_2=0.31), diagram, 0.5)
    assert [orbit.success for _, orbit in other] == [False]


@NEEDS_NUMBA
def test_wrong_values_are_refused(diagram: Diagram) -> None:
    with pytest.raises(ValueError, match=r"eps_n1 must lie in \[0, 1\], got 2.0"):
        solutions(TOY, diagram, 2.0)
    assert solutions(TOY, diagram, 0.9) == ()


@pytest.mark.slow
def test_a_map_has_solutions_where_its_diagram_is_only_drawn() -> None:
    """The cycle of x/5 + mu and -x^(1/2) + mu: x = u^2 with u^2 + u/5 = 6 mu/5, close to a root."""
    x, mu = sympy.symbols("x mu")
    root = from_sympy(sympy.Piecewise((x / 5 + mu, x < 0), (mu - sympy.sqrt(x), True)), x, mu)
    settings = Settings(span=(-0.1, 0.5), window=(-1, 1))
    found = bifurcation_diagram(root, orders=(1, 2), settings=settings, search=Search(slices=8))
    assert (found.parameter_name, found.x_name) == ("mu", "x")
    value = 0.003
    u = -0.1 + math.sqrt(0.01 + 1.2 * value)
    points = [each.orbit.x for each in solutions(root, found, value) if each.branch.order == 2]
    assert max(points) == pytest.approx(u**2, abs=1e-14)
    assert min(points) == pytest.approx(value - u, abs=1e-14)
    with pytest.raises(ValueError, match="'nu' is no parameter of this map, it has 'mu'"):
        continuation(root, shoot(root, -0.1, p=-0.1), "nu", settings=settings)
