"""The outcome of a proof that fails."""


class NotProved(Exception):  # noqa: N818  (no error: an answer)
    """Ball arithmetic could not decide something over a box; the text says what.

    Examples
    --------
    >>> from pwmap import SpecialPoint
    >>> from woodpecker import prove
    >>> prove(SpecialPoint(id="A", kind="FF", parameter=0.3, x=-0.8))
    Traceback (most recent call last):
        ...
    woodpecker.enclosures.not_proved.NotProved: no two gaps close at once here
    """
