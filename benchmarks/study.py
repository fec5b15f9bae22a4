"""A study of a population from the command to the store, beside the same job in vectorised numpy; memory; workers.

Run from the root of the repository with ``python -m benchmarks.study``; ``python -m benchmarks.study 20000`` for other
numbers of fingers. Every figure is taken in a process of its own, whose largest resident memory is reported.
"""

import json
import resource
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter

import numpy as np
from benchmarks.population_peers import squares_in_numpy
from benchmarks.table import surroundings, write

SCENARIO, SPACE, SEED = "vezzoli_2014/fig6_gap", "fingers", 1
SAMPLES = 2000
SIZES = (100_000, 1_000_000, 10_000_000)
PEER = 20_000
SLOW = 3000
SHARES = (5, 50, 95)


def scenario(samples=SAMPLES):
    import electrovib as ev

    return ev.load(SCENARIO).replace({"time.samples": samples})


def study(fingers, samples, folder):
    """Time `ev.study` with its store [s]."""
    import electrovib as ev

    experiment = scenario(samples)
    ev.study(experiment, SPACE, n=2048, seed=SEED, output=Path(folder) / "first.zarr")  # imports
    begin = perf_counter()
    found = ev.study(experiment, SPACE, n=fingers, seed=SEED, output=Path(folder) / "study.zarr")
    return {
        "time": perf_counter() - begin,
        "method": found.attrs["method"],
        "kernel": found.attrs["kernel"],
        "percentiles": found.attrs["percentiles_from"],
        "median": float(found.electrostatic_force_percentile[1].max()),
    }


def numpy_job(fingers, samples, folder):
    """Time the same job in vectorised numpy: steps of blocks of fingers, numpy's percentiles, one file [s]."""
    from electrovib.scenario.space import read_space
    from electrovib.solve.population import Population

    experiment = scenario(samples)
    Population(experiment, free=["contact.area"]).signals({"contact.area": np.full(4, 1e-4)})  # imports
    begin = perf_counter()
    space = read_space(experiment, SPACE)
    many = Population(experiment, free=space.paths)
    values = np.empty((fingers, many.time.size), np.float32)
    for start in range(0, fingers, 1024):
        stop = min(start + 1024, fingers)
        values[start:stop] = squares_in_numpy(many, space.draw(SEED, start, stop)).T
    bands = np.percentile(values, SHARES, axis=0)
    np.savez(Path(folder) / "bands.npz", bands=bands, mean=values.mean(axis=0), variance=values.var(axis=0))
    return {"time": perf_counter() - begin, "kernel": "numpy", "median": float(bands[1].max())}


def workers(count, fingers, folder):
    """Time a study whose fingers are solved one by one, with some workers of one thread [s]."""
    import electrovib as ev

    amplifier = {"source_current": "20 uA", "stray_capacitance": "100 pF"}  # fingers are solved one by one
    experiment = ev.load(SCENARIO).replace({"time.samples": 200, "circuit.amplifier": amplifier})
    begin = perf_counter()
    found = ev.study(
        experiment,
        SPACE,
        n=fingers,
        seed=SEED,
        workers=count,
        output=Path(folder) / "w.zarr",
    )
    return {"time": perf_counter() - begin, "method": found.attrs["method"]}


def in_process(what, *arguments):
    """Run one measurement in a process of its own; return its figures, with its peak memory [MB] and whole time [s]."""
    folder = tempfile.mkdtemp()
    begin = perf_counter()
    try:
        done = subprocess.run(
            [sys.executable, "-m", "benchmarks.study", "--measure", what, *map(str, arguments), folder],
            capture_output=True, text=True, check=False,
        )  # fmt: skip
        if done.returncode:
            raise RuntimeError(done.stderr)
        return json.loads(done.stdout.splitlines()[-1]) | {"whole": perf_counter() - begin}
    finally:
        shutil.rmtree(folder)


def measured(what, *arguments):
    """Measure in this process and print the figures."""
    found = {"study": study, "numpy": numpy_job, "workers": workers}[what](
        *map(int, arguments[:-1]), arguments[-1]
    )
    found["memory"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
    print(json.dumps(found))


def row(name, fingers, found):
    seconds, beside = found["time"], found["whole"] - found["time"]
    return [
        name,
        f"{fingers:.0e}",
        f"{seconds:.2f}",
        f"{fingers / seconds:.3g}",
        f"{found['memory']:.0f}",
        f"{beside:.1f}",
    ]


def main(sizes=SIZES):
    rows, found = [], {}
    for fingers in sizes:
        found[fingers] = in_process("study", fingers, SAMPLES)
        rows.append(
            row(
                f"ev.study, percentiles {found[fingers]['percentiles'].partition(' of')[0]}",
                fingers,
                found[fingers],
            )
        )
    peer = in_process("numpy", min(PEER, sizes[0]), SAMPLES)
    same = in_process("study", min(PEER, sizes[0]), SAMPLES)
    rows += [row("ev.study", min(PEER, sizes[0]), same), row("vectorised numpy", min(PEER, sizes[0]), peer)]
    for count in (1, 2):
        rows.append(row(f"one by one, {count} worker(s)", SLOW, in_process("workers", count, SLOW)))
    times = [found[size]["time"] for size in sizes]
    slopes = [(b - a) / (m - k) for a, b, k, m in zip(times, times[1:], sizes, sizes[1:], strict=False)]
    notes = [
        surroundings(["numpy", "zarr", "dask"]),
        f"{SCENARIO}, population `{SPACE}`, {SAMPLES} samples.",
        f"Method: {found[sizes[0]]['method']}; kernel: {found[sizes[0]]['kernel']}.",
        f"Time over fingers between the sizes: {', '.join(f'{1e6 * each:.2f} us' for each in slopes)} each. ev.study is"
        f" {peer['time'] / same['time']:.1f} times as fast as the same job in vectorised numpy; their medians differ by"
        f" {abs(peer['median'] / same['median'] - 1):.1e}.",
    ]
    head = ["what", "fingers", "time [s]", "fingers/s", "peak memory [MB]", "start-up [s]"]
    write("study.md", "A study of a population", notes, head, rows)


if __name__ == "__main__":
    if "--measure" in sys.argv:
        measured(*sys.argv[sys.argv.index("--measure") + 1 :])
    else:
        main(tuple(int(float(each)) for each in sys.argv[1:]) or SIZES)
