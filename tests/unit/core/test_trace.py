"""Units are stamped from the names, never trusted after arithmetic."""

from __future__ import annotations

import numpy as np
import pytest

from electrovib.core.errors import ElectrovibError
from electrovib.core.trace import FORMAT, make_trace, stamp


def trace():
    return make_trace(
        {"drive_voltage": (("time",), np.array([0.0, 1.0])), "field": (("layer", "time"), np.ones((1, 2)))},
        {"time": np.array([0.0, 1.0]), "layer": np.array(["gap"], dtype=object)},
        {"solver": "by hand"},
    )


def test_a_trace_is_stamped():
    made = trace()
    assert made.drive_voltage.attrs["units"] == "V"
    assert made.drive_voltage.attrs["long_name"] == "voltage of the drive"
    assert made.time.attrs["units"] == "s"
    assert "units" not in made.layer.attrs
    assert made.attrs["format"] == FORMAT
    assert made.attrs["solver"] == "by hand"


def test_arithmetic_does_not_carry_units_on():
    made = trace()
    made["drive_voltage"] = made.drive_voltage**2
    made["drive_voltage"].attrs["units"] = "V^2"
    stamped = stamp(made)
    assert stamped.drive_voltage.attrs["units"] == "V"


def test_stamping_leaves_the_original_alone():
    made = trace()
    made.drive_voltage.attrs["units"] = "wrong"
    stamp(made)
    assert made.drive_voltage.attrs["units"] == "wrong"


def test_other_names_keep_their_attributes():
    made = trace()
    made["mine"] = ("time", np.zeros(2), {"units": "furlong"})
    assert stamp(made).mine.attrs == {"units": "furlong"}


def test_names_outside_the_nomenclature_are_refused():
    with pytest.raises(ElectrovibError, match="Did you mean 'drive_voltage'"):
        make_trace({"drive_voltag": (("time",), np.zeros(1))}, {"time": np.zeros(1)}, {})
