"""A running server that is full, or is sent what no page sends: who gives way, who is refused, what is in its log."""

from __future__ import annotations

import asyncio
import json
import os
import subprocess
import sys

import pytest

pytest.importorskip("nicegui")  # its client library is that of the visitor

import aiohttp
from socketio.exceptions import ConnectionError as SocketIOConnectionError
from tests.browser.conftest import started
from tests.browser.visitor import Visitor

from electrovib.apps.explorer.limits import LARGEST_MESSAGE, MOST_CONNECTIONS, MOST_PAGES

pytestmark = pytest.mark.slow


async def opened(port):
    visitor = Visitor(port)
    if (status := await visitor.load()) == 200:
        await visitor.connect()
    return status, visitor


async def opened_after_others(port):
    """Open a page where those of a test before may still fill the server: they are kept for some seconds."""
    while (found := await opened(port))[0] == 503:
        await found[1].close()
        await asyncio.sleep(0.2)
    return found


def test_pages_that_were_left_give_way_and_connected_ones_do_not(server):
    async def run():
        for _ in range(10):
            status, visitor = await opened(server.port)
            assert status == 200
            await visitor.close()
        visitors = []
        for _ in range(MOST_PAGES):
            status, visitor = await opened(server.port)
            assert status == 200
            visitors.append(visitor)
        status, refused = await opened(server.port)
        assert all(each.socket.connected for each in visitors)
        assert (status, "as many as it shows at once" in refused.text) == (503, True)
        await visitors[0].socket.disconnect()
        await visitors[0].connect()  # nobody came meanwhile
        left = visitors.pop()
        await left.socket.disconnect()
        while await refused.load() == 503:  # until the server knows it
            await asyncio.sleep(0.1)
        await refused.connect()
        with pytest.raises(SocketIOConnectionError):
            await left.connect()
        for each in [*visitors, left, refused]:
            await each.close()

    asyncio.run(asyncio.wait_for(run(), 240))


def test_pages_that_are_asked_for_at_once_are_counted(server):
    async def run():
        found = [await asyncio.open_connection("127.0.0.1", server.port) for _ in range(100)]
        for _, writer in found:
            writer.write(
                f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\nConnection: close\r\n\r\n".encode()
            )
        answers = [(await reader.read()).split(b" ", 2)[1] for reader, _ in found]
        for _, writer in found:
            writer.close()
        return answers

    answers = asyncio.run(asyncio.wait_for(run(), 240))
    assert set(answers) == {b"200", b"503"}  # all were answered with a page
    assert answers.count(b"200") < 80  # some of the first may have given way on a slow machine


SOCKET = "/_nicegui_ws/socket.io/?EIO=4&transport="


async def _connected(http, port, query=""):
    try:
        return await http.ws_connect(
            f"http://127.0.0.1:{port}{SOCKET}websocket{query}", headers={"Origin": f"http://127.0.0.1:{port}"}
        )
    except aiohttp.WSServerHandshakeError as error:
        assert error.status == 403
        return None


def test_connections_that_come_at_once_are_limited(server):
    async def run():
        status, visitor = await opened_after_others(server.port)
        assert status == 200
        # a connection on which the server refused a page is closed by it, and cannot be used again
        connector = aiohttp.TCPConnector(limit=0, force_close=True)
        async with aiohttp.ClientSession(connector=connector) as http:
            for query, others in (("", 0), (f"&client_id={visitor.client}", 1)):
                found = await asyncio.gather(*(_connected(http, server.port, query) for _ in range(150)))
                assert sum(each is not None for each in found) == MOST_CONNECTIONS - others
            async with http.get(f"http://127.0.0.1:{server.port}{SOCKET}polling") as answer:
                assert answer.status == 400
            assert (await opened(server.port))[0] == 200
        await visitor.close()

    asyncio.run(asyncio.wait_for(run(), 120))


def _listener(visitor, kind, event):
    return next(
        {"client_id": visitor.client, "id": int(name), "listener_id": listener["listener_id"]}
        for name, each in visitor.elements.items()
        for listener in each.get("events", [])
        if kind in each.get("tag", "") and listener["type"] == event
    )


