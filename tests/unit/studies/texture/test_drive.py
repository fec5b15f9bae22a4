"""Drives of textures: closed form in time, the force of the full model, limits, and every combination of inputs."""

import math

import numpy as np
import pytest
from PIL import Image

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.studies.design.drive.carrier import carrier_gain
from electrovib.studies.texture.drive import mean_over_period

PLATE = "vezzoli_2014/fig6"  # friction coefficient 0.5, limit of the current 250 uA
LIMITS = {"voltage": "1 kV", "current": "250 uA"}
GRATING = {"model": "Grating", "period": "1 mm", "amplitude": "0.5 mN"}
FAINT = GRATING | {"amplitude": "10 uN"}
GAIN = carrier_gain(ev.load(PLATE), [3e3]).force[0]


def drive(texture=GRATING, path="50 mm/s", **options):
    given = {"carrier": "3 kHz", "limits": LIMITS} | options
    return ev.texture_drive(PLATE, texture=texture, path=path, **given)


def picture(values, width=4, pixels_per_millimetre=1):
    size = {"width": width, "pixels_per_millimetre": pixels_per_millimetre}
    return {"model": "GreyscalePicture", "value_samples": values} | size


@pytest.fixture(scope="module")
def grating():
    return drive(rate="96 kHz")


def test_a_grating_at_constant_speed_is_its_closed_form_in_time(grating):
    """Attraction = amplitude (1 + sin(2 pi u t/period))/mu, its root on the carrier, and the full model gives it."""
    time, ramp, voltages = grating.times, 1e-3, grating.voltages
    inside = time <= grating.path.duration
    closed = 0.5e-3 * (1 + np.sin(2 * math.pi * 50e-3 * time / 1e-3)) / 0.5
    np.testing.assert_allclose(grating.wanted_force[inside], closed[inside], rtol=1e-9, atol=1e-15)
    tone = np.sqrt(grating.wanted_force / GAIN) * np.sin(2 * math.pi * 3e3 * time)
    expected = (tone * np.clip(time / ramp, 0, 1))[inside]
    np.testing.assert_allclose(voltages[inside], expected, rtol=1e-9, atol=1e-9)
    assert 0 < grating.misfit < 0.01
    predicted, wanted = (each[500:-500] for each in (grating.predicted_force, grating.wanted_force))
    assert np.sqrt(np.mean((predicted - wanted) ** 2) / np.mean(wanted**2)) < 0.01
    friction = grating.predicted_friction[500:-500]
    np.testing.assert_allclose(friction, 0.5 * (0.5 + predicted), rtol=1e-9)
    assert voltages[0] == voltages[-1] == 0
    assert not grating.check.failed
    rows = {row.quantity: row for row in grating.check.rows}
    assert rows["peak voltage"].value == pytest.approx(np.max(np.abs(voltages)))
    assert rows["peak current"].state == "pass"
    assert grating.scenario.motion.speed == 0.05


def test_white_is_the_most_that_the_limits_give_and_black_nothing():
    """A picture of one grey value: 255 gives the largest force, and the current stays within its limit by 1 %."""
    white, black = (drive(picture([value] * 16), "100 mm/s") for value in (255, 0))
    middle = len(white.times) // 2
    assert white.wanted_force[middle] == pytest.approx(white.largest_force, rel=1e-12)
    assert 0.985 * 250e-6 < white.check.value("peak current") <= 250e-6
    assert white.predicted_force[middle] == pytest.approx(4.6e-3, rel=0.01)  # 404 V at 3 kHz on the finger
    assert not black.voltages.any()
    assert math.isnan(black.misfit)
    assert "needs no force" in black.misfit_in_words


OWN = {"set": {"circuit.amplifier": {"gain": -10.0, "saturation": "200 V"}}}
LARGEST = {
    "voltage": ({"limits": {"voltage": "100 V", "current": "1 mA"}}, 100, ""),
    "slew rate": ({"limits": LIMITS | {"slew_rate": "1 MV/s"}}, None, "determined by the slew rate, 1 MV/s"),
    "saturation": (OWN, 200, "its saturation"),
}


