"""The two laws of friction in the expansion of an impact at two contacts, side by side.

The paper does not state its contact problem. That its program bounded friction by the sum of both
normal impulses is inferred: its figures follow from the sum, and not from Coulomb's law contact by
contact (:class:`woodpecker.ExpansionFriction`). All peers know only Coulomb's law, so comparisons
with them are under "separate".
"""

from __future__ import annotations

from typing import Final

from woodpecker import ExpansionFriction, Toy

SUMMED, SEPARATE = ExpansionFriction.SUMMED, ExpansionFriction.SEPARATE
LAWS: Final = (SUMMED, SEPARATE)
TOYS: Final = {law: Toy(expansion_friction=law) for law in LAWS}
CONTACT_BY_CONTACT: Final = TOYS[SEPARATE]  # what other programs can follow too
TITLES: Final = {  # of panels
    SUMMED: "friction bounded by the sum (the paper's law, inferred)",
    SEPARATE: "Coulomb's law contact by contact",
}
SHORT: Final = {SUMMED: "sum (inferred)", SEPARATE: "contact by contact"}  # in legends
