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
PAPER = from_sympy("Piecewise((b*x + r - 2, x <= 0), (r - a*x, True))")
BETA = from_sympy("Piecewise((b*x, x < 1/b), (b*x - 1, True))", given=["b > 1"])
GAP = from_sympy("Piecewise((s*x + d, x < 0), (t*x + d - 1, True))")
CIRCLE = PiecewiseLinearMap([("x/2 + d", "x < 2 - 2*d"), ("x/2 + d - 1", "x >= 2 - 2*d")])
TURNED = CIRCLE.at({"d": "3/5"})
HALF = Fraction(1, 2)
JUMP = PiecewiseLinearMap([("x/2 + r", "x < 1"), ("-x/3 + a", "x >= 1")])


@cache
def cell() -> PiecewiseLinearMap:
    return pwmap.parameter_cells(CIRCLE, "d").cells[0].map


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
VERBS = """
    Branch Budget Diagram PiecewiseLinearMap RealRoot SpecialPoint T2.fixed_points T2.limit TENT.at
    attractor_diagram bifurcation_diagram constant_entropy cycles dynamics farey found().named
    from_sympy meeting_curve organising_centre organising_centres parameter_cells parameter_plane
    plane().at plane_raster plot_attractors plot_cobweb plot_density plot_diagram plot_entropy
    plot_kneading plot_long_run plot_map plot_plane prove rotation_interval rotation_number
    rotation_number_at rotational_word tongues with_attractors with_crises word_family
"""
MISFITS = {  # of a function, a method and a class: nothing else in an answer is their own
    "cycles()": "by name budget, progress, on_interrupt: missing a required argument: 'map_'",
    "T2.limit(0)": "PiecewiseLinearMap.limit takes x, side: missing a required argument: 'side'",
    "RealRoot()": "takes polynomial, index, low, high: missing a required argument: 'polynomial'",
    'dynamics(TENT, {"a": "7/5"}, 3)': "takes map_, values, and by name orders, budget, got 3 by",
    "T2.fixed_points(True)": "takes by name virtual, got True by place",
    "Diagram(3)": "branches, points, given, sample, about, got 3 by place",
    "TENT.at(a=2)": "got a=2; values are one mapping, such as .at({'a': '5/4'})",
}
CALLS = {  # by what is wrong in them: the value between backticks is {} in the sentence
    (TypeError, "values must be a mapping such as {'a': '5/4'}, got {}"): (
        'cycles(T2, `"2"`)', "cycles(T2, `4`)", 'cycles(TENT, `[("a", 1)]`)',
        'dynamics(TENT, `"7/5"`)', 'TENT.at(`"a"`)', "TENT.at(`None`)",
    ),
    (TypeError, "{} is a float, but the analysis is exact: write"): (
        'cycles(TENT, {"a": `1.5`})', "long().attractors[0].share((0, `1.0`))",
        'attractor_diagram(TENT, "a", (`1.5`, 2), 1)',
        'constant_entropy(TENT, "a", (1, 2), tolerance=`0.1`)',
        'bifurcation_diagram(LINES, "p", (0, `0.5`))',
        'bifurcation_diagram(P1, "r", sample={"a": `1.5`})', "plane().at(`0.5`, 1)",
        "plane().curves[0].along(`0.5`)", "from_sympy(`3.5`)",
        "long().attractors[0].density.measure(0, `0.5`)",
        'PiecewiseLinearMap(PIECES, given=["a > `1.5`"])', 'TENT.at({"a": `1.25`})', "T2(`0.5`)",
        'parameter_cells(LINES, "p", span=(0, `2.5`))', 'dynamics(TENT, {"a": `1.5`})',
        'constant_entropy(TENT, "a", (`1.5`, 2))',
    ),
    (TypeError, "budget must be pwmap.Budget, got {}"): (
        'cycles(TENT, {"a": 2}, budget=`100`)',
        'dynamics(TENT, {"a": "7/5"}, budget=`5`).attractors',
        'attractor_diagram(TENT, "a", (1, 2), 1, budget=`3`)',
        'bifurcation_diagram(LINES, "p", (-1, 2), budget=`{"pieces": 3}`)', "Meter(`3`)",
        "with_crises(plane(), 2, 3, budget=`3`)",
    ),
    (TypeError, "must be a function, got {}"): (
        'cycles(TENT, {"a": 2}, progress=`3`)',
        'bifurcation_diagram(LINES, "p", (-1, 2), progress=`1`)', "Budget(progress=`3`)",
        'cycles(TENT, {"a": 2}, on_interrupt=`3`)',
        'bifurcation_diagram(LINES, "p", (-1, 2), finished=`3`)',
        'bifurcation_diagram(LINES, "p", (-1, 2), on_interrupt=`3`)', "Budget(on_interrupt=`3`)",
    ),
    (TypeError, "expected a PiecewiseLinearMap (see its from_sympy), got {}"): (
        'constant_entropy(`"tent"`, "a", (1, 2))', 'bifurcation_diagram(`"lines"`, "p")',
        'tongues(`"circle"`, 2)', "T2.compose(`3`)", 'T2.compose(`"x"`)', "T2 @ `3`",
        'meeting_curve(`"skew"`, "L", "R")', "plot_map(`3`)", 'word_family(`"p1"`, "L R^n")',
        'parameter_plane(`"x"`, "a", "b", (0, 1), (0, 1))', 'dynamics(`"x"`)',
        'attractor_diagram(`"x"`, "a", (0, 1))', 'organising_centre(`"x/2"`, "r", "a")',
    ),
    (TypeError, "a slice needs a number, got {}"): (
        "found().at(`None`)", "found().at(`[1]`)", "found().within(`None`, 1)", "found().at(`1j`)",
    ),
    (ValueError, "the order of an iterate must be an integer j >= 1, got {}"): (
        'cycles(T2, {}, `"2"`)', "cycles(T2, {}, `True`)", 'cycles(T2, order=`"2"`)',
        'dynamics(TENT, {"a": "7/5"}, orders=(`"3"`,)).entropy', 'long().laps(`"3"`)',
        "long().laps(`0`)", 'attractor_diagram(TENT, "a", (1, 2), `"3"`)',
        'bifurcation_diagram(LINES, "p", (-1, 2), (`0`,))',
        'bifurcation_diagram(LINES, "p", (-1, 2), (`1.0`,))',
        'parameter_cells(LINES, "p", (1, `"2"`))', "T2.iterate(`True`)", "prove(T2, order=`0`)",
        'bifurcation_diagram(LINES, "p", (-1, 2), `None`)', "P1.iterate(`0`)", "P1.iterate(`1.0`)",
        'bifurcation_diagram(LINES, "p", (-1, 2), `b"1"`)',
        "parameter_cells(LINES, 'p', `bytearray(b'1')`)",
    ),
    (ValueError, "expected a rational number, got {}"): (
        'cycles(TENT, {"a": `"x"`})', 'attractor_diagram(TENT, "a", ("1", `"x"`), 1)',
        'constant_entropy(TENT, "a", (1, 2), tolerance=`"x"`)', 'TENT.at({"a": `"x+1"`})',
        'found().within("0", `"p"`)', 'long().attractors[0].density.measure("0", `"y"`)',
        'plot_cobweb(T2, `"y"`, 3)', 'found().at(`"q"`)',
    ),
    (ValueError, "a window must be an interval (low, high), got {}"): (
        "long().attractors[0].share(`1`)", "long().attractors[0].share(`(1, 0)`)",
        'long().attractors[0].share(`"01"`)',
    ),
    (ValueError, "expected a map of {} alone, this one has"): (
        'attractor_diagram(TENT, "`b`", (1, 2), 1)', 'attractor_diagram(SKEW, "`a`", (1, 2), 1)',
        "attractor_diagram(TENT, `3`, (1, 2), 1)", 'constant_entropy(PAPER, "`r`", (2, 3))',
    ),
    (ValueError, "a span must be an interval (low, high), got {}"): (
        'attractor_diagram(TENT, "a", `(2, 1)`, 1)', 'attractor_diagram(TENT, "a", 1, `1`)',
        'attractor_diagram(TENT, "a", `(1, 1)`, 1)', 'attractor_diagram(TENT, "a", `(1, 2, 3)`, 1)',
        'constant_entropy(TENT, "a", `(2, 1)`)', 'bifurcation_diagram(LINES, "p", `(2, -1)`)',
        'bifurcation_diagram(LINES, "p", `3`)', 'parameter_cells(LINES, "p", (1,), `(2, 1)`)',
        'parameter_cells(LINES, "p", span=`"ab"`)', 'parameter_cells(LINES, "p", span=`b"ab"`)',
        'parameter_plane(SKEW, "a", "b", `(1, 0)`, (0, 1))',
        'parameter_plane(SKEW, "a", "b", (0, 1), `1`)', 'attractor_diagram(TENT, "a", `None`)',
        'plot_entropy(TENT, "a", `3`)', 'parameter_cells(P1, "r", span=`(1, 1)`)',
    ),
    (ValueError, "must be an integer of at least 1, got {}"): (
        'constant_entropy(TENT, "a", (1, 2), samples=`"3"`)',
        'constant_entropy(TENT, "a", (1, 2), samples=`0`)',
        'constant_entropy(TENT, "a", (1, 2), steps=`1.5`)', 'plane_raster(plane(), `"3"`, 2)',
        "plane_raster(plane(), `0`, 2)", "plane_raster(plane(), `2.0`, 2)",
        "with_crises(plane(), columns=`0`)", 'tongues(CIRCLE, `"3"`)', 'farey(`"3"`)',
        'rotation_number_at(TURNED, `"3"`)', "rotation_number_at(TURNED, `0`)",
        "rotation_interval(TURNED, iterates=`1.5`)", 'found().of_order(`"1"`)',
        'found().stable_intervals(`"1"`)', 'plot_cobweb(T2, "1/3", `0`)',
        'plot_entropy(TENT, "a", (1, 2), steps=`0`)', "plot_density(long(), points=`0`)",
        'plot_density(long(), points=`"3"`)', "plot_kneading(long(), steps=`0`)",
        "plot_plane(plane(), samples=`0`)", "farey(`0`)", "farey(`True`)", "tongues(CIRCLE, `2.5`)",
        'word_family(P1, "L R^n").at(`0`)', 'word_family(P1, "L R^n").word(`"2"`)',
    ),
    (ValueError, "orders must name at least one iterate, got none"): (
        'bifurcation_diagram(LINES, "p", (-1, 2), ())', 'dynamics(TENT, {"a": "7/5"}, orders=())',
        'parameter_cells(LINES, "p", range(0))',
        'bifurcation_diagram(LINES, "p", (-1, 2), range(0))', 'parameter_cells(P1, "r", ())',
    ),
    (ValueError, "contradicts the assumption"): (
        'bifurcation_diagram(P1, "r", sample={"a": 0})', 'P1.at({"a": 1})',
        'P1.at({"a": "1/2", "r": 1})', 'parameter_cells(P1.at({"r": 1}), "a", span=(0, 2))',
        'parameter_cells(P1, "r", sample={"a": 1})',
        'bifurcation_diagram(P1.at({"r": 1}), "a", (0, 2))',
        'dynamics(BETA, {"b": sympy.sqrt(2) - 1})',
    ),
    (ValueError, "every parameter must have a value (.at), the map still has"): (
        "rotation_number_at(CIRCLE)", "plot_map(TENT)", "rotation_interval(CIRCLE)",
        "plot_cobweb(P1, 0, 3)",
    ),
    (ValueError, "{} is no parameter of this map, it has"): (
        'organising_centre(JUMP, "r", "`z`")', 'word_family(P1, "L R^n").thresholds(`3`)',
        'TENT.at({"`z`": 1})', "TENT.at({`3`: 1})", 'plot_entropy(TENT, "`b`", (1, 2))',
        'T2.at({"`r`": 1})', 'parameter_cells(P1, "`q`")', 'bifurcation_diagram(P1, "`q`")',
    ),
    (ValueError, "'{}' is no piece of this map, it has ('L', 'R')"): (
        'word_family(P1, "`Q`^n")', 'T2.cycle("L`Q`")', 'meeting_curve(SKEW, "`Q`", "R")',
    ),
    (ValueError, "expected text, a number or a sympy expression, got {}"): (
        "from_sympy(`None`)", "T2(`None`)", "T2.word_of(`[1]`)",
    ),
    (ValueError, "of a budget must be a positive integer, got {}"): (
        'Budget(pieces=`"3"`)', "Budget(work=`1.5`)", "Budget(pieces=`True`)", "Budget(work=`0`)",
        "Budget(letters=`-1`)",
    ),
    (ValueError, "must be an integer of at most "): (
        "plot_density(long(), points=10**30)", "plot_kneading(long(), steps=10**30)",
        "plot_cobweb(T2, 0, 10**30)", "plot_attractors(bands(), TENT, steps=10**30)",
        'plot_entropy(TENT, "a", (1, 2), steps=10**30)', "plot_plane(plane(), samples=10**30)",
    ),
}  # fmt: skip
WRONG_KIND = {
    'dynamics(TENT, {"a": "7/5"}, orders=3)': "orders must be several iterates such as (12, 24",
    'dynamics(TENT, {"a": "7/5"}, orders=b"12")': "orders must be several iterates such as (12, 24",
    'bifurcation_diagram(P1, "r", sample=3)': "sample must be a mapping such as {'a': '5/4'},",
    "with_crises(found())": "plane must be pwmap.plane.ParameterPlane, got Diagram(x over p: 3 b",
    "rotational_word(0.5)": "a rotation number must be a rational, got 0.5",
    'rotational_word("1/2")': "a rotation number must be a rational, got '1/2'",
    "rotational_word(HALF, 3)": "letters must be text, got 3",
    "rotation_number(12)": "a word must be text, got 12",
    "rotation_number_at(found())": "expected a PiecewiseLinearMap (see its from_sympy), got D",
    'PiecewiseLinearMap("x/2")': "pieces must be pairs (formula, condition), got 'x/2'; one",
    "PiecewiseLinearMap(3)": "pieces must be pairs (formula, condition), got 3; one formula is",
    'PiecewiseLinearMap(b"xx")': "pieces must be pairs (formula, condition), got b'xx'; one",
    'PiecewiseLinearMap(PIECES, given=b"a > 1")': "given must be inequalities such as ['a > 1'], ",
    "PiecewiseLinearMap(PIECES, given=3)": "given must be inequalities such as ['a > 1'], ",
    "PiecewiseLinearMap(PIECES, letters=3)": "expected 2 different letters, one for each piece",
    "T2.cycle(12)": "the word of a cycle must be text, got 12",
    "found().with_word(3)": "a word must be text, got 3",
    'found().named({"A": 3})': "a place must be two numbers, got 3",
    'found().named({"A": ("x", 1)})': "a place must be a number, got 'x'",
    'found().named(["A"])': "places must be a mapping such as {'A': 'BC1'}, got ['A']",
    'found().named({3: "BC1"})': "a name must be text, got 3",
    "found().save(3)": "the path of a file was expected, got 3",
    "load_diagram(3)": "the path of a file was expected, got 3",
    "write_graph(found().graph(), 3)": "the path of a file was expected, got 3",
    'meeting_curve(SKEW, 3, "R")': "a word must be text, got 3",
    "with_attractors(found(), found())": "found must be pwmap.longrun.AttractorDiagram, got Diagra",
    "with_attractors(3, bands())": "diagram must be pwmap.Diagram, got 3",
    "plot_map(T2, 3)": "ax must be axes of matplotlib, got 3",
    "plot_map(T2, window=3)": "window must be two numbers, got 3",
    'plot_map(T2, window=("a","b"))': "window must be a number, got 'a'",
    'plot_map(T2, window=(b"1", 2))': "window must be a number, got b'1'",
    "plot_map(T2, styles=3)": "styles must be a mapping such as {'stable': {'color': 'k'}}, got 3",
    "plot_diagram(3)": "diagram must be pwmap.Diagram, got 3",
    'plot_diagram(found(), kinds="BC")': "kinds must be several kinds such as (PointKind.BC,), g",
    "plot_diagram(found(), kinds=3)": "kinds must be several kinds such as (PointKind.BC,), got",
    "plot_kneading(3)": "seen must be pwmap.longrun.Dynamics, got 3",
    "plot_plane(3)": "plane must be pwmap.plane.ParameterPlane, got 3",
    'plot_plane(plane(), colours="period")': "colours must be pwmap.plane.Colours, got 'period'",
    "plot_plane(plane(), raster=3)": "raster must be pwmap.plane.PlaneRaster, got 3",
    'dynamics(TENT, {"a": float("nan")})': "nan is not a rational number",
    'found().named({"A": (0,0)}, within="x")': "within must be a number, got 'x'",
    "RealRoot(3,0,0,1)": "a polynomial must be a tuple of numbers, got 3",
    "found().point([])": "an id or a name must be text, got []",
    'found().path("F1", [])': "an id or a name must be text, got []",
    "found().branch([])": "an id must be text, got []",
    'Diagram(parameter_name="p", x_name="x", branches="F1", points=())': "a part of a diagram must",
    'Diagram(parameter_name="p", x_name="x", branches=(), points=[None])': "a part of a diagram mu",
    "SpecialPoint(id=True, kind=PointKind.BC, parameter=0.0, x=0.0)": "a point id must be text, go",
    'SpecialPoint(id="A", kind="BC", parameter=0.0, x=0.0, precision="0")': "a precision must be a",
    'SpecialPoint(id="A", kind="BC", parameter=0.0, x=0.0, interval=0)': "an interval must be two",
    "PiecewiseLinearMap(PIECES, letters=[1,2])": "expected 2 different letters, one for each p",
    "plot_diagram(found(), branches=3)": "branches must be a mapping such as {'F1': 'stable'},",
    'plot_diagram(found(), styles={"stable": 3})': "the style of 'stable' must be a mapping su",
    'plot_entropy(TENT, "a", (1, 2), intervals=3)': "intervals must be pwmap.longrun.EntropyIn",
    'plane_raster("x")': "plane must be pwmap.plane.ParameterPlane, got 'x'",
}
WRONG_VALUE = {
    "cycles(TENT)": "every parameter needs a value, got none for a",
    "dynamics(TENT)": "every parameter needs a value, got none for a",
    'dynamics(TENT, {"a": "(1 + sqrt(5))/2"})': "cannot read '(1 + sqrt(5))/2' as an",
    'constant_entropy(TENT, "a", (1, 2), tolerance=0)': "a tolerance must be positive, got 0",
    'bifurcation_diagram(LINES, "p", (-1, 2), "12")': "the order of an iterate must be an inte",
    'bifurcation_diagram(LINES, "p", sample={"q": 1})': "a sample is for parameters without a va",
    'parameter_plane(SKEW, "a", "a", (0, 1), (0, 1))': "expected two different parameters, got",
    'parameter_plane(SKEW, "a", "c", (0, 1), (0, 1))': "expected a map of a and c, this one ha",
    'plane().regions("2")': "period must be one of the orders 1, 2, got '2'",
    "plane().regions(7)": "period must be one of the orders 1, 2, got 7",
    'rotational_word(HALF, "L")': "the pieces need two different letters, got 'L'",
    'rotational_word(HALF, letters="LL")': "the pieces need two different letters, g",
    'rotation_number("")': "a word must consist of the letters L and R, got ''",
    'rotation_number("LRM")': "a word must consist of the letters L and R, got 'LRM'",
    'organising_centre(JUMP, "r", "r")': "expected two different parameters, got r twice",
    'word_family(P1, "L R")': "a pattern must have an exponent n, got 'L R'",
    "word_family(P1, 3)": "a pattern must be text such as 'R L^n', got 3",
    'word_family(P1, "")': "a pattern must have an exponent n, got ''",
    'word_family(P1, "L R^n", n=3)': "the exponent needs a name that is not taken by the map,",
    'PiecewiseLinearMap([("x",)])': "each piece must be a pair (formula, condition), got ('x',",
    'PiecewiseLinearMap([b"xx"])': "each piece must be a pair (formula, condition), got b'xx'",
    'PiecewiseLinearMap(PIECES, letters="A")': "expected 2 different letters, one for each pie",
    'PiecewiseLinearMap(PIECES, letters="AA")': "expected 2 different letters, one for each pi",
    "PiecewiseLinearMap(PIECES, x=3)": "the variable must be a symbol such as x, got 3",
    'from_sympy("x +")': "cannot read 'x +' as an expression: it ends too early",
    'from_sympy("x/2", 5)': "the variable must be a symbol such as x, got 5",
    'from_sympy("x/2", "n" * 101)': "a name has at most 100 characters, got 'nnnnnn",
    'from_sympy("import os")': "cannot read 'import os' as an expression: unexpected 'os'",
    'dynamics(TENT, {"a": "-0,5"})': "unexpected ',' after '0': a decimal has a point, as in 0.5",
    "TENT.at({TENT: 1})": "> is no parameter of this map, it has ['a']",
    "attractor_diagram(TENT, found(), (1, 2), 1)": "expected a map of Diagram(x over p",
    'T2("y")': "a point y holds the unknown symbol y",
    'T2.limit(0, "left")': "the side must be '-' or '+', got 'left'",
    'T2.cycle("")': "the word of a cycle must have at least one letter",
    'found().at(float("nan"))': "a slice needs a finite value of the parameter, got nan",
    "found().within(0, float('nan'))": "a slice needs a finite value of the parameter, got nan",
    "long().attractors[0].density.measure(0, sympy.pi)": "expected a real algebraic number, got p",
    'found().named({"A": (0, 10**400)})': "fit into a double, got about 1e+400",
    "found().within(1, 0)": "expected an interval from low to high, got (1, 0)",
    "prove(3)": "a map, or a diagram and its map, was expected, got 3",
    "prove(TENT)": "this cannot be certified: give values (.at) to the parameters a",
    "prove(found())": "a map, or a diagram and its map, was expected, got Diagram(x over p: 3 br",
    "prove(found().within(-9, -5), LINES)": "this cannot be certified: the diagram has no branch",
    "prove(found(), 3)": "a map, or a diagram and its map, was expected, got Diagram(x over p: 3",
    "prove(T2, orders=(1,))": "of a map, only an order can be given: prove(map, order=2)",
    "prove(found(), LINES, order=2)": "of a diagram, only orders can be given: prove(diagram, ma",
    "prove(T2, TENT)": "of a map, only an order can be given: prove(map, order=2)",
    'Budget(seconds="3")': "seconds of a budget must be a positive number, got '3'",
    'meeting_curve(SKEW, "LRL", "")': "a word must have at least one letter",
    'meeting_curve(SKEW, "L", "R", 1)': "number must name one of 1 break, from 0 on, got 1",
    'meeting_curve(SKEW, "L", "R", "0")': "number must name one of 1 break, from 0 on, got '0",
    "plot_map(T2, window=(1,0))": "a window must ascend between finite ends, got (1.0, 0.0)",
    'plot_map(T2, window=(0, float("inf")))': "between finite ends, got (0.0, inf)",
    'plot_cobweb(from_sympy("2*x"), 1, 1100)': "got (-inf, inf): give one (window=...) where",
    'plot_map(T2, styles={"x": {}})': "a style must be of one of diagonal, pieces, ends, unsta",
    'plot_density(dynamics(TENT, {"a": "1/2"}))': "expected a map with a chaotic attractor, th",
    'dynamics(TENT, {"a": 1+2j})': "expected text, a number or a sympy expression, got (1+2j)",
    'dynamics(TENT, {"a": sympy.pi})': "expected a real algebraic number, got pi",
    'dynamics(SKEW, {"a": sympy.sqrt(2), "b": sympy.sqrt(3)})': "one parameter may have an alg",
    'dynamics(TENT.iterate(2), {"a": sympy.sqrt(2)})': "an algebraic value needs the map",
    'SpecialPoint(id="a:b", kind=PointKind.BC, parameter=0.0, x=0.0)': "a point id must be tex",
    'SpecialPoint(id="A", kind="XX", parameter=0.0, x=0.0)': "'XX' is not a valid PointKind",
    'found().at("1/0")': "cannot work out 0: it divides by zero",
    "RealRoot((1,2),0,0,1)": "expected an irreducible polynomial of degree two or more, got t",
    'bifurcation_diagram(LINES, "p", (0, float("inf")))': "a span needs two rational ends, or",
    'bifurcation_diagram(LINES, "p", (None, 1))': "a span needs two rational ends, or none at",
    'bifurcation_diagram(LINES, "p", np.array([-1.0, 2.0]))': "a span must be an interval (low",
    "prove(found(), LINES, orders=3)": "the diagram must have the orders [1, 3], it has [1]",
    "found().within(10**5000, 0)": "expected an interval from low to high, got (about 1e+5000, 0)",
    'bifurcation_diagram(LINES, "p", (1, -(7**6000)))': "(low, high), got (1, about -1e+5070)",
    'P1.at({"a": -(10**5000)})': "a = about -1e+5000 contradicts the assumption a > 1",
    "Budget(work=-(10**5000))": "work of a budget must be a positive integer, got about -1e+5000",
    'prove(LINES.at({"p": Fraction(1, 10**5000)}))': "about 1e-5000 has more digits than can be ch",
    'PiecewiseLinearMap(PIECES, "y")': "the condition x > 0 does not contain the variable y: it",
    'PiecewiseLinearMap([("x/2", "x > 0"), 3])': "each piece must be a pair (formula, conditio",
    'PiecewiseLinearMap([("x/2", 3), ("x", "x <= 0")])': "expected a condition such as x < 0,",
    'PiecewiseLinearMap(PIECES, given=["x > 1"])': "x > 1 holds x, the variable of the map",
    'PiecewiseLinearMap(PIECES, given=["Eq(a, 1)"])': "such as a > 1, got Eq(a, 1)",
    'PiecewiseLinearMap(PIECES, given=["a + 1"])': "inequality such as a > 1, got a + 1",
    'PiecewiseLinearMap(PIECES, x=2 * sympy.Symbol("x"))': "a symbol such as x, got 2*x",
    'PiecewiseLinearMap(PIECES, letters=["L", "RR"])': "expected 2 different letters, one for each",
    'P1.iterate(2).cycle("LRL")': "multiple of 2: 'LRL'",
    'from_sympy("Max(x + 1, x/2)").cycle("R")': "the slope of R is 1: it has no isolated cycle",
    'T2.word_of("b")': "a point b holds the unknown symbol b",
    'T2.limit(sympy.sqrt(2), "+")': "over the rationals, got sqrt(2)",
    'T2 @ from_sympy("y + 1", "y")': "the maps have different variables, ",
    'parameter_cells(P1, "r", sample={"b": 2})': "a sample must give values to ['a'], got ['b']",
    'parameter_plane(PAPER, "a", "r", (1, 4), (0, 1))': "b must be set to a value",
    'constant_entropy(TENT.iterate(2), "a", (1, 2))': "the map itself, got an iterate of order 2",
    'attractor_diagram(TENT.iterate(2), "a", (1, 2))': "the map itself, got an iterate of order 2",
    "rotational_word(Fraction(3, 2))": "a rotation number must lie in [0, 1], got 3/2",
    'tongues(GAP.at({"s": -1}), 2)': "two pieces that increase, got the slope -1 for L",
    'tongues(from_sympy("x/2"), 2)': "of its pieces and breaks are 1 and 0",
    "tongues(cell(), 2)": "a map for all values assumed, got one of the cell",
    "tongues(GAP.iterate(2), 2)": "no iterate, got one of order 2",
    'word_family(P1, "(LR^n")': "a parenthesis is not closed",
    'word_family(P1, "LR^n)")': "a parenthesis is closed that was not opened",
    'word_family(P1, "()^n")': "a parenthesis is empty",
    'word_family(P1, "L^k")': "an exponent must be an integer, n or such as (n+1)",
    'word_family(P1, "R L^(n+99999999999)")': "+99999999999 is beyond 64: n itself may be large",
    'word_family(P1, "L^0 R^n")': "an exponent must lie in 1 to 64, 0 does not",
    'word_family(P1, "(LR^n)^n")': "a power of n stands in a power of n",
    'word_family(P1, "L^40 R^40 L^n")': "it has more than 64 letters",
    'word_family(P1, "L R^n", "r")': "a name that is not taken by the map, got 'r'",
    'word_family(P1.iterate(2), "L^n")': "no iterate, got one of order 2",
    'word_family(P1, "L R^(n-2)").at(2)': "n must be at least 3, got 2",
    'word_family(P1, "L R^n").thresholds("a")': "a does not occur linearly",
    "found().at(sympy.I)": "a slice needs a real number, got I",
    "found().at(sympy.pi)": "a slice needs a rational or algebraic number, got pi",
    "with_attractors(found(), bands())": "expected attractors over p, got them over a",
    "plot_long_run(found(), bands(), TENT)": "expected attractors over p, got them over a",
    "Budget(seconds=0)": "seconds of a budget must be a positive number, got 0",
}
UNDECIDED = {'P1.cycle("LR").admissible': "the sign of"}
CASES = [
    *((call, kind, sentence) for (kind, sentence), calls in CALLS.items() for call in calls),
    *((call, TypeError, sentence) for call, sentence in (MISFITS | WRONG_KIND).items()),
    *((call, ValueError, sentence) for call, sentence in WRONG_VALUE.items()),
    *((call, pwmap.UndecidedError, sentence) for call, sentence in UNDECIDED.items()),
]


@pytest.mark.parametrize(("call", "kind", "sentence"), CASES, ids=[call for call, *_ in CASES])
def test_a_wrong_call_is_answered_in_a_sentence(call: str, kind: type, sentence: str) -> None:
    _, *marked = call.split("`")
    value = marked[0].replace('"', "'") if marked else ""
    with pytest.raises(kind) as error:
        eval(call.replace("`", ""), dict(NAMES))
    assert type(error.value) is kind
    assert sentence.replace("{}", value) in str(error.value)
    assert "\n" not in str(error.value)


def test_values_are_exact_however_many_digits_they_have() -> None:
    """Python writes no integers of more than 4300 digits, so that no sentence may be made early."""
    assert LINES.at({"p": 10**5000}).fixed_points()[0].x == sympy.Rational(3 * (10**5000 - 1), 2)


@pytest.mark.parametrize("verb", VERBS.split())
def test_a_verb_says_what_it_takes(verb: str) -> None:
    with pytest.raises(TypeError) as error:
        eval(f"{verb}(no_such=3)", dict(NAMES))
    name = getattr(eval(verb, dict(NAMES)), "__qualname__", verb)
    assert str(error.value).startswith(f"{name} takes ")
    assert ", got no_such=3" in str(error.value)
