"""Radau collocation with three stages: nodes and weights."""

from __future__ import annotations

import numpy as np

STAGES = 3
ORDER = 2 * STAGES - 1
"""Order of convergence where the rate is smooth."""
_ROOT = np.sqrt(6.0)
NODES = np.array([(4 - _ROOT) / 10, (4 + _ROOT) / 10, 1.0])
"""Radau IIA, three stages: zeros of x^2 (x - 1)^3 differentiated twice (Hairer and Wanner 1996, IV.5)."""
WEIGHTS = np.array(
    [
        [(88 - 7 * _ROOT) / 360, (296 - 169 * _ROOT) / 1800, (-2 + 3 * _ROOT) / 225],
        [(296 + 169 * _ROOT) / 1800, (88 + 7 * _ROOT) / 360, (-2 - 3 * _ROOT) / 225],
        [(16 - _ROOT) / 36, (16 + _ROOT) / 36, 1 / 9],
    ]
)
"""Integral of each stage's polynomial from the beginning to each node, as a share of the step (the same place)."""
COEFFICIENTS = np.linalg.inv(NODES[:, None] ** np.arange(1, STAGES + 1))
"""Matrix from the increments of the stages to coefficients of powers of the share of a step."""
ERROR = np.array([-13 - 7 * _ROOT, -13 + 7 * _ROOT, -1.0]) / 3
"""Weights of the increments in the embedded error of third order (the same place, IV.8)."""
REAL_ROOT = 3 + 3 ** (2 / 3) - 3 ** (1 / 3)
"""Real eigenvalue of the inverse of `WEIGHTS`."""
RATES = np.linalg.inv(WEIGHTS)
"""Matrix from the increments of the stages to the rates at the nodes, times the step."""
