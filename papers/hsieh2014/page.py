"""The paper again as one HTML page: claims first, then each stage with its figures, then the errata."""

import base64
from collections.abc import Mapping, Sequence
from importlib.resources import files
from typing import Any

from cycloid_mj.report import html
from cycloid_mj.result import Claim, Table, Verdict
from hsieh2014.stage import Plate, Stage

PNG = b"\x89PNG"
CLAIM_HEAD = (
    *("figure", "design", "condition", "the paper says", "its number", "ours at that condition", "numerical error"),
    *("verdict", "decided by", "beside it: ours at the rated load"),
)
TALLY = {
    Verdict.AGREES: "agree",
    Verdict.DISAGREES: "disagree",
    Verdict.DEPENDS: "depend on what the paper leaves open at its condition",
    Verdict.NOT_DETERMINED: "are not determined",
}
ERRATUM_HEAD = ("Eq.", "printed", "right", "held against", "error as printed", "error corrected")


def reproduction_page(
    stages: Sequence[Stage], errata: Sequence[Mapping[str, Any]], pictures: Mapping[str, bytes], about: Sequence[str]
) -> str:
    """Give the page.

    Parameters
    ----------
    stages
        What was run; one that broke says so in its section.
    errata
        As `reproduce.errata` gives them.
    pictures
        Name of a plate -> PNG or SVG.
    about
        Lines on what was run, and how.
    """
    title = "Hsieh 2014, reproduced: cycloidal reducers with and without pins"
    claims = [claim for stage in stages for claim in stage.found.claims]
    sections = [
        html.tag("header", html.tag("h1", html.text(title)) + "".join(_line(line) for line in about)),
        _contents(stages),
        _broken(stages),
        _section("claims", "Claims", _tally(claims) + claim_table(claims), "claims"),
        *(_stage(stage, pictures) for stage in stages),
        _section("errata", "Errata of the paper", _errata(errata), "errata"),
    ]
    head = (
        '<meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        html.tag("title", html.text(title)),
        html.tag("style", _asset("cycloid_mj.report", "page.css") + _asset("hsieh2014", "reproduction.css")),
    )
    body = html.tag("main", "".join(sections))
    return f'<!doctype html>\n<html lang="en"><head>{"".join(head)}</head>\n<body>{body}</body></html>\n'


def claim_table(claims: Sequence[Claim]) -> str:
    """Give the table of claims, the verdicts marked."""
    if not claims:
        return html.tag("p", "No stage that judges a claim came through.")
    head = html.tag(
        "thead", html.tag("tr", "".join(html.tag("th", html.text(word), scope="col") for word in CLAIM_HEAD))
    )
    rows = "".join(_claim(claim) for claim in claims)
    return html.tag("div", html.tag("table", head + html.tag("tbody", rows)), class_="scroll", tabindex="0")


def error_words(claim: Claim) -> str:
    """Give the numerical error of a claim, and where it comes from."""
    error = claim.error
    return error.text if error.value is None else f"{error.value:.2g} {error.unit} ({error.text})"


def _claim(claim: Claim) -> str:
    before = (
        claim.design,
        claim.condition.words,
        claim.claim,
        claim.stated.text,
        claim.found.text,
        error_words(claim),
    )
    after = (claim.decided_by, claim.rated.text if claim.rated else "")
    cells = [
        html.tag("th", html.text(claim.figure), scope="row"),
        *(html.tag("td", html.text(cell)) for cell in before),
    ]
    cells.append(html.tag("td", html.text(claim.verdict), class_=claim.verdict.replace(" ", "-")))
    return html.tag("tr", "".join([*cells, *(html.tag("td", html.text(cell)) for cell in after)]), id_=claim.key)


def _tally(claims: Sequence[Claim]) -> str:
    counts = ", ".join(
        f"{sum(claim.verdict == verdict for claim in claims)} {words}" for verdict, words in TALLY.items()
    )
    return html.tag("p", html.text(f"Of {len(claims)} claims, {counts}. Nothing was tuned to agree.")) + html.tag(
        "p",
        "Each claim is judged at the paper's own condition: motion and stress without load (its sections 3.1 and 3.3), "
        "only the output torque under load (3.3, 3.4). An idle quantity is the spread over independent starts; where "
        "that exceeds the difference, the verdict is not determined. What the rated load makes of it is a result of "
        "ours, in the last column, and never judged.",
    )


def _contents(stages: Sequence[Stage]) -> str:
    entries = [("claims", "Claims"), *((stage.key, f"{stage.title} ({stage.paper})") for stage in stages)]
    links = "".join(
        html.tag("li", html.tag("a", html.text(words), href=f"#{key}"))
        for key, words in [*entries, ("errata", "Errata of the paper")]
    )
    return html.tag("nav", html.tag("ol", links))


def _broken(stages: Sequence[Stage]) -> str:
    broken = [stage for stage in stages if stage.error]
    if not broken:
        return ""
    lines = "".join(html.tag("li", html.text(f"{stage.title} ({stage.paper}): {stage.error}")) for stage in broken)
    return html.tag("section", html.tag("h2", "Stages that broke") + html.tag("ul", lines), class_="warnings")


def _stage(stage: Stage, pictures: Mapping[str, bytes]) -> str:
    error = html.tag("p", html.text(f"This stage broke: {stage.error}"), class_="broken") if stage.error else ""
    notes = "".join(html.tag("li", html.text(note)) for note in stage.found.notes)
    inside = [
        error,
        html.tag("div", "".join(_plate(plate, pictures[plate.name]) for plate in stage.found.plates), class_="plates"),
        *(_table(table) for table in stage.found.tables),
        html.tag("ul", notes, class_="notes") if notes else "",
        html.tag("p", html.text(f"{stage.seconds:.1f} s"), class_="notes"),
    ]
    return _section(stage.key, f"{stage.title} ({stage.paper})", "".join(inside))


def _plate(plate: Plate, picture: bytes) -> str:
    kind = "png" if picture.startswith(PNG) else "svg+xml"
    source = f"data:image/{kind};base64,{base64.b64encode(picture).decode()}"
    caption = html.tag("b", html.text(plate.stands_for)) + " " + html.text(plate.caption)
    image = html.tag("img", src=source, alt=plate.caption, loading="lazy").removesuffix("</img>")
    return html.tag("figure", image + html.tag("figcaption", caption), id_=plate.name)


def _table(table: Table) -> str:
    return html.tag("h3", html.text(table.title)) + html.table([table.header], table.cells)


def _errata(errata: Sequence[Mapping[str, Any]]) -> str:
    said = html.tag(
        "p",
        "Each printed formula and its correction are code, held against finite differences of the equation before it: "
        "the relative error of both stands beside them. Eqs 6 and 10 give the right velocity all the same, and Eq. 18 "
        "is right as printed, though it is not the size of the printed Eq. 17.",
    )
    rows = [
        (
            str(one["equation"]),
            str(one["printed"]),
            str(one["right"]),
            str(one["proof"]),
            f"{one['printed_error']:.2g}",
            f"{one['right_error']:.1g}",
        )
        for one in errata
    ]
    return said + html.table([ERRATUM_HEAD], rows)


def _section(key: str, title: str, content: str, kind: str = "") -> str:
    inside = html.tag("h2", html.text(title)) + content
    return html.tag("section", inside, id_=key, **({"class_": kind} if kind else {}))


def _line(words: str) -> str:
    return html.tag("p", html.text(words), class_="log")


def _asset(package: str, name: str) -> str:
    return files(package).joinpath("assets", name).read_text(encoding="utf-8")
