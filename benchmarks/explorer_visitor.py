"""A visitor of the page without a browser, who moves one slider and times the answers."""

import asyncio
from time import perf_counter
from typing import Any, Self

from tests.browser.visitor import Visitor

SLIDER = "Drive: high"
"""Label of the slider that is moved; it changes every plot of the first tab."""
WAIT = 30.0
"""Longest wait for an answer [s]."""


class MovingVisitor(Visitor):
    """One open page of a server on loopback.

    Parameters
    ----------
    port : int
        Of the server.
    """

    def __init__(self, port: int) -> None:
        super().__init__(port)
        self.answers = 0
        self._answered = asyncio.Event()

    async def __aenter__(self) -> Self:
        """Open the page, and wait for its first plots."""
        await self.load()
        slider = next(
            each for each in self.elements.values() if each.get("props", {}).get("aria-label") == SLIDER
        )
        self.position, self.highest = slider["props"]["model-value"], slider["props"]["max"]
        await self.connect()
        await self.answered()
        return self

    async def __aexit__(self, *_: object) -> None:
        """Leave the page."""
        await self.close()

    def _update(self, changed: dict[str, Any]) -> None:
        super()._update(changed)
        elements = [each for each in changed.values() if isinstance(each, dict)]
        if any("data" in each.get("props", {}).get("options", {}) for each in elements):
            self.answers += 1
            self._answered.set()

    @property
    def neighbour(self) -> int:
        """A position beside the present one."""
        return self.position + (1 if self.position < self.highest - 40 else -40)

    async def move(self, position: int) -> None:
        """Move the slider, without waiting."""
        self._answered.clear()
        self.position = position
        await self.event(SLIDER, "update:modelValue", position)

    async def answered(self) -> None:
        """Wait for the next plots."""
        await asyncio.wait_for(self._answered.wait(), WAIT)

    async def update(self) -> float:
        """Move the slider to its neighbouring position and return the time until the plots have come [s]."""
        begin = perf_counter()
        await self.move(self.neighbour)
        await self.answered()
        return perf_counter() - begin
