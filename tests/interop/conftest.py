"""Fixtures of the tests that run real consumers."""

from collections.abc import Iterator

import pytest

from tests.interop.web import Web


@pytest.fixture(scope="session")
def web() -> Iterator[Web]:
    """Chromium with three.js, gltf-validator and the like: one process for all tests."""
    web = Web()
    yield web
    web.close()
