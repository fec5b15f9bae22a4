"""Maps of a rough contact show the place that was asked for."""

from dataclasses import replace

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.view import plots


@pytest.fixture(scope="module")
def found():
    rough = ev.SelfAffine(rms=2e-6, hurst=0.8, longest=1e-3, roll_off=2.5e-4, shortest=2.5e-4)
    body = ev.Elastic(modulus=1e5)
    found = ev.rough_contact("bau_2010/sine", roughness=rough, body=body, voltage=[0.0, 20.0, 500.0, 20.0])
    return replace(found, rests=(*found.rests[:3], found.rests[0]))  # two maps at 20 V that differ


@pytest.mark.parametrize("quantity", ["gap", "pressure", "attraction"])
def test_each_quantity_at_the_largest_voltage_or_the_last_time_of_one(found, quantity):
    for voltage, place in ((None, 2), (20.0, 3), ("20 V", 3), (0.0, 0)):
        ax = plots.contact_map(found, quantity=quantity, voltage=voltage)
        shown = ax.images[0].get_array()
        rest = found.rests[place]
        np.testing.assert_array_equal(np.ma.getdata(shown), getattr(rest, quantity))
        if quantity == "gap":
            np.testing.assert_array_equal(np.ma.getmaskarray(shown), rest.pressure > 0)
        assert f"{100 * rest.contact_share:.3g} % of the area touch" in ax.get_title(loc="left")
        assert ax.images[0].get_extent() == [0.0, 1e-3, 0.0, 1e-3]


def test_what_was_not_computed_is_refused(found):
    with pytest.raises(InputError, match="voltage = 21 V: the contact was computed at 0, 20, 500 V"):
        plots.contact_map(found, voltage=21.0)
    for other in ("field", ["gap"]):
        with pytest.raises(InputError, match="expected one of gap, pressure, attraction"):
            plots.contact_map(found, quantity=other)
    with pytest.raises(InputError, match="voltage = high"):
        plots.contact_map(found, voltage="high")
