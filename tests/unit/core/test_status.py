"""The status of a source is written for people in one place."""

from __future__ import annotations

from electrovib.core.status import STATUSES, UNVERIFIED, status_text


def test_each_status_has_its_words_and_a_definition_none():
    assert status_text(UNVERIFIED) == "unverified, cited from memory"
    assert status_text("") == "a definition"
    assert len({status_text(status) for status in STATUSES}) == len(STATUSES) == 4
    assert all(status_text(status).startswith(status.split()[0]) for status in STATUSES)
