"""
The paper, figure by figure
===========================

We follow the argument of Leine, Glocker and van Campen (2001) from the motion (Figures 4 to 7)
to the return map (Figure 8), the diagram (Figures 9 and 10), and the map with one jump that
explains the diagram (Figures 11 and 12). The scripts that redraw the figures as printed, with every
branch and every number beside ours, are under :doc:`/reproduce`.
"""

# %%
# Rest, and the motion that hammers
# ---------------------------------
# Left alone, the sleeve jams and the bird hangs still. Friction has to be large enough for that:
# the paper states mu_2 >= 0.285. Pushed hard enough, the toy hammers for ever.

from woodpecker import Toy, equilibrium, jam_limit, shoot, simulate
from woodpecker.mechanics import free_frequency

toy = Toy()
rest = equilibrium(toy)
print(f"phi_M {rest.phi_m:.6f}, phi_S {rest.phi_s:.6f} rad, mu_2 at least {jam_limit(toy):.7f}")
print(f"without contact it swings with {free_frequency(toy):.4f} Hz")
orbit = shoot(toy, -0.53)
print(f"period {orbit.period:.6f} s, lowest at phi_S = {orbit.phi_s:.6f} rad")
print(orbit.word)

# %%
# The word is the sequence of events in Figure 7: the lower edge slips and detaches, the upper edge
# strikes, the beak strikes, the upper edge strikes again and detaches, the lower edge strikes,
# once more, and jams. Figures 4 and 5 are two periods of it:

from woodpecker.plot.motions import plot_phase_portraits, plot_time_history

motion = simulate(toy, orbit.phi_s, t_end=2.0 * orbit.period)
drawn = plot_time_history(motion)

# %%
drawn = plot_phase_portraits(motion)

# %%
# The return map
# --------------
# Figure 8. The map jumps where the upper edge and the beak strike at once and exchange their
# order: at -0.7578 and at -2.3493. The paper computed a thousand points in an hour.

import matplotlib.pyplot as plt
import numpy as np

from woodpecker import return_map
from woodpecker.plot.figures import plot_return_map

figure, ax = plt.subplots(figsize=(6.4, 5.6), layout="constrained")
drawn = plot_return_map(toy, return_map(toy, np.linspace(-2.5, -0.24, 1000)), ax)

# %%
# The diagram
# -----------
# Figures 9 and 10, as far as it is connected with the motion above. With friction in the
# expansion of an impact bounded by the sum of both normal impulses, it folds at the paper's points
# A, B and C. The paper does not say which law it takes; this one is inferred.

from pwmap.plot import plot_diagram
from woodpecker import continuation

paper = {"A": (0.111, -0.884), "B": (0.29, -0.884), "C": (0.185, -0.757)}  # read off its Figure 10
diagram = continuation(toy, orbit, "eps_n1", span=(0.05, 0.7)).named(paper)
for point in diagram.points:
    if point.order == 1 and str(point.kind) != "EP":
        name = point.name or point.id
        print(f"{name:4} {point.kind.label:26} {point.parameter:.8f}  {point.note}")
figure, ax = plt.subplots(figsize=(7.0, 4.6), layout="constrained")
drawn = plot_diagram(diagram, ax)

# %%
# Read it from the right: the stable motion begins at a flip (``PD1``); at C it meets a jump of the
# map, as does a jump crossing, and both end there, as in a fold. The crossing turns into an
# unstable motion (``FF1``), which leads to A, and from A another crossing leads to B, where the
# second stable motion begins.
#
# Why A is a fold-flip
# --------------------
# Figure 11 shows the map between A and C: two jumps, an unstable fixed point between them, and a
# stable one far below.

near = toy.replace(eps_n1=0.125)
figure, ax = plt.subplots(figsize=(6.4, 5.2), layout="constrained")
drawn = plot_return_map(near, return_map(near, np.linspace(-1.15, -0.68, 600)), ax)

# %%
# Figure 12 replaces the map by straight lines, P1^L. ``local_model`` does that for any collision,
# with the toy's own limits, slopes and speeds, and ``pwmap`` finds its diagram in exact arithmetic.
# Three branches start at A, all on the same side: a fixed point and a jump crossing of P_1, as in
# a fold, and a jump crossing of P_2, as in a flip.

from woodpecker import ToyPieces, local_model
from woodpecker.plot.figures import plot_local

at_a = diagram.point("A")
model = local_model(ToyPieces(toy), at_a.x, at_a.parameter, orders=(1, 2))
print(f"slopes {model.left.slope:.6f} and {model.right.slope:.6f}: {model.point.kind.label}")
for start in model.starts:
    print(f"P_{start.order} {start.kind} {start.word}, along {start.slope:.4f} rad")
unstable = shoot(near, -0.853)
both = continuation(near, unstable, "eps_n1", span=(0.10, 0.13), orders=(1, 2))
drawn = plot_local(model, both)

# %%
# On the left, what was followed on the toy itself; on the right, what the straight lines predict.
# They agree: A is what the paper takes it for, though nothing smooth happens there.
