"""Equations of a system of contacts, and the laws of its impacts and its modes."""
