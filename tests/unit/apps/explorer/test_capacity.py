"""How much the server takes: bytes of a request, open pages and connections."""

import asyncio
import time
import uuid

import pytest

from electrovib.apps.explorer.limits import LARGEST_REQUEST, LARGEST_UPLOAD, MOST_CONNECTIONS, MOST_PAGES
from electrovib.apps.explorer.server import FIRST_CONNECTION, RequestLimits, has_room

LOOP = asyncio.new_event_loop()
ROOT = {"type": "http", "path": "/", "headers": []}
START = {"type": "http.response.start", "status": 200, "headers": []}
LONG = 60 * FIRST_CONNECTION


class Page:
    """What is asked of an open page of the framework."""

    def __init__(self, pages, *, connected=False, was_connected=False, age=0.0):
        self.pages, self.id = pages, str(uuid.uuid4())
        self.has_socket_connection, self.environ = connected, {} if was_connected or connected else None
        self.created, self.waiting = time.time() - age, asyncio.Future(loop=LOOP)
        self._delete_tasks = {"document": self.waiting} if was_connected else {}
        pages[self.id] = self

    def delete(self):
        assert all(each.cancelled() for each in self._delete_tasks.values())
        del self.pages[self.id]


def filled(**first):
    """Fill a server with connected pages, and with two before them that are described."""
    pages = {}
    found = [Page(pages, **first), Page(pages, **first)]
    while len(pages) < MOST_PAGES:
        Page(pages, connected=True, age=LONG)
    return pages, found


async def failing(scope, receive, send):
    raise ZeroDivisionError


def call(parts, *, headers=(), full=False, path="/_nicegui/client/x/upload/1", kind="http", app=None):
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
    pages = filled(connected=True)[0] if full else {}
    asyncio.run(RequestLimits(app or read, pages=pages)(scope, receive, send))
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


def test_pages_are_limited_and_what_belongs_to_open_ones_is_served():
    received, sent = call([1], full=True, path="/")
    assert (received, sent[0]["status"]) == (0, 503)
    assert b"as many as it shows at once" in sent[1]["body"]
    assert call([1], full=True, path="/missing")[1][0]["status"] == 503
    assert call([1], path="/")[1][0]["status"] == 200
    assert call([1], full=True)[1][0]["status"] == 200
    for kind in ("lifespan", "websocket"):  # other scopes reach the application
        assert call([], kind=kind, path="/", full=True)[1][0]["status"] == 200


@pytest.mark.parametrize("first", [{"was_connected": True}, {"age": 1.01 * FIRST_CONNECTION}])
def test_a_full_server_closes_the_page_that_was_left_first(first):
    pages, (oldest, other) = filled(**first)
    assert has_room(pages)
    assert oldest.id not in pages
    assert other.id in pages
    assert len(pages) == MOST_PAGES - 1
    assert has_room(pages)
    assert len(pages) == MOST_PAGES - 1  # a server that is not full closes none
    pages, _ = filled(**first)
    Page(pages, connected=True)
    assert has_room(pages)
    assert len(pages) == MOST_PAGES - 1  # pages beyond the limit give way too


@pytest.mark.parametrize("first", [{"connected": True, "age": LONG}, {"age": 0.8 * FIRST_CONNECTION}])
def test_a_full_server_closes_no_page_that_is_connected_or_awaited(first):
    pages, _ = filled(**first)
    assert not has_room(pages)
    assert len(pages) == MOST_PAGES


def opened(number, *, age, pages):
    """Ask for pages at the same time; return the status of each answer."""
    statuses = []

    async def app(scope, receive, send):
        for _ in range(5):
            await asyncio.sleep(0)
        Page(pages, age=age)
        await send(START)
        await asyncio.sleep(0.01)  # the next one does not wait for a slow receiver

    async def send(message):
        statuses.append(message.get("status"))

    async def run():
        limits = RequestLimits(app, pages=pages)
        await asyncio.gather(*(limits(ROOT, None, send) for _ in range(number)))

    asyncio.run(run())
    return [each for each in statuses if each is not None]


@pytest.mark.parametrize("age", [0.0, LONG])
def test_pages_that_are_asked_for_at_once_are_counted(age):
    pages = {}
    served = opened(MOST_PAGES + 40, age=age, pages=pages).count(200)
    assert MOST_PAGES <= served <= MOST_PAGES + 1  # one of them had been opened when the others came
    assert len(pages) == MOST_PAGES
    pages, _ = filled(connected=True)
    pages.popitem()
    assert sorted(opened(3, age=0.0, pages=pages)) == [200, 503, 503]
    assert len(pages) == MOST_PAGES


def test_a_slow_receiver_or_a_failed_page_holds_up_nobody():
    statuses = []

    async def run():
        begun, both = [], asyncio.Event()

        async def app(scope, receive, send):
            await send(START)
            begun.append(scope)
            if len(begun) == 2:
                both.set()
            await both.wait()

        async def send(message):
            statuses.append(message.get("status"))

        limits = RequestLimits(app, pages={})
        await asyncio.gather(*(limits(ROOT, None, send) for _ in range(2)))
        for _ in range(MOST_PAGES + 5):
            await limits(ROOT, None, send)
        limits = RequestLimits(failing, pages={})
        for _ in range(2):
            with pytest.raises(ZeroDivisionError):
                await limits(ROOT, None, None)

    asyncio.run(asyncio.wait_for(run(), 10))
    assert statuses == [200] * (MOST_PAGES + 7)


def test_connections_of_a_page_and_of_none_are_limited():
    pages, closed = {}, []
    first, second = Page(pages, connected=True), Page(pages, connected=True)

    async def run():
        release = asyncio.Event()

        async def app(scope, receive, send):
            await release.wait()

        async def receive():
            return {"type": "websocket.connect"}

        async def send(message):
            closed.append(message["code"])

        limits = RequestLimits(app, pages=pages)

        def connect(query):
            scope = {"type": "websocket", "path": "/_nicegui_ws/socket.io/", "query_string": query}
            return asyncio.create_task(limits(scope, receive, send))

        queries = [b"client_id=%s" % name for name in (first.id.encode(), second.id.encode(), b"other")]
        tasks = [connect(query) for query in [*queries, b""] for _ in range(MOST_CONNECTIONS)]
        await asyncio.sleep(0)
        assert len(closed) == MOST_CONNECTIONS  # "other" and none count together
        tasks += [connect(query) for query in queries]
        await asyncio.sleep(0)
        assert len(closed) == MOST_CONNECTIONS + 3
        release.set()
        await asyncio.gather(*tasks)
        await connect(queries[0])
        assert len(closed) == MOST_CONNECTIONS + 3

    asyncio.run(asyncio.wait_for(run(), 10))
    assert set(closed) == {1008}
