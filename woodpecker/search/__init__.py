"""Branches found from slices and from one another; the network; the finished diagram."""
