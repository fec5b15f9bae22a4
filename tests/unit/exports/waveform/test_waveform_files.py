"""Waveforms read back from their files are the drive, to the error that is stated."""

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
from electrovib.exports.waveform_formats import WAVEFORM_FORMATS
from electrovib.studies.check.function import read_drive
from electrovib.studies.waveform import sampling_error, waveform

FIG6 = "vezzoli_2014/fig6"
LIMITS = {"voltage": "1 kV", "current": "250 uA"}
PULSE = ev.load(FIG6, changes={"limits": LIMITS})
SINE = {"model": "Sine", "amplitude": "100 V", "frequency": "1 kHz"}
BURST = ev.load(FIG6, changes={"drive": SINE, "limits": LIMITS, "time.duration": "5 ms"})
SUFFIXES = tuple(WAVEFORM_FORMATS)
GENERATOR = {"instrument": "hp_33120a", "gain": 20}
EDGE = {"edge": 1e-6}
pytestmark = pytest.mark.filterwarnings(r"ignore:export_waveform\((largest_error|amplifier_present)=")


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def export(scenario, path="drive.csv", **options):
    """Export with the declaration that a format needs whose samples are joined by straight lines where they are played."""
    joined = {} if str(path).endswith(".pwl") else {"edge": "line"}
    scaling = ev.Scaling(**{name: options.pop(name) for name in ("full_scale", "gain") if name in options})
    return ev.export_waveform(scenario, path, scaling=scaling, **joined | options)


def refused(words, scenario=PULSE, path="drive.csv", **options):
    with pytest.raises(InputError, match=words):
        export(scenario, path, **options)
    assert not left_by_a_kill(Path(path))


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("scenario", [PULSE, BURST], ids=["pulse", "sine"])
def test_a_file_read_back_is_the_drive_to_the_stated_error(suffix, scenario):
    found = export(scenario, f"drive{suffix}")
    times, voltages = read_back(found.path, found.full_scale)
    np.testing.assert_allclose(times, found.waveform.times, rtol=1e-14)
    np.testing.assert_array_equal(voltages, found.waveform.voltages)
    assert (voltages[0], voltages[-1]) == (0, 0)
    dense = np.linspace(0, times[-1], 100_003)
    off = np.max(np.abs(np.interp(dense, times, voltages) - scenario.drive.voltage(dense)))
    assert off <= found.waveform.error + 1e-9 * found.waveform.peak
    assert found.waveform.error <= 0.01 * found.waveform.peak
    assert found.check.value("peak voltage") == np.max(np.abs(voltages))
    if scenario is PULSE and suffix in {".csv", ".npy", ".mat"}:
        again = ev.check(found.path, FIG6, limits=LIMITS)
        assert again.value("peak voltage") == found.check.value("peak voltage") == 1000
        assert again.value("peak current") == pytest.approx(found.check.value("peak current"), rel=1e-9)


def test_the_codes_of_the_generator():
    found = export(BURST, **GENERATOR, **EDGE)
    text = found.path.read_text(encoding="utf-8")
    table = np.array([line.split(",") for line in text.splitlines() if line[0].isdigit()], dtype=float)
    times, voltages, codes = table.T
    assert 8 <= len(codes) <= 16_000
    assert (np.min(codes), np.max(codes)) == (-2047, 2047)
    assert np.max(np.abs(voltages - codes / 2047 * 100)) < 1e-12
    nearest = np.abs(codes - BURST.drive.voltage(times) / 100 * 2047)
    assert np.max(nearest) <= 0.5 + 1e-6, "the nearest code"
    assert "VOLT 10.0 VPP" in text, "100 V at a gain of 20 are 5 V, 10 V peak to peak"
    assert "OUTP:LOAD INF" in text
    rate = found.waveform.rate
    assert f"FREQ {rate / len(codes)!r} Hz" in text
    dense = np.linspace(0, 5e-3, 77_777)
    places = np.clip((dense * rate * (1 + 1e-12)).astype(int), 0, len(codes) - 1)
    off = np.max(np.abs(codes[places] / 2047 * 100 - BURST.drive.voltage(dense)))
    assert 0.9 * found.waveform.error < off <= found.waveform.error + 1e-9
    np.testing.assert_array_equal(read_drive("drive.csv").voltage_samples.values, voltages)


