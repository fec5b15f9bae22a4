"""Stories on the page: an invitation to them, their list, and a strip with the step that is told above its results."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Final

from nicegui import ui

from electrovib.apps.explorer.state import PageState
from electrovib.apps.explorer.stories import STEPS, STORIES, StoryStep

if TYPE_CHECKING:
    from electrovib.apps.explorer.page.build import VisitorPage

FOLLOW: Final = """
document.addEventListener('click', event => {
  const link = event.target.closest('a.ev-link');
  if (!link || event.button || event.ctrlKey || event.metaKey || event.shiftKey || event.altKey) return;
  event.preventDefault();
  emitEvent('explorer_link', link.search);
});
const bar = document.querySelector('.q-header');
new ResizeObserver(() => document.body.style.setProperty('--ev-top', `${bar.offsetHeight}px`)).observe(bar);
"""
"""A link of the page is followed without loading it again, unless it is opened elsewhere; the strip stays below the bar."""


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
