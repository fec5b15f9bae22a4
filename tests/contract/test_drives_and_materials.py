"""Drives are their parts and periods, dielectrics are passive, and every method takes numbers as it takes arrays."""

import inspect

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from electrovib.core.citation import STATUSES
from electrovib.core.samples import Samples
from electrovib.physics.drive.edges import Trapezium
from electrovib.physics.drive.parts import Linear
from electrovib.physics.drive.sines import Burst
from electrovib.physics.skin import Skin, time_constant


def somewhere(drive, count=400, *, first=0.0, last=1.0):
    """Times that fall on no break: irrational shares of the duration."""
    share = (np.arange(count) + 1 / np.sqrt(2)) / count
    return (first + (last - first) * share) * drive.duration


def height(drive):
    return max(float(np.max(np.abs(drive.voltage(somewhere(drive))))), 1e-12)


def breaks(drive, end):
    """Where a drive bends or jumps up to a time."""
    found = [part.until(end).times for part in drive.parts() if isinstance(part, Linear)]
    gates = [np.array([part.start, part.stop]) for part in drive.parts() if not isinstance(part, Linear)]
    return np.concatenate([*found, *gates, np.zeros(1)])


def away_from_breaks(drive, times, distance):
    near = np.min(np.abs(times[:, None] - breaks(drive, times[-1] + distance)), axis=1)
    return times[near > distance]


def test_a_drive_is_the_sum_of_its_parts_and_its_slope_is_the_derivative(drive_class, build):
    drive = build(drive_class)
    times = somewhere(drive, first=-0.5, last=1.5)
    for whole, name in ((drive.voltage, "value"), (drive.slope, "slope")):
        total = sum(getattr(part, name)(times) for part in drive.parts())
        np.testing.assert_array_equal(whole(times), total)
        assert np.max(np.abs(total)) > 0 or name == "slope"
    step = 1e-6 * drive.duration
    times = away_from_breaks(drive, somewhere(drive), 2 * step)
    numeric = (drive.voltage(times + step) - drive.voltage(times - step)) / (2 * step)
    steepest = max(float(np.max(np.abs(numeric))), height(drive) / drive.duration)
    # central difference: third derivative times step^2, below 1e-6 of the steepest slope here
    np.testing.assert_allclose(drive.slope(times), numeric, rtol=0, atol=1e-5 * steepest)


def test_the_period_is_the_period(drive_class, build):
    drive = build(drive_class)
    if drive.period is None:
        return
    times = somewhere(drive)

    def off(after):
        return np.max(np.abs(drive.voltage(times + after) - drive.voltage(times))) / height(drive)

    assert off(drive.period) < 1e-9
    for share in (2, 3, 5, 7):
        assert off(drive.period / share) > 1e-3, f"repeats after {share} times less already"


@given(data=st.data())
@settings(max_examples=25)
def test_drawn_voltages_are_finite_and_periods_are_periods(drive_class, drawn, data):
    drive = data.draw(drawn(drive_class))
    assert drive.duration > 0
    voltage = drive.voltage(somewhere(drive, 50))
    assert np.all(np.isfinite(voltage))
    assert voltage.shape == (50,)
    if drive.period is None:
        return
    for part in drive.parts():
        if isinstance(part, Linear) and part.period:
            assert part.times[0] == 0
            assert abs(part.times[-1] / part.period - 1) < 1e-12
            assert np.all(np.diff(part.times) > 0)
    times = away_from_breaks(drive, np.linspace(0, 1, 101)[1:-1] * drive.period, 1e-6 * drive.period)
    later = times + drive.period
    # the rounding of a time is a phase, or a height on an edge
    slack = 8 * np.spacing(later[-1]) * np.max(np.abs(drive.slope(times)), initial=0.0)
    atol = 1e-9 * height(drive) + slack
    np.testing.assert_allclose(drive.voltage(later), drive.voltage(times), rtol=0, atol=atol)


@given(data=st.data())
def test_a_trapezium_begins_and_ends_at_low(drawn, data):
    drive = data.draw(drawn(Trapezium)).replace({"repeat": None})
    if drive.delay + drive.rise > 0:
        assert drive.voltage(0.0) == drive.low
    end = drive.delay + drive.rise + drive.hold + drive.fall
    after = np.array([end * (1 + 1e-12) + 1e-30, 2 * end + 1, 1e6 * end + 1])
    np.testing.assert_array_equal(drive.voltage(after), drive.low)
    voltage = drive.voltage(np.linspace(0, drive.duration, 101))
    lowest, highest = sorted((drive.low, drive.high))
    slack = 1e-12 * (abs(lowest) + abs(highest))
    assert np.all((voltage >= lowest - slack) & (voltage <= highest + slack))
    assert drive.voltage(-1.0) == 0


