"""Certificates of piecewise-linear maps, and the cost of writing and checking them.

    python -m studies.exact.certificates [--fast] [--out DIR]

Small ones are kept in ``certificates/``: the paper's map P1^L at a = 5/4, r = 1 with all fixed
points and jump crossings of P_1 to P_4, its diagram over r with the fold-flip at r = 0, the tent
map, and the tent map over its slope, where cycles of period three begin at the golden mean.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

from pwmap import PiecewiseLinearMap, bifurcation_diagram, check_certificate, prove
from pwmap.proofs import Certificate
from studies.common.clocks import timed
from studies.common.exact_maps import PAPERS
from studies.common.record import Results, command

TENT = PiecewiseLinearMap.from_sympy("Piecewise((s*x, x <= 1/2), (s*(1 - x), True))")


def of_order(map_: PiecewiseLinearMap, order: int) -> Certificate:
    """All fixed points and jump crossings of an iterate."""
    return prove(map_, order=order)


def of_diagram(
    map_: PiecewiseLinearMap, parameter: str, span: tuple[int, int], last: int
) -> Certificate:
    """The diagram of orders 1 to the last."""
    orders = range(1, last + 1)
    return prove(bifurcation_diagram(map_, parameter, span, orders), map_, orders=orders)


KEPT: dict[str, Callable[[], Certificate]] = {
    **{f"p1l_order_{j}": partial(of_order, PAPERS.at({"r": 1}), j) for j in (1, 2, 3, 4)},
    "p1l_diagram": partial(of_diagram, PAPERS, "r", (-1, 3), 2),
    "tent_order_3": partial(of_order, TENT.at({"s": 2}), 3),
    "tent_diagram": partial(of_diagram, TENT, "s", (0, 2), 3),
}
LARGE: dict[str, Callable[[], Certificate]] = {
    "tent_order_10": partial(of_order, TENT.at({"s": 2}), 10),
    "p1l_diagram_order_12": partial(of_diagram, PAPERS, "r", (-1, 4), 12),
    "tent_diagram_order_6": partial(of_diagram, TENT, "s", (0, 2), 6),
}


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Write, check and measure.

    Parameters
    ----------
    fast
        Without the large ones.
    out
        Folder for ``certificates/``; the large ones are not kept.

    Returns
    -------
    dict
        Of each certificate its size [bytes], the CPU time [s] to write it, the diagram included,
        and to check it, and the statement.
    """
    folder = (out or Path()) / "certificates"
    if out is not None:
        folder.mkdir(exist_ok=True)
    found: Results = {}
    for name, make in {**KEPT, **({} if fast else LARGE)}.items():
        certificate, writing = timed(make)
        row: Results = {"write": writing.cpu}
        if out is not None:
            path = certificate.save(folder / f"{name}.json")
            row["bytes"] = path.stat().st_size
            statement, checking = timed(partial(check_certificate, path))
            row |= {"check": checking.cpu, "statement": statement if name in KEPT else ""}
            if name in LARGE:
                path.unlink()
        found[name] = row
    return found


if __name__ == "__main__":
    command(main, "certificates")
