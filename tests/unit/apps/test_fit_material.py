"""A dispersion fitted to files of spectra: material, both uncertainties, and the scenario with it."""

import tomllib
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import electrovib as ev
from electrovib.apps.cli import app
from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.physics.material import ColeCole
from electrovib.recordings.spectra.forms import forms_of
from electrovib.recordings.spectra.instrument import InstrumentError, error_by_resistor

SHARED = Path(__file__).parents[4] / "shared" / "data" / "skin_impedance"
GRID = np.geomspace(100, 1e5, 31)
SKIN = ColeCole(
    permittivity_high=50.0,
    terms=[{"strength": 1500.0, "relaxation_time": 2e-5, "broadening": 0.3}],
    conductivity=1e-4,
)
ONE = {"form": "cole-cole-1"}


def written(path, *, noise=0.01, seed=1, grid=GRID, factor=1.0):
    """A table of permittivity and loss factor with relative noise."""
    rng = np.random.default_rng(seed)
    exact = SKIN.complex_permittivity(grid) * factor
    real, loss = (part * (1 + noise * rng.normal(size=grid.size)) for part in (exact.real, -exact.imag))
    rows = [f"{f!r},{a!r},{b!r}" for f, a, b in zip(grid.tolist(), real.tolist(), loss.tolist(), strict=True)]
    path.write_text("\n".join(["f [Hz],permittivity,loss factor", *rows]))
    return path


def resistor(path, *, value=51e3, phase=0.0):
    """A table of the impedance of a resistor, with a phase in degrees."""
    rows = [f"{f!r},{value * (1 + 1e-4 * (-1) ** at)!r},{phase}" for at, f in enumerate(GRID.tolist())]
    path.write_text("\n".join(["f [Hz],|Z| [ohm],phase [deg]", *rows]))
    return path


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    return written(tmp_path_factory.mktemp("material") / "skin.csv")


def test_the_material_is_that_of_the_file_and_runs_in_a_scenario(file, tmp_path):
    out = tmp_path / "my_skin.toml"
    found = ev.fit_material(file, thickness="150 um", output=out, **ONE)
    for each, true in zip(found.parameters, (50.0, 1500.0, 2e-5, 0.3, 1e-4), strict=True):
        assert abs(each.value - true) < 4 * (each.upper - each.lower) / 3.92
        assert np.isnan(each.systematic)
    layer = tomllib.loads(out.read_text())["stack"]["stratum_corneum"]
    scenario = ev.load(
        "vezzoli_2014/fig6", changes={f"stack.stratum_corneum.{k}": v for k, v in layer.items()}
    )
    skin = scenario.stack.layers["stratum_corneum"]
    assert skin.thickness == 150e-6
    assert skin.material == found.material
    assert np.isfinite(ev.simulate(scenario).electrostatic_force).all()


def test_the_scenario_with_the_material_states_its_source(file, tmp_path):
    out = tmp_path / "with.toml"
    found = ev.fit_material(
        file, thickness="150 um", into="vezzoli_2014/fig6", systematic=0.02, output=out, **ONE
    )
    scenario = ev.load(out)
    assert scenario.stack.layers["stratum_corneum"].material == found.material
    assert scenario.stack.layers["stratum_corneum"].thickness == 150e-6
    source = scenario.sources["stack.stratum_corneum.material.terms.0.strength"]
    for words in (
        "skin.csv",
        "ColeCole, 1 term",
        "statistical 95 % interval",
        "systematic error of the instrument +- ",
    ):
        assert words in source
    ev.fit_material(file, into="vezzoli_2014/fig6", output=out, **ONE)  # our own file is replaced
    out.write_text(out.read_text().replace("150 um", "151 um") + "\n# mine")
    with pytest.raises(InputError, match="exists already"):
        ev.fit_material(file, into="vezzoli_2014/fig6", output=out, **ONE)


def test_the_systematic_error_is_that_of_a_fit_to_shifted_data(tmp_path):
    exact, shifted = (
        ev.fit_material(
            written(tmp_path / f"{factor}.csv", noise=1e-6, factor=factor), systematic=1e-3, **ONE
        )
        for factor in (1.0, 1.001)
    )
    for one, other in zip(exact.parameters, shifted.parameters, strict=True):
        assert one.systematic == pytest.approx(abs(other.value - one.value), rel=0.01, abs=3e-5 * one.value)
    assert exact.parameters[1].systematic == pytest.approx(1.5, rel=0.01)


