"""A rough contact beside tamaas (AGPL) and ContactMechanics, oracles and never dependencies: same heights, load and residual.

Run from the root of the repository with ``python -m benchmarks.rough_contact [PYTHON]``, PYTHON being that of an environment that
has both; without one its cells say so.
"""

import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from time import process_time

import numpy as np
from benchmarks.table import surroundings, timed, write

from electrovib.physics.half_space import Elastic
from electrovib.physics.topography import SelfAffine
from electrovib.solve.rough_contact import Loaded, MaxwellStress

PERIOD, MODULUS, REPEATS = 1e-3, 2e6, 3
LOADS = (2e3, 6e4)
BODY = Elastic(modulus=MODULUS * 0.75, poisson=0.5)
BEGIN = """
import sys, time
import numpy as np
heights, period, modulus, load, repeats = np.load(sys.argv[1]), *map(float, sys.argv[2:5]), int(sys.argv[5])
wall, used = [], []
def timed(solve):
    begin, spent = time.perf_counter(), time.process_time()
    found = solve()
    wall.append(time.perf_counter() - begin)
    used.append(time.process_time() - spent)
    return found
"""
PEERS = {
    "tamaas": """
import tamaas as tm
tm.initialize(2)
tm.set_log_level(tm.LogLevel.error)
for _ in range(repeats):
    model = tm.ModelFactory.createModel(tm.model_type.basic_2d, [period] * 2, list(heights.shape))
    model.E, model.nu = modulus, 0.0
    solver = tm.PolonskyKeerRey(model, heights, 1e-6, tm.PolonskyKeerRey.pressure, tm.PolonskyKeerRey.pressure)
    solver.max_iter = 5000
    timed(lambda: solver.solve(load))
print(np.median(wall), np.median(used), np.mean(model.traction > 0))
""",
    "ContactMechanics": """
from ContactMechanics import make_system
from SurfaceTopography import Topography
asked = {"external_force": load * period**2, "pentol": 1e-6 * heights.std(), "maxiter": 5000}
for _ in range(repeats):
    surface = Topography(heights, (period, period), periodic=True)
    system = make_system(substrate="periodic", surface=surface, young=modulus)
    found = timed(lambda: system.minimize_proxy(**asked))
print(np.median(wall), np.median(used), np.mean(found.jac > 0))
""",
}


def loaded(points, load):
    spectrum = SelfAffine(
        rms=5e-6, hurst=0.8, longest=PERIOD, roll_off=PERIOD / 4, shortest=PERIOD * 8 / points
    )
    heights = spectrum.heights((points, points), (PERIOD, PERIOD), seed=1)
    return Loaded(heights=heights, periods=(PERIOD, PERIOD), compliance=BODY.compliance, pressure=load)


def ours(contact, attraction=None):
    used = process_time()
    wall, rest = timed(lambda: contact.rest(attraction), REPEATS)
    return wall, (process_time() - used) / REPEATS, rest


def peer(contact, python, name):
    """Return wall and processor time [s] and contact share of a peer, or None."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "heights.npy"
        np.save(path, contact.heights)
        given = [str(each) for each in (path, PERIOD, MODULUS, contact.pressure, REPEATS)]
        done = subprocess.run(
            [python, "-c", BEGIN + PEERS[name], *given],
            capture_output=True,
            text=True,
            check=False,
            timeout=900,
        )
    return tuple(map(float, done.stdout.split()[-3:])) if done.returncode == 0 else None


def main() -> None:
    """Measure and write the page."""
    python = sys.argv[1] if sys.argv[1:] else sys.executable
    rows = []
    loaded(128, LOADS[0]).rest()  # imports what transforms need
    memory = {}
    for points in (128, 256, 512, 1024, 2048):
        for load in LOADS:
            contact = loaded(points, load)
            wall, used, rest = ours(contact)
            others = [peer(contact, python, name) if points <= 1024 else None for name in PEERS]
            attraction = MaxwellStress(voltage=100.0, electrical_thickness=1e-6)
            pulled_wall, pulled_used, pulled = ours(contact, attraction)
            rows.append(
                (
                    f"{points} x {points}, {load:g} Pa",
                    f"{wall:.3f} ({used:.3f})",
                    *(
                        f"{other[0]:.3f} ({other[1]:.3f}): {other[0] / wall:.1f} ({other[1] / used:.1f})"
                        if other
                        else "not measured"
                        for other in others
                    ),
                    ", ".join(
                        f"{each:.6f}" for each in (rest.contact_share, *(one[2] for one in others if one))
                    ),
                    f"{rest.transforms.exact:.1f} + {rest.transforms.single:.1f}",
                    f"{pulled_wall / wall:.1f} ({pulled_used / used:.1f})",
                    f"{pulled.mean_attraction:.4g}",
                )
            )
        memory[points] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
    largest = ", ".join(f"{each:.0f} MB up to {points} x {points}" for points, each in memory.items())
    write(
        "rough_contact.md",
        "Rough contact beside tamaas and ContactMechanics",
        [
            "Median wall time [s], processor time in parentheses; residual 1e-6: gap weighted with the pressure over the"
            " lowest gap, over the rms height; of ContactMechanics its penetration over the rms height. Two threads each,"
            " ContactMechanics one. Attraction: 100 V across 1 um of electrical thickness, time over that without.",
            f"Largest resident memory of this process: {largest}. Mean load of the machine over the last 15 minutes, this"
            f" benchmark included: {os.getloadavg()[2]:.1f}. {surroundings(['numpy', 'scipy'])}",
        ],
        (
            "grid, load",
            "electrovib",
            *(f"{name}: over electrovib" for name in PEERS),
            "contact shares",
            "transforms, double + single",
            "with attraction",
            "attraction [Pa]",
        ),
        rows,
    )


if __name__ == "__main__":
    main()
