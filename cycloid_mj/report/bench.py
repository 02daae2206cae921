"""The page of a calibration: what the template ``assets/bench.html`` is filled with."""

from markupsafe import Markup

from cycloid_mj.bench import Calibration
from cycloid_mj.bench.calibration import UNEXPLAINED
from cycloid_mj.report.page import environment


def calibration_page(calibration: Calibration, figure: str) -> str:
    """Write a calibration as one page that needs no other file; `figure` is the SVG of its loops."""
    drawing = figure[figure.index("<svg") :]
    return (
        environment()
        .get_template("bench.html")
        .render(
            title=f"cycloid_mj: {calibration.design.name}",
            found=calibration,
            bench=f"{calibration.fitted.bench.held} held",
            tables=calibration.tables(),
            unexplained=UNEXPLAINED,
            figure=Markup(drawing),
        )
    )