def test_a_phase_error_is_that_of_a_fit_to_turned_data(tmp_path):
    angle = 1e-3
    plain, turned = (
        ev.fit_material(written(tmp_path / f"{at}.csv", noise=1e-6, factor=factor), **ONE)
        for at, factor in enumerate((1.0, np.exp(1j * angle)))
    )
    data = SKIN.complex_permittivity(GRID)
    found = InstrumentError(phase=angle).deviations(plain.fits[0], GRID, data, noise=None)
    for one, other in zip(plain.parameters, turned.parameters, strict=True):
        assert found[one.name] == pytest.approx(abs(other.value - one.value), rel=0.05)


def test_sources_are_weighted_by_their_noise(tmp_path):
    good = written(tmp_path / "good.csv", noise=0.002, seed=2)
    bad = written(tmp_path / "bad.csv", noise=0.08, seed=3, grid=GRID * 1.01)
    noise = {"good.csv": 0.002, "bad.csv": 0.08}
    alone = ev.fit_material(good, noise={"good.csv": 0.002}, **ONE)
    both = ev.fit_material([good, bad], noise=noise, **ONE)
    alike = ev.fit_material([good, bad], **ONE)
    strength = [each.parameters[1] for each in (alone, both, alike)]
    width = strength[0].upper - strength[0].lower
    assert abs(strength[1].value - strength[0].value) < 0.05 * width
    assert strength[2].upper - strength[2].lower > 5 * width
    assert strength[1].upper - strength[1].lower < width
    assert "noise 8 % as stated" in " ".join(both.history)
    with pytest.raises(InputError, match=r"state that of 'bad\.csv' too"):
        ev.fit_material([good, bad], noise={"good.csv": 0.01}, **ONE)


def test_a_resistor_gives_the_error_of_the_instrument(file, tmp_path):
    known = resistor(tmp_path / "r.csv", value=50e3, phase=0.3)
    found = ev.fit_material(file, reference=(known, "51 kohm"), **ONE)
    assert f"modulus {100 * (1 - 50 / 51):.2g} %, phase 0.3 degrees" in " ".join(found.history)
    declared = ev.fit_material(file, reference=(known, "51 kohm"), systematic=0.05, **ONE)
    assert declared.parameters[1].systematic > 1.4 * found.parameters[1].systematic
    error = error_by_resistor(GRID, 50e3 * np.exp(0.005j) * np.ones(31), resistance=51e3)
    assert (error.gain, error.phase) == pytest.approx((1 / 51, 0.005), rel=1e-6)
    with pytest.raises(InputError, match="bad calibration"):
        ev.fit_material(file, reference=(resistor(tmp_path / "off.csv", phase=3.0), "51 kohm"), **ONE)


def impedance(path, values, *, grid=GRID):
    rows = [f"{f!r},{z.real!r},{z.imag!r}" for f, z in zip(grid.tolist(), values.tolist(), strict=True)]
    path.write_text("\n".join(["f [Hz],Z' [ohm],Z'' [ohm]", *rows]))
    return path


def test_the_capacitance_of_the_fixture_is_that_beside_the_reference(tmp_path):
    grid, rng = np.geomspace(1e4, 1e5, 31), np.random.default_rng(4)
    turns = 2j * np.pi * grid

    def measured(name, capacitance):
        noise = 1 + 1e-4 * (rng.normal(size=31) + 1j * rng.normal(size=31))
        return impedance(tmp_path / name, noise / (1 / 51e3 + turns * capacitance), grid=grid)

    sample, bare = measured("sample.csv", 33e-12), measured("bare.csv", 2e-12)
    given = {"area": "1 cm2", "thickness": "1 mm", "form": "constant"}
    unit = 1e-3 / (eps0 * 1e-4)
    for options, expected, stated in (
        ({"reference": (bare, "51 kohm")}, 31e-12, True),
        ({"reference": (bare, "51 kohm"), "parallel_capacitance": "0 F"}, 33e-12, False),
        ({"reference": (bare, "51 kohm"), "parallel_capacitance": "1 pF"}, 32e-12, False),
        ({"reference": (measured("none.csv", 0.0), "51 kohm")}, 33e-12, False),
    ):
        found = ev.fit_material(sample, **given, **options)
        assert found.material.permittivity == pytest.approx(expected * unit, rel=1e-3)
        assert ("measured in parallel with the reference" in " ".join(found.history)) is stated
    table = ev.fit_material(written(tmp_path / "skin.csv"), reference=(bare, "51 kohm"), **ONE)
    assert "reference resistor" not in " ".join(table.history)  # a permittivity has no fixture


