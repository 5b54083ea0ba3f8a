"""Verbs that are called wrongly: one sentence that names the value and what was expected."""

from fractions import Fraction
from functools import cache

import numpy as np
import pytest
import sympy

import pwmap
import pwmap.plot
from pwmap import PiecewiseLinearMap

from_sympy = PiecewiseLinearMap.from_sympy
PIECES = [("x/2", "x > 0"), ("x", "x <= 0")]
TENT = from_sympy("Piecewise((a*x, x <= 1/2), (a*(1 - x), True))")
T2 = TENT.at({"a": "7/4"})
SKEW = from_sympy("Piecewise((a*x + 1, x <= 0), (b*x + 1, True))")
P1 = from_sympy("Piecewise((r - 2, x <= 0), (r - a*x, True))", given=["a > 1"])
LINES = from_sympy("Piecewise((p + x/2, x <= 0), (p - 1 + x/3, True))")
CIRCLE = PiecewiseLinearMap([("x/2 + d", "x < 2 - 2*d"), ("x/2 + d - 1", "x >= 2 - 2*d")])
TURNED = CIRCLE.at({"d": "3/5"})
HALF = Fraction(1, 2)
JUMP = PiecewiseLinearMap([("x/2 + r", "x < 1"), ("-x/3 + a", "x >= 1")])


@cache
def found() -> pwmap.Diagram:
    return pwmap.bifurcation_diagram(LINES, "p", (-1, 2), orders=(1,))


@cache
def plane() -> pwmap.plane.ParameterPlane:
    return pwmap.parameter_plane(SKEW, "a", "b", ("1/4", "3/4"), (-5, "-1/2"))


@cache
def bands() -> pwmap.longrun.AttractorDiagram:
    return pwmap.attractor_diagram(TENT, "a", ("4/3", "3/2"), 1)


@cache
def long() -> pwmap.longrun.Dynamics:
    return pwmap.dynamics(TENT, {"a": "7/5"})


