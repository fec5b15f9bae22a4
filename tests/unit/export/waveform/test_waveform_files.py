"""Waveforms read back from their files are the drive, to the error that is stated."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner
from waveform_files import read_back

import electrovib as ev
from electrovib.apps.cli import app
from electrovib.core.errors import InputError
from electrovib.data.atomic import left_by_a_kill
from electrovib.data.readers.wave_audio import read_wave
from electrovib.export.waveform import FORMATS
from electrovib.study.check import read_drive
from electrovib.study.waveform import sampling_error, waveform

FIG6 = "vezzoli_2014/fig6"
LIMITS = {"voltage": "1 kV", "current": "250 uA"}
BURST = {
    "drive": {"model": "Sine", "amplitude": "100 V", "frequency": "1 kHz"},
    "limits": LIMITS,
    "time.duration": "5 ms",
}
SUFFIXES = tuple(FORMATS)


def joined(path):
    """The declaration that a format needs whose samples are joined by straight lines where they are played."""
    return {} if str(path).endswith(".pwl") else {"edge": "line"}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("changes", [{"limits": LIMITS}, BURST], ids=["pulse", "sine"])
def test_a_file_read_back_is_the_drive_to_the_stated_error(folder, suffix, changes):
    scenario = ev.load(FIG6, changes=changes)
    found = ev.export_waveform(scenario, f"drive{suffix}", **joined(suffix))
    times, voltages = read_back(found.path, found.full_scale)
    np.testing.assert_allclose(times, found.waveform.times, rtol=1e-14)
    np.testing.assert_array_equal(voltages, found.waveform.voltages)
    assert (voltages[0], voltages[-1]) == (0, 0)
    dense = np.linspace(0, times[-1], 100_003)
    off = np.max(np.abs(np.interp(dense, times, voltages) - scenario.drive.voltage(dense)))
    assert off <= found.waveform.error + 1e-9 * found.waveform.peak
    assert found.waveform.error <= 0.01 * found.waveform.peak
    assert found.check.value("peak voltage") == np.max(np.abs(voltages))


@pytest.mark.parametrize("suffix", [".csv", ".npy", ".mat"])
def test_a_file_is_checked_as_a_drive_again(folder, suffix):
    found = ev.export_waveform(FIG6, f"drive{suffix}", limits=LIMITS, edge="line")
    again = ev.check(found.path, FIG6, limits=LIMITS)
    assert again.value("peak voltage") == found.check.value("peak voltage") == 1000
    assert again.value("peak current") == pytest.approx(found.check.value("peak current"), rel=1e-9)


def test_the_codes_of_the_generator(folder):
    scenario = ev.load(FIG6, changes=BURST)
    found = ev.export_waveform(scenario, "drive.csv", edge=1e-6, instrument="hp_33120a", gain=20)
    text = found.path.read_text(encoding="utf-8")
    table = np.array([line.split(",") for line in text.splitlines() if line[0].isdigit()], dtype=float)
    codes = table[:, 2]
    assert 8 <= len(codes) <= 16_000
    assert np.max(codes) == 2047
    assert np.min(codes) == -2047
    assert np.max(np.abs(table[:, 1] - codes / 2047 * 100)) < 1e-12
    assert np.max(np.abs(codes - scenario.drive.voltage(table[:, 0]) / 100 * 2047)) <= 0.5 + 1e-6, (
        "the nearest code"
    )
    assert "VOLT 10.0 VPP" in text, "100 V at a gain of 20 are 5 V, 10 V peak to peak"
    assert "OUTP:LOAD INF" in text
    rate = found.waveform.rate
    assert f"FREQ {rate / len(codes)!r} Hz" in text
    held = (
        codes[np.clip((np.linspace(0, 5e-3, 77_777) * rate * (1 + 1e-12)).astype(int), 0, len(codes) - 1)]
        / 2047
        * 100
    )
    off = np.max(np.abs(held - scenario.drive.voltage(np.linspace(0, 5e-3, 77_777))))
    assert 0.9 * found.waveform.error < off <= found.waveform.error + 1e-9
    np.testing.assert_array_equal(read_drive("drive.csv").voltage_samples.values, table[:, 1])


def test_the_generator_has_limits_of_its_own(folder):
    scenario = ev.load(FIG6, changes=BURST)
    for changed, words in (
        ({}, "at least 10"),
        ({"gain": 9.9}, "--gain"),
        ({"gain": -1}, "above 0"),
        ({"gain": 2001}, "at least 0.1 V"),
        ({"gain": 1e300}, "at least 0.1 V"),
        ({"gain": 20, "full_scale": 99.0}, "more than the full scale"),
        ({"gain": 20, "full_scale": 201.0}, "at most 10 V"),
        ({"gain": 20, "rate": 4e6}, "16000 are allowed"),
        ({"gain": 20, "rate": 1e3}, "fewer than the 8"),
        ({"gain": 20, "rate": 50e3}, "is allowed"),
    ):
        with pytest.raises(InputError, match=words):
            ev.export_waveform(scenario, "drive.csv", edge=1e-6, instrument="hp_33120a", **changed)
    with pytest.raises(InputError, match=r"written as \.csv"):
        ev.export_waveform(scenario, "drive.npy", instrument="hp_33120a", gain=20)
    with pytest.raises(InputError, match="hp_33120a"):
        ev.export_waveform(scenario, "drive.csv", instrument="hp_33120", gain=20)
    assert not list(folder.iterdir())
    assert (
        ev.export_waveform(scenario, "drive.csv", edge=1e-6, instrument="hp_33120a", gain=10).full_scale
        == 100
    )
    smallest = ev.export_waveform(
        scenario, "drive.csv", edge=1e-6, instrument="hp_33120a", gain=1999, force=True
    )
    assert any(f"{100 / 1999!r} V at the output" in note for note in smallest.notes), "0.1 V peak to peak"


def test_the_scale_of_a_sound_file(folder):
    scenario = ev.load(FIG6, changes=BURST)
    found = ev.export_waveform(scenario, "drive.wav", full_scale=400.0, rate=96e3, edge="line")
    shares = read_wave(found.path).channels[0].values
    assert read_wave(found.path).step == pytest.approx(1 / 96e3)
    sent = np.append(scenario.drive.voltage(np.arange(len(shares) - 1) / 96e3), 0.0)
    assert np.max(np.abs(shares * 400 - sent)) <= 400 / 2**23
    assert np.all(np.abs(shares * 400) <= np.abs(sent) + 1e-12), "no sample is enlarged by rounding"
    assert any("AC-coupled" in note for note in found.notes)
    assert b"full scale is 400.0 V" in found.path.read_bytes()
    for changed, words in (
        ({"full_scale": 99.0}, "less than its full scale"),
        ({"full_scale": 0.0}, "above 0 V"),
        ({"gain": 2.0}, "belongs to an instrument"),
        ({"rate": 44_100.5}, "whole number"),
    ):
        with pytest.raises(InputError, match=words):
            ev.export_waveform(scenario, "other.wav", edge="line", **changed)
    negative = {"drive": {"model": "Trapezium", "high": -100.0, "rise": 1e-3, "hold": 1e-3, "fall": 1e-3}}
    with pytest.raises(InputError, match="less than its full scale"):
        ev.export_waveform(scenario.replace(negative), "other.wav", full_scale=99.0, edge="line")


def test_ngspice_plays_the_source(folder):
    scenario = ev.load(FIG6, changes=BURST)
    found = ev.export_waveform(scenario, "drive.pwl", rate=1e5)
    (folder / "play.cir").write_text(
        "play\n.include drive.pwl\nR1 drive 0 1k\n.tran 1u 5m\n.control\nrun\nwrdata out.txt v(drive)\nquit 0\n.endc\n.end\n",
        encoding="utf-8",
    )
    try:
        subprocess.run(["ngspice", "-b", "play.cir"], cwd=folder, check=True, capture_output=True, timeout=60)
    except FileNotFoundError:
        pytest.skip("ngspice is not installed")
    table = np.loadtxt(folder / "out.txt")
    expected = np.interp(table[:, 0], found.waveform.times, found.waveform.voltages)
    assert np.max(np.abs(table[:, 1] - expected)) < 1e-3


@pytest.mark.usefixtures("folder")
class TestRefused:
    def refused(self, words, scenario=FIG6, path="drive.csv", **options):
        with pytest.raises(InputError, match=words):
            ev.export_waveform(scenario, path, **{"limits": LIMITS, **joined(path), **options})
        assert not left_by_a_kill(Path(path))

    def test_without_limits(self, folder):
        for suffix in SUFFIXES:
            self.refused(r"limits.voltage .* is not declared", path=f"drive{suffix}", limits={})
        assert not list(folder.iterdir())

    def test_beyond_a_limit(self, folder):
        for suffix in SUFFIXES:
            self.refused("above 999 V", path=f"drive{suffix}", limits={"voltage": 999})
            self.refused("above 100 nA", path=f"drive{suffix}", limits={"voltage": 1000, "current": 1e-7})
        assert not list(folder.iterdir())

    @pytest.mark.parametrize("own", [{"saturation": 900.0}, {"source_current": 1e-9}, {"bandwidth": 0.1}])
    def test_a_voltage_that_only_the_amplifier_holds(self, own, folder):
        for options in ({"amplifier_present": True}, {"amplifier_present": True, "ramp": 1e-3}, {}):
            words = "does not count" if options else "only where this very amplifier stands"
            self.refused(f"reaches 1 kV, above 950 V.*{words}", limits=LIMITS | {"voltage": 950},
                set={"circuit.amplifier": own}, **options)  # fmt: skip
        assert not list(folder.iterdir())
        for options, present in (({}, False), ({"amplifier_present": True}, True)):
            found = ev.export_waveform(
                FIG6, "drive.csv", limits=LIMITS, set={"circuit.amplifier": own}, edge="line", **options
            )
            assert any("in hardware" in note for note in found.notes) == (present and "saturation" not in own)

    def test_not_zero_at_an_end(self):
        cosine = {"model": "Sine", "amplitude": 100, "frequency": 1e3, "phase": 1.57}
        self.refused("the first sample, at 0 s", set={"drive": cosine})
        self.refused("the last sample, at 50 ms, is 1 kV", set={"time.duration": "50 ms"})
        assert ev.export_waveform(
            FIG6, "part.pwl", limits=LIMITS, set={"time.duration": "50 ms"}
        ).path.exists()

    def test_discontinuities_and_coarse_rates(self):
        square = {"model": "Trapezium", "high": 100, "rise": 0, "hold": 1e-3, "fall": 1e-3, "delay": 1e-3}
        self.refused("1 discontinuities, the first of 100 V at 1 ms", set={"drive": square})
        self.refused("is allowed", rate=51.0)
        assert (
            ev.export_waveform(
                FIG6, "coarse.csv", limits=LIMITS, rate=51.0, largest_error=0.6, edge="line"
            ).waveform.error
            > 10
        )
        for wrong in (0.0, -1.0, np.nan, np.inf):
            self.refused("rate", rate=wrong)
            self.refused("rate", rate=wrong, path="drive.wav")
            self.refused("largest_error", largest_error=wrong)

    def test_a_prescribed_current(self):
        self.refused("prescribes a current", "kim_2015/current", limits={"voltage": "1 kV", "current": "1 A"})

    def test_other_suffixes_and_files(self, folder):
        self.refused(r"written as \.csv, \.npy", path="drive.xyz")
        (folder / "mine.csv").write_text("mine\n", encoding="utf-8")
        self.refused("exists already", path="mine.csv")
        assert ev.export_waveform(FIG6, "mine.csv", limits=LIMITS, force=True, edge="line").path.exists()
        assert ev.export_waveform(FIG6, "mine.csv", limits=LIMITS, edge="line").path.exists(), (
            "what electrovib wrote is replaced"
        )

    def test_what_electrovib_wrote_is_replaced_where_the_format_has_a_mark(self):
        for suffix in (".mat", ".wav", ".pwl"):
            for _ in range(2):
                assert ev.export_waveform(
                    FIG6, f"drive{suffix}", limits=LIMITS, **joined(suffix)
                ).path.exists()
        assert ev.export_waveform(FIG6, "drive.npy", limits=LIMITS, edge="line").path.exists()
        self.refused("exists already", path="drive.npy")

    def test_the_limits_file_is_never_replaced(self, folder):
        (folder / "limits.csv").write_text('voltage = "1 kV"\ncurrent = "1 mA"\n', encoding="utf-8")
        self.refused("is an input", path="limits.csv", limits="limits.csv", force=True)


def test_the_error_is_that_of_the_closed_form(folder):
    """Between two samples h apart a sine departs from the chord by A (1 - cos(w h/2)) at most."""
    drive = ev.load(FIG6, changes=BURST).drive
    found = waveform(drive, rate=50e3)
    assert found.error == pytest.approx(100 * (1 - np.cos(np.pi * 1e3 / 50e3)), rel=2e-3)
    held = waveform(drive, rate=50e3, held=True)
    assert held.error == pytest.approx(100 * np.sin(2 * np.pi * 1e3 / 50e3), rel=1e-3)
    shifted = found.voltages + 1.0
    assert sampling_error(drive, found.times, shifted, held=False, end=5e-3) == pytest.approx(
        1 + found.error, rel=1e-2
    )


def test_the_command_line(folder):
    def run(*words):
        return CliRunner(env={"COLUMNS": "200"}).invoke(app, ["export", FIG6, *words])

    (folder / "limits.toml").write_text(
        'limits = { voltage = "1 kV", current = "250 uA" }\n', encoding="utf-8"
    )
    done = run("-o", "drive.csv", "--limits", "limits.toml", "--rate", "10 kHz", "--edge", "line")
    assert done.exit_code == 0, done.exception
    assert "2721 samples at 10 kHz" in done.output
    assert "limits.voltage of limits.toml" in done.output
    held = ["h.csv", "--as", "hp_33120a", "--gain", "100", "--limits", "limits.toml"]
    assert run(*held, "--edge", "10 us").exit_code == 0
    for words in (
        [],
        ["a.csv", "-o", "b.csv"],
        ["-o", "a.csv"],
        ["-o", "a.csv", "--rate", "3 V"],
        ["a.cir", "--as", "hp_33120a"],
        ["a.cir", "--edge", "line"],
        ["a.cir", "--amplifier-present"],
        ["a.pwl", "--limits", "limits.toml", "--edge", "line"],
        ["a.csv", "--limits", "limits.toml", "--edge", "lines"],
        ["a.csv", "--limits", "limits.toml", "--edge", "0 s"],
        [*held, "--edge", "line"],
        held,
    ):
        assert isinstance(run(*words).exception, InputError), words
    assert ev.export(FIG6, "again.csv", limits="limits.toml", edge="line") == (
        folder / "again.csv"
    ).relative_to(folder)


@pytest.mark.parametrize(
    ("suffix", "options"),
    [
        (".csv", {"edge": "line"}),
        (".wav", {"edge": "line"}),
        (".csv", {"instrument": "hp_33120a", "gain": 10, "edge": 1e-6}),
    ],
)
def test_a_ramp_lets_a_drive_begin_and_end_at_zero(folder, suffix, options):
    """A cosine times an envelope of 2 ms; the bound of the error holds and is not far from the error itself."""
    cosine = {"model": "Sine", "amplitude": "50 V", "frequency": "500 Hz", "phase": 1.5}
    scenario = ev.load(FIG6, changes={"drive": cosine, "limits": LIMITS, "time.duration": "10.01 ms"})
    with pytest.raises(InputError, match="--ramp"):
        ev.export_waveform(scenario, f"drive{suffix}", **options)
    found = ev.export_waveform(scenario, f"drive{suffix}", ramp=2e-3, **options)
    times, voltages = read_back(found.path, found.full_scale)
    assert (voltages[0], voltages[-1]) == (0, 0)
    dense = np.linspace(0, times[-1], 300_007)
    end, length = times[-1], round(2e-3 * found.waveform.rate) / found.waveform.rate
    wanted = scenario.drive.voltage(dense) * np.clip(np.minimum(dense, end - dense) / length, 0, 1)
    places = np.clip(np.searchsorted(times, dense, side="right") - 1, 0, len(times) - 1)
    played = voltages[places] if found.waveform.held else np.interp(dense, times, voltages)
    off = np.max(np.abs(played - wanted))
    assert 0.3 * found.waveform.error < off <= found.waveform.error * (1 + 1e-6)
    assert any("ramps of 2 ms" in note for note in found.notes)
    for wrong in (0.0, -1.0, np.nan, 6e-3):
        with pytest.raises(InputError, match="ramp"):
            ev.export_waveform(scenario, "other.csv", ramp=wrong, edge="line")


def test_a_ramp_bounds_the_switching_current(folder):
    """Without it 100 V would be switched onto 1 kohm, 100 mA; a ramp of 5 ms leaves that of the carrier."""
    carrier = {"model": "Sine", "amplitude": "100 V", "frequency": "100 Hz", "phase": 1.5707963267948966}
    scenario = ev.load(FIG6, changes={"drive": carrier, "limits": LIMITS, "time.duration": "50 ms"})
    assert ev.check(scenario).value("peak current") > 0.09
    assert (
        ev.export_waveform(scenario, "drive.csv", ramp=5e-3, edge="line").check.value("peak current") < 5e-6
    )


SQUARE = {"drive": {"model": "Trapezium", "high": 500.0, "rise": 1e-7, "hold": 5e-3, "fall": 1e-7}}


def test_a_bandwidth_that_is_only_assumed_holds_no_current(folder):
    """One pole at 1 Hz would leave nothing of the current of a pulse; without it 500 V charge the stack within 0.1 us."""
    scenario = ev.load(FIG6, changes=SQUARE | {"circuit.amplifier": {"bandwidth": 1.0}})
    options = {"limits": LIMITS, "rate": 1e7, "edge": "line"}
    with pytest.raises(InputError, match=r"above 250 uA.*--amplifier-present"):
        ev.export_waveform(scenario, "drive.csv", **options)
    assert not list(folder.iterdir())
    present = ev.export_waveform(scenario, "drive.csv", amplifier_present=True, **options)
    assert present.check.value("peak current") < 250e-6
    named = scenario.replace({"circuit.amplifier.hardware": "our amplifier, 1 Hz"})
    found = ev.export_waveform(named, "drive.csv", **options)
    assert found.check.value("peak current") == present.check.value("peak current")
    assert any("(our amplifier, 1 Hz)" in note for note in found.notes)


def test_what_is_written_states_how_it_is_played(folder):
    scenario = ev.load(FIG6, changes=BURST)
    for edge, words in (("line", "straight lines between the samples"), (1e-6, "edges of 1 us between them")):
        found = ev.export_waveform(scenario, "drive.csv", edge=edge, largest_error=0.05)
        assert any(f"was checked with {'each' if edge != 'line' else ''}" in note for note in found.notes)
        assert words in found.path.read_text(encoding="utf-8")
        assert found.waveform.held == (edge != "line")
    steps = ev.export_waveform(
        scenario,
        "drive.csv",
        limits={"current": "1 A"},
        set={"limits.current": "1 A"},
        instrument="hp_33120a",
        gain=20,
    )
    assert any("and steps between them" in note for note in steps.notes)
