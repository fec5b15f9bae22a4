"""A measured drive of 90 000 jittered samples, from file to force, against a plain loop."""

from pathlib import Path

import numpy as np
import pytest
from scenario_parts import AREA, EPS0, constant, grounded, layer, model

import electrovib as ev
from electrovib.core.errors import InputError

CLUTCH = Path(__file__).parents[3] / "shared" / "data" / "clutch"
PERMITTIVITY, FILM, GAP, CONDUCTIVITY = 3.35, 90e-6, 5e-6, 2e-9
# The clutch has two electrodes driven in antiphase, and the column holds one of them.
ANTIPHASE = {"readback": model("OneOfTwoInAntiphase")}


def load(file, *, conductivity=CONDUCTIVITY, changes=None, **more):
    """A file of MATLAB's or NumPy's kind has no headings: columns by number, time in microseconds."""
    columns = {"time_column": 0, "time_unit": "us", "voltage_column": 3}
    stack = {"insulator": layer(FILM, constant(PERMITTIVITY)), "gap": layer(GAP, constant(1.0, conductivity))}
    own = {
        "drive": model("Sampled", file=str(file), **columns, **more),
        "force": model("MaxwellStressInGap"),
        "circuit.return_path": grounded(),
        "stack": stack,
    }
    return ev.load("vezzoli_2014/fig6", changes=own | (changes or {}))