def test_what_no_material_can_be_is_refused(tmp_path):
    data = np.full(31, 100.0) * GRID / 100  # a permittivity that rises with frequency
    rows = [f"{f},{a},{0.1 * a}" for f, a in zip(GRID, data, strict=True)]
    (tmp_path / "odd.csv").write_text("\n".join(["f [Hz],permittivity,loss factor", *rows]))
    with pytest.raises(InputError, match=r"Kramers-Kronig relations by .* more than 10 %"):
        ev.fit_material(tmp_path / "odd.csv", form="debye")
    with pytest.raises(InputError, match="misses the spectrum by"):
        ev.fit_material(written(tmp_path / "skin.csv"), form="constant")


def test_a_deviation_below_that_is_a_warning(tmp_path):
    found = ev.fit_material(written(tmp_path / "noisy.csv", noise=0.08), **ONE)
    states = {each.name: each.state for each in found.diagnostics}
    assert states["Kramers-Kronig"] == "warning"
    assert states["misfit"] == "warning"
    noise = {"noisy.csv": 0.08}
    stated = ev.fit_material(tmp_path / "noisy.csv", noise=noise, **ONE)
    assert {each.name: each.state for each in stated.diagnostics}["Kramers-Kronig"] == "ok"


def test_the_table_of_the_guide_keeps_its_loss(tmp_path, monkeypatch):
    """Permittivity and resistivity of an invented skin, imported as a table and as a dispersion."""
    text = (Path(__file__).parents[3] / "docs" / "how_to" / "my_recording.md").read_text(encoding="utf-8")
    (tmp_path / "skin.csv").write_text(text.partition("```csv\nfrequency (Hz),permittivity")[2].partition("```")[0].join(
        ["frequency (Hz),permittivity", ""]), encoding="utf-8")  # fmt: skip
    monkeypatch.chdir(tmp_path)
    rows = np.loadtxt("skin.csv", delimiter=",", skiprows=1)
    assert len(rows) >= 5
    said = CliRunner().invoke(app, ["import", "skin.csv", "--as", "material", "-o", "table.toml"])
    assert said.exit_code == 0, said.output
    assert "resistivity: 'resistivity'" in said.output
    assert "assumed to be 0" not in said.output
    material = tomllib.loads((tmp_path / "table.toml").read_text())["stack"]["stratum_corneum"]["material"]
    loss = 1 / (2 * np.pi * rows[:, 0] * eps0 * rows[:, 2])
    np.testing.assert_allclose(material["loss_samples"], loss, rtol=1e-9)
    np.testing.assert_allclose(material["permittivity_samples"], rows[:, 1], rtol=1e-9)
    said = CliRunner().invoke(app, ["fit", "skin.csv", "-o", "fitted.toml"])
    assert said.exit_code == 0, (said.output, said.exception)
    found = ev.load("vezzoli_2014/fig6", changes={"stack.stratum_corneum.material": tomllib.loads(
        (tmp_path / "fitted.toml").read_text())["stack"]["stratum_corneum"]["material"]})  # fmt: skip
    fitted = -found.stack.layers["stratum_corneum"].material.complex_permittivity(rows[:, 0]).imag
    np.testing.assert_allclose(fitted, loss, rtol=0.01)