def test_the_generator_has_limits_of_its_own(folder):
    for changed, words in (
        ({"gain": 1.0}, "at least 10"),
        ({"gain": 9.9}, "--gain"),
        ({"gain": -1}, "above 0"),
        ({"gain": 2001}, "at least 0.1 V"),
        ({"gain": 1e300}, "at least 0.1 V"),
        ({"full_scale": 99.0}, "more than the full scale"),
        ({"full_scale": 201.0}, "at most 10 V"),
        ({"rate": 4e6}, "16000 are allowed"),
        ({"rate": 1e3}, "fewer than the 8"),
        ({"rate": 50e3}, "is allowed"),
        ({"instrument": "hp_33120"}, "hp_33120a"),
        ({"path": "drive.npy"}, r"written as \.csv"),
    ):
        refused(words, BURST, **GENERATOR | EDGE | changed)
    assert not list(folder.iterdir())
    assert export(BURST, **GENERATOR | EDGE | {"gain": 10}).full_scale == 100
    smallest = export(BURST, **GENERATOR | EDGE | {"gain": 1999}, force=True)
    assert any(f"{100 / 1999!r} V at the output" in note for note in smallest.notes), "0.1 V peak to peak"


def test_the_scale_of_a_sound_file():
    found = export(BURST, "drive.wav", full_scale=400.0, rate=96e3)
    record = read_wave(found.path)
    volts = 400 * record.channels[0].values
    assert record.step == pytest.approx(1 / 96e3)
    sent = np.append(BURST.drive.voltage(np.arange(len(volts) - 1) / 96e3), 0.0)
    assert np.max(np.abs(volts - sent)) <= 400 / 2**23
    assert np.all(np.abs(volts) <= np.abs(sent) + 1e-12), "no sample is enlarged by rounding"
    assert any("AC-coupled" in note for note in found.notes)
    assert b"full scale is 400.0 V" in found.path.read_bytes()
    negative = {"drive": {"model": "Trapezium", "high": -100.0, "rise": 1e-3, "hold": 1e-3, "fall": 1e-3}}
    for scenario, changed, words in (
        (BURST, {"full_scale": 99.0}, "less than its full scale"),
        (BURST.replace(negative), {"full_scale": 99.0}, "less than its full scale"),
        (BURST, {"full_scale": 0.0}, "above 0 V"),
        (BURST, {"gain": 2.0}, "belongs to an --instrument"),
        (BURST, {"rate": 44_100.5}, "whole number"),
    ):
        refused(words, scenario, "other.wav", **changed)


def test_ngspice_plays_the_source(folder):
    found = export(BURST, "drive.pwl", rate=1e5)
    control = ".control\nrun\nwrdata out.txt v(drive)\nquit 0\n.endc\n.end\n"
    text = f"play\n.include drive.pwl\nR1 drive 0 1k\n.tran 1u 5m\n{control}"
    (folder / "play.cir").write_text(text, encoding="utf-8")
    try:
        subprocess.run(["ngspice", "-b", "play.cir"], cwd=folder, check=True, capture_output=True, timeout=60)
    except FileNotFoundError:
        pytest.skip("ngspice is not installed")
    table = np.loadtxt(folder / "out.txt")
    expected = np.interp(table[:, 0], found.waveform.times, found.waveform.voltages)
    assert np.max(np.abs(table[:, 1] - expected)) < 1e-3


# what is refused before anything is written


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_nothing_is_written_without_limits_or_beyond_one(suffix, folder):
    path = f"drive{suffix}"
    refused(r"limits.voltage .* is not declared", FIG6, path)
    refused("above 999 V", FIG6, path, limits={"voltage": 999})
    refused("above 100 nA", FIG6, path, limits={"voltage": 1000, "current": 1e-7})
    assert not list(folder.iterdir())


