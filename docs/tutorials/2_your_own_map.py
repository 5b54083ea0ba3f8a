"""
Your own map
============

The engine that follows the toy knows nothing of it. Any map of the line will do, as long as it
names its smooth pieces and what bounds them. Take two curves with a jump between them.
"""

# %%
# A formula
# ---------
# The parameter is ``p``. Each piece gets a word, which names its branches.

import matplotlib.pyplot as plt
from sympy import Piecewise, symbols

from pwmap.plot import plot_diagram
from woodpecker import Search, Settings, bifurcation_diagram, continuation, from_sympy, shoot

x, p = symbols("x p")
formula = Piecewise((p + x / 2 + x**2 / 8, x < 0), (p - 1 - x / 3 + x**2 / 5, True))
own = from_sympy(formula, x, p, words=["L", "R"])

# %%
# What is connected
# -----------------
# Shoot for a fixed point from a guess, and follow it over the span of the settings. It meets the
# jump, the jump crossing takes over, and leads to a fixed point of the other piece.

settings = Settings(span=(-1.5, 3.0), window=(-4.0, 4.0))
diagram = continuation(own, shoot(own, -1.0, p=-0.6), settings=settings)
for branch in diagram.branches:
    print(f"{branch.id:3} {branch.kind!s:12} {branch.word:6} {branch.ends}")
for point in diagram.points:
    print(f"{point.id:4} {point.parameter:+.12f} {point.x:+.12f}  {point.note} {point.cause}")

# %%
# Every branch
# ------------
# ``bifurcation_diagram`` looks at slices of the parameter and follows whatever no branch explains,
# here for the map and its second iterate.

found = bifurcation_diagram(own, orders=(1, 2), settings=settings, search=Search(slices=16))
fig, ax = plt.subplots(figsize=(7.0, 4.6), layout="constrained")
drawn = plot_diagram(found, ax)
print(len(found.branches), "branches,", len(found.points), "special points")

# %%
# Pieces in Python
# ----------------
# Where there is no formula for sympy, write the pieces as functions, with derivatives if you have
# them; ``check_derivatives`` compares these with differences of values. Each *margin* is positive
# inside its piece and zero at the border.

from woodpecker import FormulaMap, FormulaPiece, Smooth
from woodpecker.maps import check_derivatives

left = FormulaPiece("L", Smooth(lambda x, p: p + x / 2), {"x = 0": Smooth(lambda x, p: -x)})
right = FormulaPiece("R", Smooth(lambda x, p: p - 1 - x / 3), {"x = 0": Smooth(lambda x, p: x)})
lines = FormulaMap((left, right))
check_derivatives(lines, [(-1.0, 0.2), (1.0, 0.2)])
for point in continuation(lines, shoot(lines, -1.0, p=-0.5), settings=settings).points:
    print(point.kind, f"{point.parameter:.9f}", point.note)
