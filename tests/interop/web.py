"""The web's consumers for tests: scripts that run in Chromium beside three.js and its like.

`Web.run` is what most tests want. A script is an ES module whose default export is given one object::

    import * as THREE from 'three';
    export default async ({ files, ...arguments }) => ({ revision: THREE.REVISION });

Bare names in imports are those of `web/blank.html`; `harness` is `web/harness.js`, whose `pack` takes typed
arrays to Python as NumPy arrays.
"""

from __future__ import annotations

import base64
import functools
import io
import re
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

import numpy as np
from numpy.typing import NDArray

from tests.interop.chromium import PATIENCE, Chromium, Page, find_chromium

FOLDER = Path(__file__).with_name("web")


class Web:
    """A Chromium, and a loopback server that shows it the Node packages, a test's script and its files."""

    def __init__(self) -> None:
        if not (FOLDER / "node_modules/.package-lock.json").is_file():
            raise RuntimeError(
                f"expected the Node packages of {FOLDER.name}/package-lock.json, found none: "
                f"`npm ci` in tests/interop/web, or `make test-interop`"
            )
        self._mounts: dict[str, Path] = {"node_modules": FOLDER / "node_modules", "lib": FOLDER}
        self._texts: dict[str, str] = {}
        handler = functools.partial(_Handler, self._mounts, self._texts)
        self._server = ThreadingHTTPServer(("127.0.0.1", 0), handler)
        threading.Thread(target=self._server.serve_forever, name="web", daemon=True).start()
        self.origin = f"http://127.0.0.1:{self._server.server_port}"
        self._count = 0
        try:
            self.browser = Chromium(find_chromium())
        except BaseException:
            self._stop()
            raise

    def run(
        self, script: str, *, files: Path | None = None, timeout: float = PATIENCE, **arguments: object
    ) -> Any:
        """What a script's default export returns, arrays and all.

        Args:
            script: the text of an ES module, or the name of one in `web/`.
            files: a folder that the script finds under the URL `files`, which ends in a slash.
            timeout: seconds.
            **arguments: JSON; the script's other arguments.

        Raises:
            PageError: the script threw, or something complained on the console.
        """
        name = self._name()
        if re.fullmatch(r"[\w-]+\.js", script):
            module = f"/lib/{script}"
        else:
            module = f"/texts/{name}.js"
            self._texts[f"{name}.js"] = script
        with self._mounted(files) as url, self.page("/lib/blank.html") as page:
            function = "async (module, args) => (await import(module)).default(args)"
            return unpack(page.call(function, module, {**arguments, "files": url}, timeout=timeout))

    @contextmanager
    def page(self, path: str, width: int = 256, height: int = 256) -> Iterator[Page]:
        """A page of the server."""
        with self.browser.page(self.origin + path, width, height) as page:
            yield page

    def show(
        self, folder: Path, name: str = "index.html", *, ready: str, width: int = 640, height: int = 360
    ) -> tuple[NDArray[np.uint8], list[str]]:
        """A folder's own page as a person sees it, once the expression `ready` is true.

        The folder's `node_modules` are those of the tests, as if `npm install` had been run in it.

        Returns:
            The picture [height, width, 3], and the URLs that the page asked for.
        """
        with self._mounted(folder) as url, self.page(url + name, width, height) as page:
            page.wait_for(ready)
            pixels = decode_png(page.screenshot())
            page.check()
            return pixels, list(page.requests)

    def close(self) -> None:
        """End browser and server."""
        self.browser.close()
        self._stop()

    def _stop(self) -> None:
        self._server.shutdown()
        self._server.server_close()

    def _name(self) -> str:
        self._count += 1
        return f"test-{self._count}"

    @contextmanager
    def _mounted(self, folder: Path | None) -> Iterator[str]:
        if folder is None:
            yield ""
            return
        name = self._name()
        self._mounts[name] = folder
        try:
            yield f"/{name}/"
        finally:
            del self._mounts[name]


class _Handler(SimpleHTTPRequestHandler):
    """Files of the mounted folders, and texts from memory."""

    extensions_map = {  # noqa: RUF012 - the base class's name
        "": "application/octet-stream",
        ".html": "text/html; charset=utf-8",
        ".js": "text/javascript; charset=utf-8",
        ".mjs": "text/javascript; charset=utf-8",
        ".json": "application/json",
        ".gltf": "model/gltf+json",
        ".wasm": "application/wasm",
        ".png": "image/png",
    }

    def __init__(self, mounts: dict[str, Path], texts: dict[str, str], *arguments: Any) -> None:
        self._mounts, self._texts = mounts, texts
        super().__init__(*arguments)

    def do_GET(self) -> None:
        path = urlsplit(self.path).path
        if path == "/favicon.ico":
            self.send_response(204)
            self.end_headers()
        elif path.startswith("/texts/"):
            text = self._texts.get(path.removeprefix("/texts/"))
            if text is None:
                self.send_error(404)
                return
            data = text.encode()
            self.send_response(200)
            self.send_header("Content-Type", "text/javascript; charset=utf-8")
            self.send_header("Content-Length", str(len(data)))
            self.end_headers()
            self.wfile.write(data)
        else:
            super().do_GET()

    def translate_path(self, path: str) -> str:
        """The file of a URL path; one that is not there where the path leads out of its folder."""
        mount, _, rest = unquote(urlsplit(path).path).lstrip("/").partition("/")
        if rest.startswith("node_modules/"):
            mount, _, rest = rest.partition("/")
        folder = self._mounts.get(mount)
        inside = folder is not None and ".." not in rest.split("/")
        return str(folder / rest) if folder is not None and inside else str(FOLDER / "no such file")

    def end_headers(self) -> None:
        # The folder of one test must not be shown to the next; and WASM threads want an isolated origin.
        self.send_header("Cache-Control", "max-age=3600" if "/node_modules/" in self.path else "no-store")
        self.send_header("Cross-Origin-Opener-Policy", "same-origin")
        self.send_header("Cross-Origin-Embedder-Policy", "require-corp")
        super().end_headers()

    def log_message(self, *arguments: Any) -> None:
        """Stay quiet."""


def unpack(value: Any) -> Any:
    """JSON with the arrays of harness.js's `pack` turned into NumPy's."""
    if isinstance(value, list):
        return [unpack(entry) for entry in value]
    if not isinstance(value, dict):
        return value
    if value.keys() == {"dtype", "shape", "base64"}:
        data = base64.b64decode(value["base64"])
        return np.frombuffer(data, np.dtype(value["dtype"])).reshape(value["shape"]).copy()
    return {key: unpack(entry) for key, entry in value.items()}


def pack(array: NDArray[Any]) -> dict[str, Any]:
    """An array as an argument for a script, where harness.js's `unpack` makes a typed array of it."""
    data = np.ascontiguousarray(array)
    return {
        "dtype": data.dtype.name,
        "shape": list(data.shape),
        "base64": base64.b64encode(data.tobytes()).decode(),
    }


def decode_png(data: bytes) -> NDArray[np.uint8]:
    """A PNG file as [height, width, 3]."""
    from PIL import Image

    with Image.open(io.BytesIO(data)) as image:
        return np.asarray(image.convert("RGB"))
