# SPDX-License-Identifier: MIT
"""A headless Chromium without a network, spoken to through pipes (Chrome DevTools Protocol: a JSON object and a zero byte a message)."""
import base64
import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import time

PROGRAMS = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
PATIENCE_S = 60


def program():
    """The browser that is installed; None without one (tools/setup --browser installs it)."""
    return next((path for path in map(shutil.which, PROGRAMS) if path), None)


class Browser:
    """One page. Faults: what the page logged as an error, exceptions, and requests for anything but its own file."""

    def __init__(self, width=1280, height=900):
        self.folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        to_browser, self.write = os.pipe()
        self.read, from_browser = os.pipe()

        def plumb():  # the browser reads from descriptor 3 and writes to 4; the two may be in each other's place here
            reading, writing = os.dup(to_browser), os.dup(from_browser)
            os.dup2(reading, 3)
            os.dup2(writing, 4)

        self.process = subprocess.Popen(
            [program(), "--headless", "--no-sandbox", "--disable-gpu", "--remote-debugging-pipe", "--no-first-run", "--hide-scrollbars",
             "--disable-background-networking", "--disable-component-update", "--disable-sync", "--disable-quic",
             "--force-color-profile=srgb", f"--user-data-dir={self.folder.name}", f"--window-size={width},{height}", "about:blank"],
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, close_fds=False, preexec_fn=plumb)
        os.close(to_browser)
        os.close(from_browser)
        self.last, self.waiting, self.faults, self.session = 0, b"", [], None
        target = next(t for t in self.call("Target.getTargets")["targetInfos"] if t["type"] == "page")
        self.session = self.call("Target.attachToTarget", targetId=target["targetId"], flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")
        self.call("Network.emulateNetworkConditions", offline=True, latency=0, downloadThroughput=0, uploadThroughput=0)

    def close(self):
        self.session = None
        self.call("Browser.close")
        self.process.wait(PATIENCE_S)
        os.close(self.read)
        os.close(self.write)
        self.folder.cleanup()

    def _message(self):
        while b"\0" not in self.waiting:
            data = os.read(self.read, 1 << 20)
            if not data:
                raise RuntimeError("the browser has gone")
            self.waiting += data
        message, self.waiting = self.waiting.split(b"\0", 1)
        return json.loads(message)

    def _note(self, event):
        what, about = event.get("method"), event.get("params", {})
        if what == "Runtime.exceptionThrown":
            self.faults.append(about["exceptionDetails"].get("exception", {}).get("description", about["exceptionDetails"]["text"]))
        elif what == "Runtime.consoleAPICalled" and about["type"] in ("error", "warning", "assert"):
            self.faults.append(" ".join(str(a.get("value", a.get("description"))) for a in about["args"]))
        elif what == "Log.entryAdded" and about["entry"]["level"] in ("error", "warning"):
            self.faults.append(about["entry"]["text"])
        elif what == "Network.requestWillBeSent" and not about["request"]["url"].startswith(("file:", "data:", "blob:", "about:")):
            self.faults.append("asked for " + about["request"]["url"])

    def call(self, method, **parameters):
        self.last += 1
        message = {"id": self.last, "method": method, "params": parameters} | ({"sessionId": self.session} if self.session else {})
        os.write(self.write, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._message()
            if answer.get("id") == self.last:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]
            self._note(answer)

    def ask(self, expression):
        """The value of an expression of the page; promises are waited for."""
        answer = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(answer["exceptionDetails"])
        return answer["result"].get("value")

    def wait_for(self, expression):
        end = time.monotonic() + PATIENCE_S
        while not self.ask(expression):
            if time.monotonic() > end:
                raise RuntimeError(f"never true: {expression}; {self.faults}")
            time.sleep(0.05)

    def open(self, path, dark=False):
        self.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}])
        gone = self.call("Page.navigate", url=pathlib.Path(path).resolve().as_uri()).get("errorText")
        if gone:
            raise RuntimeError(f"{path}: {gone}")
        self.wait_for("document.documentElement?.dataset.pictures === 'done'")

    def screenshot(self, path=None, clip=None):
        """PNG bytes, of the whole page or of {x, y, width, height}."""
        more = {"clip": {**clip, "scale": 1}} if clip else {}
        png = base64.b64decode(self.call("Page.captureScreenshot", captureBeyondViewport=True, **more)["data"])
        if path:
            with open(path, "wb") as file:
                file.write(png)
        return png

    def _mouse(self, kind, x, y, pressed=True):
        self.call("Input.dispatchMouseEvent", type=f"mouse{kind}", x=x, y=y, button="left" if pressed else "none",
                  buttons=1 if pressed and kind != "Released" else 0, clickCount=0 if kind == "Moved" else 1)

    def drag(self, x, y, to_x, to_y, steps=5):
        self._mouse("Moved", x, y, pressed=False)
        self._mouse("Pressed", x, y)
        for i in range(1, steps + 1):
            self._mouse("Moved", x + (to_x - x) * i / steps, y + (to_y - y) * i / steps)
        self._mouse("Released", to_x, to_y)

    def click(self, x, y):
        self._mouse("Moved", x, y, pressed=False)
        self._mouse("Pressed", x, y)
        self._mouse("Released", x, y)

    def printed(self):
        """The page on paper, PDF bytes."""
        return base64.b64decode(self.call("Page.printToPDF", printBackground=True, preferCSSPageSize=True)["data"])
