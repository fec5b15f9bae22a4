"""A dispersion fitted to files of spectra: material, both uncertainties, the scenario with it, a loss that is missing."""

import inspect
import math
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.physics.material import ColeCole, Constant
from electrovib.recordings.spectra.fitted import InstrumentError, error_by_resistor
from electrovib.recordings.spectra.material import forms_of

pytestmark = pytest.mark.usefixtures("blank_pictures")

SHARED = Path(__file__).parents[4] / "shared" / "data" / "skin_impedance"
GUIDE = Path(__file__).parents[3] / "docs" / "how_to" / "my_recording.md"
GRID, WIDE = np.geomspace(100, 1e5, 31), np.geomspace(10, 1e6, 41)
SKIN = ColeCole(
    permittivity_high=50.0,
    terms=[{"strength": 1500.0, "relaxation_time": 2e-5, "broadening": 0.3}],
    conductivity=1e-4,
)
TRUE = {
    "permittivity_high": 50.0,
    "terms.0.strength": 1500.0,
    "terms.0.relaxation_time": 2e-5,
    "terms.0.broadening": 0.3,
    "conductivity": 1e-4,
}
ONE, PART = {"form": "cole-cole-1"}, {"area": "1 cm2", "thickness": "1 mm", "form": "constant"}
UNIT = 1e-3 / (eps0 * 1e-4)
"""Relative permittivity of a part of 1 cm2 and 1 mm for each farad."""


def rows(path, header, *columns):
    """Write a table of numbers, which read back as they are."""
    np.savetxt(path, np.column_stack(columns), fmt="%.17g", delimiter=",", header=header, comments="")
    return path


def written(path, *, noise=0.01, seed=1, grid=GRID, factor=1.0):
    """A table of permittivity and loss factor with relative noise."""
    rng, exact = np.random.default_rng(seed), SKIN.complex_permittivity(grid) * factor
    real, loss = (part * (1 + noise * rng.normal(size=grid.size)) for part in (exact.real, -exact.imag))
    return rows(path, "f [Hz],permittivity,loss factor", grid, real, loss)


def resistor(path, *, value=51e3, phase=0.0):
    """A table of the impedance of a resistor, with a phase in degrees."""
    ripple = 1 + 1e-4 * (-1.0) ** np.arange(31)
    return rows(path, "f [Hz],|Z| [ohm],phase [deg]", GRID, value * ripple, np.full(31, phase))


def impedance(path, values, *, grid=GRID):
    return rows(path, "f [Hz],Z' [ohm],Z'' [ohm]", grid, values.real, values.imag)


def fitted(files, **given):
    """Fit files, by the names of the arguments and of what they hold."""
    groups = [
        kind(**{name: given.pop(name) for name in inspect.signature(kind).parameters if name in given})
        for kind in (ev.SpectrumRecipe, ev.SpectrumErrors)
    ]
    return ev.fit_material(files, groups[0], errors=groups[1], **given)


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    return written(tmp_path_factory.mktemp("material") / "skin.csv")


def test_the_material_is_that_of_the_file_and_runs_in_a_scenario(file, tmp_path):
    out = tmp_path / "my_skin.toml"
    found = fitted(file, thickness="150 um", output=out, **ONE)
    for each, true in zip(found.parameters, TRUE.values(), strict=True):
        assert abs(each.value - true) < 4 * (each.upper - each.lower) / 3.92
        assert np.isnan(each.systematic)
    layer = tomllib.loads(out.read_text())["stack"]["stratum_corneum"]
    changes = {f"stack.stratum_corneum.{name}": value for name, value in layer.items()}
    scenario = ev.load("vezzoli_2014/fig6", changes=changes)
    skin = scenario.stack.layers["stratum_corneum"]
    assert (skin.thickness, skin.material) == (150e-6, found.material)
    assert np.isfinite(ev.simulate(scenario).electrostatic_force).all()
    part = fitted(file, band=("1 kHz", 1e4), **ONE)
    assert part.history[0].endswith("11 rows")  # both ends included


