"""
Your own map
============

The engine that follows the toy knows no toy. Any map of the line will do that names its smooth
pieces and what bounds them. Take two curves with a jump between them.
"""

# %%
# A formula
# ---------
# The parameter is ``p``. Pieces get words, by which branches are named.

import matplotlib.pyplot as plt
from sympy import Piecewise, symbols

from pwmap.plot import plot_diagram
from woodpecker import Search, Settings, connected, from_sympy, whole_diagram

x, p = symbols("x p")
formula = Piecewise((p + x / 2 + x**2 / 8, x < 0), (p - 1 - x / 3 + x**2 / 5, True))
own = from_sympy(formula, x, p, words=["L", "R"])

# %%
# What hangs together
# -------------------
# Give a guess of a fixed point, a parameter, and how far to go. The fixed point meets the jump,
# the jump crossing takes over, and leads to a fixed point of the other piece.

settings = Settings(span=(-1.5, 3.0), window=(-4.0, 4.0))
diagram = connected(own, -1.0, -0.6, settings)
for branch in diagram.branches:
    print(f"{branch.id:3} {branch.kind!s:12} {branch.word:6} {branch.ends}")
for point in diagram.points:
    print(f"{point.id:4} {point.parameter:+.12f} {point.x:+.12f}  {point.note} {point.cause}")

# %%
# All there is
# ------------
# ``whole_diagram`` looks at slices of the parameter, and follows what no branch explains; here
# for the map and its second iterate.

found = whole_diagram(own, settings, (1, 2), Search(slices=16), workers=1)
fig, ax = plt.subplots(figsize=(7.0, 4.6), layout="constrained")
drawn = plot_diagram(found.diagram, ax)
print(len(found.diagram.branches), "branches,", len(found.diagram.points), "special points")

# %%
# Pieces in Python
# ----------------
# Where there is no formula for sympy, write pieces as functions, with derivatives if you have
# them. ``check_derivatives`` compares those with differences of values. Each *margin* is positive
# inside of its piece and zero at its border.

from woodpecker import FormulaMap, FormulaPiece, Smooth, check_derivatives

left = FormulaPiece("L", Smooth(lambda x, p: p + x / 2), {"x = 0": Smooth(lambda x, p: -x)})
right = FormulaPiece("R", Smooth(lambda x, p: p - 1 - x / 3), {"x = 0": Smooth(lambda x, p: x)})
lines = FormulaMap((left, right))
check_derivatives(lines, [(-1.0, 0.2), (1.0, 0.2)])
for point in connected(lines, -1.0, -0.5, settings).points:
    print(point.kind, f"{point.parameter:.9f}", point.note)
