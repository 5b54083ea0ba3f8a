"""Maps of the toy and maps of formulas can be sent, copied and shared between threads."""

import copy
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import sympy
from maps import logistic, paper, two_lines
from needs import EACH_BACKEND
from pickles import Way, pickled

from pwmap import PiecewiseLinearMap
from woodpecker import FormulaMap, PiecewiseMap, Toy, ToyPieces, from_pwmap, from_sympy, local_model
from woodpecker.maps import Iterate
from woodpecker.slices import LocalModel
from woodpecker.systems import Contact, ContactSystem, Section, SystemMap

WAYS = pytest.mark.parametrize("way", [pickled, copy.deepcopy])
X = np.linspace(-2.4, 0.05, 20)


def maps() -> list[PiecewiseMap]:
    toy = Toy(mu_2=0.31)
    one = ToyPieces(toy)
    return [one, ToyPieces(toy, "m_m"), Iterate(one, 2)]


def formulas() -> list[FormulaMap]:
    x, p = sympy.symbols("x p", real=True)
    piecewise = sympy.Piecewise((x / 2 + p, x < 0), (sympy.sqrt(x) - 1, True))
    exact = PiecewiseLinearMap.from_sympy(sympy.Piecewise((x / 2 + p, x < 0), (p - x, True)), x)
    return [paper(), logistic(), from_sympy(piecewise, x, p), from_pwmap(exact, "p")]


def seen(map_: PiecewiseMap) -> str:
    """Every number that a map gives, and its words and causes."""
    p = 0.003 if getattr(map_, "parameter", "") == "m_m" else 0.4
    found = []
    for x in X.tolist():
        here = map_.at(x, p)
        causes = [here.piece.cause(code) for code in here.causes.tolist()]
        margins = here.margins.tobytes(), here.gradients.tobytes()
        found.append((*here[:3], margins, here.reason, here.piece.word, causes))
    return repr(found)


@WAYS
@pytest.mark.parametrize("used", [False, True])
def test_maps(way: Way, used: bool) -> None:
    for map_ in maps():
        before = seen(map_) if used else ""
        again = way(map_)
        assert again == map_
        assert seen(again) == (before or seen(map_))


@WAYS
def test_maps_of_formulas(way: Way) -> None:
    for map_ in formulas():
        assert seen(way(map_)) == seen(map_)


@WAYS
def test_pieces_go_on_from_where_they_were(way: Way) -> None:
    """A piece that is sent gives the same image, also outside of the set where it is taken."""
    for map_ in maps():
        p = 0.003 if getattr(map_, "parameter", "") == "m_m" else 0.4
        piece = map_.at(-0.53, p).piece
        again = way(piece)
        assert again.key == piece.key
        for x in (-0.53, -0.535, -0.52):
            one, other = again.at(x, p), piece.at(x, p)
            assert one[:3] == other[:3]
            assert one.margins.tobytes() == other.margins.tobytes()


@WAYS
def test_local_models(way: Way) -> None:
    model = local_model(two_lines(), 0.0, 0.0, orders=(1, 2))
    again: LocalModel = way(model)
    assert (again.x, again.p, again.speed) == (model.x, model.p, model.speed)
    assert (again.starts, again.point) == (model.starts, model.point)
    assert again.border.cause == model.border.cause
    assert str(again.map.at({"q": 1}).iterate(2)) == str(model.map.at({"q": 1}).iterate(2))


def test_a_map_that_threads_share_gives_each_its_own_answer() -> None:
    map_, points = ToyPieces(Toy()), [(float(x), p) for p in (0.1, 0.4, 0.7) for x in X] * 4
    for shared in (map_, map_.at(-0.6, 0.5).piece):
        expected = [repr(shared.at(x, p)[:3]) for x, p in points]
        with ThreadPoolExecutor(4) as threads:
            found = list(threads.map(lambda point, to=shared: repr(to.at(*point)[:3]), points))
        assert found == expected


def test_maps_are_equal_if_their_toys_and_parameters_are() -> None:
    assert ToyPieces(Toy()) == ToyPieces(Toy())
    assert len({ToyPieces(Toy()), ToyPieces(Toy(mu_2=0.3)), ToyPieces(Toy(), "m_m")}) == 2
    assert Iterate(ToyPieces(Toy()), 2) == Iterate(ToyPieces(Toy()), 2)
    assert Iterate(ToyPieces(Toy()), 2) != Iterate(ToyPieces(Toy()), 3)
    with pytest.raises(TypeError, match="unknown parameter 'eps'"):
        ToyPieces(Toy(), "eps")


@WAYS
@EACH_BACKEND
def test_maps_of_systems(way: Way, backend: str) -> None:
    """With the values that they hold, their derivatives and margins; so have their pieces."""
    x, v, t, w, force = sympy.symbols("x u_x t w F")
    stop = Contact(name="the stop", gap=1 - x, eps_n=0.8)
    machine = ContactSystem([x], [[1]], [force * sympy.cos(w * t) - x], [stop], {w: 2.0, force: 1})
    section = Section(when=sympy.sin(w * t), free=[x, v], at={t: 0})
    map_ = SystemMap(machine, section, ["F"], backend=backend).holding(w=2.8)
    start, p = np.array([-0.8, 2.0]), np.array([8.0])
    image = map_.at(start, p)
    for own, sent in ((map_, way(map_)), (image.piece, way(image).piece)):
        known, again = own.at(start, p), sent.at(start, p)
        assert again.piece == known.piece
        for name in ("value", "jacobian", "margins", "gradients", "codes"):
            assert getattr(again, name).tobytes() == getattr(known, name).tobytes()
