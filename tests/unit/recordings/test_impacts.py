"""Impacts in a long record of a load cell: found, measured, and taken for no edges."""

import numpy as np
import pytest
from test_ring import mode
from typer.testing import CliRunner

from electrovib.apps.cli import app
from electrovib.core.errors import InputError
from electrovib.core.trace import make_trace
from electrovib.recordings.transitions import measure_ring, measure_rings, measure_times
from electrovib.recordings.transitions.impacts import find_impacts


def cell(rng, *, frequency, quality, rate=20e3, length=4.0, impacts=3, noise=0.01, drift=0.02):
    """Load cell that is struck several times, with a linear and a slow periodic drift."""
    time = np.arange(round(length * rate)) / rate
    values = noise * rng.standard_normal(time.size) + drift * time + 0.1 * np.sin(2 * np.pi * time / 37)
    struck = length / (impacts + 1) * (np.arange(1, impacts + 1) + rng.uniform(-0.2, 0.2, impacts))
    for at in struck:
        size, phase = rng.uniform(0.5, 2.0) * rng.choice([-1, 1]), rng.uniform(-0.6, 0.6)
        values += mode(time - at, frequency=frequency, quality=quality, amplitude=size, phase=phase)
    return recorded(time, values), struck


def recorded(time, values):
    return make_trace({"normal_force_measured": (("time",), values)}, {"time": time}, {})


@pytest.mark.parametrize(
    ("frequency", "quality"),
    [
        (200.0, 3.0),
        pytest.param(380.0, 8.0, marks=pytest.mark.slow),
        pytest.param(600.0, 30.0, marks=pytest.mark.slow),
    ],
)
def test_every_impact_is_found_and_measured(frequency, quality):
    trace, struck = cell(np.random.default_rng(1), frequency=frequency, quality=quality)
    found = measure_rings(trace)
    assert [each.reference for each in found.rings] == pytest.approx(struck, abs=0.6 / frequency)
    assert found.frequency.value == pytest.approx(frequency, rel=0.005)
    assert found.quality.value == pytest.approx(quality, rel=0.03)
    assert found.frequency.count == 3
    assert not any(text.startswith("Warning") for text in found.words)
    largest = max(found.rings, key=lambda each: np.abs(each.values).max())
    assert measure_ring(trace).parameters["frequency"] == largest.parameters["frequency"]


def test_a_ring_is_no_edge_and_a_release_that_rings_is_one():
    trace, _ = cell(np.random.default_rng(2), frequency=300.0, quality=10.0, drift=0.0)
    with pytest.raises(InputError, match=r"no clear edge.*after 3 impacts"):
        measure_times(trace)
    values = trace["normal_force_measured"].copy()
    values[:] = values + np.where(trace["time"] > 3.6, 2.0, 0.0)  # one load that stays
    stepped = trace.assign(normal_force_measured=values)
    found = measure_times(stepped)
    assert [each.record.reference for each in found.rising.edges] == pytest.approx([3.6], abs=1e-3)
    assert found.falling is None


def test_a_drive_that_is_switched_often_is_no_oscillation():
    time = np.arange(40_000) / 20e3
    rng = np.random.default_rng(3)
    for duty in (0.3, 0.5, 0.7):
        values = ((time * 10) % 1 < duty) + 0.01 * rng.standard_normal(time.size)
        assert not any(each.returns for each in find_impacts(time, values))


def test_noise_has_no_impact_and_no_edge():
    time = np.arange(40_000) / 20e3
    values = 0.01 * np.random.default_rng(4).standard_normal(time.size)
    assert find_impacts(time, values) == []
    for measure in (measure_rings, measure_ring):
        with pytest.raises(InputError, match="never leaves the noise"):
            measure(recorded(time, values))
    with pytest.raises(InputError, match="times its noise") as caught:
        measure_times(recorded(time, values))
    assert len(caught.value.problems) == 1


def test_the_next_impact_ends_an_oscillation():
    """Two impacts 30 ms apart: the second strikes before the first has come to rest."""
    time = np.arange(40_000) / 20e3
    values = 0.002 * np.random.default_rng(5).standard_normal(time.size)
    for at, size in ((0.8, 1.0), (0.83, 1.5)):
        values += mode(time - at, frequency=400.0, quality=12.0, amplitude=size)
    found = measure_rings(recorded(time, values))
    assert [each.reference for each in found.rings] == pytest.approx([0.8, 0.83], abs=1.5e-3)
    assert found.rings[0].time[-1] < 0.03
    for each in found.rings:
        assert each.parameters["frequency"].value == pytest.approx(400.0, rel=0.01)
        assert each.parameters["quality"].value == pytest.approx(12.0, rel=0.05)


def test_the_command_answers_for_a_record_without_edges(tmp_path):
    trace, struck = cell(np.random.default_rng(6), frequency=380.0, quality=8.0, impacts=2, length=2.0)
    trace.to_netcdf(tmp_path / "cell.nc")
    result = CliRunner().invoke(
        app, ["times", str(tmp_path / "cell.nc"), "--ring", "-o", str(tmp_path / "out")]
    )
    assert result.exit_code == 0, result.output
    assert "mean of 2 impacts" in result.output
    assert "No time between levels: the signal has no clear edge" in result.output
    assert "more mistakes" not in result.output
    assert f"impact at {struck[0]:.3f}" in result.output
    table = (tmp_path / "out" / "times.csv").read_text()
    assert table.count("impact at") >= 4
    assert "after 2 impacts" in (tmp_path / "out" / "report.html").read_text()


@pytest.mark.slow
@pytest.mark.parametrize(("frequency", "quality"), [(200.0, 3.0), (380.0, 8.0)])
def test_intervals_of_impacts_hold_frequency_and_quality(frequency, quality):
    inside, count = np.zeros(4), 0
    for seed in range(8):
        found = measure_rings(cell(np.random.default_rng(seed), frequency=frequency, quality=quality)[0])
        for each in found.rings:
            of = each.parameters
            inside[:2] += (
                of["frequency"].lower < frequency < of["frequency"].upper,
                of["quality"].lower < quality < of["quality"].upper,
            )
            count += 1
        mean = found.frequency, found.quality
        inside[2:] += mean[0].lower < frequency < mean[0].upper, mean[1].lower < quality < mean[1].upper
    assert count == 24
    assert (inside[:2] >= 20).all()  # 22.8 of 24 are expected, fewer than 20 in one of 200 cases
    assert (inside[2:] >= 6).all()
