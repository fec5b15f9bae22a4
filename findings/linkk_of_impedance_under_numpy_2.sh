#!/usr/bin/env bash
# impedance 1.7.1: the linear Kramers-Kronig test of its documentation ends in a NameError under numpy 2.
# Expected: the number of elements and the residuals, of which those of an exact spectrum are small.
# Seen: NameError, 'np' is not defined.
# Needs python3 with venv and pip. Exits with 1 if what is seen has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv environment
environment/bin/pip install --quiet "impedance==1.7.1" "numpy==2.4.6" "pandas==3.1.1"
environment/bin/python - <<'PY'
import numpy as np
from impedance.validation import linKK

frequency = np.logspace(5, 0, 40)
impedance = 100 + 1000 / (1 + 2j * np.pi * frequency * 1e-3)
try:
    seen = f"{linKK(frequency, impedance)[0]} elements"
except NameError as error:
    seen = f"NameError: {error}"
print(f"impedance 1.7.1, numpy {np.__version__}; expected a number of elements; seen {seen}")
assert seen.startswith("NameError"), "what is seen has changed"
PY
