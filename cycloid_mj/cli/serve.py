"""``cycloid-mj app``: the designer's page in the browser."""

from typing import Annotated

from cyclopts import Parameter

from cycloid_mj.base.errors import UsageError
from cycloid_mj.cli.flags import FLAT, PRESET, PresetOptions, QuietFlag, whole
from cycloid_mj.cli.terminal import tell

EXAMPLES = """Examples:
  cycloid-mj app
  cycloid-mj app --design my.toml --port 8200 --no-browser"""

PORT = 8137

PortFlag = Annotated[int, Parameter(metavar="N", converter=whole, help=f"Port on this machine. Default: {PORT}.")]
BrowserFlag = Annotated[bool, Parameter(name="--no-browser", help="Do not open the browser.")]


def app(
    chosen: Annotated[PresetOptions, FLAT] = PRESET,
    *,
    port: PortFlag = PORT,
    no_browser: BrowserFlag = False,
    _quiet: QuietFlag = False,
) -> int:
    """Design a drive on a page in the browser.

    It asks what the drive is to do and shows drives that do it, or the most that
    goes and ways out; then the design under sliders, drawn, checked and solved as
    they move, with its forces, transmission error, losses, life, tolerances,
    stress and its parts in 3-D. It runs the design in MuJoCo and gives its files.
    The page is served on this machine alone, until Ctrl-C.
    """
    if not 1 <= port <= 65535:
        raise UsageError(f"--port {port}: give 1 to 65535")
    design = chosen.resolved()
    from cycloid_mj.app.server import new_token, open_socket, page_address, serve

    token = new_token()
    with open_socket(port) as listener:
        tell(f"{page_address(listener, token)} (stop with Ctrl-C)")
        serve(design, listener, token, show=not no_browser)
    return 0
