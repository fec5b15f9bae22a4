"""How much the server takes: bytes of a request, and open pages."""

from __future__ import annotations

import asyncio

import pytest

from electrovib.apps.explorer.capacity import RequestLimits
from electrovib.apps.explorer.limits import LARGEST_REQUEST, LARGEST_UPLOAD, MOST_PAGES


def call(parts, *, headers=(), pages=0, path="/_nicegui/client/x/upload/1", kind="http", app=None):
    """Send a request in parts; return the bytes that the application received, and what was sent back."""
    received, sent, waiting = [], [], list(parts)

    async def read(scope, receive, send):
        while True:
            message = await receive()
            if message["type"] == "http.disconnect":
                raise ConnectionError("the sender has left")
            received.append(len(message["body"]))
            if not message["more_body"]:
                break
        await send({"type": "http.response.start", "status": 200, "headers": []})
        await send({"type": "http.response.body", "body": b"page"})

    async def receive():
        part = waiting.pop(0)
        if part is None:
            return {"type": "http.disconnect"}
        return {"type": "http.request", "body": bytes(part), "more_body": bool(waiting)}

    async def send(message):
        sent.append(message)

    scope = {"type": kind, "path": path, "headers": [(k.encode(), v.encode()) for k, v in headers]}
    asyncio.run(RequestLimits(app or read, open_pages=lambda: pages)(scope, receive, send))
    return sum(received), sent


def test_a_request_reaches_the_application_up_to_the_limit():
    assert LARGEST_UPLOAD < LARGEST_REQUEST < 1.05 * LARGEST_UPLOAD
    half = LARGEST_REQUEST // 2
    received, sent = call([half, LARGEST_REQUEST - half], headers=[("content-length", str(LARGEST_REQUEST))])
    assert received == LARGEST_REQUEST
    assert sent[0]["status"] == 200


@pytest.mark.parametrize("length", [str(LARGEST_REQUEST + 1), "1e3", "-1", ""])
def test_a_request_that_declares_too_much_is_not_read(length):
    received, sent = call([5], headers=[("Content-Length", length)])
    assert received == 0
    assert sent[0]["status"] == 413
    assert b"at most" in sent[1]["body"]
    assert (b"x-content-type-options", b"nosniff") in sent[0]["headers"]


def test_a_request_that_declares_nothing_is_counted():
    received, sent = call([1_000_000] * 22)
    assert received == 20_000_000
    assert [each.get("status") for each in sent] == [413, None]


def test_a_sender_that_leaves_is_no_error():
    assert call([5, None]) == (5, [])


def test_an_error_of_the_application_stays_one():
    async def broken(scope, receive, send):
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        call([5], app=broken)


def test_pages_are_limited_and_what_belongs_to_open_ones_is_served():
    received, sent = call([1], pages=MOST_PAGES, path="/")
    assert (received, sent[0]["status"]) == (0, 503)
    assert b"as many as it shows at once" in sent[1]["body"]
    assert call([1], pages=MOST_PAGES, path="/missing")[1][0]["status"] == 503
    assert call([1], pages=MOST_PAGES - 1, path="/")[1][0]["status"] == 200
    assert call([1], pages=MOST_PAGES)[1][0]["status"] == 200


def test_other_scopes_reach_the_application():
    seen = []

    async def app(scope, receive, send):
        seen.append(scope["type"])

    for kind in ("lifespan", "websocket"):
        call([], kind=kind, path="/", pages=MOST_PAGES, app=app)
    assert seen == ["lifespan", "websocket"]
