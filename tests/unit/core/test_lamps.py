"""A statement on a result has one of three states."""

from __future__ import annotations

import pytest

from electrovib.core.lamps import STATES, Lamp


def test_a_lamp_is_plain_text():
    lamp = Lamp("Paschen", "warning", "above 800 V")
    assert lamp.to_dict() == {"name": "Paschen", "state": "warning", "text": "above 800 V"}
    assert {"ok", "warning", "unknown"} == set(STATES)


def test_unknown_states_are_refused():
    with pytest.raises(ValueError, match="'red' is not one of"):
        Lamp("Paschen", "red", "above 800 V")