def test_the_scenario_with_the_material_states_its_source(file, tmp_path):
    out = tmp_path / "with.toml"
    given = {"thickness": "150 um", "into": "vezzoli_2014/fig6", "systematic": 0.02, "output": out}
    found = fitted(file, **given, **ONE)
    scenario = ev.load(out)
    skin = scenario.stack.layers["stratum_corneum"]
    assert (skin.thickness, skin.material) == (150e-6, found.material)
    source = scenario.sources["stack.stratum_corneum.material.terms.0.strength"]
    for words in ("skin.csv", "ColeCole, 1 term", "statistical 95 % interval", "systematic error of the"):
        assert words in source
    fitted(file, into="vezzoli_2014/fig6", output=out, **ONE)  # our own file is replaced
    out.write_text(out.read_text().replace("150 um", "151 um") + "\n# mine")
    with pytest.raises(InputError, match="exists already"):
        fitted(file, into="vezzoli_2014/fig6", output=out, **ONE)


def test_the_command_writes_the_material_or_the_scenario_with_it(file, here, said, refused):
    asked = f"fit-material {file} --form cole-cole-1 --band '100 Hz..50 kHz' --scatter 'skin.csv=1 %'"
    out = said(f"{asked} --systematic 2% -o my_skin.toml")
    for words in ("terms.0.strength ", "error of the instrument (95 %)", " +- ", "written"):
        assert words in out
    text = (here / "my_skin.toml").read_text()
    assert "statistical 95 % interval" in text
    assert 'model = "ColeCole"' in text
    grid = np.geomspace(10, 1e5, 12)
    rows("s.csv", "frequency [Hz],permittivity,conductivity [S/m]", grid, 1e3 + 0 * grid, 1e-6 + 0 * grid)
    said("fit-material s.csv --into vezzoli_2014/fig6 -o with.toml")
    fitted = ev.load("with.toml").stack.layers["stratum_corneum"].material
    assert (fitted.permittivity, fitted.conductivity) == pytest.approx((1000, 1e-6), rel=1e-3)
    assert "no such layer" in refused("fit-material s.csv --into vezzoli_2014/fig6 --layer skn")


@pytest.mark.parametrize("factor", [1.001, np.exp(1e-3j)])
def test_the_systematic_error_is_that_of_a_fit_to_changed_data(factor, tmp_path):
    """Of the modulus and of the phase of the instrument."""
    exact, changed = (
        fitted(written(tmp_path / f"{at}.csv", noise=1e-6, factor=each), systematic=1e-3, **ONE)
        for at, each in enumerate((1.0, factor))
    )
    turned = InstrumentError(phase=1e-3)
    by_phase = turned.deviations(exact.fits[0], GRID, SKIN.complex_permittivity(GRID), noise=None)
    for one, other in zip(exact.parameters, changed.parameters, strict=True):
        difference = abs(other.value - one.value)
        if np.isreal(factor):
            assert one.systematic == pytest.approx(difference, rel=0.01, abs=3e-5 * one.value)
        else:
            assert by_phase[one.name] == pytest.approx(difference, rel=0.05)
    assert exact.parameters[1].systematic == pytest.approx(1.5, rel=0.01)


def test_sources_are_weighted_by_their_noise(tmp_path):
    good = written(tmp_path / "good.csv", noise=0.002, seed=2)
    bad = written(tmp_path / "bad.csv", noise=0.08, seed=3, grid=GRID * 1.01)
    alone, both = (
        fitted(files, scatter=noise, **ONE)
        for files, noise in (
            ([good], {"good.csv": 0.002}),
            ([good, bad], {"good.csv": 0.002, "bad.csv": 0.08}),
        )
    )
    (one, two) = (each.parameters[1] for each in (alone, both))
    width = one.upper - one.lower
    assert abs(two.value - one.value) < 0.05 * width
    assert two.upper - two.lower < width  # without a stated noise it is five times as wide
    assert "noise 8 % as stated" in " ".join(both.history)


def test_a_resistor_gives_the_error_of_the_instrument(file, tmp_path):
    known = resistor(tmp_path / "r.csv", value=50e3, phase=0.3)
    found = fitted(file, reference=(known, "51 kohm"), **ONE)
    assert f"modulus {100 * (1 - 50 / 51):.2g} %, phase 0.3 degrees" in " ".join(found.history)
    declared = fitted(file, reference=(known, "51 kohm"), systematic=0.05, **ONE)
    assert declared.parameters[1].systematic > 1.4 * found.parameters[1].systematic
    error = error_by_resistor(GRID, 50e3 * np.exp(0.005j) * np.ones(31), resistance=51e3)
    assert (error.gain, error.phase) == pytest.approx((1 / 51, 0.005), rel=1e-6)
    with pytest.raises(InputError, match="bad calibration"):
        fitted(file, reference=(resistor(tmp_path / "off.csv", phase=3.0), "51 kohm"), **ONE)


