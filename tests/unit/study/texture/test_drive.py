"""Drives of textures: closed form in time, the force of the full model, limits, and every combination of inputs."""

from __future__ import annotations

import math

import numpy as np
import pytest
from PIL import Image

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.study.design.gain import carrier_gain
from electrovib.study.texture.drive import mean_over_period

PLATE = "vezzoli_2014/fig6"  # friction coefficient 0.5, limit of the current 250 uA
LIMITS = {"voltage": "1 kV", "current": "250 uA"}
GRATING = {"model": "Grating", "period": "1 mm", "amplitude": "0.5 mN"}


def drive(texture=GRATING, path="50 mm/s", **options):
    return ev.texture_drive(
        PLATE, texture=texture, path=path, **{"carrier": "3 kHz", "limits": LIMITS} | options
    )


@pytest.fixture(scope="module")
def grating():
    return drive(rate="96 kHz")


def test_a_grating_at_constant_speed_is_its_closed_form_in_time(grating):
    """Attraction = amplitude (1 + sin(2 pi u t/period))/mu, at the temporal frequency u/period."""
    inside = grating.times <= grating.path.duration
    time = grating.times[inside]
    closed = 0.5e-3 * (1 + np.sin(2 * math.pi * 50e-3 * time / 1e-3)) / 0.5
    np.testing.assert_allclose(grating.wanted_force[inside], closed, rtol=1e-9, atol=1e-15)


def test_samples_are_the_root_of_the_force_on_the_carrier(grating):
    gain = carrier_gain(ev.load(PLATE), [3e3]).force[0]
    time, ramp = grating.times, 1e-3
    inside = (time >= ramp) & (time <= grating.path.duration)
    expected = np.sqrt(grating.wanted_force / gain) * np.sin(2 * math.pi * 3e3 * time)
    np.testing.assert_allclose(grating.voltages[inside], expected[inside], rtol=1e-9, atol=1e-9)
    rising = time < ramp
    np.testing.assert_allclose(
        grating.voltages[rising], (expected * time / ramp)[rising], rtol=1e-9, atol=1e-9
    )


def test_the_full_model_gives_the_wanted_force_to_one_percent(grating):
    assert 0 < grating.misfit < 0.01
    inner = slice(500, -500)
    difference = grating.predicted_force[inner] - grating.wanted_force[inner]
    size = np.sqrt(np.mean(grating.wanted_force[inner] ** 2))
    assert np.sqrt(np.mean(difference**2)) / size < 0.01
    np.testing.assert_allclose(
        grating.predicted_friction[inner], 0.5 * (0.5 + grating.predicted_force[inner]), rtol=1e-9
    )


def test_a_drive_begins_and_ends_at_0_volts_and_within_its_limits(grating):
    assert grating.voltages[0] == grating.voltages[-1] == 0
    assert not grating.check.failed
    rows = {row.quantity: row for row in grating.check.rows}
    assert rows["peak voltage"].value == pytest.approx(np.max(np.abs(grating.voltages)))
    assert rows["peak current"].state == "pass"
    assert grating.scenario.motion.speed == 0.05


def test_white_is_the_most_that_the_limits_give_and_black_nothing():
    """A picture of one grey value: 255 gives the largest force, and the current stays within its limit by 1 %."""
    white = drive(
        {"model": "GreyscalePicture", "width": 4, "value_samples": [255] * 16, "pixels_per_millimetre": 1},
        "100 mm/s",
    )
    middle = len(white.times) // 2
    assert white.wanted_force[middle] == pytest.approx(white.largest_force, rel=1e-12)
    current = next(row for row in white.check.rows if row.quantity == "peak current")
    assert 0.985 * 250e-6 < current.value <= 250e-6
    assert white.predicted_force[middle] == pytest.approx(
        4.6e-3, rel=0.01
    )  # 404 V at 3 kHz for the finger alone
    black = drive(
        {"model": "GreyscalePicture", "width": 4, "value_samples": [0] * 16, "pixels_per_millimetre": 1},
        "100 mm/s",
    )
    assert not black.voltages.any()
    assert math.isnan(black.misfit)
    assert "needs no force" in black.misfit_in_words


