"""What all tests share: the same examples in every run, and no window system."""

import gc
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager

import pytest
import typer.testing
from hypothesis import settings

from electrovib.core.budget import ONE_THREAD

os.environ.setdefault("MPLBACKEND", "Agg")
os.environ.update(ONE_THREAD | os.environ)  # for processes of `-n`, and those that tests start
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # these are hundreds: each module is compiled once
sys.dont_write_bytecode = False  # the rewritten tests too, which takes longer than to compile them
gc.disable()  # while tests are collected, of which nothing is garbage
# the same examples each time, so that a red run is red again; search for new ones with
# --hypothesis-profile=search
settings.register_profile("repeatable", deadline=None, derandomize=True, print_blob=True, max_examples=60)
settings.register_profile("search", deadline=None, print_blob=True, max_examples=1000)
settings.load_profile("repeatable")


def pytest_collection_finish(session: pytest.Session) -> None:
    """Take what was collected out of the sight of the collector of garbage, which would visit it all the time."""
    gc.freeze()
    gc.set_threshold(5000)
    gc.enable()


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: object) -> object:
    """Give each process of `-n` tests that stand together: what a module shares is made once."""
    from xdist.scheduler import WorkStealingScheduling

    return WorkStealingScheduling(config, log) if config.option.dist == "load" else None


@pytest.fixture(scope="session", autouse=True)
def _commands_built_once():
    """Build the commands of a program once, and not for each of some thousand command lines: 40 ms each."""
    kept, build = {}, typer.main.get_command

    def once(program):
        if id(program) not in kept:
            kept[id(program)] = program, build(program)
        return kept[id(program)][1]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(typer.main, "get_command", once)
        patch.setattr(typer.testing, "_get_command", once)
        yield


@pytest.fixture(scope="session")
def blank() -> Callable[[], AbstractContextManager[None]]:
    """Return a context in which nothing is drawn: tests/contract/test_figures.py draws every figure of every answer."""

    @contextmanager
    def drawing_nothing() -> Iterator[None]:
        from matplotlib.figure import Figure

        def empty(_: object) -> Figure:
            figure = Figure((1, 1))
            figure.add_subplot().set_axis_off()
            return figure

        with pytest.MonkeyPatch.context() as patch:
            for module in ("pages", "files"):
                patch.setattr(f"electrovib.view.{module}.drawn", empty)
            yield

    return drawing_nothing


@pytest.fixture
def blank_pictures(blank: Callable[[], AbstractContextManager[None]]) -> Iterator[None]:
    """Draw nothing where a test is about words and files."""
    with blank():
        yield


ALLOWED_SKIPS = ("shared/data", "device")
"""What a skip may be for where everything else is installed."""


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Iterator[None]:
    """Where CI is set a skipped test is a failure unless it misses a recording or a device."""
    report = yield
    expected = hasattr(report, "wasxfail")
    if os.environ.get("CI") and report.skipped and not expected:
        reason = report.longrepr[2] if isinstance(report.longrepr, tuple) else str(report.longrepr)
        if not any(word in reason for word in ALLOWED_SKIPS):
            report.outcome = "failed"
            report.longrepr = f"skipped where nothing may be missing: {reason}"
    return report
