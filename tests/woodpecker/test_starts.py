"""What is connected with a periodic motion does not depend on where the search starts."""

import numpy as np
import pytest
from needs import SLOW_TOY
from sympy import Piecewise, symbols

from pwmap.diagrams.diagram import Diagram, PointKind
from studies.common.random_toys import random_toy
from woodpecker.base.settings import Settings
from woodpecker.diagrams import continuation
from woodpecker.examples import two_lines
from woodpecker.maps.pieces import PiecewiseMap
from woodpecker.maps.symbolic import from_sympy
from woodpecker.shooting import shoot

X, P = symbols("x p")


def special(diagram: Diagram) -> list[tuple[str, float, float]]:
    """Kind, parameter and x of all special points, in order."""
    return sorted((point.kind.value, point.parameter, point.x) for point in diagram.points)


@pytest.mark.parametrize(
    ("own", "x", "p", "points"),
    [
        # the fixed point 1 - 1/p meets 0 at p = 1 and flips at p = 3, 0 flips at p = -1
        (
            from_sympy(P * X * (1 - X), X, P), 0.6, 2.5,
            [("BP", 1.0, 0.0), ("PD", -1.0, 0.0), ("PD", 3.0, 2 / 3)],
        ),
        # the fixed points +-sqrt(p) fold at 0, and 1 flips
        (from_sympy(P + X - X**2, X, P), 0.5, 0.25, [("LP", 0.0, 0.0), ("PD", 1.0, 1.0)]),
        # a cycle of each line ends at the jump between them
        (two_lines(), -1.0, -0.5, [("BC", 0.0, 0.0), ("BC", 1.0, 0.0)]),
        # both pieces fold at the kink: cycles exist for p < 0 only
        (
            from_sympy(Piecewise((X / 2 + P, X < 0), (2 * X + P, True)), X, P), -1.0, -0.5,
            [("BC", 0.0, 0.0)],
        ),
    ],
)  # fmt: skip
def test_a_start_at_a_special_point(
    own: PiecewiseMap, x: float, p: float, points: list[tuple[str, float, float]]
) -> None:
    """It is found there, too, up to rounding, and so is all that an ordinary start finds."""
    settings = Settings(span=(-2.0, 3.5), window=(-4.0, 4.0))
    usual = continuation(own, shoot(own, x, p=p, settings=settings), settings=settings)
    wanted = special(usual)
    inner = [each for each in wanted if each[0] != "EP"]
    assert [each[0] for each in inner] == [kind for kind, _, _ in points]
    assert np.array([each[1:] for each in inner]) == pytest.approx(
        np.array([each[1:] for each in points]), abs=1e-12
    )
    for point in usual.points:
        if point.kind is PointKind.BP:
            continue  # two branches pass there
        start = shoot(own, point.x, p=point.parameter, settings=settings)
        found = special(continuation(own, start, settings=settings))
        assert [each[0] for each in found] == [each[0] for each in wanted]
        assert np.array([each[1:] for each in found]) == pytest.approx(
            np.array([each[1:] for each in wanted]), abs=1e-9
        )


# Random toys, each with two starts: a value of its parameter, and phi_S [rad] near a motion there.
STARTS = {
    # right at a flip, or at a fold
    "flip": (0, (0.7230476, -0.465457), (0.7433461176127475, -0.4648511510146692)),
    "flip at the end of the span": (
        18, (0.003143374515835635, -0.52617), (0.0030499219214457397, -0.5045843301667208),
    ),
    "fold": (68, (0.0031363, -0.757128), (0.0031102796289835008, -0.6870945112473348)),
    # right at a border: the map may take there the piece that does not close
    "fold-flip": (1, (0.7400212, -0.507104), (0.6989412106833565, -0.5102668544574055)),
    "border": (13, (0.2145999, -0.601426), (0.15422810858171282, -0.6203675216621173)),
    "border of a root": (19, (0.5415798, -0.497979), (0.42362487639527735, -0.5043057058522792)),
    "border beside a fold": (13, (0.2145999, -0.601426), (0.0888832127916255, -0.5653262095022378)),
    # A crossing runs along the grazing border of its path, which rounding may put beyond its end.
    "grazing": (55, (0.3061099, -0.660826), (0.2268436972549425, -0.7982900817232591)),
    # From above, a step led over the end of a path to another solution of its event times.
    "another solution": (57, (0.22839933, -0.694799), (0.37839933087359295, -0.5696259095578338)),
    "steep parameter": (68, (0.0031363, -0.757128), (0.0030724722970503593, -0.5958179597481414)),
    # At borders of the law h^(3/2) slopes are finite, but were rounded to 1e13.
    "steep by rounding": (86, (0.2011249, -0.664727), (0.07778808950613321, -1.6779703124005514)),
}  # fmt: skip


@SLOW_TOY
@pytest.mark.parametrize("scene", STARTS)
def test_toys_show_the_same_from_two_starts(scene: str) -> None:
    """All special points of the motions that are connected, each to 1e-9 of its value."""
    number, *starts = STARTS[scene]
    drawn, found = random_toy(number), []
    for value, phi_s in starts:
        toy = drawn.toy.replace(**{drawn.parameter: value})
        diagram = continuation(toy, shoot(toy, phi_s), drawn.parameter, drawn.span)
        found.append(special(diagram))
    one, other = found
    assert [each[0] for each in one] == [each[0] for each in other]
    assert np.array([each[1:] for each in one]) == pytest.approx(
        np.array([each[1:] for each in other]), rel=1e-9
    )


@SLOW_TOY
def test_both_points_of_a_doubled_cycle_end_in_one_flip() -> None:
    """Where they meet they are known to the root of rounding, 5e-8 rad off the single cycle."""
    drawn = random_toy(18)
    toy = drawn.toy.replace(**{drawn.parameter: 0.0030522286452130745})
    start = shoot(toy, [-0.5052014471010513, -0.5052199379064306])
    diagram = continuation(toy, start, drawn.parameter, drawn.span, orders=(1, 2))
    p = 0.003052230669677233
    (flip,) = (each for each in diagram.points if abs(each.parameter - p) < 1e-12)
    single = toy.replace(**{drawn.parameter: p})
    assert flip.x == pytest.approx(shoot(single, -0.5052112595).phi_s, abs=1e-12)
    assert sorted(diagram.branch(name).order for name in flip.branches) == [1, 1, 2, 2]
