"""The page in the browser: time from a slider to the plots, the work of the server, and its memory.

Run from the root of the repository with ``python -m benchmarks.explorer``; it needs the extra ``dev`` and chromium.
"""

import asyncio
import json
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections.abc import AsyncIterator, Callable
from contextlib import AsyncExitStack, asynccontextmanager
from pathlib import Path
from statistics import median
from typing import Any

from benchmarks.explorer_visitor import MovingVisitor
from benchmarks.table import surroundings, write

VISITORS = 5
PACE, SECONDS = 4.0, 30.0
"""Moves of each visitor per second, and for how long."""
FLOOD, FLOODED = 20.0, 10.0
"""The same for sliders that are moved without a pause: the page sends each 20 times per second at most."""
UPDATES, WARM = 10_000, 1_000
"""Updates between which memory is compared, and those before, while caches fill."""
PRESSES = 80
OPENED = 12
"""Times that the page is opened."""
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
ARGUMENTS = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-background-networking",
    "--disable-component-update",
    "--no-first-run",
)
COUNT_PLOTS = """() => {
  window.moved = {begin: 0, last: 0, figures: 0}
  document.addEventListener('keydown', () => {
    window.moved = {begin: performance.now(), last: performance.now(), figures: 0}
  }, true)
  const line = document.querySelector('.ev-key')
  if (line) new MutationObserver(() => { window.moved.figures ||= performance.now() }).observe(
    line, {subtree: true, childList: true, characterData: true})
  for (const plot of document.querySelectorAll('.js-plotly-plot'))
    plot.on('plotly_afterplot', () => { if (plot.offsetParent !== null) window.moved.last = performance.now() })
}"""
"""Note the time of a key, and those at which the last visible plot has been drawn and the first key figure changed after it."""
CURVE = ".js-plotly-plot .scatterlayer path.js-line"


