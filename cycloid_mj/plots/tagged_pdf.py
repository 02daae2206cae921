"""Matplotlib backend of tagged PDF files (ISO 32000-1, 14.7 and 14.8), which screen readers can read.

Texts of a page are paragraphs. Axes are figures; their alternative text is that of their labels. Everything else, such
as rules and backgrounds, is an artifact. `Figure.savefig` uses this module with ``backend=BACKEND``.
"""

from typing import Any

from matplotlib.backends.backend_mixed import MixedModeRenderer
from matplotlib.backends.backend_pdf import FigureCanvasPdf, Name, PdfFile, RendererPdf

BACKEND = f"module://{__name__}"

LANGUAGE = "en"

ROLES = {"text": "P", "axes": "Figure"}
"""Groups of Matplotlib's drawing that are structure elements, and their standard structure types."""

ARTIFACT, END = b"/Artifact BMC\n", b"EMC\n"
"""Operators that begin an artifact, and that end marked content."""


class TaggedPdfFile(PdfFile):
    """A PDF file with a structure tree: a document, a section for each page, and the elements of the pages."""

    def __init__(self, filename: Any, metadata: Any = None) -> None:
        super().__init__(filename, metadata=metadata)
        self._elements: list[list[dict[str, Any]]] = []  # by page and number of the marked content

    def newPage(self, width: float, height: float) -> None:
        """Begin a page, as in Matplotlib's `PdfFile`, and an artifact for everything drawn outside of an element."""
        self._elements.append([])
        super().newPage(width, height)
        self.write(ARTIFACT)

    def endPage(self) -> None:
        """End the page and its artifact."""
        self.write(END)
        self.endStream()

    def begin_element(self, role: str) -> dict[str, Any]:
        """Begin a structure element of the page, and return it, so that an alternative text can be added."""
        elements = self._elements[-1]
        self.write(END + f"/{role} <</MCID {len(elements)}>> BDC\n".encode())
        elements.append({"Type": Name("StructElem"), "S": Name(role), "K": len(elements)})
        return elements[-1]

    def end_element(self) -> None:
        """End the structure element."""
        self.write(END + ARTIFACT)

    def writeObject(self, object: Any, contents: Any) -> None:
        """Write a PDF object, as in Matplotlib's `PdfFile`; a page also gets its number in the structure tree."""
        if isinstance(contents, dict) and contents.get("Type") == Name("Page"):
            contents |= {"StructParents": len(self._elements) - 1, "Tabs": Name("S")}
        super().writeObject(object, contents)

    def finalize(self) -> None:
        """Write structure tree, catalog and end of a tagged PDF file; call it once, after the last page."""
        self.endStream()
        root, document, parents = (self.reserveObject(name) for name in ("structure", "document", "parent tree"))
        sections, numbers = [], []
        for number, (page, elements) in enumerate(zip(self.pageList, self._elements, strict=True)):
            section = self.reserveObject("section")
            references = [self.reserveObject("element") for _ in elements]
            for reference, element in zip(references, elements, strict=True):
                self.writeObject(reference, {**element, "P": section, "Pg": page})
            # axes are drawn first, and read last
            order = sorted(range(len(elements)), key=lambda index: elements[index]["S"] == Name("Figure"))
            content = {"S": Name("Sect"), "P": document, "K": [references[index] for index in order]}
            self.writeObject(section, {"Type": Name("StructElem"), **content})
            sections.append(section)
            numbers += [number, references]
        self.writeObject(document, {"Type": Name("StructElem"), "S": Name("Document"), "P": root, "K": sections})
        self.writeObject(parents, {"Nums": numbers})
        tree = {"K": document, "ParentTree": parents, "ParentTreeNextKey": len(sections)}
        self.writeObject(root, {"Type": Name("StructTreeRoot"), **tree})
        catalog = {
            "Type": Name("Catalog"),
            "Pages": self.pagesObject,
            "StructTreeRoot": root,
            "MarkInfo": {"Marked": True},
            "Lang": LANGUAGE,
        }
        self.writeObject(self.rootObject, catalog)
        super().finalize()


class TaggedRenderer(RendererPdf):
    """Renderer that draws texts and axes of the page as structure elements."""

    def __init__(self, file: TaggedPdfFile, image_dpi: float, height: float, width: float) -> None:
        super().__init__(file, image_dpi, height, width)
        self._groups: list[str] = []  # open groups inside the figure
        self._labels: list[str] = []
        self._element: dict[str, Any] = {}

    def open_group(self, s: str, gid: str | None = None) -> None:
        """Begin a group of artists; `s` is its kind, such as "text" or "axes" (overrides Matplotlib's renderer).

        A group of a kind in `ROLES` that is directly in the figure becomes a structure element. `gid` is not used.
        """
        if s == "figure":
            return
        if not self._groups and s in ROLES:
            self._element, self._labels = self.file.begin_element(ROLES[s]), []
        self._groups.append(s)

    def close_group(self, s: str) -> None:
        """End the current group of artists, of the kind `s`, and its structure element if it has one.

        Axes get the labels that were drawn in them as alternative text. This overrides a method of Matplotlib's
        renderer.
        """
        if s == "figure":
            return
        self._groups.pop()
        if not self._groups and s in ROLES:
            if ROLES[s] == "Figure":
                self._element["Alt"] = f"Diagram with the labels: {'; '.join(self._labels)}"
            self.file.end_element()

    def draw_text(self, *arguments: Any, **options: Any) -> None:
        """Draw a text (overrides Matplotlib's renderer), and add it to the alternative text of its axes."""
        self._labels.append(str(arguments[3]).strip())
        super().draw_text(*arguments, **options)


class FigureCanvasTaggedPdf(FigureCanvasPdf):
    """Canvas that writes tagged PDF files."""

    def print_pdf(
        self, filename: Any, *, bbox_inches_restore: Any = None, metadata: Any = None, **_others: Any
    ) -> None:
        """Write the figure to a file name or stream as PDF, or append it as a page if `filename` is a `TaggedPdfFile`.

        `bbox_inches_restore` and `metadata` are arguments of Matplotlib without effect here. `Figure.savefig` calls
        this method, after it has applied its arguments `_others` to the figure.
        """
        is_appended = isinstance(filename, TaggedPdfFile)
        file = filename if is_appended else TaggedPdfFile(filename, metadata=metadata)
        resolution, self.figure.dpi = self.figure.dpi, 72  # points per inch
        width, height = self.figure.get_size_inches()
        file.newPage(width, height)
        renderer = TaggedRenderer(file, resolution, height, width)
        figure_renderer: Any = MixedModeRenderer(
            self.figure, width, height, resolution, renderer, bbox_inches_restore=bbox_inches_restore
        )
        self.figure.draw(figure_renderer)
        figure_renderer.finalize()
        file.endPage()
        if not is_appended:
            file.finalize()
            file.close()


FigureCanvas = FigureCanvasTaggedPdf
"""Name by which Matplotlib finds the canvas of a backend."""
