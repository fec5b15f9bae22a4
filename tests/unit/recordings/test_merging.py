"""Two records with clocks of their own become one Trace."""

import json

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.core.signals import make_trace
from electrovib.recordings.importing.merging import match_edges
from electrovib.recordings.importing.reduction import SignalEdges

SHIFT, RATIO = 0.37, 1 + 80e-6
RISES, FALLS = np.array([0.5, 1.1, 1.9, 2.35]), np.array([0.8, 1.5, 2.2, 2.7])


def pulses(time, rises=RISES, falls=FALLS):
    state = np.searchsorted(rises, time, side="right") - np.searchsorted(falls, time, side="right")
    return 100.0 * state


def trace(time, **signals):
    variables = {name: (("time",), values) for name, values in signals.items()}
    return make_trace(variables, {"time": time}, {"validity": "[]", "history": "read", "file": "a.csv"})


def scope(**extra):
    time = np.arange(0, 3, 1e-4)
    return trace(time, drive_voltage=pulses(time), **extra)


def daq(shift=SHIFT, ratio=RATIO, begin=-0.2, end=2.6):
    """A record whose clock is behind and slower: reference time = shift + ratio own time."""
    own = np.arange(begin, end, 5e-4)
    event = shift + ratio * own
    return trace(own, plate_voltage=pulses(event), lateral_force_measured=np.sin(3 * event))


def edges(rising, falling=()):
    times = np.array([*rising, *falling], float)
    signs = np.array([1] * len(rising) + [-1] * len(falling))
    order = np.argsort(times)
    return SignalEdges(times=times[order], signs=signs[order])


@pytest.mark.parametrize("clock", [{}, {"shift": 0.01, "ratio": 1.002, "begin": 0.0, "end": 2.9}])
def test_shift_and_ratio_of_the_clocks_come_from_common_edges(clock):
    merged = ev.merge_traces(scope(), daq(**clock), edges="drive_voltage=plate_voltage")
    time = merged["time"].values
    assert np.abs(merged["lateral_force_measured"].values - np.sin(3 * time)).max() < (
        1.5e-3 if clock else 1.2e-3
    )
    assert np.array_equal(merged["drive_voltage"].values, pulses(time))
    assert "ppm" in merged.attrs["history"]
    states = {each["name"]: each["state"] for each in json.loads(merged.attrs["validity"])}
    assert states["clock ratio"] == "ok"


def test_the_intervals_cover_the_true_clocks():
    random, covered = np.random.default_rng(4), np.zeros(2)
    for _ in range(400):

        def noisy(edges):
            return edges + random.normal(0, 1e-4, edges.size)

        own = edges((noisy(RISES) - SHIFT) / RATIO, (noisy(FALLS) - SHIFT) / RATIO)
        found = match_edges(edges(RISES, FALLS), own, steps=(1e-9, 1e-9))
        centre = own.times.mean()
        at_centre = found.shift + (found.ratio - RATIO) * centre
        errors = np.abs([found.ratio - RATIO, at_centre - SHIFT])
        covered += errors <= [found.ratio_half_width, found.shift_half_width]
    assert (covered > 380 * 0.97).all()
    assert (covered < 396).all()


def test_one_edge_gives_a_shift_and_two_a_ratio_limited_by_the_samples():
    steps, half = (3e-4, 4e-4), 1.96 * 5e-4 / np.sqrt(12)
    found = match_edges(edges([0.5]), edges([0.13]), steps=steps)
    assert (found.shift, found.ratio) == (pytest.approx(0.37), 1.0)
    assert found.shift_half_width == pytest.approx(half)
    assert found.diagnostic().state == "unknown"
    found = match_edges(edges([1.0], [3.001]), edges([0.0], [2.0]), steps=steps)
    assert (found.ratio, found.edges) == (pytest.approx(1.0005), 2)
    assert found.ratio_half_width == pytest.approx(half / np.sqrt(2))


