"""The explorer of the toy, and of any system: state -> model and branches -> views -> page.

It is not loaded by ``import woodpecker``; the extra ``explore`` brings Bokeh.
"""
