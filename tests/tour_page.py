"""The page of the docs that shows the tour of the explorer without a server: text and pictures.

The pictures are taken by the tests in a browser (``EXPLORER_PICTURES=docs/explore``). ``python
tests/tour_page.py`` makes them small enough for a page, and records the states that the page in
``docs/_static/tour`` shows.
"""

from pathlib import Path

from woodpecker.explore.tour import TOUR

DOCS = Path(__file__).parents[1] / "docs"
COLOURS = 256  # of a picture
LIVE = "_static/tour/index.html"  # under the folder of the docs


def page() -> str:
    """The page, in Markdown."""
    lines = [
        "# The tour, without a server", "",
        "Ten states of [the explorer](explore.md), one for each figure of the paper, recorded: "
        "play the motion, step from event to event, switch between maps. It needs no network, and "
        f'has <a href="{LIVE}">a page of its own</a>.',
        "", f'<iframe class="tour" src="{LIVE}" title="The tour in ten steps"></iframe>', "",
        "`woodpecker explore` shows these states alive, as below; the text after `?` is what its "
        "address bar has.",
    ]  # fmt: skip
    for k, step in enumerate(TOUR, start=1):
        lines += [
            "", f"## {k}. {step.title} ({step.figure})", "", step.text, "",
            f"![Step {k}: {step.title}](explore/tour_{k:02d}.png)", "",
            f"`?{step.state.query()}`",
        ]  # fmt: skip
    return "\n".join([*lines, ""])


def shrink(folder: Path) -> None:
    """Fewer colours for all pictures of a folder; those of thin lines stay what they are."""
    from PIL import Image

    for path in sorted(folder.glob("*.png")):
        picture = Image.open(path).convert("RGB")
        picture.quantize(COLOURS, Image.Quantize.FASTOCTREE).save(path, optimize=True)


def record(folder: Path) -> None:
    """What the page without a server loads: a script for each step, and the one that draws."""
    import tour_states

    (folder / "toy.js").write_text(tour_states.toy_script(), encoding="utf-8")
    for number in range(1, len(TOUR) + 1):
        script = tour_states.script(number)
        (folder / f"{number:02d}.js").write_text(script, encoding="utf-8")


if __name__ == "__main__":
    record((DOCS / LIVE).parent)
    shrink(DOCS / "explore")
    (DOCS / "explore_tour.md").write_text(page(), encoding="utf-8")
