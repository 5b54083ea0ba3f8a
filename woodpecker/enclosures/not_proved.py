"""``NotProved``, the outcome of a proof that fails."""


class NotProved(Exception):  # noqa: N818  (no error: an answer)
    """Ball arithmetic could not decide a question over a box; the text says which.

    Examples
    --------
    >>> from pwmap import SpecialPoint
    >>> from woodpecker import prove
    >>> prove(SpecialPoint(id="A", kind="FF", parameter=0.3, x=-0.8))
    Traceback (most recent call last):
        ...
    woodpecker.enclosures.not_proved.NotProved: no two gaps close at once here
    """
