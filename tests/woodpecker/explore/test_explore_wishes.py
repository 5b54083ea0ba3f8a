"""What a page answers to wishes that it cannot fulfil; no browser."""

import json
from typing import Any

import pytest

pytest.importorskip("bokeh")
from bokeh.document import Document

from woodpecker.explore.state import PageState
from woodpecker.explore.toy_page import make_page


@pytest.mark.parametrize(
    ("name", "value", "sentence"),
    [
        ("start", "left", "start must be a number, got 'left'"),
        ("start", "1,2", "start must be a number, got '1,2'"),
        ("tour", "first", "tour must be a number, got 'first'"),
        ("tour", "1.5", "tour must be a whole number, got '1.5'"),
    ],
)
def test_what_is_no_number_is_refused_with_a_sentence(name: str, value: str, sentence: str) -> None:
    """Not with that of Python."""
    document = Document()
    make_page(document, PageState())
    wish: Any = document.get_model_by_name("wish")
    wish.text = json.dumps({"do": name, "value": value, "n": 1})
    answer: Any = document.get_model_by_name("answer")
    assert json.loads(answer.text)["message"] == sentence
