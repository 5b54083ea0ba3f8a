"""What special points of two parameters are called."""

from __future__ import annotations

from enum import StrEnum


class PlaneKind(StrEnum):
    """A special point of codimension two, or why a curve ends; the value is its code.

    Examples
    --------
    >>> from pwmap.plane import PlaneKind
    >>> print(PlaneKind.FLIP_BORDER, PlaneKind.FLIP_BORDER.label)
    PDB flip-border collision
    >>> PlaneKind("JC") is PlaneKind.JUMP_CLOSES
    True
    """

    CUSP = "CP"
    GENERALISED_FLIP = "GPD"
    FOLD_BORDER = "LPB"
    FLIP_BORDER = "PDB"
    JUMP_CLOSES = "JC"
    TWO_BORDERS = "BB"
    CROSSING = "CR"
    DOMAIN = "DL"
    END = "EP"

    @property
    def meaning(self) -> str:
        """One phrase that says what it is."""
        return _MEANINGS[self.value]

    @property
    def label(self) -> str:
        """A name for a legend or a table."""
        return _MEANINGS[self.value].partition(":")[0]


_MEANINGS = {
    "CP": "cusp: two folds meet, and the second derivative is zero",
    "GPD": "generalised flip: the cubic coefficient of a flip is zero",
    "LPB": "fold-border collision: multiplier +1 right at a border",
    "PDB": "flip-border collision: multiplier -1 right at a border",
    "JC": "jump closes: the limits on both sides of a border meet",
    "BB": "two borders meet: a cycle lies on both",
    "CR": "crossing: curves of different cycles cross, and nothing else happens",
    "DL": "limit of the domain: beyond, the return is lost",
    "EP": "end point: end of a span or of the window, or given up",
}
