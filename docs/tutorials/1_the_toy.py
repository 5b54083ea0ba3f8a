"""
The toy, from one motion to its diagram
=======================================

The Woodpecker Toy is a sleeve on a pole, a spring, and a bird. We follow one motion, reduce
motions to a map of the line, find a periodic one and follow it over a parameter. Start with the
data of the paper; every parameter has a name, its unit is SI.
"""

# %%
# One motion
# ----------
# A motion starts at rest with the sleeve jammed and the bird at an angle phi_S. Between events it
# is known in closed form, and events are roots of known functions: there is no step size.

from woodpecker import Toy, simulate
from woodpecker.plot.motions import plot_time_history

toy = Toy()
motion = simulate(toy, -0.53, t_end=0.3)
for event in motion.events[:8]:
    print(f"{1e3 * event.time:9.5f} ms   {event.symbol}")
drawn = plot_time_history(motion)

# %%
# The symbols say what happened at which contact, 1 the beak, 2 the lower edge of the sleeve, 3
# its upper edge: ``S2`` it begins to slip, ``D2`` it detaches, ``I3`` an impact, ``J2`` the
# sleeve jams. Their sequence is the *word* of a motion.
#
# The return map
# --------------
# When the bird is at its lowest again while the sleeve jams, the toy is back on the section: one
# number, phi_S, says it all. The map from one return to the next has exact derivatives.

from woodpecker import first_return

back = first_return(toy, -0.53)
print(f"P({-0.53}) = {back.phi_s:.12f}, slope {back.slope:.6f}, after {1e3 * back.period:.4f} ms")
print(back.word)

# %%
# It jumps where two impacts change their order. More precise integration does not help there:
# both limits are right. Starts are added wherever neighbouring values lie far apart.

import matplotlib.pyplot as plt
import numpy as np

from woodpecker import return_map
from woodpecker.plot.figures import plot_return_map

fig, ax = plt.subplots(figsize=(6.4, 5.2), layout="constrained")
drawn = plot_return_map(toy, return_map(toy, np.linspace(-1.1, -0.24, 300)), ax)

# %%
# A periodic motion
# -----------------
# Its multiplier, the slope of the map there, is smaller than one in size: it attracts.

from woodpecker import shoot

orbit = shoot(toy, -0.53)
print(f"phi_S {orbit.phi_s:.10f} rad, period {orbit.period:.10f} s")
print(f"multiplier {orbit.multiplier:.6f}")

# %%
# Over a parameter
# ----------------
# ``continuation`` follows it over the restitution coefficient of the beak, with everything that is
# connected with it: stable and unstable motions, and *jump crossings*, along which a jump of the
# map lies across the diagonal.

from pwmap.plot import plot_diagram
from woodpecker import continuation

paper = {"A": (0.111, -0.884), "B": (0.29, -0.884), "C": (0.185, -0.757)}  # read off its Figure 10
diagram = continuation(toy, orbit, "eps_n1", span=(0.10, 0.70)).named(paper)
for point in diagram.points:
    name, why = point.name or point.id, point.cause or point.note
    print(f"{name:4} {point.kind!s:3} {point.parameter:.10f} {point.x:+.8f}  {why}")
fig, ax = plt.subplots(figsize=(7.0, 4.6), layout="constrained")
drawn = plot_diagram(diagram, ax)

# %%
# Read it from the right: the stable motion ends in a jump, at the paper's point C. It turns back as
# a jump crossing, turns again into an unstable motion, which leads to A. There it turns into the
# crossing that leads to B, where a second stable motion begins.
# The branches also make a graph:

graph = diagram.graph()
print(graph.number_of_nodes(), "special points,", graph.number_of_edges(), "branches")
