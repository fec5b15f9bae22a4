"""Sliders and fields of the parameters."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from nicegui import ui

from electrovib.apps.explorer.choices import AS_GIVEN, Choice, choices
from electrovib.apps.explorer.controls import SECTIONS, STEPS, Control, controls
from electrovib.apps.explorer.state import PageState, scenario_of
from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from electrovib.apps.explorer.computed import Computed
    from electrovib.apps.explorer.session import Session


class Knobs:
    """A slider and a field for each parameter of the scenario, in sections that open and close.

    Parameters
    ----------
    session : Session
        Of the visitor.
    ask : callable
        Called with the state to show next.
    """

    def __init__(self, session: Session, *, ask: Callable[[PageState], None]) -> None:
        self._session, self._ask = session, ask
        self._rows: dict[str, tuple[Control, Any, Any]] = {}
        self._silent = False
        self._moving = ""
        with ui.left_drawer(value=True, bordered=True).props("width=330").classes("p-1"):
            self._place = ui.column().classes("w-full gap-0")
        self.rebuild()

    def rebuild(self) -> None:
        """Make the controls of another scenario; they begin at its own values, whatever was changed."""
        own = self._session.own
        try:
            scenario = scenario_of(self._session.state, own=own)
        except InputError:
            scenario = scenario_of(self._session.state.reset(), own=own)
        found = controls(scenario)
        self._rows, self._moving = {}, ""
        self._place.clear()
        with self._place:
            for choice in choices(scenario):
                self._choose(choice)
            for section, heading in SECTIONS.items():
                mine = [each for each in found if each.section == section]
                if mine:
                    with (
                        ui.expansion(heading, value=section in ("drive", "stack"))
                        .classes("w-full")
                        .props("dense")
                    ):
                        for each in mine:
                            self._row(each)

    def show(self, found: Computed) -> None:
        """Write the values of a result into fields and sliders."""
        self._silent = True
        values = {path: value for path, value, _ in found.scenario.parameters()}
        for path, (control, slider, field) in self._rows.items():
            if (value := values.get(path)) is None:
                continue
            text = control.written(value)
            if field.value != text:
                field.set_value(text)
            if path != self._moving and control.position(value) != slider.value:
                slider.set_value(control.position(value))
        self._silent = False

    def _choose(self, choice: Choice) -> None:
        """Make the list of alternatives for one part."""
        chosen = self._session.state.changes.get(choice.path, AS_GIVEN)
        options = (
            dict(choice.options) if chosen in choice.options else {chosen: chosen} | dict(choice.options)
        )
        ui.select(
            options, value=chosen, label=choice.label, on_change=lambda e: self._chosen(choice, e.value)
        ).props("dense options-dense").classes("w-full")

    def _chosen(self, choice: Choice, value: str) -> None:
        state = self._session.state
        self._ask(state.reset(choice.path) if value == AS_GIVEN else state.changed(choice.path, value))
        self.rebuild()

    def _row(self, control: Control) -> None:
        label = f"{SECTIONS[control.section]}: {control.name}"
        with ui.column().classes("w-full gap-0 pb-1"):
            with ui.row().classes("w-full items-center justify-between no-wrap"):
                ui.label(control.name).classes("text-sm").tooltip(control.help)
                field = (
                    ui.input(value=control.written(control.value))
                    .props(f'dense borderless input-class="text-right" aria-label="{label}, value"')
                    .classes("w-28")
                )
            slider = ui.slider(
                min=0,
                max=STEPS,
                step=1,
                value=control.position(control.value),
                on_change=lambda e, c=control: self._moved(c, e.value),
            ).props(f'aria-label="{label}" dense')
        field.on("blur", lambda _, c=control, f=field: self._typed(c, f.value))
        field.on("keydown.enter", lambda _, c=control, f=field: self._typed(c, f.value))
        self._rows[control.path] = (control, slider, field)

    def _moved(self, control: Control, position: float) -> None:
        if not self._silent:
            self._moving = control.path  # a slider is not set while it is moved: it would jump back
            self._ask(self._session.state.changed(control.path, control.written(control.at(position))))

    def _typed(self, control: Control, text: str) -> None:
        shown = self._session.state.changes.get(control.path, control.written(control.value))
        if text.strip() and text != shown:
            self._moving = ""
            self._ask(self._session.state.changed(control.path, text.strip()))
