"""The public interface compared with its peers: a measured drive, jittered time stamps, a sine, a short run, a map.

Run from the root of the repository with ``python -m benchmarks.door``. Each figure is a ratio to its peer in the same
process and the same minute; a large drive runs in a process of its own, whose resident memory is reported.
"""

import json
import resource
import subprocess
import sys
from collections.abc import Callable
from time import perf_counter

import numpy as np
from benchmarks.table import surroundings, write

SAMPLES = 1_000_000
STEP = 1e-6
REPEATS = 3
LAWS = {"gap": "vezzoli_2014/fig6_gap", "law of Vezzoli et al. 2014": "vezzoli_2014/fig6"}


def best(work: Callable[[], object], repeats: int = REPEATS) -> float:
    """Return the shortest wall time of several repeats [s]."""
    times = []
    for _ in range(repeats):
        begin = perf_counter()
        work()
        times.append(perf_counter() - begin)
    return min(times)


def lsim(samples: int = SAMPLES) -> Callable[[], object]:
    """Return the work of one output of twelve poles at even samples."""
    from scipy.signal import lsim as peer

    poles = -1.0 / np.logspace(-5, 0, 12)
    gains = 0.9 * np.linspace(1.0, 2.0, 12) / np.linspace(1.0, 2.0, 12).sum()
    system = np.diag(poles), -poles[:, np.newaxis], gains[np.newaxis], np.array([[0.1]])
    stamps = np.arange(samples) * STEP
    return lambda: peer(system, volts(samples), stamps)


def volts(samples: int = SAMPLES) -> np.ndarray:
    """Return a clipped sine of 125 Hz, rounded to three decimals [V]."""
    wave = np.sin(2 * np.pi * 125 * STEP * np.arange(samples))
    return np.round(100 * np.clip(3 * wave, -1, 1), 3)


def stamps(kind: str) -> np.ndarray:
    """Return the time stamps of the samples [s]: decimal numbers, or displaced by up to a fifth of a step."""
    if kind == "decimal":
        return np.arange(SAMPLES) / 1e6  # rounded as float("12e-6") is
    found = np.arange(SAMPLES) * STEP
    found[1:-1] += np.random.default_rng(1).uniform(-0.2, 0.2, SAMPLES - 2) * STEP
    return found


def scenario(law: str, drive: dict[str, object], **more: object) -> object:
    """Return a dispersive skin under a drive."""
    import electrovib as ev
    from electrovib.papers import palmar_1995

    skin = palmar_1995.skins()["dry_men"].material.to_dict()
    changes = {"stack.stratum_corneum.material": skin, "drive": drive} | more
    return ev.load(LAWS[law]).replace(changes)


def large(kind: str, law: str) -> None:
    """Measure one large run in this process, and print times [s] and memory [MB]."""
    import electrovib as ev

    if kind == "sine":
        grid = {"time.duration": 1.0, "time.samples": SAMPLES}
        build = lambda: scenario(law, {"model": "Sine", "amplitude": 100.0, "frequency": 125.0}, **grid)  # noqa: E731
    else:
        record = lambda: {"model": "Sampled", "time_samples": stamps(kind), "voltage_samples": volts()}  # noqa: E731
        build = lambda: scenario(law, record())  # noqa: E731
    built = build()
    first = best(lambda: ev.simulate(built), 1)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    ours = min(best(lambda each=each: ev.simulate(each), 1) for each in [build() for _ in range(REPEATS)])
    print(json.dumps({"first": first, "ours": ours, "memory": memory, "peer": best(lsim())}))


def measured(kind: str, law: str) -> dict[str, float]:
    """Run one large run in a process of its own."""
    command = [sys.executable, "-m", "benchmarks.door", kind, law]
    return json.loads(
        subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()[-1]
    )


