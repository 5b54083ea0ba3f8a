"""Maps and what is found of them can be sent and copied, and behave as before."""

import copy
import pickle
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import pytest
import sympy
from pickles import Way, pickled
from sympy import QQ, Rational

from pwmap import (
    Cycle,
    Diagram,
    ParameterCells,
    PiecewiseLinearMap,
    RealRoot,
    bifurcation_diagram,
    dynamics,
    parameter_cells,
    parameter_plane,
    tongues,
    word_family,
)
from pwmap.longrun import Density
from pwmap.plane import ParameterPlane
from pwmap.rotations import Tongue, WordFamily

PLAIN = sympy.symbols("x a r")
ASSUMED = sympy.Symbol("x", real=True), *sympy.symbols("a r", positive=True)
Symbols = tuple[sympy.Symbol, sympy.Symbol, sympy.Symbol]


def paper(symbols: Symbols, *given: sympy.Basic) -> PiecewiseLinearMap:
    x, a, r = symbols
    return PiecewiseLinearMap([(r - 2, x <= 0), (r - a * x, x > 0)], x, given=[a > 1, *given])


def between(symbols: Symbols) -> PiecewiseLinearMap:
    """For 0 < r < 2, where its iterates are known."""
    return paper(symbols, symbols[2] > 0, symbols[2] < 2)


GOLDEN = PiecewiseLinearMap([("r - a*x", "x > 0"), ("a*x + 1", "x <= 0")]).at({"r": 1})
ROTATION = PiecewiseLinearMap([("x/2 + d", "x < 2 - 2*d"), ("x/2 + d - 1", "x >= 2 - 2*d")])
STEEP = PiecewiseLinearMap([("r - 2 + 3*x/2", "x <= 0"), ("r - 5*x/4", "x > 0")])
BETA = PiecewiseLinearMap([("b*x", "x < 1/b"), ("b*x - 1", "x >= 1/b")], given=["b > 1"])
FOUND: dict[str, Callable[[], Any]] = {
    "second": lambda: between(PLAIN).iterate(2),
    "second, assumed": lambda: between(ASSUMED).iterate(2),
    "third": lambda: paper(PLAIN).at({"a": "5/4", "r": 1}).iterate(3),
    "third, assumed": lambda: paper(ASSUMED).at({"a": "5/4", "r": 1}).iterate(3),
    "cells": lambda: parameter_cells(paper(PLAIN), "r", (1, 2), (1, 3)),
    "cells, assumed": lambda: parameter_cells(paper(ASSUMED), ASSUMED[2], (1, 2), (1, 3)),
    "cells with an edge that is no rational": lambda: parameter_cells(GOLDEN, "a", (1, 2), (1, 3)),
    "plane": lambda: parameter_plane(paper(PLAIN), "a", "r", (2, 3), (1, 3)),
    "diagram": lambda: bifurcation_diagram(paper(PLAIN).at({"a": 2}), "r", span=(-1, 3)),
    "cycle": lambda: paper(PLAIN).at({"a": 2, "r": 3}).cycle("RL"),
    "family": lambda: word_family(paper(PLAIN), "L R^k", "k"),
    "tongue": lambda: tongues(ROTATION, 3)[2],
    "density": lambda: dynamics(STEEP, {"r": 3}).attractors[0].density,
    "density of algebraic numbers": lambda: (
        dynamics(BETA, {"b": (1 + sympy.sqrt(5)) / 2}).attractors[0].density
    ),
}


def asked(found: Any) -> list[Any]:
    """All that is asked of a result here; some of it is remembered from then on."""
    match found:
        case PiecewiseLinearMap():
            return [
                str(found), repr(found), found.x, found.parameters, found.given, found.order,
                found.fixed_points(virtual=True), found.fixed_intervals(), found.jumps(),
                found.jump_crossings(), found.to_sympy(), found(Rational(-1, 3)),
                [str(piece) for piece in found.pieces],
            ]  # fmt: skip
        case ParameterCells():
            iterates = [asked_in_a_cell(cell.map.iterate(2)) for cell in found]
            ends = [(cell.lower, cell.upper) for cell in found]
            return [found.edges, found.given, found.orders, ends, iterates]
        case ParameterPlane():
            strips = [(s.lower, s.upper, s.cells.edges) for s in found.strips]
            return [strips, [(c.id, c.ends, c.along("7/3")) for c in found.curves]]
        case Diagram():
            return [found.points, [branch.exact for branch in found.branches]]
        case Cycle():
            return [found, found.admissible]
        case WordFamily():
            return [found.conditions, found.at(3), found.word(5), found.thresholds("r")]
        case Tongue():
            return [found.rotation, found.word, found.values, found.borders]
        case Density():
            measure = found.measure(0, Rational(1, 2))
            return [found.exponent_bounds, found.places, str(measure), float(measure)]
    raise TypeError(found)


def asked_in_a_cell(map_: PiecewiseLinearMap) -> list[Any]:
    return [str(map_), map_.scope, map_.fixed_points(), map_.jump_crossings(), map_.to_sympy()]


WAYS = pytest.mark.parametrize("way", [pickled, copy.deepcopy, copy.copy])


@WAYS
@pytest.mark.parametrize("made", FOUND.values(), ids=FOUND)
def test_a_copy_answers_as_its_original(way: Way, made: Callable[[], Any]) -> None:
    """Whether that was asked before it was copied or not."""
    found = made()
    unasked = way(found)
    expected = asked(found)
    assert asked(unasked) == asked(way(found)) == expected


@WAYS
def test_numbers_and_assumptions_are_copied(way: Way) -> None:
    """sqrt(2) lies between 7/5 and 10/7, and ``a > 1, r > 0, r < 2`` is in the ring of both."""
    root = RealRoot((QQ(1), QQ(0), QQ(-2)), 1, QQ(1), QQ(2))
    region = between(PLAIN).definition.region
    again, there = way(root), way(region)
    assert (again, hash(again)) == (root, hash(root))
    assert QQ(7, 5) < again < QQ(10, 7)
    assert (there.ring, there.constraints) == (region.ring, region.constraints)


def test_a_copy_goes_on_as_its_original() -> None:
    """Iterates, compositions and values of a map that was sent are those of its original."""
    map_, (_, a, r) = between(ASSUMED), ASSUMED
    sent, second = pickled(map_), asked(map_.iterate(2))
    assert asked(sent.iterate(2)) == asked(sent @ map_) == asked(map_ @ sent) == second
    values = {a: Rational(5, 4), r: 1}
    assert asked(sent.at(values)) == asked(map_.at(values))


@pytest.mark.nightly
def test_a_map_is_read_by_another_process() -> None:
    map_ = paper(ASSUMED, ASSUMED[2] > 2).iterate(2)
    code = "import pickle, sys; print(pickle.load(sys.stdin.buffer).pieces[1])"
    text = subprocess.run(
        [sys.executable, "-c", code], input=pickle.dumps(map_), capture_output=True, check=True
    ).stdout
    assert text.decode().strip() == str(map_.pieces[1])
