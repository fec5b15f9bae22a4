"""How well a fit tells which law made a recording: twins of known law, a confusion matrix, and the reliability of the odds.

Run from the root of the repository with ``python -m benchmarks.laws [TWINS]``.
"""

import itertools
import math
import sys
from collections import Counter
from time import process_time
from unittest import mock

import numpy as np
from benchmarks.table import surroundings, write_page
from scipy.interpolate import NdBSpline, make_interp_spline

import electrovib as ev
from electrovib.core.paths import value_at
from electrovib.core.signals import make_trace
from electrovib.recordings.fit.measured import MeasuredTrace
from electrovib.recordings.fit.of_scenario import fit_scenario
from electrovib.recordings.fit.prediction import Prediction, signals_over_frequency
from electrovib.recordings.fit.weighing import LIKELY, REACH, cases_of, weigh

TWINS, SAMPLES, LIVE = 500, 16, 50
FREE = ("contact.area", "stack.gap.material.conductivity")
CASES = (
    "MaxwellStressInGap",
    "MaxwellStressInGap without leak",
    "MaxwellStressInInsulator",
    "EffectiveMedium",
    "Vezzoli2014Causal",
)
NOISE = 1e-4
"""Standard deviation of a force [N]; where the fit does not know it, it is drawn within a factor of 3."""
EDGES = (0.0, 0.01, 0.05, 0.15, 0.3, 0.5, 0.7, 0.85, 0.95, 1.0)
FREQUENCIES = np.geomspace(10.0, 1e4, SAMPLES)
NODES = 41
"""Values of each parameter in the table from which predictions are interpolated."""


def base() -> ev.Scenario:
    """Return a sine of 100 V on a film, a gap that leaks and skin."""
    sine = {"model": "Sine", "amplitude": "100 V", "frequency": "100 Hz"}
    return ev.load("vezzoli_2014/fig6_gap").replace({"drive": sine, FREE[1]: 1e-7})


class Tabulated:
    """The mean force of each case over both parameters, from a table: 20 times as fast as the prediction itself.

    Cubic splines in all logarithms; beyond the table, where a search may go, it is proportional to the first parameter.
    """

    def __init__(self, scenario, cases):
        middle = [value_at(scenario, path) for path in FREE]
        self.axes = [math.log(value) + math.log(REACH) * np.linspace(-1, 1, NODES) for value in middle]
        self.tables = {id(each.scenario): self._table(each) for each in cases.values()}

    def _table(self, case):
        axes = [np.exp(axis) for path, axis in zip(FREE, self.axes, strict=True) if path not in case.zero]
        forces = [
            self._exact(case.scenario, dict(zip(FREE, point, strict=False)))
            for point in itertools.product(*axes)
        ]
        rows = np.log(forces).reshape(*(axis.size for axis in axes), SAMPLES)
        return make_interp_spline(self.axes[0], rows) if len(axes) == 1 else self._surface(rows)

    def _surface(self, rows):
        along = make_interp_spline(self.axes[0], rows)
        within = make_interp_spline(self.axes[1], np.moveaxis(along.c, 1, 0))
        surface = NdBSpline((along.t, within.t), np.moveaxis(within.c, 1, 0), 3)
        return lambda *place: surface([place])[0]

    @staticmethod
    def _exact(scenario, values):
        return signals_over_frequency(scenario.replace(values), FREQUENCIES, ["mean_force"])["mean_force"]

    def force(self, scenario, values):
        """Return the mean force at the frequencies."""
        place = [
            min(max(values[path], math.exp(axis[0])), math.exp(axis[-1]))
            for path, axis in zip(FREE, self.axes, strict=True)
            if path in values
        ]
        return np.exp(self.tables[id(scenario)](*np.log(place))) * values[FREE[0]] / place[0]


