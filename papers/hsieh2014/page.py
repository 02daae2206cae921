"""The HTML page of the reproduction: the content of the template ``assets/reproduction.html``."""

import base64
from collections.abc import Mapping, Sequence
from typing import Any

from jinja2 import ChoiceLoader, PackageLoader

from cycloid_mj.base.result import Claim, Verdict
from cycloid_mj.report.page import environment
from cycloid_mj.report.tables import TextTable
from hsieh2014.stage import StageRun

TITLE = "Hsieh 2014, reproduced: cycloidal reducers with and without pins"
PNG = b"\x89PNG"
CLAIM_HEAD = (
    *("figure", "design", "condition", "the paper says", "its number", "model at that condition", "numerical error"),
    *("verdict", "decided by", "model at the rated load"),
)
TALLY = {
    Verdict.AGREES: "agree",
    Verdict.DISAGREES: "disagree",
    Verdict.DEPENDS: "depend on values that the paper omits under its condition",
    Verdict.NOT_DETERMINED: "are not determined",
}
ERRATUM_HEAD = ("Eq.", "printed", "right", "compared with", "error as printed", "error corrected")


def reproduction_page(
    stages: Sequence[StageRun], errata: Sequence[Mapping[str, Any]], pictures: Mapping[str, bytes], about: Sequence[str]
) -> str:
    """Return the page: claims, then each stage with its figures, then the errata as `errata.errata` returns them.

    The section of a failed stage states the error. `pictures` are the plates by name, as PNG or SVG, `about` lines on
    what was run, and how.
    """
    claims = [claim for stage in stages for claim in stage.result.claims]
    numbers = [f"{sum(claim.verdict == verdict for claim in claims)} {words}" for verdict, words in TALLY.items()]
    keys = ("equation", "printed", "right", "proof")
    rows = [
        (*(each[key] for key in keys), f"{each['printed_error']:.2g}", f"{each['right_error']:.1g}") for each in errata
    ]
    shared = environment()
    assert shared.loader
    templates = shared.overlay(loader=ChoiceLoader([PackageLoader("hsieh2014", "assets"), shared.loader]))
    return templates.get_template("reproduction.html").render(
        title=TITLE,
        about=about,
        stages=stages,
        claims=claims,
        tally=", ".join(numbers),
        claim_head=CLAIM_HEAD,
        error_words=error_words,
        source=lambda name: _source(pictures[name]),
        texts=lambda each: TextTable([each.header], each.cells),
        errata=TextTable([ERRATUM_HEAD], rows),
    )


def error_words(claim: Claim) -> str:
    """Return the numerical error of a claim and its source."""
    error = claim.error
    unit = "" if error.unit == "1" else f" {error.unit}"
    return error.text if error.value is None else f"{error.value:.2g}{unit} ({error.text})"


def _source(picture: bytes) -> str:
    kind = "png" if picture.startswith(PNG) else "svg+xml"
    return f"data:image/{kind};base64,{base64.b64encode(picture).decode()}"