def record(count=90_000, seed=7):
    """Make 0 and 300 V at 10 Hz with ripple, stamped every 78 us give or take one."""
    random = np.random.default_rng(seed)
    stamps = 857.0 + np.cumsum(random.integers(77, 80, count))
    on = (stamps // 50_000) % 2 == 1
    return stamps, np.where(on, 295.0, 1.0) + random.choice([0.0, 0.344, 2.064], count)


def gap_force(time, voltage):
    """March one pole through straight pieces: film over a leaky gap, two formulas of a textbook."""
    film, gap = EPS0 * PERMITTIVITY / FILM, EPS0 / GAP
    share, constant = film / (film + gap), (film + gap) * GAP / CONDUCTIVITY
    held = share * voltage[0]
    across = [held]
    for step, rise in zip(np.diff(time), np.diff(voltage), strict=True):
        lost = -np.expm1(-step / constant)
        held = held * (1 - lost) + share * rise / step * constant * lost
        across.append(held)
    return AREA * EPS0 * (np.array(across) / GAP) ** 2 / 2


def agrees(trace, time, voltage):
    stamps = trace["time"].values
    # 7 s in doubles are good to 1e-15 s; steps of 78 us are then good to 1e-11 only, so both march the same.
    assert stamps == pytest.approx(time, rel=0, abs=4e-15)
    wanted = gap_force(stamps, voltage)
    error = np.max(np.abs(trace["electrostatic_force"].values - wanted)) / wanted.max()
    # 4e-15 was measured after 90 000 steps.
    assert error < 1e-13
    # The same check refuses a time constant that is off by one part in a million.
    assert np.max(np.abs(gap_force(stamps * (1 + 1e-6), voltage) - wanted)) > 1e-8 * wanted.max()


def shared(name):
    if not (CLUTCH / name).exists():
        pytest.skip(f"needs shared/data/clutch/{name} beside the repository")
    return CLUTCH / name


def test_jittered_record_matches_the_plain_loop(tmp_path):
    stamps, voltage = record()
    for name, factor in (("drive.npy", 1.0), ("other.npy", 0.5)):
        np.save(tmp_path / name, np.column_stack([stamps, stamps * 0, stamps * 0, voltage * factor]))
    trace = ev.simulate(load(tmp_path / "drive.npy"))
    assert trace.sizes["time"] == len(stamps)
    assert trace.attrs["dropped_samples"] == 0
    assert np.array_equal(trace["drive_voltage"], voltage)
    agrees(trace, (stamps - stamps[0]) * 1e-6, voltage)
    # another file in its place is read anew, and another parameter leaves the samples as they are
    other = load(tmp_path / "drive.npy", changes={"drive.file": str(tmp_path / "other.npy")})
    assert np.array_equal(other.drive.voltage_samples.values * 2, voltage)
    same = other.replace({"load.normal_force": "1 N"})
    assert same.drive == other.drive


@pytest.mark.parametrize(
    "name", ["square_300V_1kHz.npy", pytest.param("square_300V_10Hz.npy", marks=pytest.mark.slow)]
)
def test_clutch_recording_matches_the_plain_loop(name):
    table = np.load(shared(name))
    trace = ev.simulate(load(shared(name), **ANTIPHASE))
    time = (table[:, 0] - table[0, 0]) * 1e-6
    steps = np.diff(trace["time"])
    assert (steps.min(), steps.max()) == pytest.approx((77e-6, 79e-6), abs=1e-12)
    assert trace.attrs["dropped_samples"] == 0
    agrees(trace, time, between_the_electrodes(table))
    # The drive is on from about 2 s to 5 s: off it, what the gap still pulls is nothing beside the peak.
    force, seconds = trace["electrostatic_force"].values, trace["time"].values
    quiet = (seconds < 1.9) | (seconds > 5.2)
    assert force[quiet].max() < 1e-3 * force.max()


def between_the_electrodes(table):
    """Voltage across the clutch by the rig's own column for high voltage: 2 v1 - V while it is enabled, else 0."""
    one, enabled = table[:, 3], table[:, 2] == 1
    supply = np.median(one[one > 150]) + np.median(one[one <= 150])
    return np.where(enabled, 2 * one - supply, 0.0)


@pytest.mark.parametrize(
    ("name", "one_electrode", "both"),
    [("square_300V_10Hz.npy", 18.998e-3, 37.419e-3), ("square_300V_1kHz.npy", 20.369e-3, 36.889e-3)],
)
def test_one_electrode_taken_for_the_drive_halves_the_mean_pull(name, one_electrode, both):
    """Without a leak, where a held voltage keeps its pull; at 1 kHz a little less, as edges take their time."""
    means = []
    for readback in ({}, ANTIPHASE):
        trace = ev.simulate(load(shared(name), conductivity=0.0, **readback))
        means.append(float(trace.electrostatic_force.sel(time=slice(2.0, 4.999)).mean()))
    assert means == pytest.approx([one_electrode, both], rel=1e-3)
    # by hand, from the levels alone: the square of 295.15 - 2.06 V or of 297.22 - 2.06 V across film and gap
    held = 295.152 - 2.064 if "10Hz" in name else 297.216 - 2.064
    pull = AREA * EPS0 / 2 * (held / (FILM / PERMITTIVITY + GAP)) ** 2
    assert means[1] == pytest.approx(pull, rel=3e-3 if "10Hz" in name else 0.04)


def test_repeated_and_decreasing_stamps(tmp_path):
    stamps, voltage = record(5000)
    kept = np.ones(len(stamps), bool)
    kept[[1000, 2000, 2001]] = False
    faulty = stamps.copy()
    faulty[1000] = faulty[999]
    faulty[2000:2002] = faulty[1990:1992]
    np.save(tmp_path / "drive.npy", np.column_stack([faulty, faulty, faulty, voltage]))
    with pytest.raises(InputError) as caught:
        load(tmp_path / "drive.npy")
    assert len(caught.value.problems) == 1
    assert caught.value.problems[0].startswith("drive = ")
    # Two samples: the one that repeats and the first that goes back; its follower rises again after it.
    assert "2 of 5000 time stamps do not: sample 1000" in str(caught.value)
    assert 'stamps = { model = "KeepIncreasing" }' in str(caught.value)
    trace = ev.simulate(load(tmp_path / "drive.npy", stamps=model("KeepIncreasing")))
    assert trace.attrs["dropped_samples"] == 3
    time, measured = (stamps - stamps[0])[kept] * 1e-6, voltage[kept]
    # Only the time over which two samples in a row are dropped is longer than a 2000th of the record: it is halved.
    after = int(np.argmax(np.diff(time))) + 1
    assert after == 1999
    assert np.flatnonzero(np.diff(time) > time[-1] / 2000).tolist() == [after - 1]
    time = np.insert(time, after, np.mean(time[after - 1 : after + 1]))
    measured = np.insert(measured, after, np.mean(measured[after - 1 : after + 1]))
    assert trace.sizes["time"] == 4998
    agrees(trace, time, measured)


def test_a_number_that_is_not_finite_is_named_by_its_place(tmp_path):
    stamps, voltage = record(100)
    voltage[42] = np.nan
    np.save(tmp_path / "drive.npy", np.column_stack([stamps, stamps, stamps, voltage]))
    with pytest.raises(InputError, match=r"drive = .*row 42 \(first is 0\), column 3: nan is not a finite"):
        load(tmp_path / "drive.npy")
