#!/usr/bin/env bash
# tm-data-types 0.5.0 (Tektronix's library for files of its oscilloscopes): the voltages of a CSV are rounded to 16 bits
# of the range of the whole record when the file is read, without a warning; one spike of 100 V takes the millivolts.
# Expected: the numbers that the file prints, 0.001, 0.002, 0.003 V. Seen: 0.0018, 0.0033, 0.0033 V.
# Needs python3 with venv and pip. Exits with 1 if what is seen has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv environment
environment/bin/pip install --quiet "tm-data-types==0.5.0" "numpy==1.26.4"
environment/bin/python - <<'PY'
import warnings
from importlib.metadata import version
from pathlib import Path

import numpy as np
from tm_data_types import read_file

printed = [0.001, 0.002, 0.003, 0.002, 100.0, 0.001]
about = {"Model": "MSO54", "Waveform Type": "ANALOG", "Zero Index": 0, "Sample Interval": 1e-6}
about |= {"Record Length": len(printed), "Horizontal Units": "s", "Vertical Units": "V"}
lines = [f"{name},{value}" for name, value in about.items()]
lines += ["", "Labels,", "TIME,CH1", *(f"{at * 1e-6:.8e},{value:.8e}" for at, value in enumerate(printed))]
Path("record.csv").write_text("\n".join(lines) + "\n")
with warnings.catch_warnings(record=True) as said:
    warnings.simplefilter("always")
    read = np.asarray(read_file("record.csv").normalized_vertical_values)
print(f"tm-data-types {version('tm-data-types')}; expected {printed}")
print(f"seen {[float(f'{each:.4g}') for each in read]}, {len(said)} warnings")
step = (max(printed) - min(printed)) / 65535
assert not said, "what is seen has changed"
assert abs(read[1] - read[2]) < 0.01 * step and np.max(np.abs(read - printed)) > 0.4 * step, "what is seen has changed"
PY
