"""One number or an array of any shape: the same answers, in the same shape."""

import inspect

import numpy as np
import pytest

SAMPLES = {
    "frequency": 10 ** np.linspace(-1, 9, 12),
    "time": np.array([-0.3, -1e-3, 0.0, 1e-6, 1e-3, 3e-3, 0.01, 0.03, 0.07, 0.1, 0.3, 2.0]),
    "E": np.linspace(-3e6, 4e6, 12),
    "D": np.linspace(-2e-4, 3e-4, 12),
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
