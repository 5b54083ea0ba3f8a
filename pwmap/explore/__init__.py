"""The explorer of piecewise-linear maps, and the page, server and jobs of both explorers.

Nothing here is loaded by ``import pwmap``; the extra ``explore`` brings Bokeh.
"""
