"""Branches that hug a border where a root begins, and borders that bounces accumulate at.

With a root of height K a cycle is closer to the border than doubles tell long before it meets it:
by its margin alone the place would be known to some 1e-8 K of the parameter.
"""

import pytest
from needs import NEEDS_NUMBA
from sympy import Piecewise, Rational, sqrt, symbols

from pwmap.diagrams.diagram import Diagram
from woodpecker import PeriodicOrbit, Settings, Toy, continuation, from_sympy, shoot
from woodpecker.maps.formulas import FormulaMap

MEETS = -1.0 / 15.0 / 0.23  # 4/3 + 2 (p - 1/3) = 1.77 p + 0.6
ROUNDING = 1e-12  # of that: some spacings over the rate 0.23 at which the two sides part

# eps_N2 and eps_N3 larger than the paper's: the upper sleeve bounces, ever less
BOUNCY = Toy(
    m_m=0.0003089935146186515, j_m=5.811579672302826e-09, m_s=0.0046604888781226934,
    j_s=6.173659452492943e-07, g=11.619210436550645, r_0=0.002498618809570294,
    r_m=0.003071933048033796, h_m=0.005845298578684144, l_m=0.010100319153696104,
    l_g=0.015028977919363636, h_s=0.019733376647646884, l_s=0.02012042727010024,
    c_phi=0.006222874739310294, mu_1=0.30907416670316323, mu_2=0.3251268075394606,
    mu_3=0.29577010702913137, eps_n2=0.2257006006641285, eps_n3=0.1736377845163849,
)  # fmt: skip
SPAN = 0.42400660662503104, 0.724006606625031


def hugged(height: int) -> FormulaMap:
    """A line, and the same with a root that pulls down beyond x = 1.77 p + 0.6."""
    x, p = symbols("x p", real=True)
    margin = x - Rational(177, 100) * p - Rational(3, 5)
    line = (x - Rational(4, 3)) / 2 + p + 1
    return from_sympy(
        Piecewise((line, margin < 0), (line - height * sqrt(margin), True)), x, p, words=["L", "R"]
    )


@pytest.mark.parametrize("height", [5, 50, 488, 5000])
@pytest.mark.parametrize("start", [(1.0, 0.8), (-1.3, -0.95)])
def test_the_piece_beyond_says_where_a_branch_meets_its_border(
    height: int, start: tuple[float, float]
) -> None:
    map_ = hugged(height)
    diagram = continuation(
        map_, shoot(map_, start[0], p=start[1]), "p", (-1.0, 1.0), settings=Settings(window=(-5, 5))
    )
    (met,) = [each for each in diagram.points if each.kind.value == "BC"]
    assert abs(met.parameter - MEETS) <= ROUNDING
    assert sorted(branch.word for branch in diagram.branches) == ["L", "R"]


def connected(x: float, p: float) -> tuple[PeriodicOrbit, Diagram]:
    toy = BOUNCY.replace(eps_n1=p)
    orbit = shoot(toy, x)
    settings = Settings(window=(-2.5, -0.2738), max_evaluations=60_000)
    return orbit, continuation(toy, orbit, "eps_n1", SPAN, settings=settings)


@pytest.mark.slow
@NEEDS_NUMBA
def test_a_branch_leaves_where_bounces_accumulate_for_ever_fewer() -> None:
    """From ever more bounces, summed, to n of them: borders at distances like 0.187^n."""
    orbit, diagram = connected(-0.615118904, 0.42408161)
    assert orbit.word == "S2 D2 I3 I1 C3 D3 C2 J2"
    (branch,) = diagram.branches
    assert (branch.parameter[0], branch.parameter[-1]) == SPAN
    words = [change.word for change in branch.changes]
    for bounces in range(2, 12):
        assert f"S2 D2 I3 I1 {bounces * 'I3 '}C2 J2" in words


@NEEDS_NUMBA
def test_a_grazing_with_one_word_on_both_sides_is_passed() -> None:
    """The event is the same one at another time: its piece goes on, but with a root."""
    orbit, diagram = connected(-1.332277000907486, 0.424081606625031)
    assert orbit.word == "S2 D2 I1 I3 C2 R2 J2"
    (branch,) = diagram.branches
    assert (branch.parameter[0], branch.parameter[-1]) == SPAN
