"""The animation of one pulse, which the browser plays without the server."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from nicegui import ui


class PulsePlayer(ui.element, component="pulse_player.js"):
    """Layers with their charges beside the force, with a button that plays and a slider of the time."""

    def __init__(self) -> None:
        super().__init__()
        self._props["pulse"] = {}
        self.set_visibility(False)

    def show(self, pulse: Mapping[str, Any]) -> None:
        """Show what `electrovib.apps.explorer.fading.animation` returns, at the present place of the slider; nothing if empty."""
        if pulse and self._props["pulse"] != pulse:
            self._props["pulse"] = dict(pulse)
            self.update()
        self.set_visibility(bool(pulse))