@given(data=st.data())
def test_a_burst_begins_and_ends_at_zero(drawn, data):
    drive = data.draw(drawn(Burst)).replace({"offset": 0})
    end = drive.delay + drive.cycles / drive.frequency
    # what sin of a rounded phase leaves, at the first and after the last sample
    rounding = 2 * np.pi * drive.frequency * np.spacing(end) * drive.amplitude * 4
    assert abs(float(drive.voltage(drive.delay))) <= rounding + 1e-12 * drive.amplitude
    after = np.array([end * (1 + 1e-12), 2 * end, 10 * end])
    np.testing.assert_array_equal(drive.voltage(after), np.zeros(3))
    before = np.array([-1.0, -1e-9])
    np.testing.assert_array_equal(drive.voltage(before), np.zeros(2))


def test_a_sum_of_nothing_is_refused(discovered):
    with pytest.raises(ValueError):
        discovered["drive_class"]["Sum"].model_validate({"drives": []})


BAND = np.logspace(-1, 9, 201)
ROUNDING = 1e-13
"""Of |eps*|: below it the sign of a computed loss means nothing."""


def active(permittivity):
    """Largest Im eps* over |eps*|: above rounding the dielectric releases energy."""
    return float(np.max(permittivity.imag / np.abs(permittivity)))


@given(data=st.data())
def test_materials_are_passive_and_a_finite_sum_is_the_material(material_class, drawn, data):
    material = data.draw(drawn(material_class))
    permittivity, bound = material.complex_permittivity(BAND), material.bound_permittivity(BAND)
    assert np.all(np.isfinite(permittivity))
    assert active(permittivity) <= ROUNDING
    assert active(bound) <= ROUNDING
    assert np.all(bound.real > 0)
    # conduction only adds loss, and nothing to the stored part
    assert np.all(permittivity.imag <= bound.imag)
    exact = material.debye()
    if exact is not None:
        assert np.max(np.abs(exact.permittivity(BAND) / bound - 1)) < 1e-12
        assert exact.high > 0
        assert min(exact.strengths, default=0.0) >= 0


def test_an_active_dielectric_is_noticed_and_permittivity_has_the_frequencys_shape(material_class, build):
    """The other sign of the loss, by as little as a thousandth, is no longer passive."""
    material = build(material_class)
    permittivity = material.complex_permittivity(BAND)
    assert active(permittivity.conj() if np.any(permittivity.imag) else permittivity * (1 + 1e-3j)) > ROUNDING
    for answer in (material.complex_permittivity, material.bound_permittivity):
        assert answer(BAND.reshape(3, 67)).shape == (3, 67)
        assert np.iscomplexobj(answer(BAND))


def test_skins_are_passive_and_described(skin):
    assert active(skin.material.complex_permittivity(BAND)) <= ROUNDING
    assert active(skin.material.bound_permittivity(BAND)) <= ROUNDING
    assert isinstance(skin, Skin)
    assert skin.status in STATUSES
    assert len(skin.source) > 10
    assert len(skin.note) > 10
    relaxation = time_constant(skin.material, np.logspace(0, 6, 61))
    assert np.all(relaxation > 0)
    assert np.all(np.isfinite(relaxation))
    if skin.reproduces_force:  # one that conducts nothing predicts none
        assert skin.material.conductivity > 0


def test_skins_have_names_of_their_own(discovered):
    names = [skin.name for skin in discovered["skin"].values()]
    assert len(set(names)) == len(names)


def test_tables_carry_their_kramers_kronig_residual(discovered, build):
    kinds = discovered["material_class"].values()
    tables = [
        kind for kind in kinds if any(field.annotation is Samples for field in kind.model_fields.values())
    ]
    assert tables
    for kind in tables:
        assert 0 <= build(kind).kramers_kronig < 0.006  # the law behind it has 0.0035; rounding adds the rest
        # a stored part that rises with frequency cannot belong to its loss
        rows = dict(kind.example)
        rows["permittivity_samples"] = rows["permittivity_samples"][::-1]
        assert kind.model_validate(rows).kramers_kronig > 0.1


