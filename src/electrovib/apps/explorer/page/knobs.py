"""Sliders and fields of the parameters, and the search over them."""

from __future__ import annotations

import functools
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from nicegui import ui

from electrovib.apps.explorer.controls import SECTIONS, STEPS, choices, chosen, controls, parameters_of
from electrovib.apps.explorer.state import scenario_of
from electrovib.core.errors import InputError, nearest

if TYPE_CHECKING:
    from electrovib.apps.explorer.computed import Computed
    from electrovib.apps.explorer.controls import Choice, Control
    from electrovib.apps.explorer.page.build import VisitorPage
    from electrovib.scenario import Scenario

MOST_IMPORTANT: Final = 11
"""Parameters that a page shows first."""
_AIR: Final = 1.0
"""Relative permittivity of a layer of air, which nobody changes."""


def _of(section: str, *units: str) -> Callable[[Control], bool]:
    """Return the test for the parameters of a section in some units; in any unit where none is given."""
    return lambda each: each.section == section and (not units or each.unit in units)


def _of_materials(*units: str) -> Callable[[Control], bool]:
    return lambda each: _of("stack", *units)(each) and ".material." in each.path and each.value != _AIR


KINDS: Final[tuple[Callable[[Control], bool], ...]] = (
    _of("drive", "V", "A"),  # levels
    _of("friction"),
    _of("load"),
    lambda each: _of("stack")(each) and each.path.endswith(".thickness"),
    lambda each: each.unit == "m2",  # areas of the contact and of other electrodes
    _of("force", "m"),  # gaps of a law that has its own
    _of("motion", "m"),  # a gap that changes
    lambda each: _of_materials()(each) and each.path.endswith(".permittivity"),
    _of("drive", "1"),  # depth of a modulation
    _of("drive", "Hz"),
    _of_materials("S/m"),
    _of_materials("1"),  # how a material changes with frequency
    _of("drive", "s"),
)
"""Kinds of parameters on which the force depends most, the most important kind first.

A test compares them with the elasticities of the forces of every shipped scenario.
"""


def important(offered: Sequence[Control]) -> list[Control]:
    """Return the parameters that a page shows first, `MOST_IMPORTANT` at most, in the order of the page.

    They are those of the first of `KINDS` that have a value other than 0.
    """
    valued = [each for each in offered if each.value]
    ranked = dict.fromkeys(each.path for kind in KINDS for each in valued if kind(each))
    first = list(ranked)[:MOST_IMPORTANT]
    return [each for each in offered if each.path in first]


def words_of(typed: str) -> list[str]:
    """Return the words that were typed, in small letters; an underscore or a dot ends a word."""
    return re.sub(r"[_.,:]", " ", typed.casefold()).split()


def is_found(words: Sequence[str], texts: Sequence[str]) -> bool:
    """Return whether every word occurs in one of the texts."""
    text = " ".join(words_of(" ".join(texts)))
    return all(word in text for word in words)


_ALSO: Final = {"stratum_corneum": "skin", "insulator": "film coating", "friction": "lateral force"}
"""Other words for parts of dotted paths."""


def texts_of(control: Control) -> tuple[str, ...]:
    """Return the texts in which a parameter is searched: section, name, dotted path, meaning and other words for its parts."""
    also = (_ALSO.get(part, "") for part in control.path.split("."))
    return control.label, control.path, control.meaning, *also


def not_found(words: Sequence[str], offered: Sequence[Control]) -> str:
    """Write that no parameter has the words, with the nearest name for the first word that none has."""
    for word in words:
        if not any(is_found([word], texts_of(each)) for each in offered):
            known = {each for control in offered for each in words_of(control.label)}
            return f"No parameter is called '{word}'.{nearest(word, known)}"
    return "No parameter has all of these words; leave one out."


_FIRST: Final = "important"
"""Name of the group of parameters that a page shows first."""


@dataclass
class _Group:
    """Parameters below one heading; their rows are made when they are first shown."""

    heading: str
    controls: list[Control]
    place: ui.expansion
    is_made: bool = False


@dataclass
class _Row:
    """Elements of a parameter; one without a value has no slider."""

    control: Control
    column: Any
    field: Any
    slider: ParameterSlider | None = None


