"""What the legend of a picture says."""

from matplotlib.axes import Axes
from matplotlib.legend import Legend


def legend_of(ax: Axes) -> Legend:
    """There must be one."""
    legend = ax.get_legend()
    assert legend is not None
    return legend


def explained(ax: Axes) -> list[str]:
    """The texts of its legend."""
    return [text.get_text() for text in legend_of(ax).get_texts()]