@pytest.mark.parametrize("own", [{"saturation": 900.0}, {"source_current": 1e-9}, {"bandwidth": 0.1}])
def test_a_voltage_that_only_the_amplifier_holds_is_refused(own, folder):
    amplifier, present = {"set": {"circuit.amplifier": own}}, {"amplifier_present": True}
    held = amplifier | {"limits": LIMITS | {"voltage": 950}}
    refused("reaches 1 kV, above 950 V.*only where this very amplifier stands", **held)
    for options in (present, present | {"ramp": 1e-3}):
        refused("reaches 1 kV, above 950 V.*does not count", **held, **options)
    assert not list(folder.iterdir())
    for options, stated in (({}, False), (present, "saturation" not in own)):
        found = export(PULSE, **amplifier, **options)
        assert any("in hardware" in note for note in found.notes) == stated


def test_ends_discontinuities_rates_currents_and_suffixes():
    cosine = {"model": "Sine", "amplitude": 100, "frequency": 1e3, "phase": 1.57}
    refused("the first sample, at 0 s", set={"drive": cosine})
    short = {"set": {"time.duration": "50 ms"}}
    refused("the last sample, at 50 ms, is 1 kV", **short)
    assert export(PULSE, "part.pwl", **short).path.exists()
    step = {"model": "Trapezium", "high": 100, "rise": 0, "hold": 1e-3, "fall": 1e-3, "delay": 1e-3}
    refused("1 discontinuities, the first of 100 V at 1 ms", set={"drive": step})
    refused("is allowed", rate=51.0)
    assert export(PULSE, "coarse.csv", rate=51.0, largest_error=0.6).waveform.error > 10
    for wrong in (0.0, -1.0, np.nan, np.inf):
        refused("rate", rate=wrong)
        refused("rate", path="drive.wav", rate=wrong)
        refused("largest_error", largest_error=wrong)
    limits = {"voltage": "1 kV", "current": "1 A"}
    refused("prescribes a current", "kim_2015/current", limits=limits)
    refused(r"written as \.csv, \.npy", path="drive.xyz")


def test_only_what_electrovib_wrote_is_replaced_and_an_input_never(folder):
    """A format of numbers alone has no mark."""
    (folder / "mine.csv").write_text("mine\n", encoding="utf-8")
    refused("exists already", path="mine.csv")
    for options in ({"force": True}, {}):
        assert export(PULSE, "mine.csv", **options).path.exists()
    for suffix in SUFFIXES:
        assert export(PULSE, f"drive{suffix}").path.exists()
        if suffix == ".npy":
            refused("exists already", path="drive.npy")
        else:
            assert export(PULSE, f"drive{suffix}").path.exists()
    (folder / "limits.csv").write_text('voltage = "1 kV"\ncurrent = "1 mA"\n', encoding="utf-8")
    refused("is an input", path="limits.csv", limits="limits.csv", force=True)


def test_the_error_is_that_of_the_closed_form():
    """Between two samples h apart a sine departs from the chord by A (1 - cos(w h/2)) at most."""
    found = waveform(BURST.drive, rate=50e3)
    assert found.error == pytest.approx(100 * (1 - np.cos(np.pi * 1e3 / 50e3)), rel=2e-3)
    held = waveform(BURST.drive, rate=50e3, held=True)
    assert held.error == pytest.approx(100 * np.sin(2 * np.pi * 1e3 / 50e3), rel=1e-3)
    shifted = sampling_error(BURST.drive, found.times, found.voltages + 1.0, held=False, end=5e-3)
    assert shifted == pytest.approx(1 + found.error, rel=1e-2)


def test_an_error_above_one_per_cent_of_the_largest_voltage_is_refused():
    """A sine of 1 kHz departs from its chords by 1 - cos(pi/20) = 1.23 % at 20 kHz, and by 0.79 % at 25 kHz."""
    refused("and 1 % is allowed", BURST, rate=20e3)
    assert export(BURST, rate=25e3).waveform.share == pytest.approx(1 - np.cos(np.pi / 25), rel=2e-3)


