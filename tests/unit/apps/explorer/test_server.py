"""Addresses that cannot be served are refused with a sentence, before anything is served."""

from __future__ import annotations

import socket
from types import SimpleNamespace

import pytest

import electrovib as ev
from electrovib.apps.explorer.server import _guard, close, listening
from electrovib.core.errors import InputError

pytest.importorskip("nicegui")


@pytest.fixture
def busy():
    """Listen on a port of this machine."""
    with socket.socket() as listening:
        listening.bind(("127.0.0.1", 0))
        listening.listen()
        yield listening.getsockname()[1]


def test_a_port_in_use_is_refused_with_what_to_do(busy):
    words = rf"^port = {busy}: .* at 127\.0\.0\.1 \(another program listens there\); .* omit --port for one that is free$"
    with pytest.raises(InputError, match=words):
        ev.explore(port=busy, browser=False)


def test_without_a_port_the_next_free_one_is_taken(busy, monkeypatch):
    monkeypatch.setattr("electrovib.apps.explorer.server.FIRST_PORT", busy)
    port, sockets = listening("127.0.0.1", None)
    close(sockets)
    assert busy < port < busy + 50


def test_a_port_that_was_chosen_is_taken_before_the_page_is_served(busy, monkeypatch):
    monkeypatch.setattr("electrovib.apps.explorer.server.FIRST_PORT", busy)
    first, sockets = listening("127.0.0.1", None)
    second, others = listening("127.0.0.1", None)
    try:
        assert busy < first < second
        with pytest.raises(InputError, match=f"^port = {first}: .*another program listens there"):
            ev.explore(port=first, browser=False)
    finally:
        close([*sockets, *others])
    again, freed = listening("127.0.0.1", first)
    close(freed)
    assert again == first


def test_every_address_of_a_host_is_taken(busy, monkeypatch):
    monkeypatch.setattr("electrovib.apps.explorer.server.FIRST_PORT", busy)
    wanted = {entry[4][0] for entry in socket.getaddrinfo("localhost", busy, type=socket.SOCK_STREAM)}
    _, sockets = listening("localhost", None)
    found = {each.getsockname()[0] for each in sockets}
    close(sockets)
    assert "127.0.0.1" in found <= wanted


def test_an_address_that_this_machine_does_not_have_is_left_out(monkeypatch):
    known = socket.getaddrinfo
    monkeypatch.setattr(
        socket,
        "getaddrinfo",
        lambda _, *rest, **options: [
            entry for host in ("192.0.2.1", "127.0.0.1") for entry in known(host, *rest, **options)
        ],
    )
    _, sockets = listening("two", None)
    found = [each.getsockname()[0] for each in sockets]
    close(sockets)
    assert found == ["127.0.0.1"]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"port": 0}, "port = 0: a port is a number from 1 to 65535"),
        ({"port": 65536}, "port = 65536: a port is a number"),
        ({"host": ""}, "host is empty: give an address, for instance 127.0.0.1"),
        ({"host": "192.0.2.1", "port": 8080}, r"port = 8080: it cannot be opened at 192\.0\.2\.1 \("),
        ({"host": "no such host.invalid"}, "host = no such host.invalid: no address of this machine"),
        ({"host": "x" * 70}, "host = x+: no address of this machine"),
    ],
)
def test_addresses_that_do_not_exist_are_refused(options, words):
    with pytest.raises(InputError, match=words):
        ev.explore(browser=False, **options)


def test_pages_stand_in_the_order_in_which_they_were_left(monkeypatch):
    from nicegui import App, Client

    app, pages = App(), {name: SimpleNamespace(id=name) for name in "abc"}
    deleted = SimpleNamespace(id="d")
    monkeypatch.setattr(Client, "instances", pages)
    _guard(app, "127.0.0.1", 8080, "")
    for each in (pages["b"], pages["a"], deleted):
        for handler in app._disconnect_handlers:
            handler(each)
    assert list(pages) == ["c", "b", "a"]