def _messages(visitor):
    """Messages that leave a line each in the log, and such that leave none."""
    own = {"client_id": visitor.client}
    event = _listener(visitor, "select", "update:modelValue")
    refused = [
        "",
        "x",
        "9",
        "bAAAA",
        b"binary",
        "4",
        "4x",
        "49",
        "44",
        "40[1",
        '42["event",',
        '42["event",null]',
    ]
    refused += ['451-["event",{"_placeholder":true,"num":0}]', '42["unknown",{}]', "42" + "[" * 5000]
    events = [
        ("event", {}),
        ("event", own),
        ("event", {**own, "id": []}),
        ("event", {**event, "listener_id": "x"}),
    ]
    events += [
        ("event", {**event, "args": each})
        for each in (5, "x", [5], ["{"], ['{"a": 1}'], ["[1]"], ['{"value": 9999}'])
    ]
    events += [("handshake", {}), ("ack", own), ("log", own), ("javascript_response", own)]
    events += [("log", {**own, "level": "error", "message": "line\n" * 50})]
    ignored = [{**event, "args": ["null"]}]
    ignored += [
        {**_listener(visitor, "slider", "update:modelValue"), "args": [each]} for each in ("{}", "1e300")
    ]
    ignored += [
        {**_listener(visitor, "input", "update:value"), "args": ["[1]"]},
        _listener(visitor, "input", "blur"),
    ]
    return (
        [*refused, *(f"42{json.dumps(each)}" for each in events)],
        ["42" + "x" * 2 * LARGEST_MESSAGE, "40", *(f"42{json.dumps(['event', each])}" for each in ignored)],
    )


def test_malformed_messages_leave_one_line_each(tmp_path_factory):
    server = started(tmp_path_factory, "malformed")

    async def run():
        status, visitor = await opened(server.port)
        assert status == 200
        one_line, none = _messages(visitor)
        async with aiohttp.ClientSession() as http:
            for each in [*one_line, *none]:
                connection = await _connected(http, server.port)
                await connection.send_str("40")
                await (connection.send_bytes if isinstance(each, bytes) else connection.send_str)(each)
                await connection.close()
        while len(server.log.read_text().splitlines()) < len(one_line):
            await asyncio.sleep(0.1)
        assert visitor.socket.connected
        await visitor.close()
        return len(one_line)

    try:
        number = asyncio.run(asyncio.wait_for(run(), 120))
    finally:
        written = server.stop().splitlines()
    assert "Traceback" not in "\n".join(written)
    assert len(written) == number, written
    assert max(map(len, written)) < 400


_MISTAKEN = """
from electrovib.apps.explorer.page.bar import Bar
from electrovib.apps.explorer.server import explore
def mistaken(self):
    raise ZeroDivisionError
Bar._about = mistaken
explore(browser=False, say=lambda words: print(words, flush=True))
"""


def test_a_mistake_of_our_own_keeps_its_traceback(tmp_path):
    with (tmp_path / "log").open("w") as log:
        process = subprocess.Popen(
            [sys.executable, "-u", "-c", _MISTAKEN],
            stdout=subprocess.PIPE,
            stderr=log,
            text=True,
            env={name: value for name, value in os.environ.items() if not name.startswith("PYTEST")}
            | {"TMPDIR": str(tmp_path), "PYTHONPATH": os.pathsep.join(sys.path)},
        )

    async def run(port):
        visitor = Visitor(port)
        while True:
            try:
                await visitor.load()
                break
            except OSError:
                await asyncio.sleep(0.2)
        await visitor.connect()
        await visitor.event("About", "click", {})
        while "ZeroDivisionError" not in (tmp_path / "log").read_text():
            await asyncio.sleep(0.1)
        await visitor.close()

    try:
        line = process.stdout.readline()
        asyncio.run(asyncio.wait_for(run(int(line.partition("127.0.0.1:")[2].partition("/")[0])), 60))
    finally:
        process.terminate()
        process.wait(20)
        process.stdout.close()
    assert "in mistaken" in (tmp_path / "log").read_text()
