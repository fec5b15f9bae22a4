"""How much the server takes: bytes of a request."""

import asyncio

import pytest

from electrovib.apps.explorer.access import RequestLimits
from electrovib.apps.explorer.runner import LARGEST_REQUEST, LARGEST_UPLOAD

START = {"type": "http.response.start", "status": 200, "headers": []}


async def failing(scope, receive, send):
    raise ZeroDivisionError


def call(parts, *, headers=(), path="/_nicegui/client/x/upload/1", kind="http", app=None):
    """Send a request in parts; return the bytes that the application received, and what was sent back."""
    received, sent, waiting = [], [], list(parts)

    async def read(scope, receive, send):
        more = kind == "http"
        while more:
            message = await receive()
            if message["type"] == "http.disconnect":
                raise ConnectionError("the sender has left")
            received.append(len(message["body"]))
            more = message["more_body"]
        await send(START)
        await send({"type": "http.response.body", "body": b"page"})

    async def receive():
        part = waiting.pop(0)
        if part is None:
            return {"type": "http.disconnect"}
        return {"type": "http.request", "body": bytes(part), "more_body": bool(waiting)}

    async def send(message):
        sent.append(message)

    scope = {"type": kind, "path": path, "headers": [(k.encode(), v.encode()) for k, v in headers]}
    asyncio.run(RequestLimits(app or read)(scope, receive, send))
    return sum(received), sent


def test_a_request_reaches_the_application_up_to_the_limit():
    assert LARGEST_UPLOAD < LARGEST_REQUEST < 1.05 * LARGEST_UPLOAD
    half = LARGEST_REQUEST // 2
    received, sent = call([half, LARGEST_REQUEST - half], headers=[("content-length", str(LARGEST_REQUEST))])
    assert received == LARGEST_REQUEST
    assert sent[0]["status"] == 200
    received, sent = call([1_000_000] * 22)  # which declares nothing, and is counted
    assert received == 20_000_000
    assert [each.get("status") for each in sent] == [413, None]
    assert call([5, None]) == (5, [])  # a sender that leaves is no error
    with pytest.raises(ZeroDivisionError):
        call([5], app=failing)


@pytest.mark.parametrize("length", [str(LARGEST_REQUEST + 1), "1e3", "-1", ""])
def test_a_request_that_declares_too_much_is_not_read(length):
    received, sent = call([5], headers=[("Content-Length", length)])
    assert received == 0
    assert sent[0]["status"] == 413
    assert b"at most" in sent[1]["body"]
    assert (b"x-content-type-options", b"nosniff") in sent[0]["headers"]


@pytest.mark.parametrize("kind", ["lifespan", "websocket"])
def test_other_scopes_reach_the_application(kind):
    assert call([], kind=kind, path="/")[1][0]["status"] == 200