def twin(number, scenario, cases, tabulated):
    """Draw a law, its parameters and a recording by the prior odds, and weigh it; even numbers state the noise."""
    rng = np.random.default_rng([0, number])
    laws = list(dict.fromkeys(each.law for each in cases.values()))
    law = laws[rng.integers(len(laws))]
    variants = [name for name, each in cases.items() if each.law == law]
    true = variants[rng.integers(len(variants))]
    drawn = {path: value_at(scenario, path) * REACH ** rng.uniform(-1, 1) for path in FREE}
    drawn = {path: value for path, value in drawn.items() if path not in cases[true].zero}
    is_stated = number % 2 == 0
    noise = NOISE if is_stated else NOISE * 3 ** rng.uniform(-1, 1)
    force = tabulated.force(cases[true].scenario, drawn) + noise * rng.normal(size=SAMPLES)
    trace = make_trace({"mean_force": (("frequency",), force)}, {"frequency": FREQUENCIES}, {})
    recorded = MeasuredTrace(trace=trace, name="twin", noise={"mean_force": NOISE} if is_stated else {})
    fits = {
        name: fit_scenario(each.scenario, recorded, free=[path for path in FREE if path not in each.zero])
        for name, each in cases.items()
    }
    laws_of = {name: each.law for name, each in cases.items()}
    return true, weigh(fits, laws_of, scenario, seed=number, live=LIVE)


def weighed(count):
    """Return the true law of each twin and what its recording says."""
    scenario = base()
    every, _ = cases_of(scenario, [name for name in CASES if " " not in name])
    cases = {name: every[name] for name in CASES}
    tabulated = Tabulated(scenario, cases)

    def record(prediction, at, point):
        return (tabulated.force(prediction.prepared[at].base, dict(point)),)

    with mock.patch.object(Prediction, "_of_record", record):
        return [twin(number, scenario, cases, tabulated) for number in range(count)]


def reliability(found):
    """Return for each range of probability the mean of what was stated, the share that was true, its error, and the number."""
    pairs = [(each.probability, each.name == true) for true, told in found for each in told.candidates]
    rows = []
    for low, high in itertools.pairwise(EDGES):
        own = [pair for pair in pairs if low <= pair[0] < high or pair[0] == high == 1]
        if own:
            stated, seen = np.mean(own, axis=0)
            error = math.sqrt(max(stated * (1 - stated), 1e-12) / len(own))
            rows.append((low, high, float(stated), float(seen), error, len(own)))
    return rows


def confusion(found):
    """Return how often each true law had which law as the most probable, or several that cannot be told apart."""
    counts = Counter()
    for true, told in found:
        likely = [each.name for each in told.candidates if each.probability > LIKELY]
        counts[true, likely[0] if len(likely) == 1 else "not told apart"] += 1
    return counts


def report(found, spent):
    """Write the page of twins that took the processor time `spent` [s]."""
    count, counts, columns = len(found), confusion(found), [*CASES, "not told apart"]
    kept = [
        any(each.name == true and each.probability > LIKELY for each in told.candidates)
        for true, told in found
    ]
    tables = [
        (
            "True law, and the only one above 5 %",
            [f"In {100 * np.mean(kept):.1f} % of the twins the true law has more than 5 %."],
            ("true law", *columns),
            [(true, *(str(counts[true, name]) for name in columns)) for true in CASES],
        )
    ]
    for words, part in (("noise stated", found[::2]), ("noise not stated", found[1::2]), ("both", found)):
        rows = [
            (f"{low:g} to {high:g}", f"{stated:.3f}", f"{seen:.3f}", f"{error:.3f}", str(number))
            for low, high, stated, seen, error, number in reliability(part)
        ]
        head = ("probability", "stated, mean", "true, share", "counting error", "candidates")
        tables.append((f"Reliability, {words}", [], head, rows))
    write_page(
        "laws.md",
        f"Which law made the recording: {count} twins",
        [
            f"A mean force at {SAMPLES} frequencies. Law and parameters ({', '.join(FREE)}) are drawn from the prior, a factor of"
            f" {REACH:g} to both sides; noise of {1e3 * NOISE:g} mN, every other time not stated; {LIVE} live points.",
            f"{spent / count:.1f} s of processor time for each twin. {surroundings(['numpy', 'scipy', 'dynesty', 'electrovib'])}",
        ],
        tables,
    )


def main() -> None:
    """Weigh the twins, and write the page."""
    begin, count = process_time(), int(sys.argv[1]) if sys.argv[1:] else TWINS
    found = weighed(count)
    report(found, process_time() - begin)


if __name__ == "__main__":
    main()
