"""The harness itself: what goes wrong in a page is seen, and nothing leaves the machine."""

import json
import urllib.error
import urllib.request
from pathlib import Path

import numpy as np
import pytest

from tests.interop.chromium import PageError
from tests.interop.web import FOLDER, Web, pack

pytestmark = pytest.mark.interop


def test_arrays_go_there_and_back(web: Web) -> None:
    arrays = [np.arange(6, dtype=dtype).reshape(2, 3) for dtype in ("float32", "float64", "uint8", "int64")]
    script = """
        import { pack, unpack } from 'harness';
        export default ({ arrays }) => arrays.map((array) => pack(unpack(array), array.shape));
    """
    for sent, received in zip(arrays, web.run(script, arrays=[pack(array) for array in arrays]), strict=True):
        assert received.dtype.itemsize == sent.dtype.itemsize
        np.testing.assert_array_equal(received, sent)


@pytest.mark.parametrize(
    ("script", "complaint"),
    [
        ("export default () => { throw new Error('too dark'); };", "too dark"),
        ("export default async () => Promise.reject(new Error('too late'));", "too late"),
        ("export default () => console.error('broken');", "console.error: broken"),
        ("export default () => console.warn('deprecated');", "console.warning: deprecated"),
        ("import nothing from 'no-such-package'; export default () => 1;", "no-such-package"),
        ("export default () => {", "SyntaxError"),
        ("export default async () => (await fetch('https://example.com/')).status;", "Failed to fetch"),
    ],
)
def test_a_page_that_fails_fails_its_test(web: Web, script: str, complaint: str) -> None:
    with pytest.raises(PageError, match=complaint):
        web.run(script)


def test_a_page_that_never_ends_is_given_up_and_the_next_one_runs(web: Web) -> None:
    with pytest.raises(TimeoutError, match=r"within 0\.5 s"):
        web.run("export default () => new Promise(() => {});", timeout=0.5)
    assert web.run("export default ({ a }) => a + 1;", a=1) == 2


def test_the_server_shows_what_was_mounted_and_nothing_else(web: Web, tmp_path: Path) -> None:
    (tmp_path / "shown").mkdir()
    (tmp_path / "shown/a.json").write_text("1")
    (tmp_path / "hidden.json").write_text("2")
    script = (
        "export default async ({ files }) => ({ files, text: await (await fetch(`${files}a.json`)).text() });"
    )
    found = web.run(script, files=tmp_path / "shown")
    assert found["text"] == "1"
    for path in (
        "/test-1/a.json",
        found["files"] + "a.json",
        "/lib/../test_web.py",
        "/lib/%2e%2e/test_web.py",
    ):
        with pytest.raises(urllib.error.HTTPError, match="404"):
            urllib.request.urlopen(web.origin + path, timeout=10)


def test_the_lock_file_is_whole_and_names_no_host() -> None:
    text = (FOLDER / "package-lock.json").read_text(encoding="utf-8")
    wanted = json.loads((FOLDER / "package.json").read_text(encoding="utf-8"))["dependencies"]
    packages = {name: entry for name, entry in json.loads(text)["packages"].items() if name}
    assert "://" not in text
    assert all(entry["integrity"].startswith("sha512-") for entry in packages.values())
    assert {name: packages[f"node_modules/{name}"]["version"] for name in wanted} == wanted
