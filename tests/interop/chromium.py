"""A headless Chromium driven from Python: pages that run a script and give back what it returns.

The DevTools protocol goes through a pair of pipes, so that neither a driver package nor an open port is
needed.
WebGL 2 comes from SwiftShader, which renders on the processor: the same pixels on every machine.
"""

from __future__ import annotations

import base64
import contextlib
import json
import os
import shutil
import subprocess
import tempfile
import threading
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from queue import Empty, Queue
from typing import Any

FLAGS = (
    "--headless=new",
    "--no-sandbox",  # containers offer no user namespaces; the only pages are our own
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-dev-shm-usage",
    "--no-first-run",
    "--disable-extensions",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-features=SpareRendererForSitePerProcess,Translate,OptimizationHints,MediaRouter",
    "--renderer-process-limit=1",  # all pages are of one origin: opening one costs no process
    "--disable-breakpad",
    "--force-color-profile=srgb",
    "--force-device-scale-factor=1",
    "--hide-scrollbars",
    # No name resolves: nothing a page asks for can leave the machine.
    "--host-resolver-rules=MAP * ~NOTFOUND , EXCLUDE 127.0.0.1",
)
PATIENCE = 300.0
"""Seconds to wait for an answer: what takes two on an idle machine may take a hundred on a loaded one."""

NAMES = ("chromium", "chromium-browser", "google-chrome")


def find_chromium() -> str:
    """The program to start: $MIXLIGHT_CHROMIUM, else the first of the usual names on PATH."""
    named = os.environ.get("MIXLIGHT_CHROMIUM")
    if named and not shutil.which(named):
        raise RuntimeError(f"MIXLIGHT_CHROMIUM: expected a program, received {named!r}")
    found = named or next(filter(None, map(shutil.which, NAMES)), None)
    if not found:
        raise RuntimeError(
            f"expected one of {', '.join(NAMES)} on PATH, found none: `apt-get install chromium`, or name "
            "the program in MIXLIGHT_CHROMIUM"
        )
    return found


class PageError(RuntimeError):
    """What a page threw, or wrote to its console as an error or as a warning of a library."""


class Chromium:
    """One browser process; `page` opens pages in it."""

    def __init__(self, program: str) -> None:
        self._profile = tempfile.TemporaryDirectory(prefix="mixlight-chromium-", ignore_cleanup_errors=True)
        to_browser, self._write = os.pipe()
        self._read, from_browser = os.pipe()

        # Chromium talks on the descriptors 3 and 4, which only a shell can put in place without a fork hook.
        command = f'exec "$0" "$@" 3<&{to_browser} 4>&{from_browser}'
        self._log = Path(self._profile.name) / "log.txt"
        with open(self._log, "wb") as log:
            self._process = subprocess.Popen(
                [
                    *("/bin/bash", "-c", command, program, *FLAGS),
                    *(f"--user-data-dir={self._profile.name}", "--remote-debugging-pipe", "about:blank"),
                ],
                pass_fds=(to_browser, from_browser),
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                start_new_session=True,
            )
        os.close(to_browser)
        os.close(from_browser)
        self._lock = threading.Lock()
        self._number = 0
        self._answers: dict[int, Queue[dict[str, Any]]] = {}
        self._pages: dict[str, Page] = {}
        self._reader = threading.Thread(target=self._listen, name="chromium", daemon=True)
        self._reader.start()
        try:
            self.version: str = self.call("Browser.getVersion")["product"]
        except BaseException:
            self.close()
            raise

    def call(
        self,
        method: str,
        parameters: Mapping[str, Any] | None = None,
        session: str | None = None,
        timeout: float = PATIENCE,
    ) -> dict[str, Any]:
        """Send one command of the DevTools protocol and wait for its result."""
        answer: Queue[dict[str, Any]] = Queue()
        with self._lock:
            self._number += 1
            number = self._number
            self._answers[number] = answer
            message = {"id": number, "method": method, "params": dict(parameters or {})}
            if session:
                message["sessionId"] = session
            data = json.dumps(message).encode() + b"\0"
            try:
                while data:
                    data = data[os.write(self._write, data) :]
            except BrokenPipeError:
                raise RuntimeError(f"Chromium is gone: {self._last_words()}") from None
        try:
            found = answer.get(timeout=timeout)
        except Empty:
            raise TimeoutError(
                f"{method}: expected an answer within {timeout:g} s: {self._last_words()}"
            ) from None
        finally:
            self._answers.pop(number, None)
        if "error" in found:
            raise RuntimeError(f"{method}: {found['error'].get('message')}")
        result: dict[str, Any] = found["result"]
        return result

    @contextlib.contextmanager
    def page(self, url: str, width: int = 256, height: int = 256) -> Iterator[Page]:
        """A page of its own, closed at the end; nothing is left for the next one but the browser's cache."""
        target = self.call("Target.createTarget", {"url": "about:blank"})["targetId"]
        session = self.call("Target.attachToTarget", {"targetId": target, "flatten": True})["sessionId"]
        page = Page(self, session)
        self._pages[session] = page
        try:
            page.open(url, width, height)
            yield page
        finally:
            self._pages.pop(session, None)
            with contextlib.suppress(RuntimeError, TimeoutError):
                self.call("Target.closeTarget", {"targetId": target}, timeout=10)

    def close(self) -> None:
        """End the process and forget its profile."""
        if self._process.poll() is None:
            with contextlib.suppress(RuntimeError, TimeoutError):
                self.call("Browser.close", timeout=5)
            try:
                self._process.wait(10)
            except subprocess.TimeoutExpired:
                os.killpg(self._process.pid, 9)
                self._process.wait()
        with contextlib.suppress(OSError):
            os.close(self._write)
        self._reader.join(10)
        self._profile.cleanup()

    def _listen(self) -> None:
        """Hand out what the browser says, until it hangs up."""
        rest = b""
        with open(self._read, "rb", buffering=0) as pipe:
            while data := pipe.read(1 << 20):
                *whole, rest = (rest + data).split(b"\0")
                for text in whole:
                    message = json.loads(text)
                    waiting = self._answers.get(message.get("id", -1))
                    if waiting is not None:
                        waiting.put(message)
                    elif page := self._pages.get(message.get("sessionId", "")):
                        page.note(message["method"], message["params"])
        gone = {"error": {"message": f"Chromium is gone: {self._last_words()}"}}
        for waiting in list(self._answers.values()):
            waiting.put(gone)

    def _last_words(self) -> str:
        try:
            return self._log.read_text(errors="replace")[-600:].strip() or "it said nothing"
        except OSError:
            return "it said nothing"


