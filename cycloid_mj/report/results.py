"""Pages of results: of any outcome, by the template ``assets/outcome.html``, and of a calibration."""

import base64
from collections.abc import Sequence
from typing import TYPE_CHECKING

from markupsafe import Markup

from cycloid_mj.base.outcome import Outcome, Picture
from cycloid_mj.report.page import environment
from cycloid_mj.report.tables import TextTable

if TYPE_CHECKING:
    from cycloid_mj.bench import Calibration


MAX_SVG_BYTES = 150_000
"""Size of a vector picture above which the page has pixels: curves of many samples."""


def outcome_page(outcome: Outcome) -> str:
    """Return an outcome as one HTML page."""
    return environment().get_template("outcome.html").render(outcome=outcome, texts=TextTable.of, source=_data_url)


def _data_url(picture: Picture) -> str:
    """Return the address of a picture that is part of the page: SVG, or PNG where that is much smaller."""
    svg = picture("svg")
    kind, content = ("svg+xml", svg) if len(svg) < MAX_SVG_BYTES else ("png", picture("png"))
    return f"data:image/{kind};base64,{base64.b64encode(content).decode()}"


def calibration_page(calibration: "Calibration", figure: str, remarks: Sequence[str] = ()) -> str:
    """Return a calibration of a design by measured hysteresis loops as one HTML page.

    The page has the fitted parameters with their intervals, the loops, the residuals and the remarks.

    Parameters
    ----------
    figure
        Figure of its hysteresis loops, as SVG text.
    remarks
        Sentences on why the calibrated design cannot be used, one for each reason.
    """
    drawing = figure[figure.index("<svg") :]
    return (
        environment()
        .get_template("bench.html")
        .render(
            title=f"cycloid_mj: {calibration.design.name}",
            calibration=calibration,
            remarks=remarks,
            bench=f"{calibration.fitted.condition.held} fixed",
            tables=calibration.tables(),
            texts=TextTable.of,
            unexplained=calibration.unexplained,
            figure=Markup(drawing),
        )
    )