def test_the_voltage_is_the_limit_where_it_is_the_strictest():
    found = drive(limits={"voltage": "100 V", "current": "1 mA"}, texture=GRATING | {"amplitude": "10 uN"})
    assert found.largest_force == pytest.approx(carrier_gain(ev.load(PLATE), [3e3]).force[0] * 1e4, rel=1e-12)


def test_the_slew_rate_is_the_limit_where_it_is_the_strictest():
    """A ramp of 1 ms to 0 V belongs to the slope: w a (1 + 1/(w ramp)^2)^(1/2)."""
    found = drive(limits=LIMITS | {"slew_rate": "1 MV/s"}, texture=GRATING | {"amplitude": "10 uN"})
    amplitude = 1e6 / math.hypot(2 * math.pi * 3e3, 1e3)
    gain = carrier_gain(ev.load(PLATE), [3e3]).force[0]
    assert found.largest_force == pytest.approx(gain * amplitude**2, rel=1e-12)
    assert "determined by the slew rate, 1 MV/s" in found.notes[1]


def test_the_limits_are_those_of_the_plate_behind_the_gain_of_the_amplifier():
    amplified = drive(
        set={"circuit.amplifier": {"gain": -10.0, "saturation": "200 V"}},
        texture=GRATING | {"amplitude": "10 uN"},
    )
    assert amplified.largest_force == pytest.approx(
        carrier_gain(ev.load(PLATE), [3e3]).force[0] * 4e4, rel=1e-9
    )
    assert "the saturation of the amplifier, 200 V" in amplified.notes[1]
    alone = drive(texture=GRATING | {"amplitude": "10 uN"})
    np.testing.assert_allclose(amplified.voltages, alone.voltages / 10, rtol=1e-9, atol=1e-12)


def test_stray_capacitance_takes_its_share_of_the_current():
    """On 33 pF of the finger, 100 pF of stray capacitance leave a quarter of the amplitude."""
    alone = drive(texture=GRATING | {"amplitude": "10 uN"})
    stray = drive(
        texture=GRATING | {"amplitude": "10 uN"}, set={"circuit.amplifier": {"stray_capacitance": "100 pF"}}
    )
    assert math.sqrt(stray.largest_force / alone.largest_force) == pytest.approx(32.96 / 132.96, rel=0.01)


@pytest.mark.parametrize("limits", [None, {"voltage": "1 kV"}])
def test_without_limits_there_is_no_drive(limits):
    scenario = ev.load(PLATE, changes={"limits": {}})
    with pytest.raises(
        InputError,
        match=r"not declared, and the drive of a texture needs the largest voltage and the largest",
    ):
        ev.texture_drive(scenario, texture=GRATING, path="50 mm/s", limits=limits)


