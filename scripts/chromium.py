"""Drive Chromium by its own protocol (DevTools), with nothing between: pages, keys, the mouse, screenshots."""

import base64
import itertools
import json
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

from websocket import WebSocketTimeoutException, create_connection

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")

FLAGS = (
    *("--headless=new", "--no-sandbox", "--hide-scrollbars", "--no-first-run", "--enable-unsafe-swiftshader"),
    *("--use-angle=swiftshader", "--remote-debugging-port=0", "--remote-allow-origins=*", "--disable-dev-shm-usage"),
)

ARROWS = {"ArrowLeft": 37, "ArrowRight": 39, "ArrowUp": 38, "ArrowDown": 40}
KEYS = {"Enter": 13, "Tab": 9, "Escape": 27, "Home": 36, "End": 35, " ": 32, **ARROWS}


class Tab:
    """A page of the browser: what its console says of errors is kept in `errors`."""

    def __init__(self, address: str) -> None:
        self._socket = create_connection(address, timeout=60)
        self._numbers = itertools.count(1)
        self.errors: list[str] = []
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.send(f"{domain}.enable")

    def send(self, method: str, **values: Any) -> Any:
        """Send a command of the DevTools protocol to the browser, and return the result."""
        number = next(self._numbers)
        self._socket.send(json.dumps({"id": number, "method": method, "params": values}))
        while True:
            answer = json.loads(self._socket.recv())
            if answer.get("id") == number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']['message']}")
                return answer["result"]
            self._hear(answer)

    def _hear(self, answer: dict[str, Any]) -> None:
        values = answer.get("params", {})
        if answer.get("method") == "Runtime.exceptionThrown":
            details = values["exceptionDetails"]
            self.errors.append(details.get("exception", {}).get("description", details["text"]))
        elif answer.get("method") == "Log.entryAdded" and values["entry"]["level"] == "error":
            self.errors.append(f"{values['entry']['text']} {values['entry'].get('url', '')}")

    def run(self, script: str) -> Any:
        """Run JavaScript on the page and return its value, after its promises are fulfilled."""
        answer = self.send("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(answer["exceptionDetails"].get("exception", {}).get("description", script))
        return answer["result"].get("value")

    def go(self, address: str) -> None:
        """Open an address."""
        self.send("Page.navigate", url=address)
        self.wait("document.readyState === 'complete'", "the page is there")

    def screen(self, width: int, height: int, scheme: str = "light") -> None:
        """Set the size of the screen, and whether it is light or dark."""
        self.send("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)
        self.send("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])

    def wait(self, script: str, what: str, seconds: float = 240.0) -> None:
        """Wait until the value of a script is true, for example an element that is there.

        Raise TimeoutError with the text `what` if it is not true after a duration [s].
        """
        for _ in range(int(seconds / 0.1)):
            if self.run(f"!!({script})"):
                return
            time.sleep(0.1)
        raise TimeoutError(f"{what}: not within {seconds:g} s")

    def click(self, selector: str, word: str = "") -> None:
        """Click in the middle of the first visible element that matches a CSS selector and contains a word."""
        find = (
            f"[...document.querySelectorAll({json.dumps(selector)})].find(e => e.offsetParent !== null "
            f"&& e.innerText.includes({json.dumps(word)}))"
        )
        self.wait(f"!!{find}", f"{selector} {word} is there")
        x, y = self._middle(find)
        for kind in ("mousePressed", "mouseReleased"):
            self.send("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)

    def _middle(self, element: str) -> list[float]:
        """Scroll an element onto the screen and return its middle [px], once the page has settled."""
        place: list[float] = self.run(
            f"(async e => {{ e.scrollIntoView({{block: 'center'}}); "
            "for (let frame = 0; frame < 3; frame += 1) await new Promise(requestAnimationFrame); "
            f"const b = e.getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]; }})({element})"
        )
        return place

    def drag(self, selector: str, distance: float) -> None:
        """Drag from the middle of an element to the side, by so many pixels."""
        x, y = self._middle(f"document.querySelector({json.dumps(selector)})")
        steps = [("mousePressed", x), *(("mouseMoved", x + distance * share / 8) for share in range(1, 9))]
        for kind, at in (*steps, ("mouseReleased", x + distance)):
            self.send("Input.dispatchMouseEvent", type=kind, x=at, y=y, button="left", clickCount=1)

    def key(self, key: str, modifiers: int = 0) -> None:
        """Press a key; 2 among the modifiers is Ctrl, 8 is Shift."""
        code = KEYS.get(key, ord(key[0].upper()))
        text = {"Enter": "\r", " ": " "}.get(key, key if len(key) == 1 and not modifiers & 2 else "")
        words = {"key": key, "windowsVirtualKeyCode": code, "modifiers": modifiers}
        self.send("Input.dispatchKeyEvent", type="keyDown" if text else "rawKeyDown", text=text, **words)
        self.send("Input.dispatchKeyEvent", type="keyUp", **words)

    def type(self, text: str) -> None:
        """Type into what has the focus, over what is selected."""
        self.send("Input.insertText", text=text)

    def picture(self, file: Path) -> None:
        """Write what the screen shows as PNG."""
        file.write_bytes(base64.b64decode(self.send("Page.captureScreenshot")["data"]))

    def listen(self, seconds: float) -> None:
        """Receive events of the browser for a duration [s], and record errors of the page."""
        end = time.monotonic() + seconds
        try:
            while (left := end - time.monotonic()) > 0.0:
                self._socket.settimeout(left)
                self._hear(json.loads(self._socket.recv()))
        except WebSocketTimeoutException:
            pass
        finally:
            self._socket.settimeout(60)

    def close(self) -> None:
        """Close the connection."""
        self._socket.close()


@contextmanager
def tab(downloads: Path | None = None) -> Iterator[Tab]:
    """Start a browser without a window, and yield its page; downloads are saved in a folder."""
    if CHROMIUM is None:
        raise FileNotFoundError("needs Chromium (Debian: chromium)")
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        command = [CHROMIUM, *FLAGS, f"--user-data-dir={profile}", "about:blank"]
        with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as browser:
            try:
                page = Tab(_address(Path(profile) / "DevToolsActivePort", lambda: browser.poll() is None))
                with closing(page):
                    if downloads:
                        page.send("Page.setDownloadBehavior", behavior="allow", downloadPath=str(downloads))
                    yield page
            finally:
                browser.terminate()


def _address(answer: Path, lives: Callable[[], bool]) -> str:
    """Wait for the address of the browser's first page and return it; raise RuntimeError if the browser ends."""
    from urllib.request import urlopen

    for _ in range(600):
        if answer.exists() and (lines := answer.read_text().split()):
            with urlopen(f"http://127.0.0.1:{lines[0]}/json") as listed:
                pages = [one for one in json.load(listed) if one["type"] == "page"]
            if pages:
                return str(pages[0]["webSocketDebuggerUrl"])
        if not lives():
            break
        time.sleep(0.1)
    raise RuntimeError("Chromium did not start")
