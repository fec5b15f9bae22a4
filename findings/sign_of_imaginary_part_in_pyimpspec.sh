#!/usr/bin/env bash
# pyimpspec 5.1.3: DataSet.to_dataframe(negative_imaginary=True) negates the imaginary part and keeps its heading.
# A table saved from it is read by the next program as an inductive spectrum.
# Expected: the heading says -Im(Z). Seen: 'Im(Z) (ohm)' above values of the opposite sign.
# Needs python3 with venv and pip. Exits with 1 if what is seen has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv environment
environment/bin/pip install --quiet "pyimpspec==5.1.3"
environment/bin/python - <<'PY'
from importlib.metadata import version

import numpy as np
import pyimpspec

frequency = np.logspace(5, 0, 6)
impedance = 100 + 1000 / (1 + 2j * np.pi * frequency * 1e-3)  # a resistor, and one beside a capacitor
table = pyimpspec.DataSet(frequency, impedance).to_dataframe(negative_imaginary=True)
heading = next(name for name in table.columns if "Im(Z)" in name)
first, right = float(table[heading].iloc[0]), impedance[0].imag
print(f"pyimpspec {version('pyimpspec')}; expected '-Im(Z)' above {-right:.5g}, or 'Im(Z)' above {right:.5g}")
print(f"seen: '{heading}' above {first:.5g}")
assert heading.startswith("Im(Z)") and np.isclose(first, -right), "what is seen has changed"
PY