class Server:
    """The server in a process of its own."""

    def __init__(self, folder: Path) -> None:
        self.file, begin = folder / "times.json", time.perf_counter()
        self.process = subprocess.Popen(
            [sys.executable, "-m", "benchmarks.explorer_server", str(self.file)],
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        self.address = re.search(r"http://[^/]+", self.process.stdout.readline())[0]
        self.port = int(self.address.rsplit(":", 1)[1])
        self._wait()
        self.start = time.perf_counter() - begin

    def _wait(self) -> None:
        """Wait until the page is served."""
        end = time.perf_counter() + 30
        while time.perf_counter() < end:
            try:
                return urllib.request.urlopen(self.address, timeout=30).close()
            except OSError:
                time.sleep(0.02)
        sys.exit("the page was not served within 30 s")

    def processor_time(self) -> float:
        """Return the processor time that the server has used [s]."""
        numbers = Path(f"/proc/{self.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
        return (int(numbers[11]) + int(numbers[12])) / os.sysconf("SC_CLK_TCK")

    def memory(self) -> float:
        """Return the resident memory [MB]."""
        text = Path(f"/proc/{self.process.pid}/status").read_text()
        return int(re.search(r"VmRSS:\s+(\d+)", text)[1]) / 1e3

    def stop(self) -> list[float]:
        """End it, and return the times of each turn [s]."""
        self.process.send_signal(signal.SIGINT)
        self.process.communicate(timeout=20)
        return list(json.loads(self.file.read_text(encoding="utf-8")))


def main() -> None:
    """Measure everything, each part with a server of its own, and write the table."""
    rows, (start, _) = served(pressed)
    at_visitors, (_, times) = served(visited)
    loaded, _ = served(loaded_and_flooded)
    at_server = in_milliseconds(
        "the same: at the server, a turn, for simulation and plots of an update or the key figures that follow: median, 95 %",
        times,
        "95 %: 30 ms",
    )
    rows = [
        ["from the start of the program to its first page", f"{start:.1f} s", ""],
        *rows,
        *at_visitors,
        at_server,
        *loaded,
    ]
    write("explorer.md", "The page in the browser", _notes(), ["", "measured", "target"], rows)


def served(
    part: Callable[[Server], list[list[str]]],
) -> tuple[list[list[str]], tuple[float, list[float]]]:
    """Measure one part; return its rows, the time that its server took to start [s] and those of its turns [s]."""
    with tempfile.TemporaryDirectory() as name:
        server = Server(Path(name))
        try:
            rows = part(server)
        finally:
            times = server.stop()
    return rows, (server.start, times)


def pressed(server: Server) -> list[list[str]]:
    """Measure the time from a key on a slider until the last visible plot is drawn, in a browser."""
    from playwright.sync_api import sync_playwright

    rows = []
    with sync_playwright() as running:
        browser = running.chromium.launch(executable_path=CHROMIUM, args=list(ARGUMENTS))
        opened = [first_curve(browser, server) for _ in range(OPENED)]
        rows.append(
            in_milliseconds(
                "one visitor, from a click on the link to the first curve: median, 95 %", opened[2:]
            )
        )
        for tab in ("Over time", "Over frequency"):
            page = browser.new_page(viewport={"width": 1500, "height": 1000})
            page.goto(server.address)
            page.wait_for_selector(".js-plotly-plot .main-svg")
            page.get_by_role("tab", name=tab).click()
            time.sleep(4)
            page.evaluate(COUNT_PLOTS)
            page.locator(".q-slider__track-container").first.focus()
            moved = []
            for _ in range(PRESSES):
                page.keyboard.press("ArrowRight")
                time.sleep(0.5)
                moved.append(page.evaluate("() => window.moved"))
            page.close()
            for end, words, target in (
                ("last", "the last visible plot in the browser", "120 ms, 250 ms"),
                ("figures", "a changed key figure", ""),
            ):
                times = [1e-3 * (each[end] - each["begin"]) for each in moved[5:] if each[end]]
                row = f"one visitor, slider to {words}, tab '{tab}': median, 95 %"
                rows.append(in_milliseconds(row, times, target))
        browser.close()
    return rows


def first_curve(browser: Any, server: Server) -> float:
    """Return the time from the request of the page until its first curve is drawn, in a new window [s]."""
    with browser.new_context(viewport={"width": 1500, "height": 1000}) as context:
        page, begin = context.new_page(), time.perf_counter()
        page.goto(server.address)
        page.wait_for_selector(CURVE, state="attached")
        return time.perf_counter() - begin


def in_milliseconds(row: str, times: list[float], target: str = "") -> list[str]:
    """Return a row of the table with median and 95 % of times [s]."""
    return [row, f"{1e3 * median(times):.0f} ms, {1e3 * share(times, 0.95):.0f} ms" if times else "", target]


def visited(server: Server) -> list[list[str]]:
    """Measure the server with five visitors that have no browser, which would take its processor time."""

    async def measured() -> list[list[str]]:
        async with together(server) as visitors:
            used = server.processor_time()
            times = [time for found in await asyncio.gather(*map(paced, visitors)) for time in found]
            work = (server.processor_time() - used) / len(times)
        words = f"{VISITORS} visitors, {PACE:g} moves per second each"
        return [
            [
                f"{words}: from a move to its plots at the visitor, median, 95 %",
                f"{1e3 * median(times):.0f} ms, {1e3 * share(times, 0.95):.0f} ms",
                "",
            ],
            ["the same: processor time of the server for each update, mean", f"{1e3 * work:.0f} ms", "30 ms"],
        ]

    return asyncio.run(measured())


def loaded_and_flooded(server: Server) -> list[list[str]]:
    """Measure what a server does that is asked for more than it can compute, and its memory after many updates."""

    async def measured() -> list[list[str]]:
        async with together(server) as visitors:
            begin, row = server.memory(), await flooded(visitors)
            await asyncio.gather(*(updated(each, WARM // VISITORS) for each in visitors))
            warm = server.memory()
            await asyncio.gather(*(updated(each, UPDATES // VISITORS) for each in visitors))
            end = server.memory()
        words = (
            f"memory with {VISITORS} visitors: at the start, after {WARM:,} updates, after {UPDATES:,} more"
        )
        return [row, [words, f"{begin:.0f} MB, {warm:.0f} MB, {end:.0f} MB", "growth of 50 MB"]]

    return asyncio.run(measured())


@asynccontextmanager
async def together(server: Server) -> AsyncIterator[list[MovingVisitor]]:
    """Open the page for all visitors."""
    async with AsyncExitStack() as stack:
        yield [await stack.enter_async_context(MovingVisitor(server.port)) for _ in range(VISITORS)]


async def paced(visitor: MovingVisitor) -> list[float]:
    """Move at random times, and wait for each answer; return the times that they took [s]."""
    dice, found = random.Random(visitor.address), []
    end = time.perf_counter() + SECONDS
    while time.perf_counter() < end:
        await asyncio.sleep(dice.expovariate(PACE))
        found.append(await visitor.update())
    return found


async def flooded(visitors: list[MovingVisitor]) -> list[str]:
    """Move faster than anything can be computed; what is left to do afterwards is one update for each visitor."""
    before = sum(each.answers for each in visitors)
    moves = round(FLOOD * FLOODED)
    for _ in range(moves):
        await asyncio.gather(*(each.move(each.neighbour) for each in visitors))
        await asyncio.sleep(1 / FLOOD)
    begin = time.perf_counter()
    done = sum(each.answers for each in visitors)
    quiet, left = begin, 0
    while time.perf_counter() - quiet < 2:
        await asyncio.sleep(0.005)
        found = sum(each.answers for each in visitors)
        if found > done + left:
            left, quiet = found - done, time.perf_counter()
    return [
        f"{VISITORS} visitors, {FLOOD:g} moves per second each for {FLOODED:g} s: updates computed of {moves * VISITORS:,} moves;"
        " updates after the last move, and when the last one had come",
        f"{done + left - before}; {left}, {1e3 * (quiet - begin):.0f} ms",
        f"latest wins, at most {2 * VISITORS}",
    ]


async def updated(visitor: MovingVisitor, count: int) -> None:
    """Move and wait, many times."""
    for _ in range(count):
        await visitor.update()


def share(times: list[float], part: float) -> float:
    """Return the time that a part of the updates does not exceed."""
    return sorted(times)[round(part * (len(times) - 1))]


def _notes() -> list[str]:
    measure = """The server and what visits it share the processor. In the browser (chromium, software rendering) the time is
that from a key on a slider to the last visible plot. Visitors without a browser speak the protocol of the page; each waits for
the plots of a move before the next one, unless said otherwise."""
    return [measure, surroundings(["nicegui", "uvicorn", "numpy", "xarray"])]


if __name__ == "__main__":
    main()