def test_a_form_that_misses_few_rows_is_omitted_in_spite_of_its_criterion(tmp_path):
    """One row a decade of an invented skin: AICc alone prefers a form of few parameters that misses them."""
    rows = np.array(
        [[1, 5800, 5e5], [10, 2600, 4.4e5], [100, 1560, 3.8e5], [1000, 1240, 2.4e5], [1e4, 1100, 8e4]]
    )
    np.savetxt(tmp_path / "few.csv", rows, delimiter=",", comments="",
               header="frequency (Hz),permittivity,resistivity (ohm m)")  # fmt: skip
    found = ev.fit_material(tmp_path / "few.csv")
    assert "omitted in spite of a lower AICc" in " ".join(found.history)
    loss = 1 / (2 * np.pi * rows[:, 0] * eps0 * rows[:, 2])
    np.testing.assert_allclose(-found.material.complex_permittivity(rows[:, 0]).imag, loss, rtol=0.4)


def test_short_names_of_forms():
    assert forms_of("gabriel") == ("ColeCole, 4 terms",)
    assert forms_of("cole-cole")[:2] == ("ColeCole, 1 term", "ColeCole, 2 terms")
    assert forms_of("havriliak-negami") == ("HavriliakNegami",)
    assert len(forms_of("auto")) == 6
    with pytest.raises(InputError, match="Did you mean 'cole-cole'"):
        forms_of("colecole")


def test_mistakes_are_reported_together(file, tmp_path):
    with pytest.raises(InputError) as caught:
        ev.fit_material(
            [file, tmp_path / "none.csv"], form="cole", layer="skin", into="vezzoli_2014/fig6", output="a.txt"
        )
    words = " ".join(caught.value.problems)
    for each in ("none.csv", "form = 'cole'", "layer = 'skin'", "a.txt"):
        assert each in words
    part = ev.fit_material(file, band=("1 kHz", 1e4), **ONE)
    assert part.history[0].endswith("11 rows")  # both ends included
    with pytest.raises(InputError, match="0 rows are within it"):
        ev.fit_material(file, band=("1 MHz", "2 MHz"), **ONE)


def test_the_command_writes_the_material(file, tmp_path):
    out = tmp_path / "my_skin.toml"
    arguments = ["fit", str(file), "--form", "cole-cole-1", "--band", "100 Hz..50 kHz"]
    result = CliRunner().invoke(
        app, [*arguments, "--noise", "skin.csv=1 %", "--gain-error", "impedance=2%", "-o", str(out)]
    )
    assert result.exit_code == 0, result.output
    for words in ("terms.0.strength: ", "systematic error of the instrument +- ", "written"):
        assert words in result.output
    assert "statistical 95 % interval" in out.read_text()
    assert 'model = "ColeCole"' in out.read_text()
    for option, words in {
        "--gain-error": "expected impedance=SHARE",
        "--band": "LOW..HIGH",
        "--noise": "FILE=SHARE",
    }.items():
        refused = CliRunner().invoke(app, [*arguments, option, "x"])
        assert words in " ".join(refused.exception.problems)


@pytest.mark.slow
@pytest.mark.skipif(not SHARED.exists(), reason="needs shared/data, which is not part of the repository")
def test_skin_and_known_parts_as_measured():
    skin = ev.fit_material(SHARED / "gabriel_measured_skin_dry.txt", band=(100.0, 1.0001e5))
    assert skin.fits[0].permittivity_error < 0.04
    assert skin.fits[0].conductivity_error < 0.03
    assert "left out as outliers: 251.2 Hz" in skin.history
    given = {"columns": {"phase": "Phase [deg]"}, "area": "1 cm2", "thickness": "1 mm", "form": "constant"}
    known = (SHARED / "Cal10k_51k.csv", "51 kohm")
    part = ev.fit_material(SHARED / "Cal10k_51kp33.csv", reference=known, **given)
    capacitance = part.material.permittivity * eps0 * 1e-4 / 1e-3
    assert capacitance == pytest.approx(33e-12, rel=0.11)  # 36.3 pF; 36.7 with the capacitance of the fixture
    assert "fixture of 402.6 fF in parallel subtracted" in " ".join(part.history)
    kept = ev.fit_material(SHARED / "Cal10k_51kp33.csv", reference=known, parallel_capacitance=0, **given)
    assert kept.material.permittivity * eps0 * 0.1 - capacitance == pytest.approx(0.403e-12, rel=0.02)
    given["columns"] = {"phase": "phase [deg]"}
    bad = SHARED / "rcal_10k_20k_par101.csv"
    alone = {name: value for name, value in given.items() if name != "form"}
    for command in (ev.fit_material, ev.import_material):  # without a reference
        with pytest.raises(InputError, match=r"badly calibrated: .* constant phase of -3\.29 degrees"):
            command(bad, **alone)
    with pytest.raises(InputError, match="bad calibration"):
        ev.fit_material(bad, reference=(bad, "20 kohm"), **given)


