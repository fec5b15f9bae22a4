"""A measured dielectric: its rows, interpolation and extrapolation, refusals, and reduction."""

from __future__ import annotations

import json
from contextlib import chdir
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from electrovib.core.constants import VACUUM_PERMITTIVITY
from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.physics.material import ColeCole, ConstantPhase, Material
from electrovib.physics.tabulated import LossColumn, Tabulated
from electrovib.scenario import load, read_part
from electrovib.solve.stack.expand import reduce_material

GABRIEL = Path(__file__).parents[4] / "shared" / "data" / "skin_impedance" / "gabriel_measured_skin_dry.txt"

BROAD = ColeCole(
    permittivity_high=50,
    terms=({"strength": 2000, "relaxation_time": 1e-2, "broadening": 0.3},),
    conductivity=2e-6,
)
SKIN = ConstantPhase(permittivity=1000, reference_frequency=100, exponent=0.7545, conductivity=4e-6)
ROWS = {
    "frequency_samples": [10.0, 100.0, 1e3, 1e4, 1e5],
    "permittivity_samples": [1000.0, 800.0, 500.0, 300.0, 200.0],
    "loss_samples": [2000.0, 300.0, 100.0, 50.0, 20.0],
}


def tabulated(**changes):
    return read_part(Material, {"model": "Tabulated", "conductivity": 1e-7} | ROWS | changes)


def measured(material, frequency, *, noise=0.0, seed=0, **changes):
    """Tabulate a material, with independent relative noise of both parts."""
    values = material.complex_permittivity(frequency)
    first, second = 1 + noise * np.random.default_rng(seed).standard_normal((2, len(frequency)))
    content = {
        "frequency_samples": frequency,
        "permittivity_samples": values.real * first,
        "loss_samples": -values.imag * second,
        "conductivity": material.conductivity,
    }
    return tabulated(**content | changes)


def conduction_loss(conductivity, frequency):
    return conductivity / (2 * np.pi * np.asarray(frequency) * VACUUM_PERMITTIVITY)


def refusal(**changes):
    with pytest.raises(InputError) as caught:
        tabulated(**changes)
    assert len(caught.value.problems) == 1
    return caught.value.problems[0]


# ------------------------------------------------------------------------------ rows, between and beyond


def test_rows_are_met_with_and_without_conduction():
    material = tabulated()
    frequency = ROWS["frequency_samples"]
    whole = np.array(ROWS["permittivity_samples"]) - 1j * np.array(ROWS["loss_samples"])
    # exp(log(x)) costs a few units in the last place.
    assert material.complex_permittivity(frequency) == pytest.approx(whole, rel=1e-13)
    bound = whole + 1j * conduction_loss(1e-7, frequency)
    assert material.bound_permittivity(frequency) == pytest.approx(bound, rel=1e-13)
    assert material.bound_permittivity(frequency) != pytest.approx(whole, rel=1e-4)
    assert np.array_equal(material.table()[0], frequency)
    assert material.table()[1] == pytest.approx(bound, rel=1e-15)
    assert material.band == (10.0, 1e5)
    assert material.debye() is None


def test_any_shape_and_nan_pass():
    material = tabulated()
    assert material.bound_permittivity(37.0).shape == ()
    grid = np.array([[1.0, 37.0], [np.nan, 1e8]])
    values = material.bound_permittivity(grid)
    assert values.shape == (2, 2)
    assert np.isnan(values[1, 0])
    assert values[0, 1] == material.bound_permittivity(37.0)


def test_interpolation_is_of_second_order():
    fine = np.geomspace(10, 1e5, 1601)[:-1] * 1.001

    def worst(rows):
        material = measured(BROAD, np.geomspace(10, 1e5, rows))
        return np.max(np.abs(material.bound_permittivity(fine) / BROAD.bound_permittivity(fine) - 1))

    errors = [worst(21), worst(41), worst(81)]
    # Halving the spacing quarters the error of straight lines; 0.20 % was measured at ten rows a decade.
    assert 3.5 < errors[0] / errors[1] < 4.5
    assert 3.5 < errors[1] / errors[2] < 4.5
    assert 1e-3 < errors[1] < 3e-3