REFUSED = {
    "too much": (
        {"texture": GRATING | {"amplitude": "10 mN"}},
        r"texture: the texture needs an attraction of 20 mN, and the hardware gives 4\.6",
    ),
    "less than the plate": (
        {
            "texture": {
                "model": "RecordedFrictionForce",
                "position_samples": [0, 1e-3],
                "friction_force_samples": [0.2, 0.3],
                "baseline": 0.25,
            }
        },
        "less friction than the plate itself",
    ),
    "too steep": (
        {
            "texture": {
                "model": "GreyscalePicture",
                "width": 400,
                "value_samples": [255] * 300 + [0] * 100,
                "pixels_per_millimetre": 100,
            },
            "path": "1 m/s",
        },
        "the voltage changes at",
    ),
    "carrier above the rate": ({"rate": "5 kHz"}, r"carrier = 3000 Hz: a carrier may have 0.4 of the rate"),
    "no path": ({"path": "none.csv"}, "none.csv: there is no such file"),
    "a wrong path": ({"path": 3}, "path: expected a TOML file or a table such as"),
    "a wrong texture": ({"texture": 3}, "texture: expected a TOML file or a table such as"),
    "a wrong amount": ({"ramp": "3 V"}, "ramp = 3 V: expected a time"),
    "an amount out of range": ({"ramp": "1 h"}, "ramp = 1 h: "),
    "too many samples": ({"rate": "10 MHz"}, "more than 2000000 samples"),
    "a leak": ({"set": {"stack.insulator.leak": {"model": "Ohmic"}}}, "leak"),
    "no friction": (
        {"set": {"friction.coefficient": 0.0}},
        "friction: does not increase with the attraction",
    ),
    "real area": (
        {"set": {"friction": {"model": "AdhesiveShear", "shear_strength": 1e6}}},
        "real contact area",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_rendered_is_refused_in_a_sentence(case, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    options, words = REFUSED[case]
    with pytest.raises(InputError, match=words):
        drive(**options)


def test_a_law_that_is_not_linear_is_inverted():
    law = {"model": "PowerLaw", "coefficient": 0.5, "at_force": 0.5, "exponent": -0.2}
    found = drive(set={"friction": law}, rate="96 kHz")
    inside = slice(200, np.searchsorted(found.times, found.path.duration))
    time = found.times[inside]
    wanted = 0.5e-3 * (1 + np.sin(2 * math.pi * 50 * time))
    friction = 0.25 * ((0.5 + found.wanted_force[inside]) / 0.5) ** 0.8 - 0.25
    np.testing.assert_allclose(friction, wanted, rtol=1e-6, atol=1e-12)


def test_the_misfit_without_a_carrier_names_the_carrier():
    found = drive(carrier=None)
    assert found.misfit > 0.1
    assert found.misfit_in_words.endswith(
        "WITHOUT A CARRIER this stack does not follow the texture; take a carrier"
    )


def test_without_a_carrier_the_force_is_the_gain_of_a_sine_times_twice_the_squared_voltage():
    """The mean of a squared sine is half the square of its amplitude."""
    found = drive(carrier=None, frequency="1 kHz")
    gain = carrier_gain(ev.load(PLATE), [1e3]).force[0]
    inside = slice(10, np.searchsorted(found.times, found.path.duration))
    np.testing.assert_allclose(
        2 * gain * found.voltages[inside] ** 2, found.wanted_force[inside], rtol=1e-9, atol=1e-15
    )


def test_the_mean_over_a_period_removes_a_tone_of_that_period():
    time = np.linspace(0, 1, 2001)
    mean = mean_over_period(time, 3 + time + np.sin(2 * math.pi * 50 * time), 0.02)
    np.testing.assert_allclose(mean[100:-100], (3 + time)[100:-100], rtol=1e-9)


PICTURE = np.tile(np.uint8([[0, 60, 120, 60, 0, 0, 0, 0]]), (8, 1))
TEXTURES = {
    "grating": "Grating",
    "height": "HeightProfile",
    "force": "RecordedFrictionForce",
    "coefficient": "RecordedFrictionCoefficient",
    "picture": "GreyscalePicture",
}
PATHS = ("speed", "csv", "toml", "two dimensions")


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Textures, paths and limits as files, as a user has them."""
    folder = tmp_path_factory.mktemp("textures")
    x = np.linspace(0, 4, 41)
    bump = np.exp(-((x - 2) ** 2))
    rows = zip(x, 2e-3 * bump, 0.25 + 1e-3 * bump, 0.5 + 2e-3 * bump, strict=True)
    lines = [
        "position [mm],height [mm],friction_force [N],friction_coefficient",
        *(",".join(map(str, row)) for row in rows),
    ]
    (folder / "profile.csv").write_text("\n".join(lines), encoding="utf-8")
    Image.fromarray(PICTURE).save(folder / "picture.png")
    (folder / "grating.toml").write_text(
        'model = "Grating"\nperiod = "1 mm"\namplitude = "0.5 mN"\n', encoding="utf-8"
    )
    for name in ("height", "force", "coefficient"):
        table = f'[texture]\nmodel = "{TEXTURES[name]}"\nfile = "profile.csv"\n'
        (folder / f"{name}.toml").write_text(table, encoding="utf-8")
    table = '[texture]\nmodel = "GreyscalePicture"\nfile = "picture.png"\npixels_per_millimetre = 2\n'
    (folder / "picture.toml").write_text(table, encoding="utf-8")
    (folder / "path.csv").write_text("time [s],x [mm]\n0,0\n0.03,2\n0.04,2\n0.06,0.5\n", encoding="utf-8")
    (folder / "both.csv").write_text(
        "time [s],x [mm],y [mm]\n0,0,1\n0.03,2,1.5\n0.05,4,2\n", encoding="utf-8"
    )
    (folder / "path.toml").write_text(
        '[path]\nmodel = "ConstantSpeed"\nspeed = "80 mm/s"\nstroke = "4 mm"\n', encoding="utf-8"
    )
    return folder


def combinations():
    """Every texture, path and carrier; of each texture one path is run by default."""
    for place, texture in enumerate(TEXTURES):
        for number, path in enumerate(PATHS):
            for carrier in (None, "2 kHz"):
                few = (place + number) % 4 == 0 and bool(carrier) == (place > 1)
                marks = () if few else pytest.mark.slow
                yield pytest.param(texture, path, carrier, marks=marks)


@pytest.mark.parametrize(("texture", "path", "carrier"), list(combinations()))
def test_every_texture_on_every_path_with_and_without_carrier(texture, path, carrier, files, monkeypatch):
    monkeypatch.chdir(files.parent)
    chosen = {
        "speed": "80 mm/s",
        "csv": files / "path.csv",
        "toml": files / "path.toml",
        "two dimensions": files / "both.csv",
    }
    found = drive(files / f"{texture}.toml", chosen[path], carrier=carrier, rate="16 kHz")
    assert type(found.texture).__name__ == TEXTURES[texture]
    assert found.voltages[0] == found.voltages[-1] == 0
    assert found.wanted_force.max() > 1e-5
    assert found.positions.shape == (len(found.times), 2)
    assert len(found.predicted_friction) == len(found.times)
    if carrier:  # 16 kHz is 8 samples per cycle: straight lines between them lower the force by about a tenth
        assert found.misfit < 0.2


@pytest.mark.parametrize("suffix", [".csv", ".npy", ".mat", ".pwl"])
def test_a_drive_is_exported_as_it_is(suffix, grating, tmp_path):
    written = ev.export_waveform(
        grating.scenario,
        tmp_path / f"drive{suffix}",
        limits=LIMITS,
        rate=grating.rate,
        **({} if suffix == ".pwl" else {"edge": "line"}),
    )
    np.testing.assert_array_equal(written.waveform.voltages, grating.voltages)
    assert written.waveform.error == 0


def test_a_drive_for_the_generator_has_its_number_of_points_or_is_refused(grating, tmp_path):
    with pytest.raises(InputError, match="the waveform differs from the drive"):
        ev.export_waveform(
            grating.scenario, tmp_path / "drive.csv", limits=LIMITS, instrument="hp_33120a", gain=100
        )
    slow = drive(GRATING | {"amplitude": "50 uN"}, carrier=None, path="200 mm/s")
    written = ev.export_waveform(
        slow.scenario, tmp_path / "drive.csv", limits=LIMITS, instrument="hp_33120a", gain=100, edge=1e-6
    )
    assert len(written.waveform.times) <= 16_000
