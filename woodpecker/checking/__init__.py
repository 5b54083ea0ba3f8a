"""An independent checker of certificates: the standard library and mpmath's intervals, no more."""
