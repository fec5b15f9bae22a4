"""A server of the page in a process of its own, and a browser of the machine."""

import os
import re
import shutil
import subprocess
import sys
import time
import urllib.error
import urllib.request

import pytest

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
QUIET = ("--disable-gpu", "--disable-background-networking", "--disable-component-update", "--disable-sync")
ARGUMENTS = ("--no-sandbox", "--no-first-run", *QUIET)  # the first is required as root
WAIT = 30_000
"""Longest wait for anything on the page [ms]."""
WINDOW = {"width": 1500, "height": 1000}
EXPLORE = """
from electrovib.apps.explorer.server import explore
explore(browser=False, say=lambda words: print(words, flush=True))
"""
"""What a server does that has code of its own before."""


class Server:
    """The command, serving on loopback until it is stopped."""

    def __init__(self, *arguments, folder, code="", place=None, **settings):
        self.folder, self.log = folder, folder.parent / f"{folder.name}.log"
        kept = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST")}
        own = {"TMPDIR": str(folder), "OMP_NUM_THREADS": "1", "PYTHONPATH": os.pathsep.join(sys.path)}
        command = ["-c", code + EXPLORE] if code else ["-m", "electrovib", "explore", "--no-browser"]
        with self.log.open("w") as errors:
            self.process = subprocess.Popen(
                [sys.executable, "-u", *command, *arguments],
                stdout=subprocess.PIPE,
                stderr=errors,
                text=True,
                env=kept | own | settings,
                cwd=place,
            )
        line = next(each for each in iter(self.process.stdout.readline, "") if "http://" in each)
        self.address = re.search(r"http://\S+", line)[0]
        self.port = int(re.search(r":(\d+)/", self.address)[1])

    def stop(self):
        """End the server, and return what it wrote on its error output."""
        self.process.terminate()
        self.process.wait(20)
        self.process.stdout.close()
        return self.log.read_text()


def started(factory, name, *arguments, **settings):
    """Start a server, and wait until it answers."""
    server = Server(*arguments, folder=factory.mktemp(name), **settings)
    for _ in range(300):
        try:
            urllib.request.urlopen(f"http://127.0.0.1:{server.port}/", timeout=5).close()
        except urllib.error.HTTPError:
            break
        except OSError:
            time.sleep(0.1)
        else:
            break
    return server


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    found = started(tmp_path_factory, "server")
    yield found
    log = found.stop()
    assert "electrovib/apps" not in log, log  # the framework itself logs connections that end early


@pytest.fixture(scope="module")  # its event loop would be in the way of other tests
def browser():
    if CHROMIUM is None:
        pytest.skip("no chromium on this machine: Debian's package has it")
    playwright = pytest.importorskip("playwright.sync_api")
    with playwright.sync_playwright() as running:
        found = running.chromium.launch(executable_path=CHROMIUM, args=list(ARGUMENTS))
        yield found
        found.close()


@pytest.fixture
def opened(browser, server):
    """Open a page in a new window; every message of an error on its console fails the test."""
    contexts, errors = [], []

    def noted(message):
        if message.type == "error":
            errors.append(f"{message.text} {message.location}")

    def open_page(query="", *, port=server.port, **options):
        contexts.append(browser.new_context(**{"viewport": WINDOW} | options))
        page = contexts[-1].new_page()
        page.set_default_timeout(WAIT)
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.on("console", noted)
        page.goto(f"http://127.0.0.1:{port}/{query}")
        page.wait_for_selector(".js-plotly-plot .main-svg")
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert errors == []