def test_the_command_line(folder):
    def run(*words):
        return CliRunner(env={"COLUMNS": "200"}).invoke(app, ["export", FIG6, *words])

    text = 'limits = { voltage = "1 kV", current = "250 uA" }\n'
    (folder / "limits.toml").write_text(text, encoding="utf-8")
    limits = ["--limits", "limits.toml"]
    done = run("-o", "drive.csv", *limits, "--rate", "10 kHz", "--edge", "line")
    assert done.exit_code == 0, done.exception
    assert "2721 samples at 10 kHz" in done.output
    assert "limits.voltage of limits.toml" in done.output
    held = ["h.csv", "--instrument", "hp_33120a", "--gain", "100", *limits]
    assert run(*held, "--edge", "10 us").exit_code == 0
    for words in (
        [],
        ["a.csv", "-o", "b.csv"],
        ["-o", "a.csv"],
        ["-o", "a.csv", "--rate", "3 V"],
        ["a.cir", "--as", "hp_33120a"],
        ["a.cir", "--edge", "line"],
        ["a.cir", "--gain", "2"],
        ["a.pwl", *limits, "--edge", "line"],
        ["a.csv", *limits, "--edge", "lines"],
        ["a.csv", *limits, "--edge", "0 s"],
        [*held, "--edge", "line"],
        held,
    ):
        assert isinstance(run(*words).exception, InputError), words
    assert ev.export(FIG6, "again.csv", limits="limits.toml", edge="line") == Path("again.csv")
    assert (folder / "again.csv").exists()


# ramps, edges and amplifiers


@pytest.mark.parametrize(
    ("suffix", "options"), [(".csv", {}), (".wav", {}), (".csv", GENERATOR | {"gain": 10} | EDGE)]
)
def test_a_ramp_lets_a_drive_begin_and_end_at_zero(suffix, options):
    """A cosine times an envelope of 2 ms; the bound of the error holds and is not far from the error itself."""
    cosine = {"model": "Sine", "amplitude": "50 V", "frequency": "500 Hz", "phase": 1.5}
    scenario = BURST.replace({"drive": cosine, "time.duration": "10.01 ms"})
    refused("--ramp", scenario, f"drive{suffix}", **options)
    found = export(scenario, f"drive{suffix}", ramp=2e-3, **options)
    times, voltages = read_back(found.path, found.full_scale)
    assert (voltages[0], voltages[-1]) == (0, 0)
    end, length = times[-1], round(2e-3 * found.waveform.rate) / found.waveform.rate
    dense = np.linspace(0, end, 300_007)
    wanted = scenario.drive.voltage(dense) * np.clip(np.minimum(dense, end - dense) / length, 0, 1)
    places = np.clip(np.searchsorted(times, dense, side="right") - 1, 0, len(times) - 1)
    played = voltages[places] if found.waveform.held else np.interp(dense, times, voltages)
    off = np.max(np.abs(played - wanted))
    assert 0.3 * found.waveform.error < off <= found.waveform.error * (1 + 1e-6)
    assert any("ramps of 2 ms" in note for note in found.notes)
    for wrong in (0.0, -1.0, np.nan, 6e-3):
        refused("ramp", scenario, "other.csv", ramp=wrong)


