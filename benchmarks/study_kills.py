"""Kill a running study at random times, a hundred times, and compare its store with that of a study that was not killed.

Run from the root of the repository with ``python -m benchmarks.study_kills`` (``... 10`` for ten kills). Each kill is
SIGKILL to the command ``electrovib study``. A study that ends before its kill is begun anew under another seed.
"""

import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

FINGERS, SAMPLES = 60_000, 500
KILLS = 100


def command(path, seed):
    asked = [
        "-n",
        str(FINGERS),
        "--seed",
        str(seed),
        "-o",
        str(path),
        "--exceed",
        "1 mN",
        "--set",
        f"time.samples={SAMPLES}",
    ]
    asked += ["--records"] * (seed % 2)
    return [
        sys.executable,
        "-m",
        "electrovib",
        "study",
        "vezzoli_2014/fig6_gap",
        "--space",
        "fingers",
        *asked,
    ]


def same(one, other):
    """Whether two stores have the same files and the same numbers: sums over fingers are formed tile by tile, to 1e-12."""
    import electrovib as ev

    files = [
        {each.relative_to(folder) for each in folder.rglob("*") if each.is_file()} for folder in (one, other)
    ]
    found, expected = ev.open_study(one), ev.open_study(other)
    return files[0] == files[1] and all(
        np.allclose(found[name], expected[name], rtol=1e-12, atol=0.0, equal_nan=True)
        for name in expected.variables
    )


def quiet(arguments):
    return subprocess.Popen(arguments, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)


def run(arguments):
    with quiet(arguments) as process:
        error = process.communicate()[1]
        assert process.returncode == 0, error


def main(kills=KILLS):
    generator, done, seed = random.Random(1), 0, 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        while done < kills:
            seed += 1
            begin = time.perf_counter()
            run(command(folder / f"whole{seed}.zarr", seed))
            whole = time.perf_counter() - begin
            path, here = folder / f"killed{seed}.zarr", 0
            while done < kills:
                with quiet(command(path, seed)) as process:
                    try:
                        process.wait(generator.uniform(0.0, whole))
                        assert process.returncode == 0, process.stderr.read()
                        break
                    except subprocess.TimeoutExpired:
                        process.kill()
                        done, here = done + 1, here + 1
            run(command(path, seed))
            equal = same(path, folder / f"whole{seed}.zarr")
            print(
                f"seed {seed}: {here} kills, {done} in all; {'the same numbers' if equal else 'DIFFERENT'}",
                flush=True,
            )
            assert equal


if __name__ == "__main__":
    main(*(int(each) for each in sys.argv[1:]))
