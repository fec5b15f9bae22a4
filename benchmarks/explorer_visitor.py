"""A visitor of the page without a browser: moves one slider over the page's own websocket and times the answers."""

import asyncio
import html
import json
import re
import urllib.request
from time import perf_counter
from typing import Any, Self

import socketio

SLIDER = "Drive: high"
"""Label of the slider that is moved; it changes every plot of the first tab."""
WAIT = 30.0
"""Longest wait for an answer [s]."""


class Visitor:
    """One visitor.

    Parameters
    ----------
    address : str
        Of the page, for instance ``http://127.0.0.1:8080``.
    """

    def __init__(self, address: str) -> None:
        self.address = address
        with urllib.request.urlopen(address + "/", timeout=WAIT) as answer:
            page = answer.read().decode()
        self._client = re.search(r"'client_id': '([^']+)'", page)[1]
        elements = json.loads(
            html.unescape(re.search(r"parseElements\(String\.raw`(.*?)`\)", page, re.DOTALL)[1])
        )
        self._slider, element = next(
            (int(number), each)
            for number, each in elements.items()
            if each.get("props", {}).get("aria-label") == SLIDER and each["tag"] == "q-slider"
        )
        self.position, self.highest = element["props"]["model-value"], element["props"]["max"]
        self._listener = next(
            each["listener_id"] for each in element["events"] if each["type"] == "update:modelValue"
        )
        self.answers = 0
        self._answered = asyncio.Event()
        self._socket = socketio.AsyncClient()
        self._socket.on("update", self._update)

    async def __aenter__(self) -> Self:
        """Connect as the page's script does, and wait for the first plots."""
        query = f"?implicit_handshake=true&client_id={self._client}&tab_id={self._client}&document_id={self._client}"
        await self._socket.connect(
            self.address + "/" + query + "&next_message_id=0",
            headers={"Origin": self.address},
            transports=["websocket"],
            socketio_path="/_nicegui_ws/socket.io",
        )
        await asyncio.wait_for(self._answered.wait(), WAIT)
        return self

    async def __aexit__(self, *_: object) -> None:
        """Leave the page."""
        await self._socket.disconnect()

    async def _update(self, elements: dict[str, Any]) -> None:
        changed = [each for each in elements.values() if isinstance(each, dict)]
        if any("data" in each.get("props", {}).get("options", {}) for each in changed):
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
        message = {
            "id": self._slider,
            "client_id": self._client,
            "listener_id": self._listener,
            "args": [json.dumps(position)],
        }
        await self._socket.emit("event", message)

    async def answered(self) -> None:
        """Wait for the next plots."""
        await asyncio.wait_for(self._answered.wait(), WAIT)

    async def update(self) -> float:
        """Move the slider to its neighbouring position and return the time until the plots have come [s]."""
        begin = perf_counter()
        await self.move(self.neighbour)
        await self.answered()
        return perf_counter() - begin