def test_the_intervals_are_those_of_a_line_through_the_edges():
    own = np.array([0.0, 1.0, 2.7, 4.1, 7.3])
    late = own + 1e-3 * np.array([1, -2, 0.5, 1, -0.5])
    found = match_edges(edges(late), edges(own), steps=(1e-9, 1e-9))
    (ratio, _), squares, *_ = np.polyfit(own, late, 1, full=True)
    half = 3.18244631 * np.sqrt(squares[0] / 3)  # Student's t for three degrees of freedom
    assert found.ratio == pytest.approx(ratio, rel=1e-12)
    assert found.shift == pytest.approx(late.mean() - ratio * own.mean())
    assert found.shift_half_width == pytest.approx(half / np.sqrt(5))
    assert found.ratio_half_width == pytest.approx(half / np.linalg.norm(own - own.mean()))


def test_periodic_edges_are_refused_unless_a_shift_is_near():
    periodic = edges(np.arange(10) * 0.1, np.arange(10) * 0.1 + 0.03)
    late = edges(periodic.rising[2:] - 0.01, periodic.falling[2:] - 0.01)
    with pytest.raises(InputError, match="fit alike, because the edges are periodic"):
        match_edges(periodic, late, steps=(1e-5, 1e-5))
    for near in (0.01, 0.11, -0.09):
        assert match_edges(periodic, late, steps=(1e-5, 1e-5), near=near + 0.02).shift == pytest.approx(near)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, "state a signal whose edges both records hold, or a shift"),
        ({"edges": "gap"}, "the reference has no signal 'gap'"),
        ({"edges": "drive_voltage"}, "the other record has no signal 'drive_voltage'"),
        ({"edges": "drive_voltage=lateral_force_measured"}, "do not match in order and spacing"),
        ({"shift": "10 s"}, "do not overlap"),
    ],
)
def test_what_does_not_determine_the_alignment_is_refused(options, message):
    with pytest.raises(InputError, match=message):
        ev.merge_traces(scope(), daq(), **options)


def test_a_stated_shift_is_used_as_it_is_and_the_drift_is_unknown():
    merged = ev.merge_traces(scope(), daq(), shift="370 ms")
    time = merged["time"].values
    assert np.abs(merged["lateral_force_measured"].values - np.sin(3 * time)).max() < 1e-3
    assert time[0] == pytest.approx(0.17, abs=1.1e-4)
    assert "as stated" in merged.attrs["history"]
    assert merged.attrs["second_file"] == "a.csv"


def test_a_signal_of_both_is_kept_from_the_reference():
    other = daq().rename({"plate_voltage": "drive_voltage"})
    merged = ev.merge_traces(scope(), other, edges="drive_voltage")
    assert np.array_equal(merged["drive_voltage"].values, pulses(merged["time"].values))
    assert "drive_voltage of the second file omitted" in merged.attrs["history"]
    with pytest.raises(InputError, match="it adds no signal"):
        ev.merge_traces(other, other.drop_vars("lateral_force_measured"), edges="drive_voltage")


def test_a_coarser_reference_takes_means_and_samples_at_both_ends_are_kept():
    coarse, fine = np.arange(0, 3, 0.01), np.arange(0, 3, 1e-4)
    other = trace(fine, lateral_force_measured=5 + np.cos(2 * np.pi * 100 * fine))
    merged = ev.merge_traces(trace(coarse, drive_voltage=0 * coarse), other, shift=0.0)
    assert np.abs(merged["lateral_force_measured"].values[2:-2] - 5).max() < 1e-3
    own, reference = np.arange(5.0), np.arange(8.0)
    merged = ev.merge_traces(
        trace(reference, drive_voltage=reference), trace(own, plate_voltage=own**2), shift=2.0
    )
    np.testing.assert_array_equal(merged.time, np.arange(2.0, 7.0))
    np.testing.assert_array_equal(merged.plate_voltage, own**2)