def test_a_ramp_bounds_the_switching_current_and_a_bandwidth_that_is_only_assumed_does_not(folder):
    """One pole at 1 Hz would leave nothing of the current of 500 V within 0.1 us; without a ramp 1 kohm takes 100 mA."""
    square = {"model": "Trapezium", "high": 500.0, "rise": 1e-7, "hold": 5e-3, "fall": 1e-7}
    scenario = PULSE.replace({"drive": square, "circuit.amplifier": {"bandwidth": 1.0}})
    refused(r"above 250 uA.*as circuit\.amplifier\.hardware", scenario, rate=1e7)
    assert not list(folder.iterdir())
    present = export(scenario, rate=1e7, amplifier_present=True).check.value("peak current")
    assert present < 250e-6
    found = export(scenario.replace({"circuit.amplifier.hardware": "our amplifier, 1 Hz"}), rate=1e7)
    assert found.check.value("peak current") == present
    assert any("(our amplifier, 1 Hz)" in note for note in found.notes)
    carrier = {"model": "Sine", "amplitude": "100 V", "frequency": "100 Hz", "phase": np.pi / 2}
    scenario = BURST.replace({"drive": carrier, "time.duration": "50 ms"})
    assert ev.check(scenario).value("peak current") > 0.09
    assert export(scenario, ramp=5e-3).check.value("peak current") < 5e-6


@pytest.mark.parametrize(
    ("text", "words"),
    [
        *(
            (each, "names no amplifier")
            for each in ("none", "No", " ", "NONE", "-", "n/a", "not there", "keiner", "нет", "なし", "0")
        ),
        *((each, "has no model number") for each in ("amplificador", "our amplifier", "yes")),
        *(
            (each, "states .*more than source_current = 250 uA")
            for each in ("Trek 609E-6, 20 mA", "PA 12, 1 A", "PA 12, 0.5mA")
        ),
    ],
)
def test_only_an_amplifier_that_is_there_limits_the_current(folder, text, words):
    """One edge of 0.1 us drives tens of mA into the plate unless a real amplifier holds them back."""
    square = {"model": "Trapezium", "high": 500.0, "rise": 1e-7, "hold": 5e-3, "fall": 1e-7}
    amplifier = {"source_current": 250e-6, "hardware": text}
    scenario = PULSE.replace({"drive": square, "circuit.amplifier": amplifier})
    refused(rf"circuit.amplifier.hardware = .*{words}", scenario, rate=1e7)
    assert not list(folder.iterdir())


@pytest.mark.parametrize(
    "text", ["Trek 609E-6", "PA 12, 250uA", "Trek 609E-6 (20 mA), limited to 200 \u00b5A", "日本 HV-1"]
)
def test_an_amplifier_that_is_named_counts(text):
    amplifier = ev.load(
        PULSE, changes={"circuit.amplifier": {"source_current": 250e-6, "hardware": text}}
    ).circuit.amplifier
    assert amplifier.hardware_fault == ""


@pytest.mark.parametrize("options", [{"edge": "line"}, {"edge": 1e-6}, {"edge": "line", "ramp": 1e-3}])
def test_a_peak_between_the_samples_is_judged_whatever_error_is_allowed(folder, options):
    pulse = {"model": "Trapezium", "high": 900.0, "rise": 0.02, "hold": 0.06, "fall": 0.02}
    spike = {"model": "Trapezium", "high": 300.0, "delay": 0.05001, "rise": 1e-8, "hold": 0.0, "fall": 1e-8}
    spiked = PULSE.replace({"drive": {"model": "Sum", "drives": [pulse, spike]}, "time.duration": 0.1})
    refused("above 1 kV", spiked, rate=1e4, largest_error=10, **options)
    assert not list(folder.iterdir())
    low = spiked.replace({"drive.drives.0.high": 600.0})
    refused("differs from the drive by up to 300 V", low, rate=1e4, **options)


def test_what_is_written_states_how_it_is_played():
    for edge, words in (("line", "straight lines between the samples"), (1e-6, "edges of 1 us between them")):
        found = export(BURST, edge=edge, largest_error=0.05)
        assert any(f"was checked with {'each' if edge != 'line' else ''}" in note for note in found.notes)
        assert words in found.path.read_text(encoding="utf-8")
        assert found.waveform.held == (edge != "line")
    loose = {"limits": {"current": "1 A"}, "set": {"limits.current": "1 A"}}
    steps = export(BURST, **loose, **GENERATOR, edge=None)
    assert any("and steps between them" in note for note in steps.notes)
