"""A statement on a result has one of three states."""

from __future__ import annotations

import pytest

from electrovib.core.diagnostics import STATES, Diagnostic


def test_a_diagnostic_is_plain_text():
    diagnostic = Diagnostic("Paschen", "warning", "above 800 V")
    assert diagnostic.to_dict() == {"name": "Paschen", "state": "warning", "text": "above 800 V"}
    assert {"ok", "warning", "unknown"} == set(STATES)


def test_unknown_states_are_refused():
    with pytest.raises(ValueError, match="'red' is not one of"):
        Diagnostic("Paschen", "red", "above 800 V")