class Knobs:
    """A slider and a field for each parameter of the scenario: the important ones first, then sections that open.

    Words in the search field show the parameters that they find, of all sections.
    """

    def __init__(self, page: VisitorPage) -> None:
        self._page, self._session = page, page.session
        self._rows: dict[str, _Row] = {}
        self._groups: list[_Group] = []
        self._lists: list[tuple[Choice, Any]] = []
        self._accepted: dict[str, str] = {}
        self._open = {_FIRST: True}
        self._silent = False
        self._moving = ""
        self._unread: set[str] = set()  # what is being typed
        self._drawer = ui.left_drawer(value=None, bordered=True).props("width=320").classes("p-1")
        with self._drawer:
            with ui.column().classes("w-full gap-0"):
                self._search = self._make_search()
                self._found = ui.label().classes("text-sm px-3").props("role=status")
            self._choices = ui.column().classes("w-full gap-0 px-3")
            self._place = ui.column().classes("w-full gap-0")
        self.rebuild()

    def toggle(self) -> None:
        """Show or hide the parameters."""
        self._drawer.toggle()

    def rebuild(self) -> None:
        """Make the lists and controls of another scenario."""
        own, state = self._session.own, self._session.state
        base, scenario = scenario_of(state.reset(), own=own), self._scenario()
        self._choices.clear()
        with self._choices:
            self._lists = [
                (each, self._choose(each, each.present(state, scenario))) for each in choices(base)
            ]
        self._rebuild_rows(scenario)

    def _scenario(self) -> Scenario:
        """Return the scenario of the page; the one that is shown where the page has a mistake."""
        own, state = self._session.own, self._session.state
        try:
            return scenario_of(state, own=own)
        except InputError:
            found = self._session.computed
            return found.scenario if found is not None else scenario_of(state.reset(), own=own)

    def _rebuild_rows(self, scenario: Scenario) -> None:
        """Make the controls of a scenario; they begin at its values."""
        offered = controls(scenario)
        first = important(offered)
        self._rows, self._groups, self._moving, self._unread = {}, [], "", set()
        self._place.clear()
        with self._place:
            self._group(_FIRST, "Most important here", first)
            ui.label("All other parameters").classes("text-sm px-4 pt-2 ev-others")
            for section, heading in SECTIONS.items():
                if mine := [each for each in offered if each.section == section and each not in first]:
                    self._group(section, heading, mine)
        self._lend()
        self._mark_changed()
        self._show_found()

    def _lend(self) -> None:
        """Put the row of the parameter that a story asks for beside its sentence."""
        guide = getattr(self._page, "guide", None)  # which is made later
        if guide is None:
            return
        guide.place.clear()
        for group in self._groups:
            if any(each.path == guide.asks for each in group.controls):
                self._make_rows(group)
                self._rows[guide.asks].column.move(guide.place)

    def _group(self, name: str, heading: str, mine: list[Control]) -> None:
        """Make a part that opens and closes, and remember whether it is open."""

        def moved(event: Any) -> None:
            self._open[name] = event.value
            if event.value:
                self._make_rows(group)

        place = ui.expansion(heading, value=self._open.get(name, False), on_value_change=moved)
        place.classes("w-full" + (" ev-first" if name == _FIRST else ""))
        place.props("dense header-class=font-bold")
        group = _Group(heading, mine, place)
        self._groups.append(group)
        if place.value:
            self._make_rows(group)

    def _make_rows(self, group: _Group) -> None:
        """Make the rows of a group when it is first shown, with the present values."""
        if group.is_made:
            return
        group.is_made = True
        scenario = self._scenario()
        values = {path: value for path, value, _ in parameters_of(scenario)}
        with group.place:
            made = {each.path: self._row(each) for each in group.controls if each.path in values}
        self._rows |= made
        self._give_sliders(scenario, values)
        self._write(values, made)
        self._mark_changed()

    def _make_search(self) -> Any:
        """Make the field for words that find parameters."""
        field = ui.input(placeholder="Search the parameters", on_change=self._show_found)
        field.props('dense outlined clearable debounce=100 aria-label="Search the parameters"')
        field.on("keydown.esc", lambda _: field.set_value(""))
        return field.classes("w-full px-3 pt-1 ev-search")

    def _show_found(self) -> None:
        """Show the parameters and choices that have all words of the search, or everything without a search."""
        words = words_of(str(self._search.value or ""))
        count = 0
        for group in self._groups:
            found = {each.path for each in group.controls if is_found(words, texts_of(each))}
            if words and found:
                self._make_rows(group)
            for each in group.controls:
                if each.path in self._rows:
                    self._rows[each.path].column.set_visibility(each.path in found)
            group.place.set_visibility(bool(found or not words))
            count += len(found)
        fitting = [is_found(words, [choice.label]) for choice, _ in self._lists]
        for (_, element), is_fitting in zip(self._lists, fitting, strict=True):
            element.set_visibility(is_fitting)
        self._place.classes(**{"add" if words else "remove": "ev-searching"})
        offered = [each for group in self._groups for each in group.controls]
        is_any = count or any(fitting)
        sentence = f"{count} of {len(offered)} parameters" if is_any else not_found(words, offered)
        self._found.set_text(sentence if words else "")

    def _mark_changed(self) -> None:
        """Mark the parameters that differ from the scenario, and count them in the heading of their group."""
        changes = self._session.state.changes
        for group in self._groups:
            count = sum(each.path in changes for each in group.controls)
            heading = f"{group.heading} ({count} changed)" if count else group.heading
            if group.place.text != heading:
                group.place.set_text(heading)
        for path, row in self._rows.items():
            row.column.classes(**{"add" if path in changes else "remove": "ev-changed"})

    def show(self, found: Computed) -> None:
        """Write the values of a result into fields and sliders; an earlier one only into the field of a slider that moves."""
        values = {path: value for path, value, _ in parameters_of(found.scenario)}
        if is_latest := self._session.shown == self._session.state:
            if any(path.startswith("perception.") and path not in values for path in self._rows):
                self._rebuild_if_other()
            self._give_sliders(found.scenario, values)
            self._mark_changed()
        self._write(values, self._rows if is_latest else {self._moving} & self._rows.keys())

    def _write(self, values: Mapping[str, float | None], paths: Iterable[str]) -> None:
        """Write the values of some parameters into their fields and sliders."""
        self._silent = True
        for path in paths:
            if path not in values:
                continue
            row = self._rows[path]
            value, text = values[path], row.control.written(values[path])
            if row.field.value != text and path not in self._unread:
                row.field.set_value(text)
            if row.slider is not None and value is not None and path != self._moving:
                row.slider.show(row.control.position(value), text)
        self._silent = False

    def _rebuild_if_other(self) -> None:
        """Make the controls again, unless they are those of the state of the page and an earlier result is shown."""
        scenario = self._scenario()
        if not self._rows.keys() <= {path for path, _, _ in parameters_of(scenario)}:
            self._rebuild_rows(scenario)

    def _give_sliders(self, scenario: Scenario, values: Mapping[str, float | None]) -> None:
        """Give a slider to each parameter that has got its first value, and take it from one that has none any more."""
        rows = self._rows
        if any(row.slider is None and values.get(path) is not None for path, row in rows.items()):
            for each in controls(scenario):
                row = rows.get(each.path)
                if row is not None and row.slider is None and each.value is not None:
                    self._slide(row, each)
        for path, row in rows.items():
            if row.slider is not None and path in values and values[path] is None:
                row.slider.delete()
                row.slider = None

    def _choose(self, choice: Choice, present: str) -> Any:
        """Make the list of alternatives for one part."""
        options = {**choice.options}
        options.setdefault(present, present)
        return (
            ui.select(
                options, value=present, label=choice.label, on_change=lambda e: self._chosen(choice, e.value)
            )
            .props("dense options-dense")
            .classes("w-full")
        )

    def _chosen(self, choice: Choice, name: str) -> None:
        state = self._session.state
        if name not in choice.options or name == choice.present(state, self._scenario()):
            return
        try:
            wanted = chosen(state, choice, name, self._session.own)
        except InputError:  # which is reported when it is computed
            wanted = state.changed(choice.path, name)
        self._page.ask(wanted)
        self._rebuild_rows(self._scenario())

    def _row(self, control: Control) -> _Row:
        """Make name, field and slider of a parameter; meaning, range and source stand beside it under the pointer."""
        with ui.column().classes("w-full gap-0 ev-row") as column:
            row = _Row(control, column, self._field(control))
        if control.value is not None:
            self._slide(row, control)
        row.field.on("blur", lambda _: self._typed(row))
        row.field.on("keydown.enter", lambda _: self._typed(row))
        row.field.on("keydown.esc", lambda _: self._give_up(row))
        place = 'anchor="center right" self="center left" max-width=22rem delay=300'
        with column:
            ui.tooltip(control.help).props(place).classes("text-sm")
        return row

    def _slide(self, row: _Row, control: Control) -> None:
        """Make the slider of a parameter."""
        assert control.value is not None
        row.control = control
        with row.column:
            row.slider = ParameterSlider(
                words=control.label,
                position=control.position(control.value),
                text=control.written(control.value),
                on_move=functools.partial(self._moved, control),
            )

    def _field(self, control: Control) -> Any:
        """Make the name of a parameter and the field of its value."""

        def begins(_: object) -> None:
            if not self._silent:  # no result replaces what is being typed
                self._unread.add(control.path)

        with ui.row().classes("w-full items-center justify-between no-wrap"):
            with ui.label().classes("text-sm leading-tight ev-name"):
                ui.label(f"{SECTIONS[control.section]}: ").classes(f"ev-section ev-of-{control.section}")
                ui.label(control.name)
            return (
                ui.input(value=control.written(control.value), placeholder="not set", on_change=begins)
                .props(f'dense borderless input-class="text-right" aria-label="{control.label}, value"')
                .classes("w-28 ev-field")
            )

    def _give_up(self, row: _Row) -> None:
        """Show the present value again in place of what was typed, and take a value back that was refused."""
        path = row.control.path
        row.field.set_value(row.control.written(self._value(path)))
        self._unread.discard(path)
        if path in self._session.state.changes and self._is_refused():
            self._set(path, self._accepted.get(path, ""))

    def _moved(self, control: Control, position: float) -> str:
        """Ask for the value at a position of a slider, and return it with its unit."""
        is_other = control.path != self._moving
        self._moving = control.path  # a slider is not set while it is moved: it would jump back
        text = control.written(control.at(position))
        self._page.ask(self._session.state.changed(control.path, text), is_step=is_other)
        return text

    def _typed(self, row: _Row) -> None:
        """Take what was typed; an empty field gives the parameter back the value of the scenario."""
        path, text, state = row.control.path, str(row.field.value or "").strip(), self._session.state
        if path not in self._unread:
            return
        self._unread.discard(path)
        is_refused = self._is_refused()
        is_present = text == row.control.written(self._value(path)) and not is_refused
        if is_present or text == state.changes.get(path):
            return
        self._moving = ""
        if not is_refused:
            self._accepted[path] = state.changes.get(path, "")
        self._set(path, text)

    def _set(self, path: str, text: str) -> None:
        """Ask for a value, without a text for that of the scenario."""
        state = self._session.state
        self._page.ask(state.changed(path, text) if text else state.reset(path))

    def _is_refused(self) -> bool:
        """Return whether the scenario of the page has a mistake, so that an earlier result is shown."""
        try:
            scenario_of(self._session.state, own=self._session.own)
        except InputError:
            return True
        return False

    def _value(self, path: str) -> float | None:
        """Return the value of a parameter in the scenario of the page."""
        return {each: value for each, value, _ in parameters_of(self._scenario())}.get(path)


