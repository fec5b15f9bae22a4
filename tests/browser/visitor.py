"""A visitor without a browser: the requests and the websocket messages of the framework's own client."""

import asyncio
import contextlib
import html
import io
import json
import re
import time
from urllib.parse import urlencode

import aiohttp
import socketio


class Visitor:
    """One open page of a server on loopback."""

    def __init__(self, port: int) -> None:
        self.address, self.number = f"http://127.0.0.1:{port}", time.time_ns()
        # an idle connection is left before the server ends it, which a busy machine notices too late
        self.http = aiohttp.ClientSession(connector=aiohttp.TCPConnector(keepalive_timeout=1))
        # as in a browser: a websocket over the connection that the page came over would be ended as an idle one
        self.upgraded = aiohttp.ClientSession()
        self.socket = socketio.AsyncClient(http_session=self.upgraded, reconnection=False)
        self.elements: dict[str, dict] = {}
        self.socket.on("update", self._update)
        self.socket.on("run_javascript", self._answer)

    async def load(self, query: str = "") -> int:
        """Load the page, and return the status of the answer."""
        async with self.http.get(f"{self.address}/{query}") as answer:
            self.text = await answer.text()
            if answer.status == 200:
                found = re.search(r"parseElements\(String.raw`(.*?)`\)", self.text, re.DOTALL)[1]
                self.elements = json.loads(html.unescape(found))
                self.client = re.search(r"client_id'?: '([^']+)'", self.text)[1]
            return answer.status

    async def connect(self) -> None:
        """Open the websocket."""
        query = {
            "client_id": self.client,
            "next_message_id": 0,
            "implicit_handshake": "true",
            "tab_id": f"tab {self.number}",
            "old_tab_id": "",
            "document_id": f"document {self.number}",
        }
        await self.socket.connect(
            f"{self.address}?{urlencode(query)}",
            headers={"Origin": self.address},
            transports=["websocket"],
            socketio_path="/_nicegui_ws/socket.io",
        )

    async def close(self) -> None:
        """Leave."""
        if self.socket.connected:
            await self.socket.disconnect()
        await self.upgraded.close()
        await self.http.close()

    def _update(self, changed):
        for name, element in changed.items():
            if element is None:
                self.elements.pop(name, None)
            elif name != "_id":
                self.elements[name] = element

    async def _answer(self, request):
        if "request_id" in request:
            answer = {"client_id": self.client, "request_id": request["request_id"], "result": None}
            with contextlib.suppress(socketio.exceptions.BadNamespaceError):  # the page was left
                await self.socket.emit("javascript_response", answer)

    def _of(self, key: str, value: str | None = None) -> dict:
        return next(
            each
            for each in self.elements.values()
            if (value is None and key in each.get("props", {})) or each.get("props", {}).get(key) == value
        )

    @property
    def alert(self) -> str:
        """The sentence on a mistake; empty if there is none."""
        return self._of("role", "alert").get("text") or ""

    @property
    def texts(self) -> str:
        """All texts of the page."""
        return "\n".join(str(each.get("text") or "") for each in self.elements.values())

    async def until(self, true, seconds: float = 90.0) -> None:
        """Wait until something is true."""
        for _ in range(int(20 * seconds)):
            if true():
                return
            if not self.socket.connected:
                break
            await asyncio.sleep(0.05)
        raise TimeoutError

    async def upload(self, name: bytes, content: bytes) -> int:
        """Send a file as a browser does, whatever its name, and return the status of the answer."""
        start = b'--line\r\nContent-Disposition: form-data; name="file"; filename="' + name + b'"\r\n\r\n'
        url = next(each["props"]["url"] for each in self.elements.values() if "url" in each.get("props", {}))
        async with self.http.post(
            self.address + url,
            data=io.BytesIO(start + content + b"\r\n--line--\r\n"),
            headers={"Origin": self.address, "Content-Type": "multipart/form-data; boundary=line"},
        ) as answer:
            await answer.read()
            return answer.status

    async def sentence_on(self, name: bytes, content: bytes) -> str:
        """Send a file, and return what the page states about it."""
        self._of("role", "alert")["text"] = ""
        seen = self.texts
        assert await self.upload(name, content) == 200
        await self.until(lambda: self.alert or "Which column" in self.texts.replace(seen, ""))
        return self.alert

    def listener(self, kind: str, event: str) -> dict:
        """Return the address of the first listener to an event of an element of a kind."""
        return next(
            {"id": int(name), "listener_id": listener["listener_id"]}
            for name, each in self.elements.items()
            for listener in each.get("events", [])
            if kind in each.get("tag", "") and listener["type"] == event
        )

    async def event(self, label: str, kind: str, *arguments: object) -> None:
        """Send an event of an element that is found by one of its properties or its text."""
        found = [
            {"id": int(number), "client_id": self.client, "listener_id": listener["listener_id"]}
            for number, each in self.elements.items()
            for listener in each.get("events", [])
            if label in (each.get("text"), *each.get("props", {}).values()) and listener["type"] == kind
        ]
        if not found:
            raise LookupError(label)
        await self.socket.emit("event", found[0] | {"args": [json.dumps(each) for each in arguments]})
