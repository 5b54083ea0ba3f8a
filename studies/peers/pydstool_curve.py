"""A curve of zeros by PyCont of PyDSTool, which requests the map value by value.

    python3.9 studies/peers/pydstool_curve.py '{"x": -0.53, "p": 0.5, ...}'

PyDSTool needs older versions of numpy and scipy than the project, so this is a separate program
that imports nothing of the project; :mod:`studies.peers.pydstool_peer` starts it. For each image it
writes a line ``x p`` to its output and reads the image; its last line is the curve, as JSON. The
argument holds the start ``x`` and ``p``, the largest ``step``, the number of ``points`` and whether
to go ``forward``.
"""

from __future__ import annotations

import json
import os
import sys
from typing import Any

answers = os.fdopen(os.dup(1), "w")
os.dup2(2, 1)  # PyDSTool talks, too

import numpy as np  # noqa: E402  what follows may print
import PyDSTool  # noqa: E402

SMALLEST = 1e-6  # step, over which PyCont gives up


def ask(x: float, p: float) -> float:
    """The image of x under the map at p."""
    print(repr(x), repr(p), file=answers, flush=True)
    return float(sys.stdin.readline())


def follow(wanted: dict[str, float], forward: bool) -> dict[str, Any]:
    """The points of a curve P(x, p) - x = 0, and the sentence with which it ends."""
    asked = 0

    def distance(curve: Any, variables: dict[str, float], values: dict[str, float]) -> Any:
        nonlocal asked
        asked += 1
        x = float(variables["x"])
        return np.array([ask(x, float(values["p"])) - x])

    # a curve must belong to a model, even if it asks nothing of it
    model = PyDSTool.args(name="none", varspecs={"x": "p*x"}, pars={"p": 1.0}, ics={"x": 0.0})
    curves = PyDSTool.ContClass(PyDSTool.Generator.Vode_ODEsystem(model))
    options = PyDSTool.args(name="zeros", type="UD-C")
    options.uservars, options.userpars, options.userfunc = ["x"], {"p": wanted["p"]}, distance
    options.initpoint, options.freepars = {"x": wanted["x"]}, ["p"]
    options.StepSize, options.MaxStepSize = wanted["step"] / 2.0, wanted["step"]
    options.MinStepSize, options.MaxNumPoints = SMALLEST, int(wanted["points"])
    options.LocBifPoints = ["LP", "BP"]  # all that it knows of such a curve
    curves.newCurve(options)
    curve, said = curves["zeros"], ""
    try:
        (curve.forward if forward else curve.backward)()
    except PyDSTool.PyDSTool_ExistError as error:
        said = error.value
    except KeyError:  # of its own list of names, after all points are found
        said = "all points that were asked for"
    found = curve.curve[: curve.loc + 1].tolist()
    return {"points": [[p, x] for x, p in found], "said": said, "asked": asked}


if __name__ == "__main__":
    task = json.loads(sys.argv[1])
    result = follow(task, task.pop("forward"))
    print(json.dumps(result), file=answers, flush=True)