def test_the_capacitance_of_the_fixture_is_that_beside_the_reference(file, tmp_path):
    grid, rng = np.geomspace(1e4, 1e5, 31), np.random.default_rng(4)

    def measured(name, capacitance):
        noise = 1 + 1e-4 * (rng.normal(size=31) + 1j * rng.normal(size=31))
        return impedance(tmp_path / name, noise / (1 / 51e3 + 2j * np.pi * grid * capacitance), grid=grid)

    sample, bare = measured("sample.csv", 33e-12), measured("bare.csv", 2e-12)
    for known, stated, expected in (
        (bare, None, 31e-12),
        (bare, "0 F", 33e-12),
        (bare, "1 pF", 32e-12),
        (measured("none.csv", 0.0), None, 33e-12),
    ):
        own = {} if stated is None else {"parallel_capacitance": stated}
        found = fitted(sample, reference=(known, "51 kohm"), **PART, **own)
        assert found.material.permittivity == pytest.approx(expected * UNIT, rel=1e-3)
        told = "measured in parallel with the reference" in " ".join(found.history)
        assert told is (expected == 31e-12)
    permittivity = fitted(file, reference=(bare, "51 kohm"), **ONE)
    assert "reference resistor" not in " ".join(permittivity.history)  # it has no fixture


def test_the_phase_of_the_reference_is_read_as_that_of_the_sample(tmp_path):
    """A resistor's phase is small in degrees and in radians; that of the sample is not. Before, it was refused."""
    grid, files = np.geomspace(1e4, 1e5, 31), []
    for values in (1 / (1 / 51e3 + 2j * np.pi * grid * 33e-12), 51e3 + 0j * grid):
        turned = np.degrees(np.angle(values)) + 0.01 * (-1.0) ** np.arange(31)
        name = tmp_path / f"{len(files)}.csv"
        files.append(rows(name, "Frequency,Impedance,Phase", grid, abs(values), turned))
    sample, known = files
    found = fitted(sample, reference=(known, "51 kohm"), **PART)
    assert found.material.permittivity == pytest.approx(33e-12 * UNIT, rel=1e-3)
    with pytest.raises(InputError, match="degrees or radians"):  # of a resistor alone nothing tells it
        fitted(known, **PART)


def test_the_stated_error_covers_a_known_part(tmp_path):
    """Without the noise of the reference, the tolerance of its resistor, and the fixture, 8 of these 40 intervals missed.

    Each part is measured with an instrument, a resistor and a fixture that are all a little wrong.
    """
    rng, grid = np.random.default_rng(8), np.geomspace(1e4, 1e5, 21)
    turns, inside, wide = 2j * np.pi * grid, 0, []

    def measured(name, admittance, gain):
        noise = 1 + 3e-3 * (rng.normal(size=21) + 1j * rng.normal(size=21))
        return impedance(tmp_path / name, gain * noise / admittance, grid=grid)

    for _ in range(40):
        gain = 1 + 0.01 * rng.normal()
        leads, elsewhere = 0.5e-12 * (1 + 0.5 * rng.normal(size=2))
        own = 51e3 * (1 + 0.02 * rng.uniform(-1, 1))
        bare = measured("bare.csv", 1 / own + turns * leads, gain)
        sample = measured("sample.csv", 1 / 51e3 + turns * (33e-12 + elsewhere), gain)
        found = fitted(sample, reference=(bare, "51 kohm +- 2 %"), **PART)
        (row,) = [each for each in found.parameters if each.name == "permittivity"]
        total = np.hypot(row.systematic, (row.upper - row.lower) / 3.92)
        inside += abs(row.value - 33e-12 * UNIT) < 1.96 * total
        wide.append(total / row.value)
    assert inside >= 36  # 95 % of 40 are 38, with a standard deviation of 1.4
    assert np.median(wide) < 0.05


