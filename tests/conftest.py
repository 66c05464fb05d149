"""What all tests share: bounded threads, reproducible random numbers, and a lid on skips.

Shapes and types are checked by jaxtyping and beartype, switched on in pyproject.toml so that the doctests of
src/ are checked as well.
"""

import os
from collections.abc import Iterator

import hypothesis
import pytest

ALLOWED_SKIPS = 0
"""Tests that CI may skip. Raise it only together with the reason for the new skip. Those that need a real
consumer are not counted: CI runs them too, and there none of them may be skipped."""

INTEROP = "needs the real consumers: make test-interop"
"""Why a test marked `interop` is left out without `--interop`."""

hypothesis.settings.register_profile(
    "mixlight", deadline=None, max_examples=25, derandomize=True, database=None
)
hypothesis.settings.load_profile("mixlight")


def pytest_addoption(parser: pytest.Parser) -> None:
    """`--interop`, which `make test-interop` gives."""
    parser.addoption(
        "--interop",
        action="store_true",
        help="also run the tests that need the real consumers (tests/interop)",
    )


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out, with a reason, what needs programs that `make test` does not install."""
    if config.getoption("--interop"):
        return
    skip = pytest.mark.skip(reason=INTEROP)
    for item in items:
        if item.get_closest_marker("interop"):
            item.add_marker(skip)


@pytest.fixture(autouse=True, scope="session")
def _bounded_threads() -> Iterator[None]:
    """Two workers with two threads each would fight over two cores."""
    import torch

    before = torch.get_num_threads()
    if "PYTEST_XDIST_WORKER" in os.environ:
        torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


@pytest.fixture
def generator() -> "object":
    """A torch.Generator with a fixed seed, for tests that draw random numbers."""
    import torch

    return torch.Generator().manual_seed(2024)


@pytest.fixture
def unchecked() -> Iterator[None]:
    """Shape checks switched off, as users have them: then our own errors must catch the nonsense."""
    import jaxtyping

    jaxtyping.config.update("jaxtyping_disable", True)
    yield
    jaxtyping.config.update("jaxtyping_disable", False)


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    """In CI a rise of the skip count fails the run; with `--interop` any skip does, as all must be there."""
    interop = bool(session.config.getoption("--interop"))
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if reporter is None or exitstatus != pytest.ExitCode.OK or not (interop or "CI" in os.environ):
        return
    skipped = [str(report.longrepr) for report in reporter.stats.get("skipped", [])]
    counted = [reason for reason in skipped if interop or INTEROP not in reason]
    allowed = 0 if interop else ALLOWED_SKIPS
    if len(counted) > allowed:
        session.exitstatus = pytest.ExitCode.TESTS_FAILED
        reporter.write_line(f"{len(counted)} tests skipped, {allowed} allowed (tests/conftest.py)", red=True)