class ParameterSlider(ui.slider, component="parameter_slider.js"):
    """A slider that states its value with its unit to a screen reader.

    `text` is the value with its unit at the position at the start, from 0 to `STEPS`; `on_move` takes each
    position to which a visitor moves the slider and returns the text at it.
    """

    def __init__(self, *, words: str, position: float, text: str, on_move: Callable[[float], str]) -> None:
        super().__init__(min=0, max=STEPS, step=1, value=position, on_change=self._moved)
        assert self.component is not None
        self.tag = self.component.tag  # in place of the slider of Quasar, which the component wraps
        self._on_move, self._is_silent = on_move, False
        self._props |= {"dense": True, "aria-label": words, "text": text, "placed": 0}

    def show(self, position: float, text: str) -> None:
        """Place the slider at the position nearest to a value, which the text states, without a call of `on_move`."""
        self._state(text)
        if position == self.value:
            return
        self._is_silent = True
        self._props["placed"] += 1
        self.set_value(position)
        self._is_silent = False

    def _moved(self, event: Any) -> None:
        """State the value of the new position, in the update that returns the position to the browser."""
        position = event.value
        if not self._is_silent and isinstance(position, int | float):
            self._state(self._on_move(position))

    def _state(self, text: str) -> None:
        if self._props["text"] != text:
            self._props["text"] = text
            self.update()
