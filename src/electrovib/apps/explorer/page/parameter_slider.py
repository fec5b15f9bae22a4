"""The slider of a parameter."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from nicegui import ui

from electrovib.apps.explorer.controls import STEPS


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
