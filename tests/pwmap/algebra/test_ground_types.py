"""Whatever sympy takes for its rationals (its ground types), the answers are the same."""

import os
import pickle
import subprocess
import sys

import pytest

from pwmap import PiecewiseLinearMap, parameter_cells

DIAGRAMS = """
import json, pickle, sys
from sympy import QQ
from pwmap import PiecewiseLinearMap, bifurcation_diagram, parameter_cells
from pwmap.diagrams.graph import sanitised
import networkx as nx

paper = PiecewiseLinearMap([("r - 2", "x <= 0"), ("r - a*x", "x > 0")], given=["a > 1"])
tent = PiecewiseLinearMap([("m*x", "x <= 1/2"), ("m - m*x", "x > 1/2")])
three = PiecewiseLinearMap(
    [("r - x/2", "x < -1"), ("4*x/3 + r", "(x >= -1) & (x <= 1)"), ("1 - x", "x > 1")]
)
tiny = "1/10**18"
steep = PiecewiseLinearMap(
    [("r - 2", "x <= 0"), ("r", f"(x > 0) & (x <= {tiny})"), ("r - 10**6*x", f"x > {tiny}")]
)
for map_, name, orders in (
    (paper, "r", (1, 2, 3)), (paper.at({"r": 1}), "a", (1, 2, 3, 4)), (tent, "m", (1, 2, 3, 4)),
    (three, "r", (1, 2, 3)), (steep, "r", (1, 2, 3)),
):
    diagram = bifurcation_diagram(map_, name, orders=orders)
    print(json.dumps(nx.node_link_data(sanitised(diagram.graph()), edges="edges")))
    for branch in diagram.branches:
        print(branch.parameter.tolist(), branch.x.tolist(), branch.multiplier.tolist())
try:
    paper.at({"a": "1/2"})
except ValueError as error:
    print(error)
cells = parameter_cells(tent, "m", (1, 2, 3), (1, 2))
print(pickle.dumps(cells).hex())
print(type(QQ.one).__module__, file=sys.stderr)
"""


def output(ground_types: str, code: str = DIAGRAMS) -> tuple[str, str]:
    environment = {**os.environ, "SYMPY_GROUND_TYPES": ground_types}
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True
    )
    return done.stdout, done.stderr.strip()


@pytest.mark.nightly
def test_diagrams_and_pickles_are_the_same_with_and_without_flint() -> None:
    pytest.importorskip("flint")
    (plain, module), (fast, other) = output("python"), output("flint")
    assert (module, other) == ("sympy.external.pythonmpq", "flint.types.fmpq")
    assert len(plain) > 100_000
    assert fast == plain


@pytest.mark.nightly
@pytest.mark.parametrize("ground_types", ["python", "flint"])
def test_a_pickle_is_read_with_other_ground_types(ground_types: str) -> None:
    """At an edge that is no rational, with what was decided there."""
    if ground_types == "flint":
        pytest.importorskip("flint")
    tent = PiecewiseLinearMap([("m*x", "x <= 1/2"), ("m - m*x", "x > 1/2")])
    cells = parameter_cells(tent, "m", (1, 2, 3), ("1", "2"))
    code = (
        "import pickle, sys\n"
        f"cells = pickle.loads(bytes.fromhex('{pickle.dumps(cells).hex()}'))\n"
        "print([[str(p) for p in cell.map.iterate(3).pieces] for cell in cells])"
    )
    expected = [[str(p) for p in cell.map.iterate(3).pieces] for cell in cells]
    assert output(ground_types, code)[0].strip() == str(expected)
