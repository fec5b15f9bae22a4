"""What one step of each solver costs on one core of a common computer, measured through `electrovib.simulate`.

Estimates count in these, so that a scenario is refused or accepted alike on every machine. `benchmarks/` measures
them again.
"""

from __future__ import annotations

from typing import Final

SAMPLE: Final = 1e-6
"""Of an output time of a stack without relaxations [s]."""
SAMPLE_OF_MODE: Final = 3e-7
"""More for each relaxation [s]."""
CORNER: Final = 1e-6
"""Of a corner of the drive [s]."""
LEAK_STEP: Final = 2.5e-5
"""Of the march of a leaking layer [s]."""
GAP_STEP: Final = 4e-6
"""Of the march beneath a gap that is moved [s]."""
BRISTLE_STEP: Final = 5e-6
"""Of Radau's method on bristles, compiled, with or without a skin [s]."""
RADAU_STEP: Final = 7e-4
"""Of Radau's method on up to about ten equations [s]."""
CASE: Final = 5e-3
"""Of the simplest case of a sweep [s]."""
CASE_MEMORY: Final = 4e4
"""Of the scenario and the numbers of a case [bytes]."""

FEWER_SAMPLES: Final = "ask for fewer time.samples"
SHORTER: Final = "choose a shorter time.duration, a slower drive or one with fewer corners"
"""What makes a march shorter."""
