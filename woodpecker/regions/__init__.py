"""Regions of two parameters in which the same cycles live."""
