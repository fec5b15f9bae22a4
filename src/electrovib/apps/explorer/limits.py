"""Largest sizes of what a visitor of the page may ask for."""

from __future__ import annotations

from typing import Final

LOOPBACK: Final = ("127.0.0.1", "localhost", "[::1]")
"""Names of this machine as a browser writes them."""
MOST_CHANGES: Final = 60
"""Parameters that a link may change."""
LONGEST_VALUE: Final = 300
"""Letters of a value in a link."""
LONGEST_LINK: Final = 6000
"""Letters of the part of an address behind its question mark."""
MOST_SAMPLES: Final = 20_000
"""Output times, and frequencies, of one simulation."""
SHOWN_SAMPLES: Final = 400
"""Points of a curve that are sent to the browser."""
LARGEST_UPLOAD: Final = 20_000_000
"""Bytes of a recording."""
LARGEST_REQUEST: Final = LARGEST_UPLOAD + 100_000
"""Bytes of a request: those of a file, and those that its form adds."""
LARGEST_SCENARIO: Final = 500_000
"""Bytes of a scenario (TOML)."""
MOST_PARAMETERS: Final = 400
"""Parameters of a scenario, each of which has a slider."""
MOST_VALUES: Final = 2_000_000
"""Numbers of a recording, all channels together."""
MOST_COLUMNS: Final = 200
"""Columns of a recording, each of which is offered as a signal."""
LONGEST_LINE: Final = 20_000
"""Letters of a line of a recording that is a text."""
LONGEST_NAME: Final = 120
"""Letters of the name of a file or of a column that are shown."""
LARGEST_MESSAGE: Final = 1_000_000
"""Bytes of a message of a browser."""
LONGEST_RUN: Final = 20.0
"""Estimated seconds of one simulation, above which it is refused."""
LONGEST_SHORT_RUN: Final = 0.1
"""Estimated seconds up to which simulations take turns; a longer one runs beside fits and reports."""
LONGEST_QUICK_RUN: Final = 2.0
"""Seconds after which a simulation ends for whose result nobody waits any more."""
LARGEST_RUN: Final = 500e6
"""Estimated memory of one simulation, above which it is refused [bytes]."""
FINGERS: Final = 200
"""Draws from the population for a band."""