def test_goes_on_as_one_relaxation_beyond_the_band():
    material = tabulated()
    edges = np.array([10.0, 1e5])
    inside, outside = (
        material.bound_permittivity(edges),
        material.bound_permittivity(edges * [1 - 1e-9, 1 + 1e-9]),
    )
    assert outside == pytest.approx(inside, rel=1e-8)
    # One term of time 1/(2 pi f_min) has half its strength and its largest loss at f_min.
    first = inside[0]
    below = first.real + first.imag - 2 * first.imag / (1 + 1j * 0.1)
    assert material.bound_permittivity(1.0) == pytest.approx(below, rel=1e-12)
    assert material.complex_permittivity(1e-3).imag == pytest.approx(-conduction_loss(1e-7, 1e-3), rel=1e-4)


@st.composite
def tables(draw):
    count = draw(st.integers(4, 12))
    steps = draw(st.lists(st.floats(0.01, 1.5), min_size=count, max_size=count))
    frequency = draw(st.floats(0.1, 1e4)) * np.exp(np.cumsum(steps))
    size = st.floats(1e-3, 1e9)
    permittivity, loss = (draw(st.lists(size, min_size=count, max_size=count)) for _ in range(2))
    table = tabulated(
        frequency_samples=frequency, permittivity_samples=permittivity, loss_samples=loss, conductivity=0
    )
    most = min(table.conduction_bounds()[1], 1e3)
    return table.replace({"conductivity": most * draw(st.floats(0, 1))})


@given(material=tables())
@settings(max_examples=60, deadline=None)
def test_any_table_is_passive_from_a_tenth_of_a_hertz_to_a_gigahertz(material):
    frequency = np.concatenate([np.geomspace(0.1, 1e9, 401), material.table()[0]])
    values = material.bound_permittivity(frequency)
    assert np.all(values.imag <= 0)
    assert np.all(values.real > 0)
    assert np.all(np.isfinite(values))
    assert np.all(material.complex_permittivity(frequency).imag <= 0)


def test_example_is_a_causal_material():
    material = read_part(Material, {"model": "Tabulated", **Tabulated.example})
    # The law behind it has 0.0035; rounding to three digits adds the rest.
    assert material.kramers_kronig < 0.006
    assert reduce_material(material).largest_error < 0.02


# ------------------------------------------------------------------------------ columns and files


def columns():
    frequency = np.array(ROWS["frequency_samples"])
    permittivity, factor = np.array(ROWS["permittivity_samples"]), np.array(ROWS["loss_samples"])
    sigma = 2 * np.pi * frequency * VACUUM_PERMITTIVITY * factor
    return {
        "LossFactor": factor,
        "LossTangent": factor / permittivity,
        "Conductivity": sigma,
        "Resistivity": 1 / sigma,
    }


@pytest.mark.parametrize("name", columns())
def test_four_ways_to_write_the_loss(name):
    other = tabulated(loss={"model": name}, loss_samples=columns()[name])
    assert other.table()[1] == pytest.approx(tabulated().table()[1], rel=1e-14)
    assert other.conduction_bounds() == pytest.approx(tabulated().conduction_bounds(), rel=1e-14, abs=0)


def write(path, headings, *arrays):
    rows = zip(*(np.asarray(array).tolist() for array in arrays), strict=True)
    path.write_text("\n".join([headings, *(",".join(map(repr, row)) for row in rows)]), encoding="utf-8")


def test_reads_eps_and_rho_of_a_file_with_units(tmp_path):
    frequency, permittivity = ROWS["frequency_samples"], ROWS["permittivity_samples"]
    kilo = columns()["Resistivity"] / 1e3
    write(tmp_path / "skin.csv", "f [kHz],eps,rho", np.array(frequency) / 1e3, permittivity, kilo)
    content = {
        "model": "Tabulated",
        "file": "skin.csv",
        "frequency_column": "f",
        "permittivity_column": "eps",
        "loss": {"model": "Resistivity", "column": "rho", "unit": "kohm m"},
        "conductivity": "0.1 uS/m",
    }
    with chdir(tmp_path):
        material = read_part(Material, content)
    assert material.table()[1] == pytest.approx(tabulated().table()[1], rel=1e-14)

    again = read_part(Material, json.loads(json.dumps(material.to_dict(), default=lambda s: s.packed())))
    assert again == material
    assert again.table()[1].tobytes() == material.table()[1].tobytes()


