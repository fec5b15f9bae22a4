"""A measured dielectric: its rows, interpolation and extrapolation, refusals, and reduction.

That tables are passive and consistent, shapes, NaN and the forms of a loss are held by tests/contract.
"""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from electrovib.core.constants import VACUUM_PERMITTIVITY
from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.physics.material import ColeCole, ConstantPhase, Material
from electrovib.scenario import read_part
from electrovib.solve.stack.expand import reduce_material

GABRIEL = Path(__file__).parents[5] / "shared" / "data" / "skin_impedance" / "gabriel_measured_skin_dry.txt"
BROAD = ColeCole(
    permittivity_high=50,
    terms=({"strength": 2000, "relaxation_time": 1e-2, "broadening": 0.3},),
    conductivity=2e-6,
)
SKIN = ConstantPhase(permittivity=1000, reference_frequency=100, exponent=0.7545, conductivity=4e-6)
BAND = np.geomspace(10, 1e6, 51)
ROWS = {
    "frequency_samples": [10.0, 100.0, 1e3, 1e4, 1e5],
    "permittivity_samples": [1000.0, 800.0, 500.0, 300.0, 200.0],
    "loss_samples": [2000.0, 300.0, 100.0, 50.0, 20.0],
}
FREQUENCY, PERMITTIVITY, LOSS = (np.array(row) for row in ROWS.values())
HEADINGS = "frequency,permittivity,loss"


def tabulated(**changes):
    return read_model(Material, {"model": "Tabulated", "conductivity": 1e-7} | ROWS | changes)


def measured(material, frequency, *, noise=0.0, seed=0, **changes):
    """Tabulate a material, with independent relative noise of both parts."""
    values = material.complex_permittivity(frequency)
    first, second = 1 + noise * np.random.default_rng(seed).standard_normal((2, len(frequency)))
    rows = zip(ROWS, (frequency, values.real * first, -values.imag * second), strict=True)
    return tabulated(**dict(rows) | {"conductivity": material.conductivity} | changes)


def conduction_loss(conductivity, frequency):
    return conductivity / (2 * np.pi * np.asarray(frequency) * VACUUM_PERMITTIVITY)


def write(path, headings, *arrays):
    rows = zip(*(np.asarray(array).tolist() for array in arrays), strict=True)
    path.write_text("\n".join([headings, *(",".join(map(repr, row)) for row in rows)]), encoding="utf-8")
    return {"model": "Tabulated", "file": str(path), "conductivity": 1e-7}


def test_rows_are_met_with_and_without_conduction():
    material = tabulated()
    whole = PERMITTIVITY - 1j * LOSS
    # exp(log(x)) costs a few units in the last place.
    assert material.complex_permittivity(FREQUENCY) == pytest.approx(whole, rel=1e-13)
    bound = whole + 1j * conduction_loss(1e-7, FREQUENCY)
    assert material.bound_permittivity(FREQUENCY) == pytest.approx(bound, rel=1e-13)
    assert np.array_equal(material.table()[0], FREQUENCY)
    assert material.table()[1] == pytest.approx(bound, rel=1e-15)
    assert (material.band, material.debye()) == ((10.0, 1e5), None)


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
    material, edges = tabulated(), np.array([10.0, 1e5])
    inside = material.bound_permittivity(edges)
    outside = material.bound_permittivity(edges * [1 - 1e-9, 1 + 1e-9])
    assert outside == pytest.approx(inside, rel=1e-8)
    # One term of time 1/(2 pi f_min) has half its strength and its largest loss at f_min.
    first = inside[0]
    below = first.real + first.imag - 2 * first.imag / (1 + 1j * 0.1)
    assert material.bound_permittivity(1.0) == pytest.approx(below, rel=1e-12)
    assert material.complex_permittivity(1e-3).imag == pytest.approx(-conduction_loss(1e-7, 1e-3), rel=1e-4)


