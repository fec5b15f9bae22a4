"""Certified values of the NIST StRD, nonlinear regression, through our fit layer."""

import re
from pathlib import Path

import numpy as np
import pytest

from electrovib.recordings.fit import fit_function

FOLDER = Path(__file__).parent.parent.parent / "data" / "nist_strd"


def lanczos(x, b1, b2, b3, b4, b5, b6):
    return b1 * np.exp(-b2 * x) + b3 * np.exp(-b4 * x) + b5 * np.exp(-b6 * x)


def gauss(x, b1, b2, b3, b4, b5, b6, b7, b8):
    return (
        b1 * np.exp(-b2 * x) + b3 * np.exp(-((x - b4) ** 2) / b5**2) + b6 * np.exp(-((x - b7) ** 2) / b8**2)
    )


def mgh09(x, b1, b2, b3, b4):
    return b1 * (x**2 + x * b2) / (x**2 + x * b3 + b4)


def mgh10(x, b1, b2, b3):
    return b1 * np.exp(b2 / (x + b3))


def mgh17(x, b1, b2, b3, b4, b5):
    return b1 + b2 * np.exp(-x * b4) + b3 * np.exp(-x * b5)


def thurber(x, b1, b2, b3, b4, b5, b6, b7):
    return (b1 + b2 * x + b3 * x**2 + b4 * x**3) / (1 + b5 * x + b6 * x**2 + b7 * x**3)


FUNCTIONS = {
    **{f"Lanczos{n}": lanczos for n in (1, 2, 3)},
    **{f"Gauss{n}": gauss for n in (1, 2, 3)},
    "MGH09": mgh09,
    "MGH10": mgh10,
    "MGH17": mgh17,
    "Thurber": thurber,
}


def certified(name):
    """Rows (start 1, start 2, value, standard deviation), then x and y."""
    lines = (FOLDER / f"{name}.dat").read_text(encoding="ascii").splitlines()
    rows = [re.match(r"\s*b\d+\s*=\s*(\S+)\s+(\S+)\s+(\S+)\s+(\S+)", line) for line in lines]
    first = max(at for at, line in enumerate(lines) if line.startswith("Data:")) + 1
    data = np.array([[float(word) for word in line.split()] for line in lines[first:] if line.strip()])
    return np.array([[float(word) for word in row.groups()] for row in rows if row]), data[:, 1], data[:, 0]


@pytest.mark.parametrize("start", [0, 1], ids=["start 1", "start 2"])
@pytest.mark.parametrize("name", FUNCTIONS)
def test_certified_values_to_six_digits_and_deviations_to_four(name, start):
    rows, x, y = certified(name)
    names = [f"b{at + 1}" for at in range(len(rows))]
    found = fit_function(FUNCTIONS[name], x, y, start=dict(zip(names, rows[:, start], strict=True)))
    np.testing.assert_allclose([found.values[each] for each in names], rows[:, 2], rtol=1e-6)
    # the residuals of Lanczos1 are the rounding of its 14 digits: doubles cannot give its deviations better
    digits = 1e-2 if name == "Lanczos1" else 1e-4
    np.testing.assert_allclose([found.standard_deviations[each] for each in names], rows[:, 3], rtol=digits)