ROOMS = (pwmap, pwmap.maps, pwmap.longrun, pwmap.plane, pwmap.rotations, pwmap.plot)
NAMES = {name: getattr(room, name) for room in ROOMS for name in room.__all__}
NAMES |= {"np": np, "sympy": sympy} | globals()
WRONG_KIND = {
    'cycles(T2, "2")': "values must be a mapping such as {'a': '5/4'}, got '2'",
    "cycles(T2, 4)": "values must be a mapping such as {'a': '5/4'}, got 4",
    "cycles(T2, orders=(1, 2))": "got orders=(1, 2)",
    'cycles(TENT, {"a": 1.5})': "1.5 is a float, but the analysis is exact: write the rational",
    'cycles(TENT, [("a", 1)])': "values must be a mapping such as {'a': '5/4'}, got [('a', 1)]",
    'cycles(TENT, {"a": 2}, budget=100)': "budget must be pwmap.Budget, got 100",
    'cycles(TENT, {"a": 2}, progress=3)': "progress must be a function, got 3",
    "cycles()": "missing a required argument: 'map_'",
    'dynamics(TENT, "7/5")': "values must be a mapping such as {'a': '5/4'}, got '7/5'",
    'dynamics(TENT, {"a": "7/5"}, orders=3)': "orders must be several iterates such as (12, 24",
    'dynamics(TENT, {"a": "7/5"}, 3)': "got 3 by place",
    'dynamics(TENT, {"a": "7/5"}, budget=5).attractors': "budget must be pwmap.Budget, got 5",
    "long().attractors[0].share((0, 1.0))": "1.0 is a float, but the analysis is exact: write",
    'attractor_diagram(TENT, "a", (1.5, 2), 1)': "1.5 is a float, but the analysis is exact: w",
    'attractor_diagram(TENT, "a")': "missing a required argument: 'span'",
    'attractor_diagram(TENT, "a", (1, 2), 1, budget=3)': "budget must be pwmap.Budget, got 3",
    'attractor_diagram(TENT, "a", (1, 2), orders=(1,))': "got orders=(1,)",
    'constant_entropy(TENT, "a", (1, 2), tolerance=0.1)': "0.1 is a float, but the analysis is",
    'constant_entropy("tent", "a", (1, 2))': "expected a PiecewiseLinearMap (see its from_symp",
    'bifurcation_diagram(LINES, "p", (0, 0.5))': "0.5 is a float, but the analysis is exact: w",
    'bifurcation_diagram(LINES, "p", (-1, 2), order=2)': "got order=2",
    "bifurcation_diagram(LINES)": "missing a required argument: 'parameter'",
    'bifurcation_diagram("lines", "p")': "expected a PiecewiseLinearMap (see its from_sympy),",
    'bifurcation_diagram(P1, "r", sample=3)': "sample must be a mapping such as {'a': '5/4'},",
    'bifurcation_diagram(P1, "r", sample={"a": 1.5})': "1.5 is a float, but the analysis is ex",
    'bifurcation_diagram(LINES, "p", (-1, 2), progress=1)': "progress must be a function, got",
    'bifurcation_diagram(LINES, "p", (-1, 2), budget={"pieces": 3})': "budget must be pwmap.Budget",
    'parameter_plane(SKEW, "a", "b")': "missing a required argument: 'across_span'",
    'plane().at("1/2")': "missing a required argument: 'along'",
    "plane().at(0.5, 1)": "0.5 is a float, but the analysis is exact: write the rational 1/2 ins",
    "plane().curves[0].along(0.5)": "0.5 is a float, but the analysis is exact: write the ration",
    "with_crises(found())": "plane must be pwmap.plane.ParameterPlane, got Diagram(x over p: 3 b",
    'tongues("circle", 2)': "expected a PiecewiseLinearMap (see its from_sympy), got 'circle'",
    "tongues(CIRCLE)": "missing a required argument: 'q_max'",
    "rotational_word(0.5)": "a rotation number must be a rational, got 0.5",
    'rotational_word("1/2")': "a rotation number must be a rational, got '1/2'",
    "rotational_word(HALF, 3)": "letters must be text, got 3",
    "rotation_number(12)": "a word must be text, got 12",
    "rotation_number_at(found())": "expected a PiecewiseLinearMap (see its from_sympy), got D",
    'organising_centre(JUMP, "r")': "missing a required argument: 'along'",
    'PiecewiseLinearMap("x/2")': "pieces must be pairs (formula, condition), got 'x/2'; one",
    "PiecewiseLinearMap(3)": "pieces must be pairs (formula, condition), got 3; one formula is",
    "PiecewiseLinearMap(None)": "pieces must be pairs (formula, condition), got None; one form",
    "PiecewiseLinearMap(PIECES, given=3)": "given must be inequalities such as ['a > 1'], got",
    "PiecewiseLinearMap(PIECES, letters=3)": "expected 2 different letters, one for each piece",
    'PiecewiseLinearMap(PIECES, y="x")': "got y='x'",
    "PiecewiseLinearMap()": "missing a required argument: 'pieces'",
    "from_sympy(3.5)": "3.5 is a float, but the analysis is exact: write the rational 7/2 inst",
    'TENT.at("a")': "values must be a mapping such as {'a': '5/4'}, got 'a'",
    "TENT.at(a=2)": "got a=2; values are one mapping, such as .at({'a': '5/4'})",
    "T2.compose(3)": "expected a PiecewiseLinearMap (see its from_sympy), got 3",
    'T2.compose("x")': "expected a PiecewiseLinearMap (see its from_sympy), got 'x'",
    "T2 @ 3": "expected a PiecewiseLinearMap (see its from_sympy), got 3",
    "T2.limit(0)": "missing a required argument: 'side'",
    "T2.cycle(12)": "the word of a cycle must be text, got 12",
    "T2.fixed_points(True)": "got True by place",
    "found().at(None)": "a slice needs a number, got None",
    "found().at([1])": "a slice needs a number, got [1]",
    "found().within(None, 1)": "a slice needs a number, got None",
    "long().attractors[0].density.measure(0, 0.5)": "0.5 is a float, but the analysis is exact",
    "found().with_word(3)": "a word must be text, got 3",
    'found().named({"A": 3})': "a place must be two numbers, got 3",
    'found().named({"A": ("x", 1)})': "a place must be a number, got 'x'",
    'found().named(["A"])': "places must be a mapping such as {'A': 'BC1'}, got ['A']",
    'found().named({3: "BC1"})': "a name must be text, got 3",
    "found().save(3)": "the path of a file was expected, got 3",
    "load_diagram(3)": "the path of a file was expected, got 3",
    "write_graph(found().graph(), 3)": "the path of a file was expected, got 3",
    "Budget(progress=3)": "progress must be a function, got 3",
    "Budget(100)": "got 100 by place",
    "Budget(piece=3)": "got piece=3",
    'meeting_curve(SKEW, 3, "R")': "a word must be text, got 3",
    'meeting_curve("skew", "L", "R")': "expected a PiecewiseLinearMap (see its from_sympy), go",
    "with_attractors(found(), found())": "found must be pwmap.longrun.AttractorDiagram, got Diagra",
    "with_attractors(3, bands())": "diagram must be pwmap.Diagram, got 3",
    "plot_map(3)": "expected a PiecewiseLinearMap (see its from_sympy), got 3",
    "plot_map(T2, 3)": "ax must be axes of matplotlib, got 3",
    "plot_map(T2, window=3)": "window must be two numbers, got 3",
    'plot_map(T2, window=("a","b"))': "window must be a number, got 'a'",
    "plot_map(T2, styles=3)": "styles must be a mapping such as {'stable': {'color': 'k'}}, got 3",
    "plot_diagram(3)": "diagram must be pwmap.Diagram, got 3",
    'plot_diagram(found(), kinds="BC")': "kinds must be several kinds such as (PointKind.BC,), g",
    "plot_diagram(found(), kinds=3)": "kinds must be several kinds such as (PointKind.BC,), got",
    "plot_cobweb(T2)": "missing a required argument: 'start'",
    "plot_kneading(3)": "seen must be pwmap.longrun.Dynamics, got 3",
    "plot_plane(3)": "plane must be pwmap.plane.ParameterPlane, got 3",
    'plot_plane(plane(), colours="period")': "colours must be pwmap.plane.Colours, got 'period'",
    "plot_plane(plane(), raster=3)": "raster must be pwmap.plane.PlaneRaster, got 3",
    'dynamics(TENT, {"a": float("nan")})': "nan is not a rational number",
    'cycles(TENT, {"a": 2}, on_interrupt=3)': "on_interrupt must be a function, got 3",
    "TENT.at(None)": "values must be a mapping such as {'a': '5/4'}, got None",
    "Branch()": "missing a required argument: 'id'",
    "Branch(1,2,3)": "got 1 by place",
    'SpecialPoint("A")': "got 'A' by place",
    "Diagram(3)": "got 3 by place",
    "found().at(1j)": "a slice needs a number, got 1j",
    'found().named({"A": (0,0)}, within="x")': "within must be a number, got 'x'",
    'found().named({"A": (0,0)}, near=0.1)': "Diagram.named takes places, within, got near=0.1",
    "RealRoot(3,0,0,1)": "a polynomial must be a tuple of numbers, got 3",
    "RealRoot()": "missing a required argument: 'polynomial'",
    "Meter(3)": "budget must be pwmap.Budget, got 3",
    'word_family(TENT, "L R^n", budget=3)': "word_family takes map_, pattern, n, got budget=3",
    'word_family("p1", "L R^n")': "expected a PiecewiseLinearMap (see its from_sympy), got 'p1",
    'organising_centre(JUMP, "r", "a", 3)': "got 3 by place",
    "plane_raster(plane(), size=3)": "got size=3",
    "with_crises(plane(), 2, 3, budget=3)": "budget must be pwmap.Budget, got 3",
    'bifurcation_diagram(LINES, "p", (-1, 2), finished=3)': "finished must be a function, got",
    'bifurcation_diagram(LINES, "p", (-1, 2), on_interrupt=3)': "on_interrupt must be a functi",
    'meeting_curve(SKEW, "L")': "missing a required argument: 'cycle'",
    "prove()": "missing a required argument: 'what'",
    "found().point([])": "an id or a name must be text, got []",
    'found().path("F1", [])': "an id or a name must be text, got []",
    "found().branch([])": "an id must be text, got []",
    'Diagram(parameter_name="p", x_name="x", branches="F1", points=())': "a part of a diagram must",
    'Diagram(parameter_name="p", x_name="x", branches=(), points=[None])': "a part of a diagram mu",
    "SpecialPoint(id=True, kind=PointKind.BC, parameter=0.0, x=0.0)": "a point id must be text, go",
    'SpecialPoint(id="A", kind="BC", parameter=0.0, x=0.0, precision="0")': "a precision must be a",
    'SpecialPoint(id="A", kind="BC", parameter=0.0, x=0.0, interval=0)': "an interval must be two",
    "Budget(on_interrupt=3)": "on_interrupt must be a function, got 3",
    "PiecewiseLinearMap(PIECES, letters=[1,2])": "expected 2 different letters, one for each p",
    "plot_diagram(found(), branches=3)": "branches must be a mapping such as {'F1': 'stable'},",
    'plot_diagram(found(), styles={"stable": 3})': "the style of 'stable' must be a mapping su",
    'plot_entropy(TENT, "a", (1, 2), intervals=3)': "intervals must be pwmap.longrun.EntropyIn",
}
WRONG_VALUE = {
    'cycles(T2, {}, "2")': "the order of an iterate must be an integer j >= 1, got '2'",
    "cycles(T2, {}, True)": "the order of an iterate must be an integer j >= 1, got True",
    'cycles(T2, order="2")': "the order of an iterate must be an integer j >= 1, got '2'",
    "cycles(TENT)": "every parameter needs a value, got none for a",
    'cycles(TENT, {"a": "x"})': "expected a rational number, got 'x'",
    "dynamics(TENT)": "every parameter needs a value, got none for a",
    'dynamics(TENT, {"a": "7/5"}, orders=("3",)).entropy': "the order of an iterate must be an",
    'dynamics(TENT, {"a": "(1 + sqrt(5))/2"})': "cannot read '(1 + sqrt(5))/2' as an",
    'long().laps("3")': "the order of an iterate must be an integer j >= 1, got '3'",
    "long().laps(0)": "the order of an iterate must be an integer j >= 1, got 0",
    "long().attractors[0].share(1)": "a window must be an interval (low, high), got 1",
    "long().attractors[0].share((1, 0))": "a window must be an interval (low, high), got (1, 0",
    'long().attractors[0].share("01")': "a window must be an interval (low, high), got '01'",
    'attractor_diagram(TENT, "a", (1, 2), "3")': "the order of an iterate must be an integer j",
    'attractor_diagram(TENT, "b", (1, 2), 1)': "expected a map of b alone, this one has ['a']",
    'attractor_diagram(TENT, "a", (2, 1), 1)': "a span must be an interval (low, high), got (2",
    'attractor_diagram(TENT, "a", 1, 1)': "a span must be an interval (low, high), got 1",
    'attractor_diagram(TENT, "a", ("1", "x"), 1)': "expected a rational number, got 'x'",
    'attractor_diagram(TENT, "a", (1, 1), 1)': "a span must be an interval (low, high), got (1",
    'attractor_diagram(TENT, "a", (1, 2, 3), 1)': "a span must be an interval (low, high), got",
    'attractor_diagram(SKEW, "a", (1, 2), 1)': "expected a map of a alone, this one has ['a',",
    "attractor_diagram(TENT, 3, (1, 2), 1)": "expected a map of 3 alone, this one has ['a']",
    'constant_entropy(TENT, "a", (1, 2), tolerance="x")': "expected a rational number, got 'x'",
    'constant_entropy(TENT, "a", (1, 2), tolerance=-1)': "a tolerance must be positive, got -1",
    'constant_entropy(TENT, "a", (1, 2), samples="3")': "samples must be an integer of at",
    'constant_entropy(TENT, "a", (1, 2), samples=0)': "samples must be an integer of at least",
    'constant_entropy(TENT, "a", (1, 2), steps=1.5)': "steps must be an integer of at least 1,",
    'constant_entropy(TENT, "a", (2, 1))': "a span must be an interval (low, high), got (2, 1)",
    'bifurcation_diagram(LINES, "p", (2, -1))': "a span must be an interval (low, high), got (",
    'bifurcation_diagram(LINES, "p", 3)': "a span must be an interval (low, high), got 3",
    'bifurcation_diagram(LINES, "p", (-1, 2), "12")': "the order of an iterate must be an inte",
    'bifurcation_diagram(LINES, "p", (-1, 2), (0,))': "the order of an iterate must be an inte",
    'bifurcation_diagram(LINES, "p", (-1, 2), (1.0,))': "the order of an iterate must be an in",
    'bifurcation_diagram(LINES, "p", (-1, 2), ())': "orders must name at least one iterate, go",
    'bifurcation_diagram(LINES, "p", sample={"q": 1})': "a sample must give values to [], got",
    'bifurcation_diagram(P1, "r", sample={"a": 0})': "the sample {'a': 0} contradicts the assu",
    'parameter_cells(LINES, "p", (1, "2"))': "the order of an iterate must be an integer j >=",
    'parameter_cells(LINES, "p", (1,), (2, 1))': "a span must be an interval (low, high), got",
    'parameter_cells(LINES, "p", span="ab")': "a span must be an interval (low, high), got 'ab",
    'parameter_plane(SKEW, "a", "a", (0, 1), (0, 1))': "expected two different parameters, got",
    'parameter_plane(SKEW, "a", "c", (0, 1), (0, 1))': "expected a map of a and c, this one ha",
    'parameter_plane(SKEW, "a", "b", (1, 0), (0, 1))': "a span must be an interval (low, high)",
    'parameter_plane(SKEW, "a", "b", (0, 1), 1)': "a span must be an interval (low, high), got",
    'plane().regions("2")': "period must be one of the orders 1, 2, got '2'",
    "plane().regions(7)": "period must be one of the orders 1, 2, got 7",
    'plane_raster(plane(), "3", 2)': "columns must be an integer of at least 1, got '3'",
    "plane_raster(plane(), 0, 2)": "columns must be an integer of at least 1, got 0",
    "plane_raster(plane(), 2.0, 2)": "columns must be an integer of at least 1, got 2.0",
    "with_crises(plane(), columns=0)": "columns must be an integer of at least 1, got 0",
    'tongues(CIRCLE, "3")': "the largest denominator must be an integer of at least 1, got '3'",
    'farey("3")': "the largest denominator must be an integer of at least 1, got '3'",
    'rotational_word(HALF, "L")': "the pieces need two different letters, got 'L'",
    'rotational_word(HALF, letters="LL")': "the pieces need two different letters, g",
    'rotation_number("")': "a word must consist of the letters L and R, got ''",
    'rotation_number("LRM")': "a word must consist of the letters L and R, got 'LRM'",
    "rotation_number_at(CIRCLE)": "every parameter must have a value (.at), the map still has",
    'rotation_number_at(TURNED, "3")': "the number of iterates must be an integer of at least",
    "rotation_number_at(TURNED, 0)": "the number of iterates must be an integer of at least 1,",
    "rotation_interval(TURNED, iterates=1.5)": "the number of iterates must be an integer of a",
    'organising_centre(JUMP, "r", "r")': "expected two different parameters, got r twice",
    'organising_centre(JUMP, "r", "z")': "z is no parameter of this map, it has ['a', 'r']",
    'word_family(P1, "L R")': "a pattern must have an exponent n, got 'L R'",
    'word_family(P1, "Q^n")': "the pattern 'Q^n' cannot be read: 'Q' is no piece of this map,",
    "word_family(P1, 3)": "a pattern must be text such as 'R L^n', got 3",
    'word_family(P1, "")': "a pattern must have an exponent n, got ''",
    'word_family(P1, "L R^n", n=3)': "the exponent needs a name that is not taken by the map,",
    'word_family(P1, "L R^n").at(0)': "the exponent n must be an integer of at least 1, got 0",
    'word_family(P1, "L R^n").word("2")': "the exponent n must be an integer of at least 1, go",
    'word_family(P1, "L R^n").thresholds(3)': "3 is no parameter of this map, it has ['a', 'r'",
    'PiecewiseLinearMap([("x/2", "x > 0")])': "there is a gap: no piece covers x < 0",
    "PiecewiseLinearMap([])": "a map needs at least one piece",
    'PiecewiseLinearMap([("x",)])': "each piece must be a pair (formula, condition), got ('x',",
    'PiecewiseLinearMap(PIECES, letters="A")': "expected 2 different letters, one for each pie",
    'PiecewiseLinearMap(PIECES, letters="AA")': "expected 2 different letters, one for each pi",
    "PiecewiseLinearMap(PIECES, x=3)": "the variable must be a symbol such as x, got 3",
    "from_sympy(None)": "expected text, a number or a sympy expression, got None",
    'from_sympy("x +")': "cannot read 'x +' as an expression: it ends too early",
    'from_sympy("x/2", 5)': "the variable must be a symbol such as x, got 5",
    'from_sympy("import os")': "cannot read 'import os' as an expression: unexpected 'os'",
    'TENT.at({"z": 1})': "z is no parameter of this map, it has ['a']",
    "TENT.at({TENT: 1})": "> is no parameter of this map, it has ['a']",
    "attractor_diagram(TENT, found(), (1, 2), 1)": "expected a map of Diagram(x over p",
    'TENT.at({"a": "x+1"})': "expected a rational number, got 'x+1'",
    "TENT.at({3: 1})": "3 is no parameter of this map, it has ['a']",
    "T2.iterate(True)": "the order of an iterate must be an integer j >= 1, got True",
    'T2("y")': "a point y holds the unknown symbol y",
    "T2(None)": "expected text, a number or a sympy expression, got None",
    "T2.word_of([1])": "expected text, a number or a sympy expression, got [1]",
    'T2.limit(0, "left")': "the side must be '-' or '+', got 'left'",
    "T2.limit(0, 1)": "the side must be '-' or '+', got 1",
    'T2.cycle("LQ")': "'Q' is no piece of this map, it has ('L', 'R')",
    'T2.cycle("")': "the word of a cycle must have at least one letter",
    'found().at(float("nan"))': "a slice needs a finite value of the parameter, got nan",
    'found().of_order("1")': "order must be an integer of at least 1, got '1'",
    'found().within("0", "p")': "expected a rational number, got 'p'",
    "found().within(0, float('nan'))": "a slice needs a finite value of the parameter, got nan",
    'long().attractors[0].density.measure("0", "y")': "expected a rational number, got 'y'",
    "long().attractors[0].density.measure(0, sympy.pi)": "expected a real algebraic number, got p",
    'found().named({"A": (0, 10**400)})': "a place must fit into a double, got 10000000",
    "found().within(1, 0)": "expected an interval from low to high, got (1, 0)",
    'found().stable_intervals("1")': "order must be an integer of at least 1, got '1'",
    "prove(3)": "a map, or a diagram and its map, was expected, got 3",
    "prove(TENT)": "this cannot be certified: give values (.at) to the parameters a",
    "prove(found())": "a map, or a diagram and its map, was expected, got Diagram(x over p: 3 br",
    "prove(found().within(-9, -5), LINES)": "this cannot be certified: the diagram has no branch",
    "prove(found(), 3)": "a map, or a diagram and its map, was expected, got Diagram(x over p: 3",
    "prove(T2, order=0)": "the order of an iterate must be an integer j >= 1, got 0",
    "prove(T2, orders=(1,))": "of a map, only an order can be given: prove(map, order=2)",
    "prove(found(), LINES, order=2)": "of a diagram, only orders can be given: prove(diagram, ma",
    "prove(T2, TENT)": "of a map, only an order can be given: prove(map, order=2)",
    'Budget(pieces="3")': "pieces of a budget must be a positive integer, got '3'",
    "Budget(work=1.5)": "work of a budget must be a positive integer, got 1.5",
    'Budget(seconds="3")': "seconds of a budget must be a positive number, got '3'",
    'meeting_curve(SKEW, "LRL", "")': "a word must have at least one letter",
    'meeting_curve(SKEW, "Q", "R")': "'Q' is no piece of this map, it has ('L', 'R')",
    'meeting_curve(SKEW, "L", "R", 5)': "number must name one of 1 breaks, from 0 on, got 5",
    'meeting_curve(SKEW, "L", "R", "0")': "number must name one of 1 breaks, from 0 on, got '0",
    "plot_map(TENT)": "every parameter must have a value (.at), the map still has a",
    "plot_map(T2, window=(1,0))": "a window must ascend, got (1.0, 0.0)",
    'plot_map(T2, styles={"x": {}})': "a style must be of one of diagonal, pieces, ends, unsta",
    'plot_cobweb(T2, "1/3", 0)': "steps must be an integer of at least 1, got 0",
    'plot_cobweb(T2, "y", 3)': "expected a rational number, got 'y'",
    'plot_entropy(TENT, "a", (1, 2), steps=0)': "steps must be an integer of at least 1, got 0",
    'plot_entropy(TENT, "b", (1, 2))': "b is no parameter of this map, it has ['a']",
    'plot_density(dynamics(TENT, {"a": "1/2"}))': "expected a map with a chaotic attractor, th",
    "plot_density(long(), points=0)": "points must be an integer of at least 1, got 0",
    'plot_density(long(), points="3")': "points must be an integer of at least 1, got '3'",
    "plot_kneading(long(), steps=0)": "steps must be an integer of at least 1, got 0",
    "plot_plane(plane(), samples=0)": "samples must be an integer of at least 1, got 0",
    'dynamics(TENT, {"a": "7/5"}, orders=())': "orders must name at least one iterate, got non",
    'dynamics(TENT, {"a": 1+2j})': "expected text, a number or a sympy expression, got (1+2j)",
    'dynamics(TENT, {"a": sympy.pi})': "expected a real algebraic number, got pi",
    'dynamics(SKEW, {"a": sympy.sqrt(2), "b": sympy.sqrt(3)})': "one parameter may have an alg",
    'dynamics(TENT.iterate(2), {"a": sympy.sqrt(2)})': "an algebraic value needs the map",
    'SpecialPoint(id="a:b", kind=PointKind.BC, parameter=0.0, x=0.0)': "a point id must be tex",
    'SpecialPoint(id="A", kind="XX", parameter=0.0, x=0.0)': "'XX' is not a valid PointKind",
    'found().at("1/0")': "cannot work out 0: it divides by zero",
    "RealRoot((1,2),0,0,1)": "expected an irreducible polynomial of degree two or more, got t",
    'word_family(P1, ["L","R"])': "a pattern must be text such as 'R L^n', got ['L', 'R']",
    'parameter_cells(LINES, "p", range(0))': "orders must name at least one iterate, got none",
    'bifurcation_diagram(LINES, "p", (0, float("inf")))': "a span needs two rational ends, or",
    'bifurcation_diagram(LINES, "p", (None, 1))': "a span needs two rational ends, or none at",
    'bifurcation_diagram(LINES, "p", (-1, 2), range(0))': "orders must name at least one itera",
    'bifurcation_diagram(LINES, "p", (-1, 2), None)': "the order of an iterate must be an inte",
    'bifurcation_diagram(LINES, "p", np.array([-1.0, 2.0]))': "a span must be an interval (low",
    'attractor_diagram(TENT, "a", None)': "a span must be an interval (low, high), got None",
    "prove(found(), LINES, orders=3)": "this cannot be certified: the diagram has no branch ov",
    "Budget(pieces=True)": "pieces of a budget must be a positive integer, got True",
    'PiecewiseLinearMap(PIECES, "y")': "the condition x > 0 does not contain y: put it among t",
    'PiecewiseLinearMap([("x/2", "x > 0"), 3])': "each piece must be a pair (formula, conditio",
    'PiecewiseLinearMap([("x/2", 3), ("x", "x <= 0")])': "expected a condition such as x < 0,",
    'plot_entropy(TENT, "a", 3)': "a span must be an interval (low, high), got 3",
}
CASES = [
    *((call, TypeError, sentence) for call, sentence in WRONG_KIND.items()),
    *((call, ValueError, sentence) for call, sentence in WRONG_VALUE.items()),
]


@pytest.mark.slow
@pytest.mark.parametrize(("call", "kind", "sentence"), CASES, ids=[call for call, *_ in CASES])
def test_a_wrong_call_is_answered_in_a_sentence(call: str, kind: type, sentence: str) -> None:
    with pytest.raises(kind) as error:
        eval(call, dict(NAMES))
    assert type(error.value) is kind
    assert sentence in str(error.value)
    assert "\n" not in str(error.value)


def test_a_hundred_wrong_calls_are_tried() -> None:
    assert len(CASES) > 150
