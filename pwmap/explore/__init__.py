"""The explorer of piecewise-linear maps, and the page, server and jobs of both explorers.

It is not loaded by ``import pwmap``; the extra ``explore`` brings Bokeh.
"""
