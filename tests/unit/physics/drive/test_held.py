"""Held samples with edges, against their values written out."""

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.physics.drive.base import Drive
from electrovib.scenario import read_part


def held(edge, times=(0, 1, 2, 5), volts=(1, 10, 4, 0)):
    samples = {"model": "Sampled", "time_samples": list(times), "voltage_samples": list(volts)}
    return read_part(Drive, {"model": "Held", "samples": samples, "edge": edge})


@pytest.mark.parametrize(
    ("edge", "ends", "volts"),
    [
        (0, 5, [1, 1, 1, 10, 10, 10, 4, 4, 4, 0]),
        (0.4, 5.4, [0, 0.5, 1, 1, 5.5, 10, 10, 4, 4, 2]),
        (1, 6, [0, 0.2, 0.9, 1, 2.8, 9.1, 10, 4, 4, 3.2]),
    ],
)
def test_levels_and_edges(edge, ends, volts):
    drive = held(edge)
    times = [0, 0.2, 0.9, 1, 1.2, 1.9, 2, 3, 4.99, 5.2]
    np.testing.assert_allclose(drive.voltage(times), volts, rtol=1e-12)
    assert drive.duration == pytest.approx(ends)
    assert drive.largest() == 10
    assert drive.voltage(6.0) == 0


def test_an_edge_of_one_interval_is_a_line_one_interval_later():
    times = np.arange(1000) * 1.7e-5  # not representable: an edge ends where the next begins, to the rounding
    volts = np.sin(np.arange(1000))
    drive = held(float(np.min(np.diff(times))), times, volts)
    moments = np.linspace(1e-4, 0.0169, 5003)
    np.testing.assert_allclose(drive.voltage(moments), np.interp(moments - 1.7e-5, times, volts), atol=1e-8)
    assert len(drive.parts()[0].times) == 1001


def test_an_edge_longer_than_an_interval_is_refused():
    with pytest.raises(
        InputError, match=r"edge of 1\.1 s is longer than the shortest interval between samples, 1 s"
    ):
        held(1.1)
