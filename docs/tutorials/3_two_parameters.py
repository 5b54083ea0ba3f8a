"""
Two parameters
==============

A bifurcation over one parameter is a point; over two it is a curve. For piecewise-linear maps
``pwmap`` finds the polynomials of these curves; for any other map they are followed in doubles.
"""

# %%
# An exact plane
# --------------
# The parameters are both slopes of a skew tent map. In every cell of the rectangle there is one
# answer; the curves between cells have polynomials, and the points in which they meet are exact.

import matplotlib.pyplot as plt

from pwmap import PiecewiseLinearMap, parameter_plane
from pwmap.plot import plot_plane

tent = PiecewiseLinearMap.from_sympy("Piecewise((a*x + 1, x <= 0), (b*x + 1, True))")
plane = parameter_plane(tent, "a", "b", ("1/4", "3/4"), (-5, "-1/2"), orders=(1, 2, 3))
for curve in plane.curves:
    print(f"{curve.id}: {curve.polynomial} = 0,  {' '.join(curve.words)}")
for point in plane.points:
    print(point.kind.label, point.values, point.curves)
fig, ax = plt.subplots(figsize=(6.4, 4.8), layout="constrained")
drawn = plot_plane(plane, ax)

# %%
# The toy over two of its parameters
# ----------------------------------
# As ``continuation`` follows a motion over one parameter, ``curve_in_two`` follows a special point
# over two. Point C of the paper, over the restitution coefficient of the beak and the friction at
# the lower edge:

from woodpecker import Toy, continuation, curve_in_two, shoot
from woodpecker.plot.plane import plot_curves

toy = Toy()
diagram = continuation(toy, shoot(toy, -0.53), span=(0.15, 0.5))
c = next(point for point in diagram.points if abs(point.parameter - 0.185127) < 1e-6)
curve = curve_in_two(toy, c, ("eps_n1", "mu_2"), span=((0, 1), (0.295, 0.35)))
for point in curve.points:
    print(f"{point.kind!s:3}", *(f"{value:.9f}" for value in point.values), point.cause)
fig, ax = plt.subplots(figsize=(6.4, 4.4), layout="constrained")
drawn = plot_curves({"C": curve}, ax)
ax.locator_params(axis="x", nbins=6)

# %%
# On its way the jump closes (JC), and the multiplier right at the border passes -1 (PDB): points
# of codimension two. Where curves of another kind begin, ``point.starts`` names them, and the
# same function follows them from there.