def test_the_tolerance_of_the_resistor_and_the_fixture_count(tmp_path):
    grid = np.geomspace(1e4, 1e5, 21)
    exact = 51e3 / (1 + 2j * np.pi * grid * 51e3 * 1e-12)
    own = error_by_resistor(grid, exact, resistance=51e3)
    assert (own.gain, own.fixture_uncertainty) == (pytest.approx(0, abs=1e-9), pytest.approx(1e-12, rel=1e-6))
    stated = error_by_resistor(grid, exact, resistance=51e3, tolerance=0.03)
    assert stated.gain == pytest.approx(0.03 / np.sqrt(3), rel=1e-6)  # a uniform distribution
    sample = impedance(tmp_path / "s.csv", 1 / (1 / 51e3 + 2j * np.pi * grid * 33e-12), grid=grid)
    bare = impedance(tmp_path / "r.csv", exact, grid=grid)
    for value, capacitance in (("51 kohm", None), ("51 kohm +- 510 ohm", None), ("51 kohm", "1 pF")):
        found = fitted(sample, reference=(bare, value), parallel_capacitance=capacitance, **PART)
        row = next(each for each in found.parameters if each.name == "permittivity")
        fixture = 0.0 if capacitance else 1e-12 * UNIT
        tolerance = row.value * 0.01 / np.sqrt(3) if "+-" in value else 0.0
        assert row.systematic == pytest.approx(np.hypot(fixture, tolerance), rel=0.02, abs=1e-3)
    assert "whose tolerance is not stated" in " ".join(found.history)
    with pytest.raises(InputError, match="tolerance = 2"):
        fitted(sample, reference=(bare, "51 kohm +- 200 %"), **PART)


@pytest.mark.slow
def test_a_deviation_is_a_warning_unless_it_is_that_of_the_stated_noise(tmp_path):
    file = written(tmp_path / "noisy.csv", noise=0.08)
    found, stated = (fitted(file, scatter=each, **ONE) for each in ({}, {"noisy.csv": 0.08}))
    states = {each.name: each.state for each in found.diagnostics}
    assert (states["Kramers-Kronig"], states["misfit"]) == ("warning", "warning")
    assert {each.name: each.state for each in stated.diagnostics}["Kramers-Kronig"] == "ok"


def test_the_table_of_the_guide_keeps_its_loss(here, said):
    """Permittivity and resistivity of an invented skin, imported as a table and as a dispersion."""
    _, start, after = GUIDE.read_text(encoding="utf-8").partition("frequency (Hz),permittivity")
    (here / "skin.csv").write_text(start + after.partition("```")[0], encoding="utf-8")
    frequency, permittivity, resistivity = np.loadtxt("skin.csv", delimiter=",", skiprows=1, unpack=True)
    assert frequency.size >= 5
    out = said("import skin.csv --as material -o table.toml")
    assert "resistivity: 'resistivity'" in out
    assert "assumed to be 0" not in out
    material = tomllib.loads((here / "table.toml").read_text())["stack"]["stratum_corneum"]["material"]
    loss = 1 / (2 * np.pi * frequency * eps0 * resistivity)
    np.testing.assert_allclose(material["loss_samples"], loss, rtol=1e-9)
    np.testing.assert_allclose(material["permittivity_samples"], permittivity, rtol=1e-9)
    said("fit-material skin.csv -o fitted.toml")
    fitted = tomllib.loads((here / "fitted.toml").read_text())["stack"]["stratum_corneum"]["material"]
    changed = ev.load("vezzoli_2014/fig6", changes={"stack.stratum_corneum.material": fitted})
    skin = changed.stack.layers["stratum_corneum"].material
    np.testing.assert_allclose(-skin.complex_permittivity(frequency).imag, loss, rtol=0.01)


@pytest.mark.slow
def test_a_form_that_misses_few_rows_is_omitted_in_spite_of_its_criterion(tmp_path):
    """One row a decade of an invented skin: AICc alone prefers a form of few parameters that misses them."""
    frequency = np.geomspace(1, 1e4, 5)
    permittivity, resistivity = [5800, 2600, 1560, 1240, 1100], np.array([5e5, 4.4e5, 3.8e5, 2.4e5, 8e4])
    header = "frequency (Hz),permittivity,resistivity (ohm m)"
    found = fitted(rows(tmp_path / "few.csv", header, frequency, permittivity, resistivity))
    assert "omitted in spite of a lower AICc" in " ".join(found.history)
    assert "left out" not in " ".join(found.history)
    loss = 1 / (2 * np.pi * frequency * eps0 * resistivity)
    np.testing.assert_allclose(-found.material.complex_permittivity(frequency).imag, loss, rtol=0.4)


