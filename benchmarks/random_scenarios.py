"""Run random scenarios of the whole declared space, each in a process of its own with a budget.

    python benchmarks/random_scenarios.py 3000 --first 10000

Prints the share that runs, the share that is refused and by which sentences, and the median and the 99th percentile of
the times. The exit code is 1 if a scenario crashes, does not end, or takes more memory than its budget.
"""

from __future__ import annotations

import argparse
import collections
import contextlib
import multiprocessing.pool
import os
import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "robustness"))

from watched import ALLOWED, HELD, Outcome, outcome_of

import electrovib as ev

WRONG = ("crashed", "endless")
LETTERS = 110


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("count", type=int, help="scenarios")
    parser.add_argument("--first", type=int, default=10_000, help="seed of the first")
    given = parser.parse_args()
    ev.simulate(ev.load("vezzoli_2014/fig6"))  # everything is imported once
    found: list[Outcome] = []
    seeds = range(given.first, given.first + given.count)
    with multiprocessing.pool.ThreadPool(os.cpu_count()) as pool, contextlib.suppress(KeyboardInterrupt):
        for outcome in pool.imap_unordered(outcome_of, seeds):
            found.append(outcome)
            if outcome.what in WRONG or outcome.memory > HELD:
                print(outcome, flush=True)
    report(found)
    sys.exit(any(each.what in WRONG or each.memory > HELD for each in found))


def report(found: list[Outcome]) -> None:
    print(f"{len(found)} scenarios, each allowed {ALLOWED['time']:g} s and {ALLOWED['memory'] / 1e9:g} GB")
    for what, count in collections.Counter(each.what for each in found).most_common():
        times = sorted(each.seconds for each in found if each.what == what)
        middle, late = times[len(times) // 2], times[min(len(times) - 1, int(0.99 * len(times)))]
        held = max(each.memory for each in found if each.what == what)
        print(
            f"{what:8} {count / len(found):6.1%}  median {middle:6.2f} s, 99 % {late:6.2f} s, longest {times[-1]:6.2f} s,"
            f" memory at most {held / 1e6:.0f} MB"
        )
    print()
    reasons = collections.Counter(reason(each) for each in found if each.what not in ("ran", *WRONG))
    for text, count in reasons.most_common():
        print(f"{count / len(found):6.1%}  {text}")


def reason(outcome: Outcome) -> str:
    """Return the first sentence of a refusal, without its numbers and names."""
    text = re.sub(r"\{.*?\}|'.*?'", "~", outcome.said.split("\n")[0])
    return f"{outcome.what}: {re.sub(r'[-+]?[0-9.]+(e[-+]?[0-9]+)?', '#', text)[:LETTERS]}"


if __name__ == "__main__":
    main()
