"""What a page of the toy keeps while its state changes; no browser."""

import gc
import json
import random
import tracemalloc
import weakref
from typing import Any

import pytest

pytest.importorskip("bokeh")
from bokeh.core.serialization import Serializer
from bokeh.document import Document

from woodpecker.explore.state import PageState
from woodpecker.explore.toy_page import make_page
from woodpecker.simulation.words import word_of

WARM = 80  # changes until every cache is full: of the tables of a toy 64 are kept
COUNT = 120  # changes that are measured
MOST = 1_000  # bytes that a change may leave: a quarter of the states is kept for *undo*


def held() -> int:
    """Bytes that are held, without the words of returns, of which some thousands are kept."""
    word_of.cache_clear()
    gc.collect()
    return tracemalloc.get_traced_memory()[0]


def answering(document: Document) -> None:
    """Serialize what changes, as the server does for its page."""

    def send(event: Any) -> None:
        letter = Serializer(references=document.models.synced_references)
        letter.serialize(event)
        document.models.flush_synced(lambda model: not letter.has_ref(model))

    document.on_change(send)


@pytest.mark.nightly
def test_changes_of_the_state_leave_nothing_behind() -> None:
    """Drags, rests and other iterates; a motion that is drawn takes 60 times as much as is left."""
    document, rng = Document(), random.Random(1)
    make_page(document, PageState())
    answering(document)
    wish: Any = document.get_model_by_name("wish")

    def change(number: int) -> None:
        value = 0.2 + 0.5 * rng.random()
        asked: dict[str, Any] = {"do": "set", "values": {"eps_n1": value}, "drag": number % 4 > 0}
        if number % 8 == 0:
            asked = {"do": "order", "value": str(1 + number // 8 % 2)}
        wish.text = json.dumps({**asked, "n": number})

    tracemalloc.start()
    try:
        for number in range(WARM):
            change(number)
        before = held()
        for number in range(WARM, WARM + COUNT):
            change(number)
        left = held() - before
    finally:
        tracemalloc.stop()
    assert left < MOST * COUNT


@pytest.mark.slow
def test_a_page_that_is_closed_is_forgotten() -> None:
    document = Document()
    make_page(document, PageState())
    closed = weakref.ref(document)
    del document
    gc.collect()
    assert closed() is None
