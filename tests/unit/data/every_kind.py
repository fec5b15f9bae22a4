"""Traces of every kind, and how two of them are compared."""

import numpy as np
import xarray

from electrovib.core.signals import make_trace

TIME, LAYERS = np.arange(5) * 0.1, ["insulator", "gap", "stratum_corneum"]


def small(**attributes) -> xarray.Dataset:
    """Time, frequency, layers in both orders, complex, and every float that is easily spoilt."""
    random = np.random.default_rng(1)
    return make_trace(
        {
            "field": (("layer", "time"), random.standard_normal((3, 5))),
            "displacement": (("time", "layer"), random.standard_normal((5, 3))),
            "drive_voltage": (("time",), [np.nan, np.inf, -np.inf, -0.0, 5e-324]),
            "field_gain": (("frequency", "layer"), random.standard_normal((4, 3)) + 1j),
            "impedance": (("frequency",), [1 + 2j, complex(np.nan, 1), complex(0, np.inf), -(0.0 + 0.0j)]),
            "effective_voltage_gain": (("frequency",), np.ones(4, complex)),
            "normal_force": ((), 0.5),
            "permittivity": (("layer",), [3.35 + 0j, 1.0, 1560 - 2j]),
        },
        {"time": TIME, "frequency": [1.0, 2.0, 3.0, 4.0], "layer": LAYERS},
        {"solver": "modes, µ\n2 lines", "empty": "", "steps": 3, "tau": 0.1, **attributes},
    )


def with_sweep() -> xarray.Dataset:
    values = np.random.default_rng(2).standard_normal((2, 2, 3, 5))
    return make_trace(
        {"field": (("drive.rise", "stack.gap.material", "layer", "time"), values)},
        {"time": TIME, "layer": LAYERS, "drive.rise": [1e-6, 1e-3], "stack.gap.material": ["air", "oil"]},
        {},
    )


def only(name: str) -> xarray.Dataset:
    return make_trace({"impedance": ((name,), [1 + 1j, 2.0])}, {name: [1.0, 2.0]}, {})


def same(first: xarray.Dataset, second: xarray.Dataset) -> None:
    """Stricter than xarray: dtypes, order, types of attributes, and the sign of zero."""
    xarray.testing.assert_identical(first, second)
    assert list(first.variables) == list(second.variables)
    assert {k: type(v) for k, v in first.attrs.items()} == {k: type(v) for k, v in second.attrs.items()}
    for name in first.variables:
        one, two = first[name], second[name]
        assert one.dims == two.dims
        assert one.dtype.kind == two.dtype.kind
        if one.dtype.kind in "fc":
            np.testing.assert_array_equal(signs(one.values), signs(two.values))


def signs(values: np.ndarray) -> np.ndarray:
    """Signs of both parts; that of NaN means nothing and no text keeps it."""
    parts = np.stack([values.real, values.imag])
    return np.where(np.isnan(parts), 0.0, np.copysign(1.0, parts))
