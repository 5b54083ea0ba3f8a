"""
P1^L, by hand and by pwmap
==========================

The paper explains its point A by a map with one jump, Eq. (14): P1^L(x) = r - 2 for x <= 0, and r
- a x for x > 0, with a > 1. Everything about it can be worked out on paper, so it is a good first
map for ``pwmap``, which works in exact arithmetic with a and r as symbols.
"""

# %%
# Fixed points
# ------------
# *By hand.* On the left x = r - 2, which lies there for r <= 2; its slope is 0. On the right x =
# r - a x, so x = r/(1 + a), which lies there for r > 0; its slope -a is larger than one in size.

from sympy import symbols

from pwmap import PiecewiseLinearMap, parameter_cells

x, a, r = symbols("x a r")
p1 = PiecewiseLinearMap.from_sympy("Piecewise((r - 2, x <= 0), (r - a*x, True))", given=[a > 1])
between = PiecewiseLinearMap.from_sympy(
    "Piecewise((r - 2, x <= 0), (r - a*x, True))", given=[a > 1, r > 0, r < 2]
)
for point in between.fixed_points():
    print(point.word, point.x, "multiplier", point.multiplier, "stable:", point.stable)

# %%
# The second iterate
# ------------------
# *By hand.* All x <= 0 go to r - 2 < 0, and stay on the left: r - 2. An x > 0 goes to r - a x,
# which is positive if x < r/a; then the right piece counts again, r - a (r - a x) = a^2 x + (1 -
# a) r. Otherwise it goes to r - 2. That is Eq. (15) of the paper.

print(between.iterate(2))

# %%
# The jump at 0 has the limits r - 2 < 0 and (1 - a) r < 0: it no longer crosses the diagonal.
# The new jump at r/a does, from r to r - 2. In general P_j has just one jump crossing, at
# x* (1 - (-a)^(1 - j)) with x* = r/(1 + a):

for order in range(1, 6):
    (jump,) = between.iterate(order).jump_crossings()
    print(order, jump.x, (jump.x - r / (1 + a) * (1 - (-a) ** (1 - order))).simplify())

# %%
# Over r
# ------
# Nothing above depends on where r lies between 0 and 2. ``parameter_cells`` finds the values at
# which the answer changes, for any a > 1 at once:

cells = parameter_cells(p1, r, orders=(1, 2, 3))
print(cells.edges)

# %%
# At r = 0 a fixed point folds into a jump crossing, and a jump branch of the second iterate
# starts: the fold-flip, FF. It is the paper's Figure 12:

import matplotlib.pyplot as plt

from pwmap import bifurcation_diagram
from pwmap.plot import plot_diagram, plot_map

example = p1.at({a: "5/4"})
diagram = bifurcation_diagram(example, r, span=(-1, 4), orders=(1, 2))
for point in diagram.points:
    if str(point.kind) != "EP":
        print(point.kind, point.note, "at r =", point.exact["parameter"], diagram.sides(point.id))

fig, axes = plt.subplots(1, 3, figsize=(10.0, 3.6), layout="constrained")
plot_map(example.at({r: 1}), axes[0])
plot_map(example.at({r: 1}).iterate(2), axes[1])
drawn = plot_diagram(diagram, axes[2])