def test_hash_covers_the_numbers_of_the_file(tmp_path):
    content = {"model": "Tabulated", "file": str(tmp_path / "a.csv"), "conductivity": 0}
    digests = []
    for factor in (1.0, 1.0, 1 + 1e-15):
        loss = np.array(ROWS["loss_samples"]) * factor
        write(
            tmp_path / "a.csv",
            "frequency,permittivity,loss",
            ROWS["frequency_samples"],
            ROWS["permittivity_samples"],
            loss,
        )
        digests.append(read_part(Material, content).digest())
    assert digests[0] == digests[1] != digests[2]


def test_another_file_replaces_the_numbers(tmp_path):
    headings = "frequency,permittivity,loss"
    frequency, permittivity, loss = ROWS.values()
    write(tmp_path / "a.csv", headings, frequency, permittivity, loss)
    write(tmp_path / "b.csv", headings, frequency, np.array(permittivity) * 2, loss)
    where = "stack.stratum_corneum.material"
    content = {"model": "Tabulated", "file": str(tmp_path / "a.csv"), "conductivity": 1e-7}
    first = load("vezzoli_2014/fig6", changes={where: content})
    table = first.stack.layers["stratum_corneum"].material.table()[1]
    second = first.replace({f"{where}.file": str(tmp_path / "b.csv")})
    assert second.stack.layers["stratum_corneum"].material.table()[1].real == pytest.approx(
        2 * table.real, rel=1e-15
    )
    kept = first.replace({f"{where}.conductivity": 0})
    assert np.array_equal(kept.stack.layers["stratum_corneum"].material.table()[1].real, table.real)


def test_a_material_alone_reads_no_file(tmp_path):
    write(tmp_path / "a.csv", "frequency,permittivity,loss", *ROWS.values())
    content = {"model": "Tabulated", "file": str(tmp_path / "a.csv"), "conductivity": 1e-7}
    with pytest.raises(
        InputError, match=r"holds no rows: its file is read with a scenario.*electrovib\.scenario\.read_part"
    ):
        read_model(Material, content)
    assert read_part(Material, content).band == (ROWS["frequency_samples"][0], ROWS["frequency_samples"][-1])


# ------------------------------------------------------------------------------ what is refused

