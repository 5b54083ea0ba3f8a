"""An independent checker of certificates, on the standard library and mpmath's intervals."""
