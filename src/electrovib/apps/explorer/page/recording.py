"""The tab for recordings: drop a file or take a simulated example, say which column is which signal, fit parameters."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from nicegui import events, ui

from electrovib.apps.explorer import reading
from electrovib.apps.explorer.page.plots import fit_content
from electrovib.apps.explorer.pictures import EXAMPLE
from electrovib.apps.explorer.reading import fittable, read_upload
from electrovib.apps.explorer.runner import LARGEST_UPLOAD
from electrovib.core.errors import ElectrovibError, InputError
from electrovib.core.paths import value_at
from electrovib.core.signals import SIGNALS
from electrovib.recordings.importing.choice import ProposedColumn, proposed_columns
from electrovib.recordings.importing.clock import has_times
from electrovib.view.style import pretty_quantity

if TYPE_CHECKING:
    import xarray
    from numpy.typing import NDArray

    from electrovib.apps.explorer.computed import Computed
    from electrovib.apps.explorer.page.build import VisitorPage
    from electrovib.scenario import Scenario
    from electrovib.view.fitted import FitResult

HIDDEN: Final = (
    "stack.gap.thickness",
    "stack.stratum_corneum.thickness",
    "stack.insulator.thickness",
    "friction.coefficient",
    "contact.area",
)
"""Parameters that may differ, the first one first that the signal shows clearly."""
MEASURED: Final = ("lateral_force_measured", "lateral_force", "electrostatic_force")
"""Signals that may be recorded, as an instrument would, the first one first that varies."""
FACTOR: Final = 1.3
"""Ratio of the hidden value to that of the scenario."""
NOISE: Final = 0.015
"""Standard deviation of the noise, over the difference between the largest and the smallest value of the signal."""
_CLEAR: Final = 2.0
"""Root mean square of what the hidden value changes, over that of the noise, from which it is clear."""
_CONSTANT: Final = 1e-3
"""Part of its largest value by which a signal varies at least; the noise of any other is a part of its value."""
SEED: Final = 29


@dataclass(frozen=True)
class Example:
    """A simulated recording as a file (CSV) with one `signal`; `path` had the hidden `value` [SI], in `unit`.

    `name` is what it is called wherever it is shown.
    """

    name: str
    content: bytes
    signal: str
    path: str
    value: float
    unit: str

    @property
    def remark(self) -> str:
        """What was hidden, as the page states it after a fit."""
        value = pretty_quantity(self.value, self.unit, digits=4)
        return f"The example was simulated with {self.path} = {value}."

    def read(self) -> xarray.Dataset:
        """Read it as a file that a visitor drops."""
        found = read_upload(f"{EXAMPLE}).csv", self.content, {self.signal: self.signal})
        assert found.trace is not None
        return found.trace.assign_attrs(title=self.name)


def example(shown: Computed, name: str) -> Example:
    """Simulate a recording of the scenario as it is shown, with one parameter of `HIDDEN` increased and with noise.

    `name` is that of the scenario. A scenario is refused that has no signal over time of `MEASURED`, or none that
    a parameter changes clearly.
    """
    times, signal = shown.values("time"), _signal(shown)
    even = np.linspace(times[0], times[-1], times.size)  # as an instrument samples
    before = _sampled(shown.scenario, signal, even)
    noise = NOISE * _scale(before)
    for path in HIDDEN:
        if path not in fittable(shown.scenario):
            continue
        value = float(f"{FACTOR * value_at(shown.scenario, path):.3g}")
        try:
            after = _sampled(shown.scenario.replace({path: value}), signal, even)
        except ElectrovibError:  # beyond the declared range
            continue
        if np.sqrt(np.mean((after - before) ** 2)) >= _CLEAR * noise:
            words = f"{EXAMPLE}: {name} with one value changed and noise)"
            units = {each: quantity.unit for each, _, quantity in shown.scenario.parameters()}
            return Example(words, _written(even, after, noise, signal), signal, path, value, units[path])
    raise InputError(
        f"There is no example for this scenario: none of {', '.join(HIDDEN)} changes its {_plain(signal)} clearly."
        " Choose another scenario."
    )


def _signal(shown: Computed) -> str:
    """Return the signal that is recorded: the first one that varies, else the first one that is not 0."""
    known = [each for each in MEASURED if shown.has(each) and np.isfinite(shown.values(each)).all()]
    varying = [
        each for each in known if np.ptp(shown.values(each)) > _CONSTANT * _largest(shown.values(each))
    ]
    for each in (*varying, *known):
        if _largest(shown.values(each)) > 0:
            return each
    raise InputError(
        f"There is no example for this scenario: it has no {' or '.join(map(_plain, MEASURED))} over time."
        " Choose another scenario."
    )


def _largest(values: NDArray[Any]) -> float:
    return float(np.abs(values).max())


def _scale(values: NDArray[Any]) -> float:
    """Return the size of a signal to which its noise is relative."""
    largest, range_ = _largest(values), float(np.ptp(values))
    return range_ if range_ > _CONSTANT * largest else largest


def _sampled(scenario: Scenario, signal: str, time: NDArray[Any]) -> NDArray[Any]:
    from electrovib.solve.simulate import simulate

    return np.asarray(simulate(scenario, time=time)[signal].values)


def _written(time: NDArray[Any], values: NDArray[Any], noise: float, signal: str) -> bytes:
    """Write a file with the noise of an instrument."""
    noisy = values + noise * np.random.default_rng(SEED).normal(size=values.size)
    rows = (f"{at:.9g},{each:.7g}" for at, each in zip(time, noisy, strict=True))
    return "\n".join([f"time (s),{signal} ({SIGNALS[signal].unit})", *rows]).encode()


def _plain(name: str) -> str:
    return name.replace("_", " ")


_LABELS: Final = """
document.querySelectorAll('.q-uploader__input').forEach(e => e.setAttribute('aria-label', 'Choose a file'));
document.querySelectorAll('.q-uploader__header a').forEach(e => e.setAttribute('aria-label', 'Choose a file'));
"""
"""Names of the controls of the framework's element for files, which it leaves without one."""
MOST_COLUMNS: Final = 12
"""Columns of a recording for which the page asks."""
_UNUSED: Final = ""
_REFRESH: Final = 0.25
"""Time between two updates of the progress of a fit [s]."""
_TOO_LARGE: Final = (
    f"The file was not taken: a page takes one file of at most {LARGEST_UPLOAD / 1e6:g} MB at a time."
)


