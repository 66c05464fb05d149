"""What all tests share: bounded threads, reproducible random numbers, and a lid on skips.

Shapes and types are checked by jaxtyping and beartype, switched on in pyproject.toml so that the doctests of
src/ are checked as well.
"""

import os
from collections.abc import Iterator

import hypothesis
import pytest

ALLOWED_SKIPS = 0
"""Tests that CI may skip. Raise it only together with the reason for the new skip."""

hypothesis.settings.register_profile(
    "mixlight", deadline=None, max_examples=25, derandomize=True, database=None
)
hypothesis.settings.load_profile("mixlight")


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


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    """In CI a rise of the skip count fails the run."""
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if reporter is None or "CI" not in os.environ or exitstatus != pytest.ExitCode.OK:
        return
    skipped = [str(report.longrepr) for report in reporter.stats.get("skipped", [])]
    if len(skipped) > ALLOWED_SKIPS:
        session.exitstatus = pytest.ExitCode.TESTS_FAILED
        reporter.write_line(
            f"{len(skipped)} tests skipped, {ALLOWED_SKIPS} allowed (tests/conftest.py)", red=True
        )
