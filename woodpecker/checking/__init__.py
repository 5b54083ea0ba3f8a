"""An independent checker of certificates: the standard library and mpmath's intervals, no more.

It shares no code with what finds the proofs (:mod:`woodpecker.proofs`), nor with the kernel.
"""
