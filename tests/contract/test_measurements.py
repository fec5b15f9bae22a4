"""Every declared measurement: a set-up that runs, units, sources of what is not printed, and how its numbers came here."""

import re

import numpy as np
import pytest

from electrovib.core.citation import STATUSES
from electrovib.core.signals import SIGNALS
from electrovib.core.units import KINDS
from electrovib.scenario.space.reading import read_space
from electrovib.studies.evidence.files import measurements
from electrovib.studies.evidence.measurement import divisor, unit_of
from electrovib.studies.evidence.predicted import candidates, predict

MEASURED = measurements()
FIRST = {re.sub(r"\d+", "", name): name for name in reversed(MEASURED)}.values()
"""One measurement of those whose names differ in a number alone: the same set-up at other values."""


@pytest.mark.parametrize("name", MEASURED)
def test_a_measurement_says_where_it_is_from_and_in_which_unit(name):
    each = MEASURED[name]
    assert each.title
    assert each.group
    assert each.source
    assert each.unit in KINDS
    if not callable(each.quantity) and not divisor(each) and each.scale == 1:
        assert SIGNALS[each.quantity.partition(" ")[2].partition(" in ")[0]].unit == each.unit
    if not callable(each.quantity) and divisor(each) and each.scale == 1:
        assert unit_of(each.quantity, divisor(each), each.scenario) == each.unit
    for path, table in each.unknown.items():
        assert table.get("source") or table.get("choice"), (
            f"{path}: a range has a source, or is called a choice"
        )
        assert not table.get("source") or table.get("status") in STATUSES, path
    for model, own in each.of_model.items():
        assert model in candidates(each), model
        assert all(table is None or table.get("source") or table.get("choice") for table in own.values())
    if each.unknown:
        assert set(read_space(each.scenario, {"space": dict(each.unknown)}).paths) == set(each.unknown)


@pytest.mark.parametrize(
    "name", [pytest.param(each, marks=() if each in FIRST else pytest.mark.slow) for each in MEASURED]
)
def test_a_measurement_can_be_predicted(name):
    each = MEASURED[name]
    found, refused = predict(each, n=2)
    assert found, f"no candidate predicts it: {refused}"
    assert len(found) + len(refused) == len(candidates(each))
    assert not [why for why in refused.values() if "() of '" in why], "a function of ours fails"
    for one in found:
        assert one.values.shape == (2, len(each.values))
        assert np.isfinite(one.values).all()
