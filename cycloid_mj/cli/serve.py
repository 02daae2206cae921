"""``cycloid-mj app``: the designer's page in the browser."""

import socket
from typing import Annotated

from cyclopts import Parameter

from cycloid_mj.base.errors import CycloidError, UsageError
from cycloid_mj.cli.flags import FLAT, PRESET, PresetOptions, whole
from cycloid_mj.cli.terminal import tell

EXAMPLES = """Examples:
  cycloid-mj app
  cycloid-mj app --design my.toml --port 8200 --no-browser"""

PORT = 8137

PortFlag = Annotated[int, Parameter(metavar="N", converter=whole, help=f"Port on this machine. Default: {PORT}.")]
BrowserFlag = Annotated[bool, Parameter(name="--no-browser", help="Do not open the browser.")]


def app(
    chosen: Annotated[PresetOptions, FLAT] = PRESET, *, port: PortFlag = PORT, no_browser: BrowserFlag = False
) -> int:
    """Open a page with a design under sliders, solved as they move.

    The page is served on this machine alone, until Ctrl-C. It gives the design as
    TOML, its parts, its model and its data sheet, and runs it in MuJoCo. Needs
    the extra app: pip install 'cycloid-mj[app]'.
    """
    if not 1 <= port <= 65535:
        raise UsageError(f"--port {port}: give 1 to 65535")
    design = chosen.resolved()
    try:
        from cycloid_mj.app.page import serve
    except ModuleNotFoundError as error:
        if error.name not in {"nicegui", "starlette"}:
            raise
        raise CycloidError("the page needs NiceGUI: pip install 'cycloid-mj[app]'") from error
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(("127.0.0.1", port))
        except OSError as error:
            raise CycloidError(f"port {port} is taken: give another with --port") from error
    tell(f"http://127.0.0.1:{port} (Ctrl-C ends it)")
    serve(design, port, show=not no_browser)
    return 0