FOUR = [1.0, 2.0, 3.0, 4.0]
FAULTS = {
    "empty": ({name: [] for name in ROWS}, ["holds no rows", 'file = "skin.csv"']),
    "three rows": ({name: values[:3] for name, values in ROWS.items()}, ["at least 4 rows, not 3"]),
    "unequal": ({"loss_samples": FOUR}, ["differ in length", "frequency 5", "loss factor 4"]),
    "decreasing": (
        {"frequency_samples": [10.0, 100.0, 50.0, 1e4, 1e5]},
        ["must rise", "row 2 (first is 0), 50 Hz, comes after 100 Hz", "sort the table"],
    ),
    "repeated": (
        {"frequency_samples": [10.0, 100.0, 100.0, 1e4, 1e5]},
        ["must rise", "row 2 (first is 0), 100 Hz, repeats 100 Hz"],
    ),
    "zero frequency": ({"frequency_samples": [0.0, *FOUR]}, ["row 0", "frequency must be above 0 Hz"]),
    "negative frequency": ({"frequency_samples": [-5.0, *FOUR]}, ["row 0", "-5 Hz", "above 0 Hz"]),
    "nan": (
        {"permittivity_samples": [np.nan, *FOUR]},
        ["row 0 (first is 0)", "permittivity = nan", "not a finite number"],
    ),
    "infinite frequency": ({"frequency_samples": [*FOUR, np.inf]}, ["row 4", "frequency = inf"]),
    "active": (
        {"loss_samples": [2000.0, 300.0, -1e-3, 50.0, 20.0]},
        ["row 2 (first is 0), 1000 Hz", "loss factor = -0.001 must be 0 or more", "Im eps* > 0", "active"],
    ),
    "no permittivity": (
        {"permittivity_samples": [1000.0, 0.0, 500.0, 300.0, 200.0]},
        ["row 1 (first is 0), 100 Hz", "permittivity = 0 must be above 0"],
    ),
    "negative resistivity": (
        {"loss": {"model": "Resistivity"}, "loss_samples": [1e5, 1e4, -1e3, 1e2, 1.0]},
        ["row 2 (first is 0), 1000 Hz", "resistivity = -1000 must be above 0", "active"],
    ),
    "no resistivity": (
        {"loss": {"model": "Resistivity"}, "loss_samples": [1e5, 1e4, 1e3, 1e2, 0.0]},
        ["row 4", "resistivity = 0 must be above 0"],
    ),
    "overdrawn": (
        {"conductivity": "1 mS/m"},
        [
            "conductivity = 1 mS/m alone",
            "row 0 (first is 0), 10 Hz",
            "whole loss of the table there is 2000",
            "0 to 1.113 uS/m",
        ],
    ),
    "absurd": (
        {"loss": {"model": "Conductivity"}, "frequency_samples": [1e-320, *FOUR]},
        ["row 0", "too large"],
    ),
    "unit": (
        {"loss": {"model": "Resistivity", "unit": "S/m"}},
        ["loss.unit = 'S/m'", "a resistivity", "'ohm m'"],
    ),
    "time for frequency": ({"frequency_unit": "ms"}, ["frequency_unit = 'ms'", "a frequency"]),
    "no such loss": (
        {"loss": {"model": "Resistvity"}},
        ["unknown LossColumn model 'Resistvity'", "Did you mean 'Resistivity'"],
    ),
    "text": ({"loss_samples": ["a", *FOUR]}, ["loss_samples", "not numbers"]),
}


@pytest.mark.parametrize("name", FAULTS)
def test_one_clear_sentence(name):
    changes, words = FAULTS[name]
    said = refusal(**changes)
    assert "\n" not in said
    for word in words:
        assert word in said


def test_conductivity_has_to_be_declared():
    with pytest.raises(InputError, match="conductivity: missing: conductivity at zero frequency"):
        read_part(Material, {"model": "Tabulated"} | ROWS)


