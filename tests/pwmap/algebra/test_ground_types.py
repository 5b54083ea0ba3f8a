"""What was found with one kind of sympy's rationals (its ground types) is read with the other.

That all answers are the same is seen by the whole folder, which runs once more at night with
sympy's own.
"""

import os
import pickle
import subprocess
import sys

import pytest

from pwmap import PiecewiseLinearMap, parameter_cells


def output(ground_types: str, code: str) -> str:
    environment = {**os.environ, "SYMPY_GROUND_TYPES": ground_types}
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True
    )
    return done.stdout.strip()


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
        "from sympy import QQ\n"
        f"cells = pickle.loads(bytes.fromhex('{pickle.dumps(cells).hex()}'))\n"
        "print(type(QQ.one).__module__)\n"
        "print([[str(p) for p in cell.map.iterate(3).pieces] for cell in cells])"
    )
    expected = [[str(p) for p in cell.map.iterate(3).pieces] for cell in cells]
    rationals = {"python": "sympy.external.pythonmpq", "flint": "flint.types.fmpq"}[ground_types]
    assert output(ground_types, code) == f"{rationals}\n{expected}"