def test_short_names_of_forms():
    assert forms_of("gabriel") == ("ColeCole, 4 terms",)
    assert forms_of("cole-cole")[:2] == ("ColeCole, 1 term", "ColeCole, 2 terms")
    assert forms_of("havriliak-negami") == ("HavriliakNegami",)
    assert len(forms_of("auto")) == 6
    with pytest.raises(InputError, match="Did you mean 'cole-cole'"):
        forms_of("colecole")


@pytest.mark.slow
@pytest.mark.skipif(not SHARED.exists(), reason="needs shared/data, which is not part of the repository")
def test_skin_and_known_parts_as_measured():
    skin = fitted(SHARED / "gabriel_measured_skin_dry.txt", band=(100.0, 1.0001e5))
    assert skin.fits[0].permittivity_error < 0.04
    assert skin.fits[0].conductivity_error < 0.03
    assert "left out as outliers: 251.2 Hz" in skin.history
    given, known = PART | {"columns": {"phase": "Phase [deg]"}}, (SHARED / "Cal10k_51k.csv", "51 kohm")
    part = fitted(SHARED / "Cal10k_51kp33.csv", reference=known, **given)
    capacitance = part.material.permittivity / UNIT
    assert capacitance == pytest.approx(33e-12, rel=0.11)  # 36.3 pF; 36.7 with the capacitance of the fixture
    assert "fixture of 402.6 fF in parallel subtracted" in " ".join(part.history)
    kept = fitted(SHARED / "Cal10k_51kp33.csv", reference=known, parallel_capacitance=0, **given)
    assert kept.material.permittivity / UNIT - capacitance == pytest.approx(0.403e-12, rel=0.02)
    given["columns"] = {"phase": "phase [deg]"}
    bad = SHARED / "rcal_10k_20k_par101.csv"
    alone = {name: value for name, value in given.items() if name != "form"}
    recipe = ev.SpectrumRecipe(**alone)
    for command in (ev.fit_material, ev.import_material):  # without a reference
        with pytest.raises(InputError, match=r"badly calibrated: .* constant phase of -3\.29 degrees"):
            command(bad, recipe)
    with pytest.raises(InputError, match="bad calibration"):
        fitted(bad, reference=(bad, "20 kohm"), **given)


def lossless(path, material=SKIN, *, noise=0.01, seed=1, zeros=False):
    """A table of permittivity alone, with relative noise; or with a loss factor of 0 in each row."""
    rng = np.random.default_rng(seed)
    real = material.complex_permittivity(WIDE).real * (1 + noise * rng.normal(size=WIDE.size))
    if zeros:
        return rows(path, "f [Hz],permittivity,loss factor", WIDE, real, 0 * real)
    return rows(path, "f [Hz],permittivity", WIDE, real)


def loss_of(found):
    (told,) = [each for each in found.diagnostics if each.name == "loss"]
    assert told.state == "unknown"
    return told.text


@pytest.mark.slow
@pytest.mark.parametrize("noise", [None, 0.01])
def test_a_dispersion_is_recovered_from_the_real_part_within_its_intervals(tmp_path, noise):
    inside, known = np.zeros(4), dict(list(TRUE.items())[:4])
    for seed in range(20):
        file = lossless(tmp_path / "eps.csv", seed=seed)
        found = fitted(file, loss="unknown", scatter={"eps.csv": noise} if noise else {}, **ONE)
        by = {each.name: each for each in found.parameters}
        inside += [by[path].lower <= value <= by[path].upper for path, value in known.items()]
        assert by["conductivity"].value == 0.0
        assert "not measured" in by["conductivity"].note
    assert (inside >= 16).all()  # binomial of 0.95 and 20: fewer in 3e-4 of all cases
    assert inside.sum() >= 70


def test_the_loss_that_follows_is_that_of_the_dispersion_without_conduction(tmp_path):
    """The true loss factor, computed from the twin, lies in the stated interval; conduction alone is missing from it."""
    found = fitted(lossless(tmp_path / "eps.csv"), loss="unknown")
    text = loss_of(found)
    assert "not measured" in text
    assert "lower bound" in text
    told = re.findall(r"([\d.e+-]+) \(([\d.e+-]+) to ([\d.e+-]+)\)", text)
    told = [[float(each) for each in row] for row in told]
    bound = -SKIN.conducting(0.0).complex_permittivity(np.array([10, math.sqrt(10 * 1e6), 1e6])).imag
    for (value, lower, upper), true in zip(told, bound, strict=True):
        assert lower <= value <= upper
        assert lower <= true <= upper
    assert told[1][2] < 1.1 * told[1][1]  # known in the middle of the band
    assert told[0][2] > 1.1 * told[0][1]  # and less well at its ends
    assert "without a measured loss" in " ".join(each.text for each in found.diagnostics)


