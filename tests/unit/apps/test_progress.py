"""Items of a long computation, shown on a terminal and absent elsewhere."""

from __future__ import annotations

import io
import os
import sys
from types import SimpleNamespace

import pytest

from electrovib.apps.progress import items_shown
from electrovib.core.items import computed, each_item, items_heard
from electrovib.view import reproduce as page


class Terminal(io.StringIO):
    def isatty(self):
        return True


def shown(monkeypatch, stream, *, columns=80):
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setattr("shutil.get_terminal_size", lambda: os.terminal_size((columns, 24)))
    with items_shown("reproducing a paper"):
        assert computed([("numbers", lambda: [1, 2]), ("figures of it", list)]) == [(1, 2), ()]
    list(each_item(["after the end"]))
    return stream.getvalue()


def test_each_item_replaces_the_line_of_the_one_before(monkeypatch):
    lines = shown(monkeypatch, Terminal()).split("\r\x1b[K")
    assert lines == [
        "",
        "reproducing a paper, after 0 s: 1 of 2, numbers",
        "reproducing a paper, after 0 s: 2 of 2, figures of it",
        "",
    ]


def test_a_line_is_no_longer_than_the_terminal(monkeypatch):
    lines = shown(monkeypatch, Terminal(), columns=30).split("\r\x1b[K")
    assert max(map(len, lines)) == 29


def test_a_pipe_shows_nothing(monkeypatch):
    assert shown(monkeypatch, io.StringIO()) == ""


def test_the_line_is_removed_after_an_error(monkeypatch):
    monkeypatch.setattr(sys, "stderr", stream := Terminal())

    def interrupted():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), items_shown("reproducing a paper"):
        computed([("numbers", interrupted)])
    assert stream.getvalue().endswith("numbers\r\x1b[K")


def test_the_figures_of_a_reproduction_are_items(monkeypatch):
    heard = []

    found = SimpleNamespace(panels=[SimpleNamespace(id="decay"), SimpleNamespace(id="thresholds")])
    monkeypatch.setattr("electrovib.view.reproduce.drawn", lambda panel: pytest.fail(panel.id))
    with items_heard(lambda *item: heard.append(item)), pytest.raises(pytest.fail.Exception):
        page.contents_of(found)
    assert heard == [("drawing of decay", 1, 2)]
