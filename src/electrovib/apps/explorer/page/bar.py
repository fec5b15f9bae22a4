"""The bar at the top: which scenario, reset, curves to compare, dark or light."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING

from nicegui import ui

from electrovib.apps.explorer.downloads import DOWNLOADS, Download
from electrovib.apps.explorer.state import PageState, presets
from electrovib.core.errors import ElectrovibError
from electrovib.study.catalogue import scenarios

if TYPE_CHECKING:
    from electrovib.apps.explorer.session import Session


class Bar:
    """Controls that belong to the whole page.

    Parameters
    ----------
    session : Session
        Of the visitor.
    ask : callable
        Called with the state to show next.
    redraw : callable
        Called when the present result has to be drawn again.
    """

    def __init__(
        self, session: Session, *, ask: Callable[[PageState], None], redraw: Callable[[], None]
    ) -> None:
        self._session, self._ask, self._redraw = session, ask, redraw
        meanings = {each.name: each.meaning for each in scenarios()}
        self._names = {
            name: f"{name}: {meanings.get(name, 'the scenario of this page')}"
            for name in presets(session.own)
        }
        with ui.header().classes("items-center gap-3 px-3 py-1"):
            ui.label("electrovib").classes("text-lg font-bold").props("role=heading aria-level=1")
            self._select = ui.select(
                self._names,
                value=session.state.preset,
                label="Scenario",
                on_change=lambda e: self._choose(e.value),
            )
            self._select.props(
                "dense dark options-dense use-input hide-selected fill-input input-debounce=0"
            ).classes("w-96")
            ui.button("Reset", on_click=lambda: ask(self._session.state.reset())).props(
                "flat color=white no-caps"
            )
            ui.button("Keep curve", on_click=self._pin).props("flat color=white no-caps")
            ui.button("Drop curves", on_click=self._unpin).props("flat color=white no-caps")
            with ui.button("Download").props("flat color=white no-caps"), ui.menu():
                for each in DOWNLOADS:
                    ui.menu_item(each.label, on_click=lambda each=each: self._download(each))
            ui.space()
            self._dark = ui.dark_mode(value=False)
            ui.button("Dark or light", on_click=self._change_theme).props("flat color=white no-caps")
        ui.timer(0.01, self._take_theme_of_browser, once=True)

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
        if name != self._session.state.preset:
            self._ask(PageState(name))

    def _pin(self) -> None:
        self._session.pin()
        self._redraw()

    def _unpin(self) -> None:
        self._session.unpin()
        self._redraw()
