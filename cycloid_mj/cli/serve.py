"""``cycloid-mj app``: the designer's page in the browser."""

from typing import Annotated

from cyclopts import Parameter

from cycloid_mj.base.errors import UsageError
from cycloid_mj.cli.flags import FLAT, PRESET, PresetOptions, QuietFlag, integer_flag
from cycloid_mj.cli.terminal import tell

EXAMPLES = """Examples:
  cycloid-mj app
  cycloid-mj app --design my.toml --port 8200 --no-browser"""

PORT = 8137
"""Default port of the page (arbitrary)."""

PortFlag = Annotated[int, integer_flag(f"Port on this computer. Default: {PORT}.")]
BrowserFlag = Annotated[bool, Parameter(name="--no-browser", help="Do not open a browser.")]


def app(
    design_options: Annotated[PresetOptions, FLAT] = PRESET,
    *,
    port: PortFlag = PORT,
    no_browser: BrowserFlag = False,
    _quiet: QuietFlag = False,
) -> int:
    """Open the browser app: from requirements to a finished design.

    Enter requirements to get drives that meet them, or the maximum and alternatives. Change the design with sliders;
    it is drawn, checked and solved immediately: forces, transmission error, losses, life, tolerances, stress and parts
    in 3-D. Simulate it in MuJoCo and download its files. The page is served on this computer only, until Ctrl-C.
    """
    if not 1 <= port <= 65535:
        raise UsageError(f"--port {port} is out of range: give a number from 1 to 65535")
    design = design_options.resolve()
    from cycloid_mj.app.server import new_token, open_socket, page_address, serve

    token = new_token()
    with open_socket(port) as listener:
        tell(f"open {page_address(listener, token)} in a browser (stop with Ctrl-C)")
        serve(design, listener, token, show=not no_browser)
    return 0