class Page:
    """One page: `call` runs a function in it, `screenshot` shows it."""

    def __init__(self, browser: Chromium, session: str) -> None:
        self._browser = browser
        self._session = session
        self._loaded = threading.Event()
        self.requests: list[str] = []
        """URLs that the page asked for."""
        self.problems: list[str] = []
        """What it threw, and what it or a library complained about."""

    def open(self, url: str, width: int, height: int) -> None:
        """Load a URL and wait for it."""
        for domain in ("Runtime", "Page", "Network", "Log"):
            self._call(f"{domain}.enable")
        self._call(
            "Emulation.setDeviceMetricsOverride",
            {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False},
        )
        found = self._call("Page.navigate", {"url": url})
        if "errorText" in found or not self._loaded.wait(PATIENCE):
            raise PageError(f"{url}: {found.get('errorText', 'not loaded in time')}")

    def call(self, function: str, *arguments: object, timeout: float = PATIENCE) -> Any:
        """The awaited result, as JSON, of a JavaScript function expression applied to JSON arguments.

        Raises:
            PageError: it threw, or the page complained meanwhile.
        """
        words = ", ".join(json.dumps(argument) for argument in arguments)
        found = self._call(
            "Runtime.evaluate",
            {
                "expression": f"({function})({words})",
                "awaitPromise": True,
                "returnByValue": True,
                "userGesture": True,
            },
            timeout,
        )
        if "exceptionDetails" in found:
            details = found["exceptionDetails"]
            thrown = details.get("exception", {})
            raise PageError(thrown.get("description") or str(thrown.get("value", details["text"])))
        self.check()
        return found["result"].get("value")

    def wait_for(self, expression: str, timeout: float = PATIENCE) -> Any:
        """The first truthy value of an expression.

        Raises:
            PageError: the page complained meanwhile.
            TimeoutError: it stayed falsy.
        """
        end = time.monotonic() + timeout
        while time.monotonic() < end:
            if value := self.call(f"() => {expression}"):
                return value
            time.sleep(0.05)
        raise TimeoutError(f"{expression}: expected a value within {timeout:g} s")

    def screenshot(self) -> bytes:
        """The page as a PNG file, as a person would see it."""
        return base64.b64decode(self._call("Page.captureScreenshot", {"format": "png"})["data"])

    def check(self) -> None:
        """Raise `PageError` for what the page complained about so far."""
        if self.problems:
            problems, self.problems = self.problems, []
            raise PageError("\n".join(problems))

    def note(self, method: str, parameters: Mapping[str, Any]) -> None:
        """Take an event in; called from the thread that listens."""
        if method == "Page.loadEventFired":
            self._loaded.set()
        elif method == "Network.requestWillBeSent":
            self.requests.append(parameters["request"]["url"])
        elif method == "Runtime.exceptionThrown":
            details = parameters["exceptionDetails"]
            self.problems.append(details.get("exception", {}).get("description") or details["text"])
        elif method == "Runtime.consoleAPICalled":
            words = [str(word.get("value", word.get("description"))) for word in parameters["args"]]
            if parameters["type"] in ("error", "warning", "assert"):
                self.problems.append(f"console.{parameters['type']}: {' '.join(words)}")
        elif method == "Log.entryAdded" and parameters["entry"]["level"] == "error":
            entry = parameters["entry"]
            self.problems.append(f"{entry['text']} {entry.get('url', '')}")

    def _call(
        self, method: str, parameters: Mapping[str, Any] | None = None, timeout: float = PATIENCE
    ) -> dict[str, Any]:
        return self._browser.call(method, parameters, self._session, timeout)
