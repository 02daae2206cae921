"""Read the text of a PDF that Chromium printed: its fonts map glyphs to characters by ``ToUnicode`` tables."""

import re
import zlib


def pdf_text(pdf: bytes) -> str:
    """Return the text of all pages in the order in which it is drawn, without spaces between the pieces."""
    objects = {
        int(number): content
        for number, content in re.findall(rb"(?:^|[\r\n])(\d+) 0 obj\b(.*?)\bendobj", pdf, flags=re.DOTALL)
    }
    fonts = _fonts(objects)
    pages = []
    for content in objects.values():
        if re.search(rb"/Type\s*/Page\b", content):
            (number,) = re.findall(rb"/Contents (\d+) 0 R", content)
            pages.append(_drawn(_stream(objects[int(number)]), fonts))
    return "\n".join(pages)


def _fonts(objects: dict[int, bytes]) -> dict[str, dict[int, str]]:
    """Return the table of each font, by its name in the content of pages."""
    fonts = {}
    for content in objects.values():
        for name, number in re.findall(rb"/(F\d+) (\d+) 0 R", content):
            if table := re.search(rb"/ToUnicode (\d+) 0 R", objects[int(number)]):
                fonts[name.decode()] = _characters(_stream(objects[int(table[1])]).decode("latin-1"))
    return fonts


def _characters(table: str) -> dict[int, str]:
    """Read a ``ToUnicode`` table: glyph -> characters."""
    glyphs = {}
    for block in re.findall(r"beginbfchar(.*?)endbfchar", table, flags=re.DOTALL):
        for glyph, text in re.findall(r"<(\w+)>\s*<(\w+)>", block):
            glyphs[int(glyph, 16)] = bytes.fromhex(text).decode("utf-16-be")
    for block in re.findall(r"beginbfrange(.*?)endbfrange", table, flags=re.DOTALL):
        for first, last, text in re.findall(r"<(\w+)>\s*<(\w+)>\s*<(\w+)>", block):
            for number in range(int(first, 16), int(last, 16) + 1):
                glyphs[number] = chr(int(text, 16) + number - int(first, 16))
    return glyphs


def _drawn(content: bytes, fonts: dict[str, dict[int, str]]) -> str:
    """Return the text that the content of a page draws."""
    text, font = "", dict[int, str]()
    for name, one, several in re.findall(
        r"/(F\d+) [\d.-]+ Tf|<(\w*)>\s*Tj|\[([^\]]*)\]\s*TJ", content.decode("latin-1")
    ):
        if name:
            font = fonts.get(name, {})
            text += "\n"
        for glyphs in [one] if one else re.findall(r"<(\w*)>", several):
            text += "".join(font.get(int(glyphs[at : at + 4], 16), "") for at in range(0, len(glyphs), 4))
    return text


def _stream(content: bytes) -> bytes:
    data = content.partition(b"stream")[2].lstrip(b"\r\n").rpartition(b"endstream")[0]
    return zlib.decompress(data) if b"/FlateDecode" in content else data