def test_the_phase_of_the_reference_is_read_as_that_of_the_sample(tmp_path):
    """A resistor's phase is small in degrees and in radians; that of the sample is not. Before, it was refused."""
    grid = np.geomspace(1e4, 1e5, 31)
    for name, values in (
        ("sample.csv", 1 / (1 / 51e3 + 2j * np.pi * grid * 33e-12)),
        ("r.csv", 51e3 + 0j * grid),
    ):
        turned = np.degrees(np.angle(values)) + 0.01 * (-1.0) ** np.arange(31)
        rows = [
            f"{row[0]!r},{row[1]!r},{row[2]!r}"
            for row in np.column_stack([grid, abs(values), turned]).tolist()
        ]
        (tmp_path / name).write_text("\n".join(["Frequency,Impedance,Phase", *rows]))
    given = {"area": "1 cm2", "thickness": "1 mm", "form": "constant"}
    found = ev.fit_material(tmp_path / "sample.csv", reference=(tmp_path / "r.csv", "51 kohm"), **given)
    assert found.material.permittivity * eps0 * 0.1 == pytest.approx(33e-12, rel=1e-3)
    with pytest.raises(InputError, match="degrees or radians"):  # of a resistor alone nothing tells it
        ev.fit_material(tmp_path / "r.csv", **given)


def twin(rng, folder, *, tolerance):
    """A known part measured with an instrument, a resistor and a fixture that are all a little wrong."""
    grid = np.geomspace(1e4, 1e5, 21)
    turns = 2j * np.pi * grid
    gain = 1 + 0.01 * rng.normal()
    leads, elsewhere = 0.5e-12 * (1 + 0.5 * rng.normal(size=2))

    def measured(name, admittance):
        noise = 1 + 3e-3 * (rng.normal(size=21) + 1j * rng.normal(size=21))
        return impedance(folder / name, gain * noise / admittance, grid=grid)

    own = 51e3 * (1 + tolerance * rng.uniform(-1, 1))
    bare = measured("bare.csv", 1 / own + turns * leads)
    sample = measured("sample.csv", 1 / 51e3 + turns * (33e-12 + elsewhere))
    return sample, (bare, f"51 kohm +- {100 * tolerance} %")


def test_the_stated_error_covers_a_known_part(tmp_path):
    """Without the noise of the reference, the tolerance of its resistor, and the fixture, 8 of these 40 intervals missed."""
    rng, unit = np.random.default_rng(8), 1e-3 / (eps0 * 1e-4)
    inside, wide = 0, []
    for _ in range(40):
        sample, known = twin(rng, tmp_path, tolerance=0.02)
        found = ev.fit_material(sample, reference=known, area="1 cm2", thickness="1 mm", form="constant")
        (row,) = [each for each in found.parameters if each.name == "permittivity"]
        total = np.hypot(row.systematic, (row.upper - row.lower) / 3.92)
        inside += abs(row.value - 33e-12 * unit) < 1.96 * total
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
    given = {"area": "1 cm2", "thickness": "1 mm", "form": "constant"}
    unit = 1e-3 / (eps0 * 1e-4)
    for value, capacitance in (("51 kohm", None), ("51 kohm +- 510 ohm", None), ("51 kohm", "1 pF")):
        found = ev.fit_material(sample, reference=(bare, value), parallel_capacitance=capacitance, **given)
        row = next(each for each in found.parameters if each.name == "permittivity")
        parts = (
            0.0 if capacitance else 1e-12 * unit,
            row.value * 0.01 / np.sqrt(3) if "+-" in value else 0.0,
        )
        assert row.systematic == pytest.approx(np.hypot(*parts), rel=0.02, abs=1e-3)
    assert "whose tolerance is not stated" in " ".join(found.history)
    with pytest.raises(InputError, match="tolerance = 2"):
        ev.fit_material(sample, reference=(bare, "51 kohm +- 200 %"), **given)
