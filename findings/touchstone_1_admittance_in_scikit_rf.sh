#!/usr/bin/env bash
# scikit-rf 2.2.0: admittances of a Touchstone file of version 1 come out R^2 times too large.
# Version 1 of the format writes Z and Y normalised to the reference resistance R of the option line:
# Z = R z and Y = y / R. A file with z = 1 and one with y = 1 describe the same resistor of 50 ohm.
# Expected: 50 ohm from both. Seen: 50 ohm from Z, and 0.02 ohm from Y, because y is multiplied by R as well.
# Needs python3 with venv and pip. Exits with 1 if what is seen has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv environment
environment/bin/pip install --quiet "scikit-rf==2.2.0"
environment/bin/python - <<'PY'
from pathlib import Path

import skrf

found = {}
for kind in "ZY":
    name = f"{kind}.s1p"
    Path(name).write_text(f"# Hz {kind} RI R 50\n1000 1 0\n2000 1 0\n")
    found[kind] = abs(skrf.Network(name).z[0, 0, 0])
print(f"scikit-rf {skrf.__version__}; expected 50 ohm from both; seen {found['Z']:.4g} from Z, {found['Y']:.4g} from Y")
assert abs(found["Z"] - 50) < 1e-9 and abs(found["Y"] - 0.02) < 1e-9, "what is seen has changed"
PY