@pytest.mark.parametrize("case", LARGEST)
def test_the_strictest_limit_of_the_plate_determines_the_largest_force(case):
    """A ramp of 1 ms to 0 V belongs to the slope: w a (1 + 1/(w ramp)^2)^(1/2)."""
    options, amplitude, words = LARGEST[case]
    amplitude = amplitude or 1e6 / math.hypot(2 * math.pi * 3e3, 1e3)
    found, alone = drive(FAINT, **options), drive(FAINT)
    exact = 1e-9 if options is OWN else 1e-12
    assert found.largest_force == pytest.approx(GAIN * amplitude**2, rel=exact)
    assert words in found.notes[1]
    gain = 10 if options is OWN else 1
    np.testing.assert_allclose(gain * found.voltages, alone.voltages, rtol=1e-9, atol=1e-11)


def test_stray_capacitance_takes_its_share_of_the_current():
    """On 33 pF of the finger, 100 pF of stray capacitance leave a quarter of the amplitude."""
    own = {"circuit.amplifier": {"stray_capacitance": "100 pF"}}
    stray, alone = (drive(FAINT, set=each).largest_force for each in (own, {}))
    assert math.sqrt(stray / alone) == pytest.approx(32.96 / 132.96, rel=0.01)


RECORDED = {
    "model": "RecordedFrictionForce",
    "position_samples": [0, 1e-3],
    "friction_force_samples": [0.2, 0.3],
}
STEEP = picture([255] * 300 + [0] * 100, 400, 100)
REAL = {"friction": {"model": "AdhesiveShear", "shear_strength": 1e6}}
REFUSED = {
    "limits": ({"limits": None, "set": {"limits": {}}}, "not declared, and the drive of a texture needs"),
    "current": ({"limits": {"voltage": "1 kV"}, "set": {"limits": {}}}, "not declared, and the drive of"),
    "too much": ({"texture": GRATING | {"amplitude": "10 mN"}}, r"attraction of 20 mN, .* gives 4\.6"),
    "less": ({"texture": RECORDED | {"baseline": 0.25}}, "less friction than the plate itself"),
    "too steep": ({"texture": STEEP, "path": "1 m/s"}, "the voltage changes at"),
    "carrier": ({"rate": "5 kHz"}, r"carrier = 3000 Hz: a carrier may have 0.4 of the rate"),
    "no path": ({"path": "none.csv"}, "none.csv: there is no such file"),
    "a wrong path": ({"path": 3}, "path: expected a TOML file or a table such as"),
    "a wrong texture": ({"texture": 3}, "texture: expected a TOML file or a table such as"),
    "a wrong amount": ({"ramp": "3 V"}, "ramp = 3 V: expected a time"),
    "an amount out of range": ({"ramp": "1 h"}, "ramp = 1 h: "),
    "too many samples": ({"rate": "10 MHz"}, "more than 2000000 samples"),
    "a leak": ({"set": {"stack.insulator.leak": {"model": "Ohmic"}}}, "leak"),
    "no friction": ({"set": {"friction.coefficient": 0.0}}, "friction: does not increase with the"),
    "real area": ({"set": REAL}, "real contact area"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_rendered_is_refused_in_a_sentence(case, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    options, words = REFUSED[case]
    with pytest.raises(InputError, match=words):
        drive(**options)


def test_a_law_that_is_not_linear_is_inverted_and_a_mean_over_a_period_removes_its_tone():
    law = {"model": "PowerLaw", "coefficient": 0.5, "at_force": 0.5, "exponent": -0.2}
    found = drive(set={"friction": law}, rate="96 kHz")
    inside = slice(200, np.searchsorted(found.times, found.path.duration))
    wanted = 0.5e-3 * (1 + np.sin(2 * math.pi * 50 * found.times[inside]))
    friction = 0.25 * ((0.5 + found.wanted_force[inside]) / 0.5) ** 0.8 - 0.25
    np.testing.assert_allclose(friction, wanted, rtol=1e-6, atol=1e-12)
    time = np.linspace(0, 1, 2001)
    mean = mean_over_period(time, 3 + time + np.sin(2 * math.pi * 50 * time), 0.02)
    np.testing.assert_allclose(mean[100:-100], (3 + time)[100:-100], rtol=1e-9)


def test_without_a_carrier_the_force_is_the_gain_of_a_sine_times_twice_the_squared_voltage():
    """The mean of a squared sine is half the square of its amplitude; the misfit names the carrier."""
    found = drive(carrier=None)
    gain = carrier_gain(ev.load(PLATE), [100.0]).force[0]
    inside = slice(10, np.searchsorted(found.times, found.path.duration))
    force = 2 * gain * found.voltages[inside] ** 2
    np.testing.assert_allclose(force, found.wanted_force[inside], rtol=1e-9, atol=1e-15)
    found = drive(carrier=None)
    assert found.misfit > 0.1
    words = "WITHOUT A CARRIER this stack does not follow the texture; take a carrier"
    assert found.misfit_in_words.endswith(words)


TABLES = {
    "Grating": 'period = "1 mm"\namplitude = "0.5 mN"',
    "HeightProfile": 'file = "profile.csv"',
    "RecordedFrictionForce": 'file = "profile.csv"',
    "RecordedFrictionCoefficient": 'file = "profile.csv"',
    "GreyscalePicture": 'file = "picture.png"\npixels_per_millimetre = 2',
}
PATHS = {
    "path.csv": "time [s],x [mm]\n0,0\n0.03,2\n0.04,2\n0.06,0.5\n",
    "both.csv": "time [s],x [mm],y [mm]\n0,0,1\n0.03,2,1.5\n0.05,4,2\n",
    "path.toml": '[path]\nmodel = "ConstantSpeed"\nspeed = "80 mm/s"\nstroke = "4 mm"\n',
}


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Textures and paths as files, as a user has them."""
    folder = tmp_path_factory.mktemp("textures")
    x = np.linspace(0, 4, 41)
    bump = np.exp(-((x - 2) ** 2))
    rows = zip(x, 2e-3 * bump, 0.25 + 1e-3 * bump, 0.5 + 2e-3 * bump, strict=True)
    lines = ["position [mm],height [mm],friction_force [N],friction_coefficient"]
    lines += [",".join(map(str, row)) for row in rows]
    Image.fromarray(np.tile(np.uint8([[0, 60, 120, 60, 0, 0, 0, 0]]), (8, 1))).save(folder / "picture.png")
    texts = {
        f"{name}.toml": f'[texture]\nmodel = "{name}"\n{text}\n' for name, text in TABLES.items()
    } | PATHS
    for name, text in (texts | {"profile.csv": "\n".join(lines)}).items():
        (folder / name).write_text(text, encoding="utf-8")
    return folder


def combinations():
    """Every texture, path and carrier; of each texture one path is run by default."""
    for place, texture in enumerate(TABLES):
        for number, path in enumerate(("80 mm/s", "path.csv", "path.toml", "both.csv")):
            for carrier in (None, "2 kHz"):
                few = (place + number) % 4 == 0 and bool(carrier) == (place > 1)
                yield pytest.param(texture, path, carrier, marks=() if few else pytest.mark.slow)


@pytest.mark.parametrize(("texture", "path", "carrier"), list(combinations()))
def test_every_texture_on_every_path_with_and_without_carrier(texture, path, carrier, files, monkeypatch):
    monkeypatch.chdir(files.parent)
    chosen = files / path if path in PATHS else path
    found = drive(files / f"{texture}.toml", chosen, carrier=carrier, rate="16 kHz")
    assert type(found.texture).__name__ == texture
    assert found.voltages[0] == found.voltages[-1] == 0
    assert found.wanted_force.max() > 1e-5
    assert found.positions.shape == (len(found.times), 2)
    assert len(found.predicted_friction) == len(found.times)
    if carrier:  # 16 kHz is 8 samples per cycle: straight lines between them lower the force by about a tenth
        assert found.misfit < 0.2


@pytest.mark.parametrize("suffix", [".csv", ".npy", ".mat", ".pwl"])
def test_a_drive_is_exported_as_it_is(suffix, grating, tmp_path):
    asked = {"limits": LIMITS, "rate": grating.rate} | ({} if suffix == ".pwl" else {"edge": "line"})
    written = ev.export_waveform(grating.scenario, tmp_path / f"drive{suffix}", **asked)
    np.testing.assert_array_equal(written.waveform.voltages, grating.voltages)
    assert written.waveform.error == 0


def test_a_drive_for_the_generator_has_its_number_of_points_or_is_refused(grating, tmp_path):
    generator = {"limits": LIMITS, "instrument": "hp_33120a", "scaling": ev.Scaling(gain=100)}
    with pytest.raises(InputError, match="the waveform differs from the drive"):
        ev.export_waveform(grating.scenario, tmp_path / "drive.csv", **generator)
    slow = drive(GRATING | {"amplitude": "50 uN"}, carrier=None, path="200 mm/s")
    written = ev.export_waveform(slow.scenario, tmp_path / "drive.csv", **generator, edge=1e-6)
    assert len(written.waveform.times) <= 16_000
