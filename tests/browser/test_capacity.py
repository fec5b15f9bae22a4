"""A running server that is left early, or is sent what no page sends: what is refused, what is in its log."""

import asyncio
import json

import pytest

pytest.importorskip("nicegui")  # its client library is that of the visitor

import aiohttp
from tests.browser.conftest import started
from tests.browser.visitor import Visitor

from electrovib.apps.explorer.runner import LARGEST_MESSAGE

pytestmark = pytest.mark.slow


async def opened(port):
    visitor = Visitor(port)
    assert await visitor.load() == 200
    await visitor.connect()
    return visitor


LEFT_AT_ONCE = "import electrovib.apps.explorer.server as server; server.UNCONNECTED = 0.1"


def test_visitors_who_leave_while_something_is_made_leave_nothing_in_the_log(tmp_path_factory):
    server = started(tmp_path_factory, "left", code=f"{LEFT_AT_ONCE}\n")

    async def run():
        visitors = [await opened(server.port) for _ in range(4)]
        for each in visitors:
            await each.until(lambda each=each: "mN" in each.texts)
            for name, element in each.elements.items():
                if element.get("tag") == "q-item":
                    for one in element.get("events", []):
                        to = {"id": int(name), "client_id": each.client, "listener_id": one["listener_id"]}
                        await each.socket.emit("event", to | {"args": ["{}"]})
        await asyncio.gather(*(each.close() for each in visitors))
        await asyncio.sleep(15)

    asyncio.run(asyncio.wait_for(run(), 120))
    assert "Traceback" not in server.stop()


SOCKET = "/_nicegui_ws/socket.io/?EIO=4&transport="


async def _connected(http, port):
    address = f"http://127.0.0.1:{port}"
    return await http.ws_connect(f"{address}{SOCKET}websocket", headers={"Origin": address})


def test_messages_come_over_a_checked_connection_alone(server):
    async def run():
        async with (
            aiohttp.ClientSession() as http,
            http.get(f"http://127.0.0.1:{server.port}{SOCKET}polling") as answer,
        ):
            assert answer.status == 400

    asyncio.run(asyncio.wait_for(run(), 60))


REFUSED = ("", "x", "9", "bAAAA", b"binary", "4", "4x", "49", "44", "40[1", '42["event",', '42["event",null]')
MORE = ('451-["event",{"_placeholder":true,"num":0}]', '42["unknown",{}]', "42" + "[" * 5000)
ARGUMENTS = (5, "x", [5], ["{"], ['{"a": 1}'], ["[1]"], ['{"value": 9999}'])


def _messages(visitor):
    """Messages that leave a line each in the log, and such that leave none."""
    own = {"client_id": visitor.client}
    event = own | visitor.listener("select", "update:modelValue")
    wrong = [{}, own, {**own, "id": []}, {**event, "listener_id": "x"}]
    wrong += [{**event, "args": each} for each in ARGUMENTS]
    events = [("event", each) for each in wrong]
    events += [("handshake", {}), ("ack", own), ("log", own), ("javascript_response", own)]
    events += [("log", {**own, "level": "error", "message": "line\n" * 50})]
    slider = own | visitor.listener("slider", "update:modelValue")
    ignored = [{**event, "args": ["null"]}, *({**slider, "args": [each]} for each in ("{}", "1e300"))]
    ignored += [{**own, **visitor.listener("input", "update:value"), "args": ["[1]"]}]
    ignored += [own | visitor.listener("input", "blur")]
    none = ["42" + "x" * 2 * LARGEST_MESSAGE, "40", *(f"42{json.dumps(['event', each])}" for each in ignored)]
    return [*REFUSED, *MORE, *(f"42{json.dumps(each)}" for each in events)], none


def test_malformed_messages_leave_one_line_each(tmp_path_factory):
    server = started(tmp_path_factory, "malformed")

    async def run():
        visitor = await opened(server.port)
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


MISTAKEN = """
from electrovib.apps.explorer.page.build import Bar
def mistaken(self):
    raise ZeroDivisionError
Bar._about = mistaken
"""


def test_a_mistake_of_our_own_keeps_its_traceback(tmp_path_factory):
    server = started(tmp_path_factory, "mistaken", code=MISTAKEN)

    async def run():
        visitor = await opened(server.port)
        await visitor.event("About", "click", {})
        while "ZeroDivisionError" not in server.log.read_text():
            await asyncio.sleep(0.1)
        await visitor.close()

    try:
        asyncio.run(asyncio.wait_for(run(), 60))
    finally:
        log = server.stop()
    assert "in mistaken" in log
