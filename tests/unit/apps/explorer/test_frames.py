"""Messages over a websocket that are none of the page, and what is written about them."""

import asyncio
import itertools
import logging

import pytest

pytest.importorskip("nicegui")
from socketio.exceptions import ConnectionRefusedError as Refused

from electrovib.apps.explorer import access
from electrovib.apps.explorer.access import MOST_LINES, Frames, check_events, is_kept

EVENTS = ("connect", "disconnect", "event", "ack")
GOOD = ["1", "3", "40", "40{}", "41", '42["event",{}]', '4217["ack",{"a":[1]}]', '42["event",{"a":"\\n"}]']
MALFORMED = r"""
x
0
2probe
9
bAAAA
4
40[1
43[]
42
42[]
451-["event",{"_placeholder":true,"num":0}]
42["event",
42["event",{}]x
42["event",{},{}]
42["event",null]
42["other",{}]
42[[],{}]
42["connect",{}]
42["disconnect",{}]
429999999999["event",{}]
42["event",{"a":NaN}]
²
""".strip().splitlines()


@pytest.fixture
def lines(monkeypatch):
    found = []
    monkeypatch.setattr(access, "_LINES", itertools.count(1))
    monkeypatch.setattr(access.LOG, "warning", lambda text, *parts: found.append(text % parts))
    return found


def through(messages):
    """Send messages through the check; return what the application received, and what the browser."""
    received, sent, waiting = [], [], [{"type": "websocket.connect"}]
    for each in messages:
        form = "bytes" if isinstance(each, bytes) else "text"
        waiting.append({"type": "websocket.receive", form: each})
    waiting.append({"type": "websocket.disconnect", "code": 1000})

    async def app(scope, receive, send):
        received.append(await receive())
        while received[-1]["type"] != "websocket.disconnect":
            received.append(await receive())

    async def receive():
        return waiting.pop(0)

    async def send(message):
        sent.append(message)

    asyncio.run(Frames(app, events=EVENTS)({"type": "websocket"}, receive, send))
    return received, sent


def test_messages_of_the_page_and_other_requests_pass(lines):
    received, sent = through(GOOD)
    assert [each["text"] for each in received[1:-1]] == GOOD
    assert (sent, lines) == ([], [])
    seen = []

    async def app(scope, receive, send):
        seen.append(receive)

    asyncio.run(Frames(app, events=EVENTS)({"type": "http"}, "receive", None))
    assert seen == ["receive"]


OTHERS = ["", "42" + "[" * 5000, b"abc", b'42["event",{}]']


@pytest.mark.parametrize("message", [*MALFORMED, *OTHERS], ids=lambda each: ascii(each)[:30])
def test_any_other_message_ends_the_connection_with_one_line(message, lines):
    received, sent = through([message, GOOD[0]])
    assert [each["type"] for each in received] == ["websocket.connect", "websocket.disconnect"]
    assert [(each["type"], each["code"]) for each in sent] == [("websocket.close", 1007)]
    assert len(sent[0]["reason"].encode()) <= 123
    assert len(lines) == 1
    assert lines[0].endswith(": " + str(message)[:120].encode("unicode_escape").decode())
    assert len(lines[0]) < 400
    assert "\n" not in lines[0]


def test_a_handshake_that_cannot_be_read_is_one_line_with_its_address(lines):
    def connect(_, environment, authority=None):
        raise Refused("no page") if environment["QUERY_STRING"] else KeyError("client_id")

    check_events(handlers := {"connect": connect})
    with pytest.raises(Refused):
        asyncio.run(handlers["connect"]("a", {"QUERY_STRING": "a=1"}, None))
    assert lines == []
    assert asyncio.run(handlers["connect"]("a", {"QUERY_STRING": "", "more": "x"}, None)) is False
    assert len(lines) == 1
    assert "more" not in lines[0]


def test_a_report_of_a_browser_is_one_line_and_the_number_of_lines_is_limited(lines):
    check_events(handlers := {"log": None})
    for level in ("debug", "info", "warning", "error"):
        asyncio.run(handlers["log"]("a", {"level": level, "message": f"{level}\n" * 50}))
    assert [each.split("): ")[1][:7] for each in lines] == ["warning", "error\\n"]
    assert max(map(len, lines)) < 250
    for number in range(MOST_LINES + 50):
        access.log(f"line {number}.")
    assert len(lines) == MOST_LINES + 1
    assert f"line {MOST_LINES - 3}." in lines[-2]
    assert "not written" in lines[-1]


def logged(message):
    return logging.LogRecord("nicegui", logging.ERROR, "", 0, message, None, None)


def raised(function):
    with pytest.raises(Exception) as caught:
        function()
    return logged(caught.value)


def test_mistakes_of_our_own_stay_in_the_log_and_those_of_a_browser_are_one_line_or_none(lines):
    from nicegui.elements.select import Select

    assert is_kept(raised(lambda: 1 / 0))
    assert is_kept(logged("text"))
    assert not is_kept(logged(TimeoutError()))  # a browser that does not answer
    assert lines == []
    assert not is_kept(raised(lambda: Select._event_args_to_value(None, None)))
    assert len(lines) == 1
    assert "a value (AttributeError" in lines[0]