@st.composite
def tables(draw):
    count = draw(st.integers(4, 12))
    steps, permittivity, loss = (
        draw(st.lists(st.floats(*ends), min_size=count, max_size=count))
        for ends in ((0.01, 1.5), (1e-3, 1e9), (1e-3, 1e9))
    )
    frequency = draw(st.floats(0.1, 1e4)) * np.exp(np.cumsum(steps))
    rows = dict(zip(ROWS, (frequency, permittivity, loss), strict=True))
    table = tabulated(**rows, conductivity=0)
    most = min(table.conduction_bounds()[1], 1e3)
    return table.replace({"conductivity": most * draw(st.floats(0, 1))})


@given(material=tables())
@settings(max_examples=60, deadline=None)
def test_any_table_is_passive_from_a_tenth_of_a_hertz_to_a_gigahertz(material):
    frequency = np.concatenate([np.geomspace(0.1, 1e9, 401), material.table()[0]])
    values = material.bound_permittivity(frequency)
    assert np.all(np.isfinite(values))
    assert np.all(values.imag <= 0)
    assert np.all(values.real > 0)
    assert np.all(material.complex_permittivity(frequency).imag <= 0)


RESISTIVITIES = 1 / (2 * np.pi * FREQUENCY * VACUUM_PERMITTIVITY * LOSS)


def test_reads_eps_and_rho_of_a_file_with_units(tmp_path):
    kilo = RESISTIVITIES / 1e3
    content = write(tmp_path / "skin.csv", "f [kHz],eps,rho", FREQUENCY / 1e3, PERMITTIVITY, kilo)
    content |= {"frequency_column": "f", "permittivity_column": "eps", "conductivity": "0.1 uS/m"}
    content["loss"] = {"model": "Resistivity", "column": "rho", "unit": "kohm m"}
    material = read_part(Material, content)
    assert material.table()[1] == pytest.approx(tabulated().table()[1], rel=1e-14)
    assert material.conduction_bounds() == pytest.approx(tabulated().conduction_bounds(), rel=1e-14, abs=0)
    again = read_part(Material, json.loads(json.dumps(material.to_dict(), default=lambda s: s.packed())))
    assert again == material
    assert again.table()[1].tobytes() == material.table()[1].tobytes()


FOUR = [1.0, 2.0, 3.0, 4.0]
RESISTIVITY = {"model": "Resistivity"}
OPEN = {"loss": RESISTIVITY}
LOWER, EQUAL = [10.0, 100.0, 50.0, 1e4, 1e5], [10.0, 100.0, 100.0, 1e4, 1e5]
GAIN, VOID = [2000.0, 300.0, -1e-3, 50.0, 20.0], [1000.0, 0.0, 500.0, 300.0, 200.0]
DRAWN = [
    "= 1 mS/m alone",
    "row 0 (first is 0), 10 Hz",
    "whole loss of the table there is 2000",
    "0 to 1.113 uS/m",
]
THIRD = "row 2 (first is 0), "
FAULTS = [
    ({name: [] for name in ROWS}, ["holds no rows", 'file = "skin.csv"']),
    ({name: values[:3] for name, values in ROWS.items()}, ["at least 4 rows, not 3"]),
    ({"loss_samples": FOUR}, ["differ in length", "frequency 5", "loss factor 4"]),
    ({"frequency_samples": LOWER}, ["must rise", f"{THIRD}50 Hz, comes after 100 Hz", "sort the table"]),
    ({"frequency_samples": EQUAL}, ["must rise", f"{THIRD}100 Hz, repeats 100 Hz"]),
    ({"frequency_samples": [0.0, *FOUR]}, ["row 0", "frequency must be above 0 Hz"]),
    ({"frequency_samples": [-5.0, *FOUR]}, ["row 0", "-5 Hz", "above 0 Hz"]),
    ({"permittivity_samples": [np.nan, *FOUR]}, ["row 0 (first is 0)", "permittivity = nan", "not a finite"]),
    ({"frequency_samples": [*FOUR, np.inf]}, ["row 4", "frequency = inf"]),
    (
        {"loss_samples": GAIN},
        [f"{THIRD}1000 Hz", "factor = -0.001 must be 0 or more", "Im eps* > 0", "active"],
    ),
    ({"permittivity_samples": VOID}, ["row 1 (first is 0), 100 Hz", "permittivity = 0 must be above 0"]),
    (OPEN | {"loss_samples": [3, 2, -1e3, 1, 1]}, [f"{THIRD}1000 Hz", "= -1000 must be above 0", "active"]),
    (OPEN | {"loss_samples": [1e5, 1e4, 1e3, 1e2, 0.0]}, ["row 4", "resistivity = 0 must be above 0"]),
    ({"conductivity": "1 mS/m"}, DRAWN),
    ({"loss": {"model": "Conductivity"}, "frequency_samples": [1e-320, *FOUR]}, ["row 0", "too large"]),
    ({"loss": RESISTIVITY | {"unit": "S/m"}}, ["loss.unit = 'S/m'", "a resistivity", "'ohm m'"]),
    ({"frequency_unit": "ms"}, ["frequency_unit = 'ms'", "a frequency"]),
    ({"loss": {"model": "Resistvity"}}, ["LossColumn model 'Resistvity'", "Did you mean 'Resistivity'"]),
    ({"loss": {"model": "LossFactor", "colum": "loss"}}, ["loss.colum: unknown", "Did you mean 'column'?"]),
    ({"loss_samples": ["a", *FOUR]}, ["loss_samples", "not numbers"]),
]