def test_faults_of_a_file_are_told_once(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # a long path would be shortened
    write(tmp_path / "up.csv", "frequency,permittivity,loss", [4.0, 3, 2, 1], FOUR, FOUR)
    cases = {
        "up.csv": {"words": "row 1 (first is 0), 3 Hz, comes after 4 Hz"},
        "none.csv": {"words": "there is no such file"},
    }
    for file, case in cases.items():
        with pytest.raises(InputError) as caught:
            read_part(Material, {"model": "Tabulated", "file": file, "conductivity": 0})
        assert len(caught.value.problems) == 1
        assert case["words"] in str(caught.value)
        assert f"{{model = 'Tabulated', file = '{file}', ...}}: " in str(caught.value)
    wrong = {"file": str(tmp_path / "up.csv"), "loss": {"model": "LossFactor", "colum": "loss"}}
    with pytest.raises(InputError) as caught:
        read_part(Material, {"model": "Tabulated", "conductivity": 0} | wrong)
    assert caught.value.problems == (
        "loss.colum: unknown parameter 'colum' of LossFactor. Did you mean 'column'?",
    )


def test_a_table_without_the_usual_loss_column_names_the_other_forms(tmp_path):
    write(tmp_path / "skin.csv", "frequency,permittivity,reactance", FOUR, FOUR, FOUR)
    content = {"model": "Tabulated", "file": str(tmp_path / "skin.csv"), "conductivity": 0}
    with pytest.raises(InputError, match="no column 'loss'") as caught:
        read_part(Material, content)
    assert 'loss = { model = "..." } with Conductivity, LossFactor, LossTangent, Resistivity' in str(
        caught.value
    )
    with pytest.raises(InputError, match="no column 'frequenzy'") as caught:
        read_part(Material, content | {"frequency_column": "frequenzy"})
    assert "loss" not in str(caught.value)


@pytest.mark.parametrize("loss", LossColumn.__subclasses__())
def test_every_loss_column_is_tried_above(loss):
    assert loss.__name__ in columns()


def test_noise_may_take_five_percent_of_the_conduction():
    most = tabulated().conduction_bounds()[1]
    material = tabulated(conductivity=1.04 * most)
    assert material.bound_permittivity(10.0).imag == 0
    assert "declare from 0 to" in refusal(conductivity=1.08 * most)
    # A film whose loss the bridge could not see: 1e-4 as loss tangent, below the 1e-3 allowed.
    film = {"permittivity_samples": [3.35] * 5, "loss_samples": [0.0] * 5}
    tiny = 2 * np.pi * 10 * VACUUM_PERMITTIVITY * 3.35e-4
    assert np.all(tabulated(**film, conductivity=tiny).table()[1] == 3.35)
    assert "whole loss of the table there is 0" in refusal(**film, conductivity=20 * tiny)


# ------------------------------------------------------------------------------ what it says of itself


@pytest.mark.parametrize("noise", [0.01, 0.03])
def test_kramers_kronig_residual_tells_noise_from_nonsense(noise):
    frequency = np.geomspace(10, 1e6, 51)
    # A residual is about the noise; 51 points determine that of 1 % to a tenth, so half is far off.
    assert measured(SKIN, frequency, noise=noise).kramers_kronig == pytest.approx(noise, rel=0.5)
    mixed = measured(SKIN, frequency)
    loss = mixed.loss_samples.values * (frequency / 1e3) ** 0.3
    assert mixed.replace({"loss_samples": loss, "conductivity": 0}).kramers_kronig > 0.1


def test_too_few_rows_give_no_residual():
    assert np.isnan(tabulated(**{name: values[:4] for name, values in ROWS.items()}).kramers_kronig)


def test_bounds_hold_the_true_conductivity():
    table = measured(SKIN, np.geomspace(10, 1e6, 51))
    least, most = table.conduction_bounds()
    assert least == 0
    # Without noise the smallest is the first: conduction plus the constant phase's own loss at 10 Hz.
    loss = -SKIN.complex_permittivity(10.0).imag
    assert most == pytest.approx(2 * np.pi * 10 * VACUUM_PERMITTIVITY * loss, rel=1e-12, abs=0)
    assert SKIN.conductivity < most < 2 * SKIN.conductivity
    assert table.replace({"conductivity": most}).conduction_bounds() == (least, most)


def test_bounds_span_the_share_of_charge_that_is_not_lost():
    frequency = np.array([10.0, 100.0])
    material = measured(SKIN, np.geomspace(10, 1e6, 51))

    def held(conductivity):
        thickness, film = 200e-6, VACUUM_PERMITTIVITY * 3.35 / 90e-6
        axis = 2j * np.pi * frequency
        admittance = axis * VACUUM_PERMITTIVITY * material.complex_permittivity(frequency) / thickness
        return np.abs(1 - conductivity / thickness / (admittance + axis * film))

    none, every = (held(conductivity) for conductivity in material.conduction_bounds())
    assert np.array_equal(none, [1, 1])
    true = held(SKIN.conductivity)
    assert np.all((every < true) & (true < none))
    # The permittivity at the rows is the measured one whatever is declared: only the split is open.
    for conductivity in material.conduction_bounds():
        other = material.replace({"conductivity": conductivity})
        assert other.complex_permittivity(frequency) == pytest.approx(
            material.complex_permittivity(frequency), rel=1e-12
        )


# ------------------------------------------------------------------------------ Debye terms


def test_reduction_follows_the_rows_and_states_its_error():
    material = measured(SKIN, np.geomspace(10, 1e6, 51))
    reduction = reduce_material(material)
    frequency, rows = material.table()
    error = np.abs(reduction.debye.permittivity(frequency) / rows - 1)
    assert reduction.largest_error == pytest.approx(error.max(), rel=1e-12)
    # No term below the band: the loss of slower ones is missing at its low end. 5.9 % was measured.
    assert material.slowest_relaxation == pytest.approx(1 / (2 * np.pi * 10), rel=1e-15)
    assert max(reduction.debye.relaxation_times) <= material.slowest_relaxation
    assert 0.03 < error[0] < 0.08
    # A decade further up little is missing; 0.6 % was measured.
    assert error[frequency > 100].max() < 0.01


def test_loss_that_is_left_out_of_the_declaration_is_stated_as_error():
    material = measured(SKIN, np.geomspace(10, 1e6, 51))
    errors = [reduce_material(material.replace({"conductivity": s})).largest_error for s in (4e-6, 2e-6, 0.0)]
    # All terms are faster than the lowest row, so slow loss that is not declared finds no place: 6, 53, 61 %.
    assert errors[0] < 0.08
    assert 0.3 < errors[1] < errors[2]


def test_rows_beyond_the_band_do_not_cost_terms():
    wide = measured(BROAD, np.geomspace(10, 1e10, 91))
    narrow = measured(BROAD, np.geomspace(10, 1e6, 51))
    assert reduce_material(wide).largest_error == pytest.approx(
        reduce_material(narrow).largest_error, rel=1e-6
    )
    fast = measured(BROAD, np.geomspace(1e7, 1e9, 21))
    assert reduce_material(fast).largest_error < 0.1


def test_noisy_table_is_reduced_to_its_noise():
    frequency = np.geomspace(10, 1e6, 51)
    noisy = measured(BROAD, frequency, noise=0.01, seed=3, conductivity=BROAD.conductivity * 0.98)
    reduction = reduce_material(noisy)
    fine = np.geomspace(30, 1e6, 301)
    error = np.abs(reduction.debye.permittivity(fine) / BROAD.bound_permittivity(fine) - 1)
    # 1 % of the whole loss is up to 2 % of the polarisation; the terms average a part of it: 1.1 % was measured.
    assert error.max() < 0.03
    # Against the rows themselves the noise is all there, three times 1 % at one of 51 rows.
    assert reduction.largest_error > 0.02


# ------------------------------------------------------------------------------ a real table


def gabriel(**changes):
    if not GABRIEL.exists():
        pytest.skip("needs shared/data/skin_impedance/gabriel_measured_skin_dry.txt beside the repository")
    content = {
        "model": "Tabulated",
        "file": str(GABRIEL),
        "frequency_column": "Frequency",
        "permittivity_column": "Permittivity",
        "loss": {"model": "LossFactor", "column": "Loss Factor"},
        "conductivity": "170 uS/m",
    }
    return read_part(Material, content | changes)


def test_measured_whole_skin():
    material = gabriel()
    assert len(material.table()[0]) == 156
    assert material.band == (100.0, 20e9)
    # 4.6 % was measured: more than the noise of its five digits, as its bump near 251 Hz and its step at
    # 35 kHz make it; far less than what two quantities that do not belong together give.
    assert material.kramers_kronig == pytest.approx(0.046, abs=0.01)
    # Between 355 Hz and 100 Hz the conductivity rises again, which no passive material does: its smallest is
    # the most that may be declared.
    assert material.conduction_bounds()[1] == pytest.approx(1.7666e-4, rel=1e-4, abs=0)
    with pytest.raises(InputError, match=r"declare from 0 to 176\.7 uS/m"):
        gabriel(conductivity="190 uS/m")


def test_measured_whole_skin_by_its_conductivity():
    other = gabriel(loss={"model": "Conductivity", "column": "Conductivity"})
    # Both columns are printed with five digits, and the conduction taken out magnifies that.
    assert other.table()[1] == pytest.approx(gabriel().table()[1], rel=0.02)
    assert other.complex_permittivity([100.0]) == pytest.approx([1325 - 32476j], rel=1e-3)


def test_error_of_the_measured_whole_skin():
    material = gabriel()
    reduction = reduce_material(material)
    frequency, rows = material.table()
    kept = frequency <= 1e6
    error = np.abs(reduction.debye.permittivity(frequency) - rows)[kept]
    # Of the polarisation, which at 100 Hz is a twentieth of the whole: 54 % was measured. Of the whole: 4.8 %.
    assert reduction.largest_error == pytest.approx(0.54, abs=0.1)
    whole = np.abs(material.complex_permittivity(frequency[kept]))
    assert 0.02 < np.max(error / whole) < 0.07