SAMPLES = {
    "frequency": 10 ** np.linspace(-1, 9, 12),
    "wavenumber": 10 ** np.linspace(1, 7, 12),
    "time": np.array([-0.3, -1e-3, 0.0, 1e-6, 1e-3, 3e-3, 0.01, 0.03, 0.07, 0.1, 0.3, 2.0]),
    "E": np.linspace(-3e6, 4e6, 12),
    "D": np.linspace(-2e-4, 3e-4, 12),
    "V": np.linspace(-90.0, 100.0, 12),
    "normal_force": np.linspace(0.0, 2.0, 12),
    "electrostatic_force": np.linspace(0.0, 0.5, 12),
    "real_contact_area": np.linspace(0.0, 1e-5, 12),
    "deflection": np.linspace(-1e-4, 2e-4, 12),
    "rate": np.linspace(-1e-3, 1e-3, 12),
    "speed": np.linspace(-0.1, 0.2, 12),
    "direction": np.sign(np.linspace(-0.1, 0.2, 12)),
    "strength": np.linspace(0.1, 2.0, 12),
    "voltage": np.linspace(-2e3, 3e3, 12),
    "gap": np.linspace(0.0, 1e-4, 12),
    "pressure": np.geomspace(10.0, 1e7, 12),
    "force": np.linspace(-3.0, 3.1, 12),
    "full_scale": np.linspace(0.5, 2.5, 12),
    "permittivity": np.linspace(1.0, 2000.0, 12),
    "values": np.linspace(0.1, 30.0, 12),
    "periods": np.linspace(-1.3, 2.2, 12),
    "reading": np.linspace(-5.0, 5.0, 12),
}
"""What each argument that may be an array is tried with."""
WHOLE_RECORDS = {
    ("doubts", "share"),
    ("diagnostics", "share"),
    ("keep", "time"),
    ("wraps", "counts"),
    ("position", "counts"),
    ("driving", "voltage"),
    ("added_friction", "position"),
    ("along", "vectors"),
    ("slope", "position"),
    ("positions", "time"),
}
"""Arguments that are one record, not elements on their own."""


def array_methods(kind):
    """Public methods with arguments declared as arrays, and the names of all their arguments."""
    for name, method in inspect.getmembers(kind, inspect.isfunction):
        if name.startswith("_") or not method.__module__.startswith("electrovib."):
            continue
        signature = inspect.signature(method)
        if str(signature.return_annotation).startswith("tuple"):
            continue  # several answers
        parameters = [p for p in signature.parameters.values() if p.name != "self"]
        arrays = [p.name for p in parameters if any(w in str(p.annotation) for w in ("Array", "Real"))]
        if arrays and not any((name, array) in WHOLE_RECORDS for array in arrays):
            yield name, [p.name for p in parameters]


def compare(function, names):
    row = {name: SAMPLES[name] for name in names}
    block = {name: SAMPLES[name].reshape(3, 4) for name in names}
    expected, shaped = function(**row), function(**block)
    assert np.shape(expected) == (12,)
    assert np.shape(shaped) == (3, 4)
    # numpy may round its vector loops and single numbers apart by the last digits
    np.testing.assert_allclose(np.ravel(shaped), expected, rtol=1e-14, atol=0)
    for index in range(12):
        alone = function(**{name: float(SAMPLES[name][index]) for name in names})
        assert np.shape(alone) == ()
        np.testing.assert_allclose(alone, expected[index], rtol=1e-13, atol=1e-300)
    return expected


def test_scalar_equals_array_and_nan_passes(final_class, build):
    """What series may hold, they hand on: NaN gives NaN there, and nothing elsewhere."""
    model = build(final_class)
    for method, names in array_methods(final_class):
        unknown = set(names) - set(SAMPLES)
        assert not unknown, f"{final_class.__name__}.{method}: give {unknown} a place in SAMPLES"
        whole = compare(getattr(model, method), names)
        if np.asarray(whole).dtype == bool:
            continue  # a yes or no
        for name in names:
            given = {key: SAMPLES[key].copy() for key in names}
            given[name][5] = np.nan
            answer = getattr(model, method)(**given)
            always = method in ("complex_permittivity", "bound_permittivity", "voltage")
            if np.isfinite(whole[5]) and (always or np.any(answer[5] != whole[5])):
                assert np.isnan(answer[5]), f"{method}({name}=nan)"
            np.testing.assert_array_equal(np.delete(answer, 5), np.delete(whole, 5))


def test_methods_with_arrays_are_found_and_one_that_mixes_its_elements_is_refused(discovered):
    kinds = discovered["final_class"].values()
    found = {(kind.__name__, method) for kind in kinds for method, _ in array_methods(kind)}
    assert {("Debye", "bound_permittivity"), ("Layer", "impedance"), ("Sine", "voltage")} <= found
    assert ("MaxwellStressInGap", "pressure") in found
    with pytest.raises(AssertionError):
        compare(lambda frequency: frequency / np.sum(frequency), ["frequency"])
