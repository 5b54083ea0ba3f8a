"""An independent checker of certificates, on the standard library and mpmath's intervals.

Files and seals are read by :mod:`pwmap.checking`, which needs the standard library only.
"""
