"""The nomenclature: one word, one unit, one meaning."""

from __future__ import annotations

import pytest

from electrovib.core.errors import ElectrovibError
from electrovib.core.signals import SIGNALS, signal
from electrovib.core.units import KINDS


def test_every_signal_has_a_known_unit_and_a_meaning():
    for name, known in SIGNALS.items():
        assert name.isidentifier()
        assert name == name.lower()
        assert known.unit in KINDS, name
        assert known.doc


def test_no_unit_hides_in_a_name():
    endings = ("_v", "_mv", "_n", "_mn", "_s", "_ms", "_us", "_hz", "_khz", "_pa")
    assert not [name for name in SIGNALS if name.endswith(endings)]


def test_meanings_differ():
    meanings = [known.doc for known in SIGNALS.values()]
    assert len(set(meanings)) == len(meanings)


def test_unknown_signals_are_refused_with_the_nearest():
    assert signal("electrostatic_force").unit == "N"
    with pytest.raises(ElectrovibError, match="Did you mean 'electrostatic_force'"):
        signal("electrostatic_forse")
