"""Explorers of the toy and of any system in a browser: state -> model, branches -> views -> page.

``import woodpecker`` does not load them; they need Bokeh, from the extra ``explore``.
"""
