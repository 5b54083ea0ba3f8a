"""The kinds of special points of two parameters."""

from __future__ import annotations

from pwmap.diagrams.data import Coded


class PlaneKind(Coded):
    """A special point of codimension two, or why a curve ends; the value is its code."""

    CUSP = "CP", "cusp: two folds meet, and the second derivative is zero"
    GENERALISED_FLIP = "GPD", "generalised flip: the cubic coefficient of a flip is zero"
    FOLD_BORDER = "LPB", "fold-border collision: multiplier +1 right at a border"
    FLIP_BORDER = "PDB", "flip-border collision: multiplier -1 right at a border"
    JUMP_CLOSES = "JC", "jump closes: the limits on both sides of a border meet"
    DEGENERATE_GRAZING = "DG", "degenerate grazing: an infinite slope at a border changes its sign"
    TWO_BORDERS = "BB", "two borders meet: a cycle lies on both"
    CROSSING = "CR", "crossing: curves of different cycles cross, and nothing else happens"
    DOMAIN = "DL", "limit of the domain: beyond, the return is lost"
    END = "EP", "end point: end of a span or of the window, or given up"
