"""The bar at the top: which scenario, reset, curves to compare, dark or light."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from html import escape
from typing import TYPE_CHECKING, Final

from nicegui import ui

from electrovib.apps.explorer.downloads import DOWNLOADS, Download
from electrovib.apps.explorer.state import PageState, presets
from electrovib.core.errors import ElectrovibError
from electrovib.studies.catalogue import scenarios

if TYPE_CHECKING:
    from electrovib.apps.explorer.session import Session

_SKIP: Final = "() => document.querySelector('[role=tab][aria-selected=true]').focus()"
"""Past the parameters, which are some sixty stops of the keyboard."""


class Bar:
    """Controls that belong to the whole page.

    `ask` is called with the state to show next, `reset` to take all changes back, `redraw` when the present
    result has to be drawn again, `toggle` to show or hide the parameters.
    """

    def __init__(
        self,
        session: Session,
        *,
        ask: Callable[[PageState], None],
        reset: Callable[[], None],
        redraw: Callable[[], None],
        toggle: Callable[[], None],
    ) -> None:
        self._session, self._ask, self._redraw = session, ask, redraw
        meanings = {each.name: each.meaning for each in scenarios()}
        self._names = {
            name: f"{name}: {meanings.get(name, 'the scenario of this page')}"
            for name in presets(session.own)
        }
        with ui.header().classes("items-center gap-x-2 gap-y-0 px-2 py-1"):
            ui.button("Skip to the results").on("click", js_handler=_SKIP).props("no-caps").classes("ev-skip")
            ui.button(icon="menu", on_click=toggle).props(
                'flat dense color=white aria-label="Show or hide the parameters"'
            ).tooltip("Show or hide the parameters")
            ui.label("electrovib").classes("text-lg font-bold").props("role=heading aria-level=1")
            self._select = ui.select(
                self._names,
                value=session.state.preset,
                label="Scenario",
                on_change=lambda e: self._choose(e.value),
            )
            self._select.props(
                "dense dark options-dense use-input hide-selected fill-input input-debounce=0"
            ).classes("ev-scenario")
            _button("Reset", reset, "Take all changes back")
            _button("Keep curve", self._pin, "Keep the present curves, dashed, beside the next ones")
            _button("Drop curves", self._unpin, "Remove the curves that were kept")
            with _button("Download", None, "Scenario, numbers, figures, report and references"), ui.menu():
                for each in DOWNLOADS:
                    ui.menu_item(each.label, on_click=lambda each=each: self._download(each))
            self._dark = ui.dark_mode(value=False)
            _button("About", self._about, "What electrovibration is, and what this page shows")
            _button("Dark or light", self._change_theme, "Change the colours of the page")
        ui.timer(0.01, self._take_theme_of_browser, once=True)

    def _about(self) -> None:
        """Show what the page is about."""
        with ui.dialog(value=True) as dialog, ui.card().classes("ev-about"):
            ui.label("Electrovibration").classes("text-lg font-bold").props("role=heading aria-level=2")
            ui.html("".join(f"<p>{escape(each)}</p>" for each in ABOUT), sanitize=False)
            ui.button("Close", on_click=dialog.close).props("no-caps")
        dialog.on("hide", dialog.delete)

    @property
    def is_dark(self) -> bool:
        """Whether the page is dark."""
        return bool(self._dark.value)

    def _change_theme(self) -> None:
        self._dark.toggle()
        self._redraw()

    async def _take_theme_of_browser(self) -> None:
        with suppress(TimeoutError):  # of a browser that does not answer; the page is then a light one
            if await ui.run_javascript(
                "window.matchMedia('(prefers-color-scheme: dark)').matches", timeout=5
            ):
                self._change_theme()

    def offer(self, name: str) -> None:
        """Add a scenario to the list, and choose it."""
        self._names = {name: f"{name}: the scenario that was dropped on this page"} | self._names
        self._select.set_options(self._names, value=name)

    async def _download(self, wanted: Download) -> None:
        found = self._session.computed
        if found is None:
            return
        try:
            content = await self._session.work(lambda: wanted.make(found))
        except ElectrovibError as error:
            ui.notify(f"{wanted.label}: {error}", type="negative", multi_line=True)
        else:
            ui.download.content(content, wanted.name, wanted.media_type)

    def _choose(self, name: str) -> None:
        if name in self._names and name != self._session.state.preset:
            self._ask(PageState(name))

    def show(self, name: str) -> None:
        """Show the name of a scenario that was chosen elsewhere."""
        self._select.set_value(name)

    def _pin(self) -> None:
        self._session.pin()
        self._redraw()

    def _unpin(self) -> None:
        self._session.unpin()
        self._redraw()


def _button(words: str, on_click: Callable[[], object] | None, explained: str) -> ui.button:
    """Make a button of the bar, with what it does on hover."""
    button = ui.button(words, on_click=on_click).props("flat dense color=white no-caps").classes("px-2")
    with button:
        ui.tooltip(explained)
    return button


ABOUT: Final = (
    "A voltage between the electrode of a plate and a finger attracts the skin to the plate. The attraction adds to the force"
    " with which the finger presses, so the friction of a sliding finger follows the voltage, and the finger feels a vibration or"
    " a texture on a smooth surface: electrovibration. A finger at rest feels nothing of it.",
    "The attraction is caused by the electric field between plate and skin. The voltage is shared between the layers: at fast"
    " changes as between capacitors, under a constant voltage as between resistors. Charge that passes through the skin and the"
    " gap therefore makes the force fade within the time constant of these layers, although the voltage stays. 'Voltage across"
    " each layer', and 'Over frequency', show this.",
    "Move a slider, or type a value with its unit into the field beside it; an empty field gives the value of the scenario back."
    " The pointer on a parameter shows its meaning, range and source. The button 'back' of the browser takes the last change"
    " back, and the address of the page reproduces what is shown.",
    "'Validity' states whether the models hold for this result: 'ok', 'warning' (outside the range in which a model was"
    " verified, or above a strength), or 'unknown' where no statement is possible.",
)
"""What the page shows, for a person who has not met electrovibration, a paragraph each."""