@pytest.mark.parametrize("zeros", [False, True])
def test_a_material_without_loss_is_constant(tmp_path, zeros):
    file = lossless(tmp_path / "film.csv", Constant(permittivity=3.4), zeros=zeros)
    found = fitted(file, loss="none")
    (level, conductivity) = found.parameters
    assert found.form == "Constant"
    assert found.material.conductivity == 0.0
    assert level.lower < 3.4 < level.upper
    assert level.upper - level.lower == pytest.approx(2 * 1.96 * 3.4 * 0.01 / math.sqrt(41), rel=0.35)
    assert conductivity.note == "0 as stated with the loss"
    assert "stated to be 0" in loss_of(found)
    unknown = fitted(file, loss="unknown", form="constant").parameters[0]
    assert (unknown.value, unknown.lower) == pytest.approx((level.value, level.lower))
    # without any scatter
    flat = rows(tmp_path / "flat.csv", "f [Hz],permittivity", WIDE, np.full(WIDE.size, 3.0))
    for loss in ("none", "unknown"):
        exact = fitted(flat, loss=loss, form="constant")
        assert exact.parameters[0].value == pytest.approx(3, rel=1e-9)


@pytest.mark.parametrize("noise", [{}, {"eps.csv": 0.01}])
def test_the_error_of_the_modulus_reaches_the_permittivity(tmp_path, noise):
    """By a closed form: an error of the modulus of 2 % is one of 2 % of every permittivity."""
    file = lossless(tmp_path / "eps.csv")
    found = fitted(file, loss="unknown", systematic=0.02, scatter=noise, **ONE)
    by = {each.name: each for each in found.parameters}
    assert by["terms.0.strength"].systematic == pytest.approx(by["terms.0.strength"].value * 0.0202, rel=0.01)
    assert by["terms.0.broadening"].systematic == pytest.approx(0, abs=1e-6)


def test_what_no_material_can_be_or_what_is_not_said_is_refused(file, tmp_path, said):
    """A permittivity that rises, a band without rows, noise of one file, a loss that is missing or disregarded."""
    rising = rows(tmp_path / "odd.csv", "f [Hz],permittivity,loss factor", GRID, GRID, 0.1 * GRID)
    other = written(tmp_path / "bad.csv", seed=3, grid=GRID * 1.01)
    eps, zero = lossless(tmp_path / "eps.csv"), lossless(tmp_path / "zero.csv", zeros=True)
    for files, given, words in (
        (rising, {"form": "debye"}, "Kramers-Kronig relations by .* more than 10 %"),
        (file, {"form": "constant"}, "misses the spectrum by"),
        (file, {"band": ("1 MHz", "2 MHz")}, "0 rows are within it"),
        ([file, other], {"scatter": {"skin.csv": 0.01}}, r"state that of 'bad\.csv' too"),
        (eps, {}, "hold no loss.*--loss none, --loss unknown"),
        (zero, {}, "hold no loss.*--loss none, --loss unknown"),
        (eps, {"loss": "unknwon"}, "loss = 'unknwon': expected measured, none, unknown"),
        (eps, {"loss": "none"}, "Kramers-Kronig.*--loss unknown"),
        (eps, {"loss": "none", **ONE}, "without dispersion"),
        (file, {"loss": "none"}, "the data hold a loss"),
        (file, {"loss": "unknown"}, "the data hold a loss"),
    ):
        with pytest.raises(InputError, match=words):
            fitted(files, **given)
    wrong = {"form": "cole", "layer": "skin", "into": "vezzoli_2014/fig6", "output": "a.gif"}
    with pytest.raises(InputError) as caught:  # all mistakes at once
        fitted([file, tmp_path / "none.csv"], **wrong)
    for each in ("none.csv", "form = 'cole'", "layer = 'skin'", "a.gif"):
        assert each in " ".join(caught.value.problems)
    out = said(f"fit-material {eps} --loss unknown --form cole-cole-1")
    assert "to the permittivity alone" in out
    assert "nan" not in out
