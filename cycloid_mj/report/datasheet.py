"""The page of a data sheet: fills the template ``assets/datasheet.html``."""

import re

from markupsafe import Markup

from cycloid_mj.life.datasheet import Datasheet
from cycloid_mj.plots.datasheet import datasheet_pictures, describe_kind, format_ratio, format_unit, format_value
from cycloid_mj.plots.save import encode_figure
from cycloid_mj.report.page import environment


def datasheet_page(sheet: Datasheet) -> str:
    """Return a data sheet as one HTML page with diagrams and tables."""
    diagrams = {name: Markup(_inline(figure)) for name, figure in _draw_figures(sheet).items()}
    design = sheet.design
    return (
        environment()
        .get_template("datasheet.html")
        .render(
            title=f"cycloid_mj: data sheet of {design.name}",
            sheet=sheet,
            design=design,
            kind=describe_kind(design),
            ratio=format_ratio(design.reduction),
            format_unit=format_unit,
            format_value=format_value,
            **diagrams,
        )
    )


def _draw_figures(sheet: Datasheet) -> dict[str, str]:
    return {name: encode_figure(figure, "svg").decode() for name, figure in datasheet_pictures(sheet).items()}


def _inline(svg: str) -> str:
    """Return an SVG file without its XML prolog, to be embedded in HTML."""
    return re.sub(r"^.*?(?=<svg)", "", svg, count=1, flags=re.DOTALL)
