"""Pictures with matplotlib, which nothing else of the package imports.

Functions that plot or draw give a :class:`pwmap.plot.Drawn`: the axes, the figure, and every artist
by its name in the legend. Their ``styles`` are properties of matplotlib by the same names; a
ValueError names those that there are.
"""
