"""What a browser sends over its websocket: anything but the messages of the page is refused, with one line in the log."""

from __future__ import annotations

import functools
import inspect
import itertools
import logging
import re
from collections.abc import Callable, Iterable, Mapping, MutableMapping
from traceback import walk_tb
from typing import Any, Final

import orjson
from socketio.exceptions import SocketIOError  # type: ignore[import-untyped]

from electrovib.apps.explorer.access import App, Receive, Scope, Send
from electrovib.apps.explorer.limits import LONGEST_NAME

LOG: Final = logging.getLogger(__name__)
MOST_LINES: Final = 100
"""Lines in the log about messages that were refused; a sender without end would fill the disk."""
_LINES: Final = itertools.count(1)
_KNOWN: Final = re.compile(r"1|3|40(\{\})?|41|42\d{0,9}(?P<event>\[.*)", re.DOTALL)
"""Messages of the framework's client: close, pong, connect, disconnect, and an event that may ask for an answer."""
_INVALID: Final = 1007
"""Code with which a websocket is closed."""


class Frames:
    """Checks of the messages, events of given names, that reach an ASGI application over websockets."""

    def __init__(self, app: App, *, events: Iterable[str]) -> None:
        self._app, self._events = app, frozenset(events) - {"connect", "disconnect"}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Hand a connection to the application; it ends with the first message that is not one of the page."""
        if scope["type"] != "websocket":
            await self._app(scope, receive, send)
            return

        async def checked() -> MutableMapping[str, Any]:
            message = await receive()
            if message["type"] == "websocket.receive" and (mistake := self._mistake(message)):
                log(mistake, message.get("bytes") if message.get("text") is None else message["text"])
                await send({"type": "websocket.close", "code": _INVALID, "reason": mistake})
                return {"type": "websocket.disconnect", "code": _INVALID}
            return message

        await self._app(scope, checked, send)

    def _mistake(self, message: MutableMapping[str, Any]) -> str:
        """Return what is wrong with a message; empty if nothing is."""
        text = message.get("text")
        if text is None:
            return "binary data"
        found = _KNOWN.fullmatch(text)
        if found is None:
            return "no message of the page"
        if found["event"] is None:
            return ""
        try:
            event = orjson.loads(found["event"])
        except ValueError as error:
            return f"an event that cannot be read ({error})"[:100]
        match event:
            case [str(name), dict()] if name in self._events:
                return ""
        return "no event of the page"


def check_events(handlers: MutableMapping[str, Any]) -> None:
    """Let each handler of an event refuse what it cannot read with one line in the log.

    Handlers are those of the framework, by the name of the event; mistakes of a function of the page do not
    reach them.
    """
    for name in handlers.keys() - {"disconnect"}:
        handlers[name] = _checked(name, _report if name == "log" else handlers[name])


def _checked(name: str, handler: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(handler)
    async def call(sender: str, *message: Any) -> Any:
        try:
            answer = handler(sender, *message)
            return await answer if inspect.isawaitable(answer) else answer
        except SocketIOError:  # the answer to a page that is no longer there
            raise
        except Exception as error:  # noqa: BLE001 - whatever the framework raises for it
            content = message[0]
            log(f"the event '{name}' ({type(error).__name__}: {error})", content.get("QUERY_STRING", content))
            return False

    return call


def _report(_: str, message: Mapping[str, Any]) -> None:
    """Write what a browser reports of itself into the log."""
    if message["level"] in ("warning", "error"):
        log("a report", message["message"])


def is_kept(record: logging.LogRecord) -> bool:
    """Return whether a report of the framework stays in the log: not of a value that it cannot read, which is one line.

    Nor is one kept of a browser that has not answered, which every visitor causes who leaves early.
    """
    error = record.msg
    if not isinstance(error, Exception):
        return True
    if any(frame.f_code.co_name == "_event_args_to_value" for frame, _ in walk_tb(error.__traceback__)):
        log(f"a value ({type(error).__name__}: {error})")
        return False
    return not isinstance(error, TimeoutError)


def log(what: str, content: object = "") -> None:
    """Write one line, unless there are `MOST_LINES` of them."""
    number = next(_LINES)
    if number <= MOST_LINES:
        line = f"A browser sent something that is not used ({what}): {str(content)[:LONGEST_NAME]}"
        LOG.warning("%s", line.encode("unicode_escape").decode())
    if number == MOST_LINES:
        LOG.warning("Further messages of this kind are not written.")
