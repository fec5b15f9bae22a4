"""The page of one visitor, the bar at its top, and the stories that are told in a strip above the results."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from fastapi import Request
from nicegui import app, events, ui

from electrovib.apps.explorer.page.knobs import Knobs
from electrovib.apps.explorer.page.plots import Plots
from electrovib.apps.explorer.page.recording import RecordingPanel
from electrovib.apps.explorer.runner import Workers, end_work
from electrovib.apps.explorer.session import DOWNLOADS, Download, Session
from electrovib.apps.explorer.state import STEPS, STORIES, PageState, StoryStep, presets, read_query
from electrovib.core.errors import ElectrovibError, InputError
from electrovib.studies.catalogue import scenarios

if TYPE_CHECKING:
    from electrovib.apps.explorer.computed import Computed, Further
    from electrovib.scenario import Scenario


class Guide:
    """Tells a story; `is_first` invites to one, as nothing is asked for in the address.

    At `place`, beside the sentence, are the controls of the parameter that the step `asks` to change.
    """

    def __init__(self, page: VisitorPage, *, is_first: bool) -> None:
        self._page = page
        with ui.row().classes("ev-story").props("role=region aria-label=Invitation") as self._invitation:
            ui.label("New here?")
            for story in STORIES:
                _link(f"A story for a {story.reader}", story.steps[0])
            _close(lambda: self._invitation.set_visibility(False), "Close the invitation")
        with ui.row().classes("ev-story ev-told").props("role=region aria-label=Story") as self._strip:
            with ui.element("div").classes("ev-sentence").props("aria-live=polite"):
                self._place = ui.label().classes("font-bold")
                self._sentence = ui.label()
            self._links = {words: _link(words) for words in ("Previous", "Show again", "Next")}
            _close(lambda: page.ask(replace(page.session.state, story="")), "Close the story")
            self.place = ui.element("div").classes("ev-asked")
        self.asks = ""
        self._dialog: ui.dialog | None = None
        self._invitation.set_visibility(is_first)
        self._strip.set_visibility(False)
        self.tell(page.session.state)

    def tell(self, state: PageState) -> None:
        """Show the step of a story that belongs to a state, whatever the visitor has changed since."""
        if self._dialog is not None:
            self._dialog.close()
        self._strip.set_visibility(bool(state.story))
        self.asks = STEPS[state.story].asks if state.story else ""
        if not state.story:
            return
        self._invitation.set_visibility(False)
        story = next(each for each in STORIES if STEPS[state.story] in each.steps)
        place = story.steps.index(STEPS[state.story])
        self._place.set_text(f"Story for a {story.reader}, {place + 1} of {len(story.steps)}")
        self._sentence.set_text(_unbroken(story.steps[place].sentence))
        near = (story.steps[at : at + 1] for at in (place - 1, place, place + 1))
        for link, steps in zip(self._links.values(), near, strict=True):
            link.set_visibility(bool(steps))
            for step in steps:
                _lead(link, step)
        self._links["Show again"].set_visibility(state != PageState.of_step(story.steps[place]))

    def choose(self) -> None:
        """List all stories with links to their steps."""
        self._dialog = ui.dialog(value=True).props("aria-label=Stories")
        with self._dialog, ui.card().classes("ev-stories"):
            ui.label("Stories").classes("text-lg font-bold").props("role=heading aria-level=2")
            for story in STORIES:
                ui.label(f"{story.title}, for a {story.reader}").classes("font-bold").props(
                    "role=heading aria-level=3"
                )
                with ui.element("ol"):
                    for step in story.steps:
                        with ui.element("li"):
                            _link(_unbroken(step.sentence), step)
            ui.button("Close", on_click=self._dialog.close).props("no-caps")
        self._dialog.on("hide", self._forget)

    def _forget(self) -> None:
        if self._dialog is not None:
            self._dialog.delete()
        self._dialog = None


def _unbroken(sentence: str) -> str:
    """Keep numbers together with their units."""
    return re.sub(r"(?<=\d) ", "\N{NO-BREAK SPACE}", sentence)


def _link(words: str, step: StoryStep | None = None) -> ui.link:
    found = ui.link(words).classes("ev-link")
    if step is not None:
        _lead(found, step)
    return found


def _lead(link: ui.link, step: StoryStep) -> None:
    """Let a link lead to a step of a story."""
    link.props["href"] = f"/?{PageState.of_step(step).to_query()}"
    link.update()


def _close(on_click: Callable[[], object], words: str) -> None:
    ui.button(icon="close", on_click=on_click).props(
        f'flat dense round size=sm color=inherit aria-label="{words}"'
    )


_STYLE: Final = (Path(__file__).parent / "style.css").read_text(encoding="utf-8")
_SCRIPT: Final = (Path(__file__).parent / "page.js").read_text(encoding="utf-8")
_PRIMARY: Final = "#1c5d94"
"""Dark enough for white text."""
WORKERS: Final = 1
"""Threads in which short simulations run, of which a slider repeats one at a time."""
PATIENT_WORKERS: Final = 4
"""Threads in which long simulations, fits, reports and uploads run."""
DROPPED: Final = "dropped"
"""Name of a scenario that was dropped on the page; no link reproduces it."""


def build(own: Mapping[str, Scenario], first: str) -> None:
    """Declare the page; `first` is the name of the scenario that is shown where the address names none."""
    workers = Workers(
        ThreadPoolExecutor(WORKERS, thread_name_prefix="explorer"),
        ThreadPoolExecutor(PATIENT_WORKERS, thread_name_prefix="explorer-patient"),
    )

    def close() -> None:
        end_work()
        for each in (workers.quick, workers.patient):
            each.shutdown(wait=False, cancel_futures=True)

    app.on_shutdown(close)

    @ui.page("/")
    def page(request: Request) -> None:
        VisitorPage(own, first, workers, request.url.query)


class VisitorPage:
    """What one visitor sees, in parts that know the page; `query` is the part of the address behind the question mark."""

    def __init__(self, own: Mapping[str, Scenario], first: str, workers: Workers, query: str) -> None:
        state, mistake = PageState(first), ""
        try:
            state = read_query(query, own=own, default=first)
        except InputError as error:
            mistake = _unread(error)
        self.session = Session(own, state, workers, self._show, self.complain, self._busy, self._tell)
        self.client, self.first = ui.context.client, first
        ui.add_css(_STYLE)
        ui.colors(primary=_PRIMARY)
        self.bar, self.knobs = Bar(self), Knobs(self)
        with ui.column().classes("w-full gap-2"):
            self.message = ui.label(mistake).props("role=alert").classes("text-negative whitespace-pre-line")
            self.guide = Guide(self, is_first=not query)
            self.kept = KeptStrip(self)
            self.plots = Plots(self)
            with self.plots.place:
                self.recording = RecordingPanel(self)
        if self.guide.asks:
            self.knobs.rebuild()
        self.client.on_delete(self._leave)
        ui.on("explorer_back", self._went)
        ui.on("explorer_link", lambda event: self._went(event, is_link=True))
        ui.timer(0.01, lambda: ui.run_javascript(_SCRIPT), once=True)
        ui.timer(0.01, lambda: self.session.ask(self.session.state), once=True)

    def ask(self, state: PageState, *, is_step: bool = True) -> None:
        """Compute another state, and write it into the address.

        `is_step`: the button `back` of the browser leads to the present state; not while a slider moves.
        """
        history = ui.navigate.history
        with self.client:
            (history.push if is_step else history.replace)(f"/?{state.to_query()}")
        self._change(state, is_other=state.preset != self.session.state.preset)

    def take(self, scenario: Scenario) -> None:
        """Show a scenario that was dropped on the page."""
        self.session.own = {**self.session.own, DROPPED: scenario}
        state = PageState(DROPPED, tab=self.session.state.tab)
        self.session.state, self.session.shown = state, None  # shown may be another one of that name
        self.bar.offer(DROPPED)
        self.ask(state)
        self.knobs.rebuild()

    def open(self, tab: str) -> None:
        """Show another tab, which becomes part of the address."""
        if tab != self.session.state.tab:
            self.ask(replace(self.session.state, tab=tab))

    def reset(self) -> None:
        """Take all changes back, with the models and materials that replaced others."""
        self.ask(self.session.state.reset())
        self.knobs.rebuild()

    def swap(self) -> None:
        """Show the state that is kept, and keep the present one in its place."""
        kept = self.session.kept
        if kept is None:
            return
        self.session.keep()
        present = self.session.state
        self._go(replace(kept.state, tab=present.tab, story=present.story))

    def redraw(self) -> None:
        """Show the present result again."""
        if self.session.computed is not None:
            self._show(self.session.computed, self.session.further)

    def complain(self, sentence: str) -> None:
        """Show a sentence about a mistake; an empty one takes it back."""
        with self.client:
            self.message.set_text(sentence)

    def _change(self, state: PageState, *, is_other: bool) -> None:
        self.session.ask(state)
        asked = self.guide.asks
        self.guide.tell(state)
        self.message.set_text("")
        if is_other or self.guide.asks != asked:
            self.knobs.rebuild()

    def _went(self, event: events.GenericEventArguments, *, is_link: bool = False) -> None:
        """Show the state of an address to which the visitor went, back or forward or by a link of the page."""
        try:
            state = read_query(str(event.args).removeprefix("?"), own=self.session.own, default=self.first)
        except InputError as error:
            self.complain(_unread(error))
            return
        self._go(state, is_step=is_link)

    def _go(self, state: PageState, *, is_step: bool = True) -> None:
        """Show a state that the controls do not show yet; `is_step` as for `ask`, without which the address is left as it is."""
        if is_step:
            ui.navigate.history.push(f"/?{state.to_query()}")
        self._change(state, is_other=True)
        self.bar.show(state.preset)
        self.plots.open(state.tab)

    def _leave(self) -> None:
        self.session.stop()
        self.recording.stop()

    def _show(self, found: Computed, further: Further) -> None:
        with self.client:
            self.knobs.show(found)
            self.kept.show()
            self.plots.show(found, further)

    def _tell(self) -> None:
        with self.client:
            self.plots.tell()

    def _busy(self, is_busy: bool) -> None:
        with self.client:
            self.plots.busy(is_busy)


def _unread(error: InputError) -> str:
    return f"The link could not be read: {'; '.join(map(str, error.problems))}"


_SKIP: Final = "() => document.querySelector('[role=tab][aria-selected=true]').focus()"
"""Past the parameters, which are some thirty stops of the keyboard."""
_IS_DARK: Final = "window.matchMedia('(prefers-color-scheme: dark)').matches"


class Bar:
    """Controls that belong to the whole page."""

    def __init__(self, page: VisitorPage) -> None:
        self._page, self._session = page, page.session
        meanings = {each.name: each.meaning for each in scenarios()}
        self._names = {
            name: f"{name}: {meanings.get(name, 'the scenario of this page')}"
            for name in presets(page.session.own)
        }
        with ui.header().classes("items-center gap-x-2 gap-y-0 px-2 py-1"):
            ui.button("Skip to the results").on("click", js_handler=_SKIP).props("no-caps").classes("ev-skip")
            ui.button(icon="menu", on_click=lambda: page.knobs.toggle()).props(  # noqa: PLW0108 - made later
                'flat dense color=white aria-label="Show or hide the parameters"'
            ).tooltip("Show or hide the parameters")
            ui.label("electrovib").classes("text-lg font-bold").props("role=heading aria-level=1")
            self._select = (
                ui.select(
                    self._names,
                    value=page.session.state.preset,
                    label="Scenario",
                    on_change=lambda e: self._choose(e.value),
                )
                .props("dense dark options-dense use-input hide-selected fill-input input-debounce=0")
                .classes("ev-scenario")
            )
            explained = "What to see first: five steps for each kind of visitor"
            _button("Stories", lambda: page.guide.choose(), explained)  # noqa: PLW0108 - made later
            _button("Reset", page.reset, "Take all changes back")
            _button(
                "Keep as A",
                self._keep,
                "Keep this state as A; curves and key figures then show it beside the next ones",
            )
            with _button("Download", None, "Scenario, numbers, figures, report and references"), ui.menu():
                for each in DOWNLOADS:
                    ui.menu_item(each.label, on_click=lambda each=each: self._download(each))
            self._dark = ui.dark_mode(value=False)
            _button("About", self._about, "What electrovibration is, and what this page shows")
            _button("Dark or light", self._change_theme, "Change the colours of the page")
        ui.timer(0.01, self._take_theme_of_browser, once=True)

    @property
    def is_dark(self) -> bool:
        """Whether the page is dark."""
        return bool(self._dark.value)

    def offer(self, name: str) -> None:
        """Add a scenario to the list, and choose it."""
        self._names = {name: f"{name}: the scenario that was dropped on this page"} | self._names
        self._select.set_options(self._names, value=name)

    def show(self, name: str) -> None:
        """Show the name of a scenario that was chosen elsewhere."""
        self._select.set_value(name)

    def _choose(self, name: str) -> None:
        if name in self._names and name != self._session.state.preset:
            self._page.ask(PageState(name, tab=self._session.state.tab))

    def _keep(self) -> None:
        self._session.keep()
        self._page.redraw()

    def _change_theme(self) -> None:
        self._dark.toggle()
        self._page.redraw()

    async def _take_theme_of_browser(self) -> None:
        with suppress(TimeoutError):  # of a browser that does not answer; the page is then a light one
            if await ui.run_javascript(_IS_DARK, timeout=5):
                self._change_theme()

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

    def _about(self) -> None:
        """Show what the page is about."""
        with ui.dialog(value=True).props("aria-label=About") as dialog, ui.card().classes("ev-about"):
            ui.label("Electrovibration").classes("text-lg font-bold").props("role=heading aria-level=2")
            ui.html((Path(__file__).parent / "about.html").read_text(encoding="utf-8"), sanitize=False)
            ui.button("Close", on_click=dialog.close).props("no-caps")
        dialog.on("hide", dialog.delete)


class KeptStrip:
    """The state that is kept as A: what it is, and what can be done with it."""

    def __init__(self, page: VisitorPage) -> None:
        self._page, self._session = page, page.session
        with (
            ui.row()
            .classes("ev-story ev-compared")
            .props('role=region aria-label="Kept as A"') as self._strip
        ):
            self._name = ui.label().classes("ev-sentence")
            for words, work in (("Swap", page.swap), ("Drop", self._drop)):
                ui.button(words, on_click=work).props("flat dense no-caps color=inherit")
        self.show()

    def show(self) -> None:
        """Show which state is kept."""
        kept = self._session.kept
        self._strip.set_visibility(kept is not None)
        self._name.set_text(f"A, dashed: {kept.name}" if kept else "")

    def _drop(self) -> None:
        self._session.earlier = None
        self._page.redraw()


def _button(words: str, on_click: Callable[[], object] | None, explained: str) -> ui.button:
    """Make a button of the bar, with what it does on hover."""
    button = ui.button(words, on_click=on_click).props("flat dense color=white no-caps").classes("px-2")
    with button:
        ui.tooltip(explained)
    return button
