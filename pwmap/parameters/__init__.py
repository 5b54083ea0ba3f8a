"""Cells of parameters, branches over them, and where these meet."""
