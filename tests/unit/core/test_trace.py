"""The nomenclature, one word, one unit, one meaning: units are stamped from the names, never trusted after arithmetic."""

from __future__ import annotations

from typing import Annotated

import numpy as np
import pytest

from electrovib.core.column_unit import column_unit, is_unit_of
from electrovib.core.errors import ElectrovibError, InputError
from electrovib.core.model import Model, read_model
from electrovib.core.signals import SIGNALS, signal
from electrovib.core.trace import FORMAT, make_trace, stamp
from electrovib.core.units import KINDS


def test_every_signal_has_a_known_unit_and_a_meaning_of_its_own():
    for name, known in SIGNALS.items():
        assert name.isidentifier()
        assert name == name.lower()
        assert known.unit in KINDS, name
        assert known.doc
    endings = ("_v", "_mv", "_n", "_mn", "_s", "_ms", "_us", "_hz", "_khz", "_pa")
    assert not [name for name in SIGNALS if name.endswith(endings)]
    assert len({known.doc for known in SIGNALS.values()}) == len(SIGNALS)
    assert signal("electrostatic_force").unit == "N"
    with pytest.raises(ElectrovibError, match="Did you mean 'electrostatic_force'"):
        signal("electrostatic_forse")


@pytest.fixture
def made():
    variables = {
        "drive_voltage": (("time",), np.array([0.0, 1.0])),
        "field": (("layer", "time"), np.ones((1, 2))),
    }
    places = {"time": np.array([0.0, 1.0]), "layer": np.array(["gap"], dtype=object)}
    return make_trace(variables, places, {"solver": "by hand"})


def test_a_trace_is_stamped(made):
    assert made.drive_voltage.attrs["units"] == "V"
    assert made.drive_voltage.attrs["long_name"] == "voltage of the drive"
    assert made.time.attrs["units"] == "s"
    assert "units" not in made.layer.attrs
    assert made.attrs["format"] == FORMAT
    assert made.attrs["solver"] == "by hand"
    with pytest.raises(ElectrovibError, match="Did you mean 'drive_voltage'"):
        make_trace({"drive_voltag": (("time",), np.zeros(1))}, {"time": np.zeros(1)}, {})


def test_a_stamp_is_that_of_the_name_and_leaves_the_original_and_other_names_alone(made):
    made["drive_voltage"] = made.drive_voltage**2
    made["drive_voltage"].attrs["units"] = "V^2"
    made["mine"] = ("time", np.zeros(2), {"units": "furlong"})
    stamped = stamp(made)
    assert stamped.drive_voltage.attrs["units"] == "V"
    assert made.drive_voltage.attrs["units"] == "V^2"
    assert stamped.mine.attrs == {"units": "furlong"}


class Column(Model):
    """A column of this test."""

    unit: Annotated[str, column_unit("s")] = "s"


@pytest.mark.parametrize(
    ("kind", "units", "others"),
    [
        ("s", ["us", "µs"], ["V", "", "3 us", 5]),
        ("1", ["1", "-", "%"], ["V"]),
        ("V/m", ["kV/mm"], ["V"]),
    ],
)
def test_the_unit_of_a_files_column(kind, units, others):
    assert all(is_unit_of(kind, text) for text in units)
    assert not any(is_unit_of(kind, text) for text in others)
    assert read_model(Column, {"unit": "ms"}).unit == "ms"
    with pytest.raises(InputError, match="the column holds a time: expected a unit such as 's'"):
        read_model(Column, {"unit": "V"})
