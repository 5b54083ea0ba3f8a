"""The answer of a proof that could not be made."""


class Undecided(Exception):  # noqa: N818  (no error: an answer)
    """What ball arithmetic could not decide over a box; the text says what."""
