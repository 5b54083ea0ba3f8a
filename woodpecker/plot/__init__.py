"""Pictures with matplotlib, which is imported nowhere else in the package.

Functions that plot or draw return a :class:`pwmap.plot.Drawn`: the axes, the figure, and every
artist under its name in the legend. Their ``styles`` map these names to properties of matplotlib;
for an unknown name a ValueError lists the known ones.
"""
