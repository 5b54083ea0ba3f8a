"""The explorer: one page in the browser that shows the toy, its map and its branches.

State (:mod:`~woodpecker.explore.state`) -> data (:mod:`~woodpecker.explore.model`,
:mod:`~woodpecker.explore.branches`) -> views -> page. Nothing here is loaded by
``import woodpecker``; the extra ``explore`` brings Bokeh.
"""