@pytest.mark.parametrize(("changes", "words"), FAULTS)
def test_a_fault_is_one_clear_sentence(changes, words):
    with pytest.raises(InputError) as caught:
        tabulated(**changes)
    (said,) = caught.value.problems
    assert "\n" not in said
    assert [word for word in words if word not in said] == []


def test_conductivity_has_to_be_declared_and_files_are_read_with_a_scenario(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # a long path would be shortened
    content = write(Path("up.csv"), HEADINGS, FOUR[::-1], FOUR, FOUR)
    down = r"\{model = 'Tabulated', file = 'up.csv', ...\}: .*row 1 \(first is 0\), 3 Hz, comes after 4 Hz"
    unread = r"holds no rows: its file is read with a scenario.*electrovib\.scenario\.read_part"
    # the forms of a loss are named for a loss column only
    other = content | {"frequency_column": "frequenzy"}
    for read, table, words in (
        (read_model, {"model": "Tabulated"} | ROWS, "conductivity: missing: conductivity at zero frequency"),
        (read_model, content, unread),
        (read_part, content, down),
        (read_part, other, "no column 'frequenzy'(?!.*Resistivity)"),
    ):
        with pytest.raises(InputError, match=words) as caught:
            read(Material, table)
        assert len(caught.value.problems) == 1


def test_noise_may_take_five_percent_of_the_conduction():
    most = tabulated().conduction_bounds()[1]
    assert tabulated(conductivity=1.04 * most).bound_permittivity(10.0).imag == 0
    with pytest.raises(InputError, match="declare from 0 to"):
        tabulated(conductivity=1.08 * most)
    # A film whose loss the bridge could not see: 1e-4 as loss tangent, below the 1e-3 allowed.
    film = {"permittivity_samples": [3.35] * 5, "loss_samples": [0.0] * 5}
    tiny = 2 * np.pi * 10 * VACUUM_PERMITTIVITY * 3.35e-4
    assert np.all(tabulated(**film, conductivity=tiny).table()[1] == 3.35)
    with pytest.raises(InputError, match="whole loss of the table there is 0"):
        tabulated(**film, conductivity=20 * tiny)


def test_the_kramers_kronig_residual_is_the_noise_unless_rows_are_too_few():
    # 51 points determine that of 1 % to a tenth, so half is far off
    assert measured(SKIN, BAND, noise=0.01).kramers_kronig == pytest.approx(0.01, rel=0.5)
    assert np.isnan(tabulated(**{name: values[:4] for name, values in ROWS.items()}).kramers_kronig)


def test_bounds_hold_the_true_conductivity_and_leave_only_the_split_open():
    table = measured(SKIN, BAND)
    least, most = table.conduction_bounds()
    assert least == 0
    # Without noise the smallest is the first: conduction plus the constant phase's own loss at 10 Hz.
    loss = -SKIN.complex_permittivity(10.0).imag
    assert most == pytest.approx(2 * np.pi * 10 * VACUUM_PERMITTIVITY * loss, rel=1e-12, abs=0)
    assert SKIN.conductivity < most < 2 * SKIN.conductivity
    for declared in (least, most):
        other = table.replace({"conductivity": declared})
        assert other.conduction_bounds() == (least, most)
        assert other.complex_permittivity(BAND) == pytest.approx(table.complex_permittivity(BAND), rel=1e-12)


def test_reduction_follows_the_rows_and_states_its_error():
    material = measured(SKIN, BAND)
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
    # Slow loss that is not declared as conduction finds no place: 6, 53, 61 %.
    errors = [reduce_material(material.replace({"conductivity": s})).largest_error for s in (4e-6, 2e-6, 0.0)]
    assert errors[0] < 0.08
    assert 0.3 < errors[1] < errors[2]


def test_rows_beyond_the_band_do_not_cost_terms():
    wide, narrow = measured(BROAD, np.geomspace(10, 1e10, 91)), measured(BROAD, BAND)
    expected = reduce_material(narrow).largest_error
    assert reduce_material(wide).largest_error == pytest.approx(expected, rel=1e-6)
    assert reduce_material(measured(BROAD, np.geomspace(1e7, 1e9, 21))).largest_error < 0.1


def test_noisy_table_is_reduced_to_its_noise():
    reduction = reduce_material(
        measured(BROAD, BAND, noise=0.01, seed=3, conductivity=0.98 * BROAD.conductivity)
    )
    fine = np.geomspace(30, 1e6, 301)
    error = np.abs(reduction.debye.permittivity(fine) / BROAD.bound_permittivity(fine) - 1)
    # 1 % of the whole loss is up to 2 % of the polarisation; the terms average a part of it: 1.1 % was measured.
    assert error.max() < 0.03
    # Against the rows themselves the noise is all there, three times 1 % at one of 51 rows.
    assert reduction.largest_error > 0.02


def gabriel(loss, column, **changes):
    if not GABRIEL.exists():
        pytest.skip("needs shared/data/skin_impedance/gabriel_measured_skin_dry.txt beside the repository")
    content = {"model": "Tabulated", "file": str(GABRIEL), "conductivity": "170 uS/m"}
    content |= {"frequency_column": "Frequency", "permittivity_column": "Permittivity"}
    return read_part(Material, content | {"loss": {"model": loss, "column": column}} | changes)


def test_measured_whole_skin():
    material = gabriel("LossFactor", "Loss Factor")
    frequency, rows = material.table()
    assert (len(frequency), material.band) == (156, (100.0, 20e9))
    # 4.6 % was measured: more than the noise of its five digits, as its bump near 251 Hz and its step at
    # 35 kHz make it; far less than what two quantities that do not belong together give.
    assert material.kramers_kronig == pytest.approx(0.046, abs=0.01)
    # Between 355 Hz and 100 Hz the conductivity rises again, which no passive material does: its smallest is
    # the most that may be declared.
    assert material.conduction_bounds()[1] == pytest.approx(1.7666e-4, rel=1e-4, abs=0)
    with pytest.raises(InputError, match=r"declare from 0 to 176\.7 uS/m"):
        gabriel("LossFactor", "Loss Factor", conductivity="190 uS/m")
    other = gabriel("Conductivity", "Conductivity")
    # Both columns are printed with five digits, and the conduction taken out magnifies that.
    assert other.table()[1] == pytest.approx(rows, rel=0.02)
    assert other.complex_permittivity([100.0]) == pytest.approx([1325 - 32476j], rel=1e-3)
    # Of the polarisation, which at 100 Hz is a twentieth of the whole: 54 % was measured. Of the whole: 4.8 %.
    reduction, kept = reduce_material(material), frequency <= 1e6
    assert reduction.largest_error == pytest.approx(0.54, abs=0.1)
    error = np.abs(reduction.debye.permittivity(frequency) - rows)[kept]
    assert 0.02 < np.max(error / np.abs(material.complex_permittivity(frequency[kept]))) < 0.07