def _large_rows() -> list[list[str]]:
    wanted = {"decimal": 20, "jittered": 8, "sine": 10}
    rows = []
    for kind, target in wanted.items():
        for law in LAWS:
            found = measured(kind, law)
            what = f"{SAMPLES} {'output times of a sine' if kind == 'sine' else f'samples, {kind} time stamps'}, {law}"
            ratio = f"{found['peer'] / found['ours']:.3g}"
            times = (
                f"{found['ours'] * 1e3:.3g} (first {found['first'] * 1e3:.3g})",
                f"{found['peer'] * 1e3:.3g}",
            )
            rows.append([what, *times, ratio, f"{target}", f"{found['memory']:.0f}"])
    return rows


def _short_row() -> list[str]:
    import electrovib as ev

    figure = ev.load("vezzoli_2014/fig6")
    ev.simulate(figure)
    time = best(lambda: ev.simulate(figure), 30)
    return ["figure 6 at 2001 times", f"{time * 1e3:.3g}", "", "", "under 8 ms", ""]


def _map_row(side: int = 30) -> list[str]:
    import electrovib as ev

    settled = {"time.initial_state": {"model": "PeriodicState"}}
    base = scenario(
        "law of Vezzoli et al. 2014", {"model": "Sine", "amplitude": 100.0, "frequency": 1e3}, **settled
    )
    over = {
        "stack.insulator.thickness": np.geomspace(1e-6, 1e-4, side),
        "drive.frequency": np.geomspace(10, 1e4, side),
    }
    names = ["mean electrostatic_force", "swing lateral_force", "peak current"]
    together = ev.sweep(base, over, quantity=names)
    ours = best(lambda: ev.sweep(base, over, quantity=names))
    chosen = [(row, column) for row in range(0, side, 6) for column in range(0, side, 6)]
    alone, off = 0.0, 0.0
    for row, column in chosen:
        case = {
            path: values[[place]] for (path, values), place in zip(over.items(), (row, column), strict=True)
        }
        found = ev.sweep(base, case, quantity=names)
        alone += best(lambda case=case: ev.sweep(base, case, quantity=names))
        for name in names:
            value = float(found[name].values[0, 0])
            off = max(off, abs(float(together[name].values[row, column]) / value - 1))
    peer = alone / len(chosen) * side**2
    what = f"map of {side} x {side}, three quantities; largest difference {off:.1e}"
    return [what, f"{ours * 1e3:.4g}", f"{peer * 1e3:.4g}", f"{peer / ours:.3g}", "10", ""]


def _prepared_row(points: int = 1000) -> list[str]:
    import electrovib as ev
    from electrovib.core.paths import value_at

    free = [
        "drive.amplitude",
        "stack.insulator.thickness",
        "stack.stratum_corneum.thickness",
        "contact.area",
        "friction.coefficient",
    ]
    model = ev.prepare("bau_2010/sine", free=free, quantity=["mean electrostatic_force"])
    begin = np.array([value_at(model.base, path) for path in free])
    share = np.random.default_rng(1).uniform(0.8, 1.2, (len(free), points))
    time = best(lambda: model(begin[:, np.newaxis] * share))
    return [f"{points} mean forces over five free parameters", f"{time * 1e3:.4g}", "", "", "under 0.3 s", ""]


def main() -> None:
    """Measure everything and write the table."""
    rows = [*_large_rows(), _short_row(), _map_row(), _prepared_row()]
    head = ["what", "time, ms", "peer, ms", "times faster", "wanted", "resident memory, MB"]
    write("door.md", "The public interface", _notes(), head, rows)


def _notes() -> list[str]:
    setting = """`ev.simulate` with all signals and checks on a dispersive skin (`palmar_1995/dry_men`), by the Maxwell stress in
the gap and by the law of Vezzoli et al. 2014, which filters by relaxations of its own. Peer of a large run: one
`scipy.signal.lsim` of one output with 12 poles on as many even samples, in the same process. Peer of the map: each
case by itself through `ev.sweep`, 25 of the 900 measured."""
    measure = f"""Best of {REPEATS}; the first run of a process, which also fits the material, is given separately. Memory:
largest resident set after the first run, imports and the record itself included."""
    return [setting, measure, surroundings(["numpy", "scipy", "xarray"])]


if __name__ == "__main__":
    if len(sys.argv) > 1:
        large(*sys.argv[1:])
    else:
        main()