class RecordingPanel:
    """Controls for a recording."""

    def __init__(self, page: VisitorPage) -> None:
        self._page, self._session = page, page.session
        self._content = b""
        self._uploaded: reading.Uploaded | None = None
        self._running: reading.RunningFit | None = None
        self._example: Example | None = None
        with ui.row().classes("items-center gap-x-4 gap-y-1"):
            ui.button("Load an example recording (simulated)", on_click=self._load_example).props("no-caps")
            ui.label(
                "The scenario shown, with one value changed and noise: a fit has to find the value."
            ).classes("text-sm")
        ui.label(
            "Drop a recording (CSV of an oscilloscope, MATLAB, netCDF, ISF, TDMS, ...) to compare and fit it, or a"
            " scenario (TOML) to show it. It stays in the memory of this page."
        ).classes("text-sm")
        self._upload = (
            ui.upload(
                label="Drop a file here",
                auto_upload=True,
                max_file_size=LARGEST_UPLOAD,
                max_files=1,
                on_upload=self._dropped,
                on_rejected=lambda _: page.complain(_TOO_LARGE),
            )
            .classes("w-96 max-w-full")
            .props('aria-label="Drop a file"')
        )
        ui.timer(0.1, lambda: ui.run_javascript(_LABELS), once=True)
        self._name = ui.label().classes("text-sm font-bold").props("role=status")
        self._columns = ui.column().classes("gap-1")
        self._fit = ui.column().classes("w-full gap-1")
        self._result = ui.html("", sanitize=False).classes("text-sm")

    async def _dropped(self, event: events.UploadEventArguments) -> None:
        name, content = event.file.name, await event.file.read()
        self._upload.reset()
        self._page.complain("")
        try:
            if name.lower().endswith(reading.SCENARIO_SUFFIX):
                read = self._session.read(lambda: reading.read_uploaded_scenario(name, content))
                self._page.take(await read)
                return
            found = await self._session.read(lambda: reading.read_upload(name, content))
        except ElectrovibError as error:
            self._page.complain(str(error))
            return
        self._content, self._uploaded, self._example = content, found, None
        self._name.set_text(found.name)
        self._columns.clear()
        if found.trace is not None:
            self._compare(found.trace)
        else:
            self._choose_columns(found)

    async def _load_example(self) -> None:
        """Simulate a recording, read it as a file that is dropped, compare it, and propose to fit what it hides."""
        session, shown = self._session, self._session.computed
        if shown is None:
            return
        self._page.complain("")

        def made() -> tuple[Example, xarray.Dataset]:
            found = example(shown, session.state.preset)
            return found, found.read()

        try:
            found, measured = await session.read(made)
        except ElectrovibError as error:
            self._page.complain(str(error))
            return
        self._example, self._uploaded = found, None
        self._name.set_text(found.name)
        self._columns.clear()
        self._compare(measured, [found.path])

    def _choose_columns(self, found: reading.Uploaded) -> None:
        """Let the visitor state which column is which signal."""
        recorded = found.recorded
        assert recorded is not None
        channels = [each for each in recorded.channels if each.name != recorded.time]
        signals = {_UNUSED: "not used"} | {each: each.replace("_", " ") for each in reading.OVER_TIME}
        rows: list[tuple[str, Any, Any, Any]] = []
        proposed = {each.column: each for each in proposed_columns(recorded)}
        with self._columns:
            asked = f"{found.name}: {recorded.size} samples. Which column is which signal?"
            ui.label(asked).classes("text-sm")
            for each in channels[:MOST_COLUMNS]:
                first = proposed.get(each.name, ProposedColumn(column=each.name, signal=_UNUSED))
                sign = "" if "/" in first.scale else first.scale  # of a sensor only the visitor knows it
                with ui.row().classes("items-end"):
                    ui.label(f"{each.name} [{each.unit or 'unit not stated'}]").classes("text-sm w-40 pb-2")
                    taken = self._as_read(first.signal)
                    signal = ui.select(signals, label=f"signal of {each.name}", value=taken)
                    unit = ui.input(f"unit of {each.name}, for instance V", value=first.unit)
                    scale = ui.input(f"scale of {each.name}, for instance 1.5 N/V", value=sign)
                signal.classes("w-60 max-w-full")
                unit.classes("w-72 max-w-full").set_visibility(not each.unit)
                scale.classes("w-72 max-w-full")
                rows.append((each.name, signal, unit, scale))
            step = ui.input("time between samples, for instance 0.1 ms").classes("w-80 max-w-full")
            step.set_visibility(not has_times(recorded))
            ui.button("Compare", on_click=lambda: self._import(rows, str(step.value))).props("no-caps")

    def _as_read(self, signal: str) -> str:
        """Return a proposed signal, as the tribometer reads it where the scenario has a rig."""
        shown = self._session.computed
        measured = f"{signal}_measured"
        return measured if shown and shown.scenario.rig and measured in reading.OVER_TIME else signal

    async def _import(self, rows: Sequence[tuple[str, Any, Any, Any]], step: str) -> None:
        assert self._uploaded is not None
        name, content = self._uploaded.name, self._content
        try:
            wanted, scales = _chosen_columns(rows)
            options = {"step": step.strip(), "scale": scales}
            found = await self._session.read(lambda: reading.read_upload(name, content, wanted, **options))
        except ElectrovibError as error:
            self._page.complain(str(error))
            return
        self._page.complain("")
        assert found.trace is not None
        self._compare(found.trace)

    def _compare(self, measured: xarray.Dataset, free: Sequence[str] = ()) -> None:
        """Show a recording with the prediction, and offer to fit parameters, of which some are chosen already."""
        self._session.measured = measured
        self._result.set_content("")
        self._offer_fit(free)
        self._page.redraw()

    def _offer_fit(self, free: Sequence[str]) -> None:
        self._fit.clear()
        if self._session.computed is None:
            return
        paths = reading.fittable(self._session.computed.scenario)
        with self._fit, ui.row().classes("w-full items-center"):
            chosen = ui.select(paths, label="parameters to fit", multiple=True, value=list(free))
            chosen.classes("w-96 max-w-full").props("use-chips")
            self._start_button = ui.button("Fit", on_click=lambda: self._start(list(chosen.value)))
            self._cancel_button = ui.button("Cancel", on_click=self._cancel).props("no-caps flat")
            self._progress = ui.label("").classes("text-sm").props("role=status")
        self._start_button.props("no-caps")
        self._cancel_button.set_visibility(False)

    def _cancel(self) -> None:
        if self._running is not None:
            self._running.cancel()

    async def _start(self, free: list[str]) -> None:
        session = self._session
        if session.computed is None or session.measured is None or self._running is not None:
            return
        try:
            running = reading.RunningFit(session.computed.scenario, session.measured, free)
        except ElectrovibError as error:
            self._page.complain(str(error))
            return
        self._running = running
        self._page.complain("")
        self._start_button.set_enabled(False)
        self._cancel_button.set_visibility(True)
        timer = ui.timer(_REFRESH, lambda: self._progress.set_text(running.progress))
        try:
            result = await session.work(running.run)
        except ElectrovibError as error:
            self._progress.set_text(str(error))
        else:
            self._progress.set_text("")
            remark = "" if self._example is None else f"<p>{escape(self._example.remark)}</p>"
            self._result.set_content(fit_content(result.document) + remark)
            self._take_estimates(result, free)
        finally:
            timer.cancel()
            self._start_button.set_enabled(True)
            self._cancel_button.set_visibility(False)
            self._running = None

    def _take_estimates(self, result: FitResult, free: Sequence[str]) -> None:
        """Show the scenario with the fitted values."""
        state = self._session.state
        for row in result.rows:
            if row.name in free:
                state = state.changed(row.name, f"{row.value:.9g}")
        self._page.ask(state)

    def stop(self) -> None:
        """End what runs, when the visitor has left, and forget the file."""
        self._cancel()
        self._content, self._uploaded = b"", None
        # the web framework keeps it, and all it refers to
        asyncio.get_running_loop().call_soon(vars(self._upload).clear)


def _chosen_columns(rows: Sequence[tuple[str, Any, Any, Any]]) -> tuple[dict[str, str], dict[str, str]]:
    """Return the column and the scale of each signal from what was chosen for each column."""
    wanted: dict[str, str] = {}
    scales: dict[str, str] = {}
    for column, signal, unit, scale in rows:
        if signal.value == _UNUSED:
            continue
        if signal.value in wanted:
            words = signal.value.replace("_", " ")
            raise InputError(f"Two columns are chosen as {words}; choose one of them.")
        text = str(unit.value or "").strip()
        wanted[signal.value] = f"{column} [{text}]" if text else column
        if factor := str(scale.value or "").strip():
            scales[signal.value] = factor
    if not wanted:
        raise InputError("No column is chosen; state for at least one which signal it is.")
    return wanted, scales
