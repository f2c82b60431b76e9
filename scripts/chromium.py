"""A headless Chromium, driven through the DevTools protocol."""

import base64
import json
import shutil
import subprocess
import time
import urllib.request
from math import hypot

from websockets.sync.client import connect

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")

_FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--disable-dev-shm-usage",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--mute-audio",
    "--no-first-run",
    "--disable-extensions",
    "--disable-background-networking",
    "--remote-debugging-port=0",
)


def find_chromium():
    """The browser's path, or None."""
    return next(filter(None, map(shutil.which, NAMES)), None)


class Tab:
    """A page of the browser."""

    def __init__(self, address):
        self._socket = connect(address, max_size=None, open_timeout=60)
        self._number = 0
        self.console = []
        self.call("Runtime.enable")
        self.call("Page.enable")
        self.call("Page.bringToFront")

    def call(self, method, **parameters):
        self._number += 1
        order = {"id": self._number, "method": method, "params": parameters}
        self._socket.send(json.dumps(order))
        while True:
            answer = json.loads(self._socket.recv(timeout=120))
            if answer.get("method") == "Runtime.exceptionThrown":
                self.console.append(answer["params"]["exceptionDetails"])
            if answer.get("id") == self._number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]

    def run(self, script):
        """The value of an expression in the page."""
        answer = self.call("Runtime.evaluate", expression=script, returnByValue=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(f"{script}: {answer['exceptionDetails']}")
        return answer["result"].get("value")

    def wait(self, script, timeout=120.0):
        """Wait until an expression is true."""
        end = time.monotonic() + timeout
        while time.monotonic() < end:
            if value := self.run(script):
                return value
            time.sleep(0.1)
        raise TimeoutError(f"{script} after {timeout} s; the page says: {self.text()}")

    def text(self):
        """All that can be read on the page."""
        return self.run("document.body?.innerText")

    def says(self, text, timeout=120.0):
        """Wait until a text can be read on the page."""
        return self.wait(f"document.body?.innerText?.includes({json.dumps(text)})", timeout)

    def press(self, label, timeout=60.0):
        """Press a button or a tab, once it can be."""
        self.wait(
            "(() => { const all = [...document.querySelectorAll('button')];"
            f" const one = all.find((b) => b.innerText.trim() === {json.dumps(label)});"
            " if (!one || one.disabled || one.dataset.disabled) return false;"
            " one.click(); return true; })()",
            timeout,
        )

    def tab(self, label, timeout=60.0):
        """Open a tab of the panel."""
        one = f"document.querySelector('[role=tab][title={json.dumps(label)}]')"
        self.wait(f"{one} !== null", timeout)
        left, top, width, height = self.box(one)
        self.drag(
            (left + width / 2.0, top + height / 2.0), (left + width / 2.0, top + height / 2.0)
        )
        self.wait(f"{one}.getAttribute('aria-selected') === 'true'", timeout)

    def key(self, name, code):
        """Press a key, such as ``ArrowRight``, 39."""
        for kind in ("rawKeyDown", "keyUp"):
            key = {"key": name, "code": name, "windowsVirtualKeyCode": code}
            self.call("Input.dispatchKeyEvent", type=kind, **key)

    def box(self, script):
        """Where an element is: left, top, width and height [pixels]."""
        return self.run(
            f"(() => {{ const r = ({script}).getBoundingClientRect();"
            " return [r.left, r.top, r.width, r.height]; })()"
        )

    def frames(self, number=2):
        """Wait until the page has been drawn so many times."""
        script = (
            "new Promise((done) => { requestAnimationFrame(() => done(true));"
            " setTimeout(() => done(false), 2000); })"  # a hidden tab is not drawn
        )
        for _ in range(number):
            self.call("Runtime.evaluate", expression=script, awaitPromise=True)

    def mouse(self, kind, place, **more):
        """A mouse event, ``Moved``, ``Pressed`` or ``Released``, at a point [pixels]."""
        at = {"x": float(place[0]), "y": float(place[1])}
        self.call("Input.dispatchMouseEvent", type=f"mouse{kind}", **at, **more)
        self.frames()  # what is below the mouse is found out when the scene is drawn

    def drag(self, start, end, pixels=12.0):
        """Drag the mouse from one point to another [pixels], some at a time."""
        (x, y), (to_x, to_y) = start, end
        steps = max(1, round(hypot(to_x - x, to_y - y) / pixels))
        self.mouse("Moved", start)
        self.mouse("Pressed", start, button="left", clickCount=1)
        for step in range(1, steps + 1):
            share = step / steps
            place = x + share * (to_x - x), y + share * (to_y - y)
            self.mouse("Moved", place, button="left", buttons=1)
        self.mouse("Released", end, button="left", clickCount=1)

    def settle(self, patience=3.0):
        """Wait until two pictures, some seconds apart, are the same."""
        before = None
        for _ in range(40):
            now = self.picture()
            if now == before:
                return
            before = now
            time.sleep(patience)

    def picture(self, path=None):
        """The page as PNG; what the browser says of its own graphics is closed."""
        closed = "[class*=Notification] button"
        self.run(f"document.querySelectorAll('{closed}').forEach((b) => b.click())")
        data = base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"])
        if path is not None:
            path.write_bytes(data)
        return data

    def close(self):
        self.call("Page.close")
        self._socket.close()


class Chromium:
    """The browser; its folder is removed by whoever made it."""

    def __init__(self, folder, width=1400, height=1000):
        program = find_chromium()
        assert program is not None
        command = [program, *_FLAGS, f"--user-data-dir={folder}", f"--window-size={width},{height}"]
        self._log = (folder / "chromium.log").open("wb")
        self._process = subprocess.Popen(
            [*command, "about:blank"], stdout=self._log, stderr=self._log
        )
        file, end = folder / "DevToolsActivePort", time.monotonic() + 60.0
        while not (file.is_file() and file.read_text().count("\n")):
            assert self._process.poll() is None, (folder / "chromium.log").read_text()
            assert time.monotonic() < end, "chromium does not start"
            time.sleep(0.1)
        self._port = int(file.read_text().splitlines()[0])

    def open(self, address):
        """A tab at an address."""
        request = urllib.request.Request(
            f"http://127.0.0.1:{self._port}/json/new?{address}", method="PUT"
        )
        with urllib.request.urlopen(request, timeout=60) as answer:
            return Tab(json.load(answer)["webSocketDebuggerUrl"])

    def close(self):
        self._process.terminate()
        try:
            self._process.wait(20.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._log.close()
