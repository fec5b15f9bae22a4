"""Two records with clocks of their own become one Trace."""

import json

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.core.trace import make_trace
from electrovib.recordings.importing.common_edges import match_edges
from electrovib.recordings.importing.periods import SignalEdges, find_edges

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


def daq(step=5e-4, begin=-0.2, end=2.6):
    """A record whose clock is SHIFT behind and slower: reference time = SHIFT + RATIO own time."""
    own = np.arange(begin, end, step)
    event = SHIFT + RATIO * own
    return trace(own, plate_voltage=pulses(event), lateral_force_measured=np.sin(3 * event))


def test_shift_and_ratio_of_the_clocks_come_from_common_edges():
    merged = ev.merge_traces(scope(), daq(), edges="drive_voltage=plate_voltage")
    time = merged["time"].values
    assert np.abs(merged["lateral_force_measured"].values - np.sin(3 * time)).max() < 3 * 4e-4
    assert np.array_equal(merged["drive_voltage"].values, pulses(time))
    assert "80" in merged.attrs["history"] or "ppm" in merged.attrs["history"]
    states = {each["name"]: each["state"] for each in json.loads(merged.attrs["validity"])}
    assert states["clock ratio"] == "ok"


def test_a_slow_clock_is_stretched():
    own = np.arange(0, 2.9, 5e-4)
    event = 0.01 + 1.002 * own
    other = trace(own, plate_voltage=pulses(event), lateral_force_measured=np.sin(3 * event))
    merged = ev.merge_traces(scope(), other, edges="drive_voltage=plate_voltage")
    assert np.abs(merged["lateral_force_measured"].values - np.sin(3 * merged["time"].values)).max() < 1.5e-3


def test_the_intervals_cover_the_true_clocks():
    random, covered = np.random.default_rng(4), np.zeros(2)
    for _ in range(400):

        def noisy(edges):
            return edges + random.normal(0, 1e-4, edges.size)

        own = SignalEdges(rising=(noisy(RISES) - SHIFT) / RATIO, falling=(noisy(FALLS) - SHIFT) / RATIO)
        found = match_edges(SignalEdges(rising=RISES, falling=FALLS), own, steps=(1e-9, 1e-9))
        centre = np.concatenate([own.rising, own.falling]).mean()
        at_centre = found.shift + (found.ratio - RATIO) * centre
        covered += (
            abs(found.ratio - RATIO) <= found.ratio_half_width,
            abs(at_centre - SHIFT) <= found.shift_half_width,
        )
    assert (covered > 380 * 0.97).all()
    assert (covered < 396).all()


def test_one_edge_gives_a_shift_and_no_ratio():
    own = SignalEdges(rising=np.array([0.13]), falling=np.array([]))
    found = match_edges(SignalEdges(rising=np.array([0.5]), falling=np.array([])), own, steps=(3e-4, 4e-4))
    assert (found.shift, found.ratio) == (pytest.approx(0.37), 1.0)
    assert found.shift_half_width == pytest.approx(1.96 * 5e-4 / np.sqrt(12))
    assert found.diagnostic().state == "unknown"


def test_two_edges_give_a_ratio_limited_by_the_samples():
    own = SignalEdges(rising=np.array([0.0]), falling=np.array([2.0]))
    found = match_edges(
        SignalEdges(rising=np.array([1.0]), falling=np.array([3.001])), own, steps=(3e-4, 4e-4)
    )
    assert found.ratio == pytest.approx(1.0005)
    assert found.edges == 2
    assert found.ratio_half_width == pytest.approx(1.96 * 5e-4 / np.sqrt(12) / np.sqrt(2))


def test_periodic_edges_are_refused_unless_a_shift_is_near():
    periodic = SignalEdges(rising=np.arange(10) * 0.1, falling=np.arange(10) * 0.1 + 0.03)
    late = SignalEdges(rising=periodic.rising[2:] - 0.01, falling=periodic.falling[2:] - 0.01)
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


def test_a_coarser_reference_takes_means():
    coarse, fine = np.arange(0, 3, 0.01), np.arange(0, 3, 1e-4)
    other = trace(fine, lateral_force_measured=5 + np.cos(2 * np.pi * 100 * fine))
    merged = ev.merge_traces(trace(coarse, drive_voltage=0 * coarse), other, shift=0.0)
    assert np.abs(merged["lateral_force_measured"].values[2:-2] - 5).max() < 1e-3


def test_edges_of_the_records_are_those_of_the_pulses():
    edges = find_edges(np.asarray(scope()["time"]), np.asarray(scope()["drive_voltage"]))
    assert np.abs(edges.rising - RISES).max() < 1e-4
    assert np.abs(edges.falling - FALLS).max() < 1e-4


def test_samples_at_both_ends_of_the_other_record_are_kept():
    own = np.arange(5.0)
    merged = ev.merge_traces(
        trace(np.arange(8.0), drive_voltage=np.arange(8.0)), trace(own, plate_voltage=own**2), shift=2.0
    )
    np.testing.assert_array_equal(merged.time, np.arange(2.0, 7.0))
    np.testing.assert_array_equal(merged.plate_voltage, own**2)
