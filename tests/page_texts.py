"""Texts on a page of a data sheet: none is clipped, and none lies on another."""

from itertools import combinations

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text


def require_separate_texts(page: Figure) -> None:
    """Assert that all texts of a page are within it and apart from each other."""
    canvas = FigureCanvasAgg(page)
    canvas.draw()
    # labels of ticks beyond an axis are there, but not drawn
    ruled = [axis for axes in page.axes for axis in (axes.xaxis, axes.yaxis)]
    ticks = {text for axis in ruled for text in axis.findobj(Text) if text is not axis.label}
    boxes = {
        (text.get_text(), text): text.get_window_extent(canvas.get_renderer())
        for text in page.findobj(Text)
        if text.get_text().strip() and text not in ticks
    }
    assert len(boxes) > 15
    for (words, _), box in boxes.items():
        assert 0 <= box.x0 < box.x1 <= page.bbox.x1, words
        assert 0 <= box.y0 < box.y1 <= page.bbox.y1, words
    for (one, first), (other, second) in combinations(boxes.items(), 2):
        assert not first.padded(-0.5).overlaps(second.padded(-0.5)), (one[0], other[0])
