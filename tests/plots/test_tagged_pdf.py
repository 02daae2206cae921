"""Tagged PDF files: the structure tree, and content that belongs to it."""

import re
import zlib

import pytest
from matplotlib.figure import Figure

from cycloid_mj.plots.save import document


@pytest.fixture(scope="module")
def pdf() -> bytes:
    """Two pages, each with two texts, a rule and a chart."""
    pages = []
    for number in (1, 2):
        page = Figure(figsize=(4.0, 3.0))
        page.text(0.1, 0.9, f"Data sheet {number}")
        page.text(0.1, 0.8, "Rated torque: 3 N m")
        axes = page.add_axes((0.2, 0.2, 0.6, 0.4))
        axes.plot([0.0, 1.0], [1.0, 2.0])
        axes.set(xlabel="time [s]", ylabel="torque [N m]")
        pages.append(page)
    return document(pages)


def objects(pdf: bytes) -> dict[int, bytes]:
    """Return the last object of each number."""
    return {int(number): content for number, content in re.findall(rb"(?s)(\d+) 0 obj\n(.*?)endobj", pdf)}


def page_contents(pdf: bytes) -> list[bytes]:
    """Return the content of each page."""
    streams = [zlib.decompress(content) for content in re.findall(rb"(?s)stream\n(.*?)\nendstream", pdf)]
    return [stream for stream in streams if b"Artifact" in stream]


def test_the_catalog_refers_to_the_structure_and_states_the_language(pdf: bytes) -> None:
    (catalog,) = [content for content in objects(pdf).values() if b"/Catalog" in content]
    assert b"/Marked true" in catalog
    assert b"/Lang (en)" in catalog
    assert re.search(rb"/StructTreeRoot \d+ 0 R", catalog)


def test_all_content_of_a_page_is_an_element_or_an_artifact(pdf: bytes) -> None:
    contents = page_contents(pdf)
    assert len(contents) == 2
    for content in contents:
        assert re.findall(rb"/(\w+) <</MCID (\d+)>> BDC", content) == [(b"Figure", b"0"), (b"P", b"1"), (b"P", b"2")]
        depth = 0
        for operator in re.findall(rb"\b(BDC|BMC|EMC|Tj|TJ)\b", content):
            depth += {b"BDC": 1, b"BMC": 1, b"EMC": -1}.get(operator, 0)
            assert 0 <= depth <= 1
            assert depth or operator == b"EMC"
        assert depth == 0


def test_the_structure_has_the_elements_in_reading_order(pdf: bytes) -> None:
    elements = {number: content for number, content in objects(pdf).items() if b"/StructElem" in content}
    sections = [content for content in elements.values() if b"/Sect" in content]
    assert len(sections) == 2
    for section in sections:
        children = [int(number) for number in re.findall(rb"(\d+) 0 R", section.partition(b"/K")[2])]
        roles = [re.search(rb"/S /(\w+)", elements[number])[1] for number in children if number in elements]
        assert [role for role in roles if role != b"Document"] == [b"P", b"P", b"Figure"]
    (alternative, *_) = [content for content in elements.values() if b"/S /Figure" in content]
    assert b"time [s]" in alternative
    assert b"torque [N m]" in alternative
