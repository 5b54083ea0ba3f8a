"""The page of the docs that shows the tour of the explorer without a server: text and pictures.

The pictures are those that the tests in a browser keep (``EXPLORER_PICTURES=docs/explore``), here
made small enough for a page by ``python tests/tour_page.py``.
"""

from __future__ import annotations

from pathlib import Path

from woodpecker.explore.state import to_query
from woodpecker.explore.tour import TOUR

DOCS = Path(__file__).parents[1] / "docs"
COLOURS = 256  # of a picture


def page() -> str:
    """The page, in Markdown."""
    lines = [
        "# The tour, without a server", "",
        "Ten states of [the explorer](explore.md), one for each figure of the paper. "
        "`woodpecker explore` shows them alive; the text after `?` is what its address bar has.",
    ]  # fmt: skip
    for k, step in enumerate(TOUR, start=1):
        lines += [
            "", f"## {k}. {step.title} ({step.figure})", "", step.text, "",
            f"![Step {k}: {step.title}](explore/tour_{k:02d}.png)", "",
            f"`?{to_query(step.state)}`",
        ]  # fmt: skip
    return "\n".join([*lines, ""])


def shrink(folder: Path) -> None:
    """Fewer colours for all pictures of a folder; those of thin lines stay what they are."""
    from PIL import Image

    for path in sorted(folder.glob("*.png")):
        picture = Image.open(path).convert("RGB")
        picture.quantize(COLOURS, Image.Quantize.FASTOCTREE).save(path, optimize=True)


if __name__ == "__main__":
    shrink(DOCS / "explore")
    (DOCS / "explore_tour.md").write_text(page(), encoding="utf-8")
