"""What a slider shows: its picture, drawn once and with its titles as the text that stands for it."""

from __future__ import annotations

import io

from IPython.display import Image
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure


def as_image(figure: Figure) -> Image:
    """Return the figure as a PNG; the notebook's own way draws it twice, to find its margins."""
    png = io.BytesIO()
    FigureCanvasAgg(figure).print_png(png)
    titles = [axes.get_title() for axes in figure.axes]
    return Image(png.getvalue(), alt="; ".join(title for title in titles if title))
