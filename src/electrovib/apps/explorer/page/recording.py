"""The tab for recordings: drop a file, say which column is which signal, fit parameters."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Final

from nicegui import events, ui

from electrovib.apps.explorer.limits import LARGEST_UPLOAD
from electrovib.apps.explorer.page.words import fit_words
from electrovib.apps.explorer.reading import (
    OVER_TIME,
    SCENARIO_SUFFIX,
    RunningFit,
    Uploaded,
    fittable,
    named,
    read_upload,
    read_uploaded_scenario,
)
from electrovib.apps.explorer.state import PageState
from electrovib.core.errors import ElectrovibError
from electrovib.recordings.importing.choice import ProposedColumn, proposed_columns

if TYPE_CHECKING:
    from electrovib.apps.explorer.session import Session
    from electrovib.scenario import Scenario
    from electrovib.view.fitted import FitResult

DROPPED: Final = "dropped"
"""Name of a scenario that was dropped on the page; it belongs to one visitor, and no link reproduces it."""
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


class RecordingPanel:
    """Controls for a recording.

    `ask` is called with the state to show next, `redraw` when the present result has to be drawn again,
    `complain` with a sentence about a mistake, empty when there is none, and `take` with a scenario that was
    dropped.
    """

    def __init__(
        self,
        session: Session,
        *,
        ask: Callable[[PageState], None],
        redraw: Callable[[], None],
        complain: Callable[[str], None],
        take: Callable[[Scenario], None],
    ) -> None:
        self._session, self._ask, self._redraw = session, ask, redraw
        self._complain, self._take = complain, take
        self._content = b""
        self._uploaded: Uploaded | None = None
        self._running: RunningFit | None = None
        self.element = ui.column().classes("w-full gap-2")
        with self.element:
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
                    on_rejected=lambda _: complain(
                        f"The file was not taken: a page takes one file of at most {LARGEST_UPLOAD / 1e6:g} MB at a time."
                    ),
                )
                .classes("w-96 max-w-full")
                .props('aria-label="Drop a file"')
            )
            ui.timer(0.1, lambda: ui.run_javascript(_LABELS), once=True)
            self._columns = ui.column().classes("gap-1")
            self._fit = ui.column().classes("gap-1")
            self._result = ui.html("", sanitize=False).classes("text-sm")

    async def _dropped(self, event: events.UploadEventArguments) -> None:
        name, content = event.file.name, await event.file.read()
        self._upload.reset()
        self._complain("")
        try:
            if name.lower().endswith(SCENARIO_SUFFIX):
                self._take(await self._session.read(lambda: read_uploaded_scenario(name, content)))
                return
            found = await self._session.read(lambda: read_upload(name, content))
        except ElectrovibError as error:
            self._complain(f"{error}")
            return
        self._content, self._uploaded = content, found
        self._columns.clear()
        if found.trace is not None:
            self._compare(found)
        else:
            self._choose_columns(found)

    def _choose_columns(self, found: Uploaded) -> None:
        """Let the visitor state which column is which signal."""
        assert found.recorded is not None
        channels = [each for each in found.recorded.channels if each.name != found.recorded.time]
        signals = {_UNUSED: "not used"} | {each: each.replace("_", " ") for each in OVER_TIME}
        rows: list[tuple[str, Any, Any, Any]] = []
        proposed = {each.column: each for each in proposed_columns(found.recorded)}
        with self._columns:
            asked = f"{found.name}: {found.recorded.size} samples. Which column is which signal?"
            ui.label(asked).classes("text-sm")
            for each in channels[:MOST_COLUMNS]:
                first = proposed.get(each.name, ProposedColumn(column=each.name, signal=_UNUSED))
                with ui.row().classes("items-end"):
                    ui.label(f"{each.name} [{each.unit or 'unit not stated'}]").classes("text-sm w-40 pb-2")
                    signal = ui.select(
                        signals,
                        label=f"signal of {each.name}",
                        value=self._as_read(first.signal),
                    ).classes("w-60 max-w-full")
                    unit = ui.input(f"unit of {each.name}, for instance V", value=first.unit)
                    unit.classes("w-72 max-w-full").set_visibility(not each.unit)
                    sign = "" if "/" in first.scale else first.scale  # of a sensor only the visitor knows it
                    scale = ui.input(f"scale of {each.name}, for instance 1.5 N/V", value=sign)
                    scale.classes("w-72 max-w-full")
                    rows.append((each.name, signal, unit, scale))
            step = ui.input("time between samples, for instance 0.1 ms").classes("w-80 max-w-full")
            step.set_visibility(not found.recorded.time and found.recorded.step is None)
            ui.button("Compare", on_click=lambda: self._import(rows, str(step.value))).props("no-caps")

    def _as_read(self, signal: str) -> str:
        """Return a proposed signal, as the tribometer reads it where the scenario has a rig."""
        shown = self._session.computed
        measured = f"{signal}_measured"
        return measured if shown and shown.scenario.rig and measured in OVER_TIME else signal

    async def _import(self, rows: Sequence[tuple[str, Any, Any, Any]], step: str) -> None:
        assert self._uploaded is not None
        name, content = self._uploaded.name, self._content
        wanted: dict[str, str] = {}
        scales: dict[str, str] = {}
        for column, signal, unit, scale in rows:
            if signal.value == _UNUSED:
                continue
            if signal.value in wanted:
                self._complain(
                    f"Two columns are chosen as {signal.value.replace('_', ' ')}; choose one of them."
                )
                return
            text = str(unit.value or "").strip()
            wanted[signal.value] = f"{column} [{text}]" if text else column
            if factor := str(scale.value or "").strip():
                scales[signal.value] = factor
        if not wanted:
            self._complain("No column is chosen; state for at least one which signal it is.")
            return
        try:
            options = {"step": step.strip(), "scale": scales}
            found = await self._session.read(lambda: named(name, content, wanted, **options))
        except ElectrovibError as error:
            self._complain(str(error))
            return
        self._complain("")
        self._compare(found)

    def _compare(self, found: Uploaded) -> None:
        self._session.measured = found.trace
        self._result.set_content("")
        self._offer_fit()
        self._redraw()

    def _offer_fit(self) -> None:
        self._fit.clear()
        if self._session.computed is None:
            return
        paths = fittable(self._session.computed.scenario)
        with self._fit, ui.row().classes("items-center"):
            chosen = ui.select(paths, label="parameters to fit", multiple=True, value=[])
            chosen.classes("w-96 max-w-full").props("use-chips")
            self._start_button = ui.button("Fit", on_click=lambda: self._start(list(chosen.value))).props(
                "no-caps"
            )
            self._cancel_button = ui.button("Cancel", on_click=self._cancel).props("no-caps flat")
            self._cancel_button.set_visibility(False)
            self._progress = ui.label("").classes("text-sm").props("role=status")

    def _cancel(self) -> None:
        if self._running is not None:
            self._running.cancel()

    async def _start(self, free: list[str]) -> None:
        session = self._session
        if session.computed is None or session.measured is None or self._running is not None:
            return
        try:
            running = self._running = RunningFit(session.computed.scenario, session.measured, free)
        except ElectrovibError as error:
            self._complain(str(error))
            return
        self._complain("")
        self._start_button.set_enabled(False)
        self._cancel_button.set_visibility(True)
        timer = ui.timer(_REFRESH, lambda: self._progress.set_text(running.progress))
        try:
            result = await session.work(running.run)
        except ElectrovibError as error:
            self._progress.set_text(str(error))
        else:
            self._progress.set_text("")
            self._result.set_content(fit_words(result))
            self._take_estimates(result, running.free)
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
        self._ask(state)

    def stop(self) -> None:
        """End what runs, when the visitor has left, and forget the file."""
        self._cancel()
        self._content, self._uploaded = b"", None
        asyncio.get_running_loop().call_soon(
            vars(self._upload).clear
        )  # the web framework keeps it, and all it refers to
