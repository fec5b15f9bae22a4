"""First minutes of a new user: the install command of the README in an empty environment, then one task after the other.

Run from the root of the repository with ``python -m benchmarks.first_minutes``; it installs packages from their index.
"""

import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import urllib.request
from pathlib import Path
from time import perf_counter, sleep

from benchmarks.table import surroundings, write

ROOT = Path(__file__).parent.parent
DOCUMENTED = {
    "my.toml": "README.md",
    "sliding.toml": "docs/how_to/my_screen.md",
    "law.py": "docs/how_to/my_paper.md",
}
"""Files that a user copies from a page."""
VOLTAGE = "time [ms],voltage [V]\n0,0\n5,300\n40,300\n45,0\n60,0\n"
MISTAKES = """schema = 1
drive = { model = "Trapezium", high = "1 kg", rise = "36 ms", hold = "100 ms", fall = "36 ms" }
force = { model = "MaxwelStress" }
friction = { model = "Coulomb", coefficent = 0.5 }
contact = { model = "FixedArea", area = "-1 cm2" }
[load]
normal_force = "half"
[circuit]
return_path = { model = "Grounded", resistance = "1 kohm", inductance = 3 }
[stack.insulator]
thickness = "0 um"
material = "silicca"
[stack.stratum_corneum]
thickness = "200 um"
material = { model = "Constant", permittivity = 0.1 }
"""
SKIN = (
    '{ model = "ColeCole", permittivity_high = 4, conductivity = "1 uS/m",'
    ' terms = [{ strength = 1000, relaxation_time = "1 ms", broadening = 0.2 }] }'
)
TASKS = [
    ("first figure", ["electrovib run vezzoli_2014/fig6 -o first.nc --report first.html"], [0]),
    ("own voltage", ['electrovib run vezzoli_2014/fig6 --set drive.high="500 V" -o half.nc'], [0]),
    (
        "own film, from the materials",
        [
            "electrovib list parylene",
            "electrovib run my.toml --set stack.insulator.material=parylene_c -o film.nc",
            "electrovib run my.toml --set stack.insulator.material=parylene_c --set force.model=MaxwellStressInGap -o film.nc",
            "electrovib compare my.toml --materials silica,pet,parylene_c",
        ],
        [0, 2, 0, 0],
    ),
    (
        "own drive from a CSV",
        [
            'electrovib run my.toml --set drive=\'{ model = "Sampled", file = "drive.csv" }\' -o driven.nc --report driven.html'
        ],
        [0],
    ),
    ("two waveforms compared", ["electrovib report first.nc half.nc -o overlay.html"], [0]),
    (
        "map over thickness and frequency",
        [
            'electrovib run my.toml --set drive=\'{ model = "Sine", amplitude = "100 V", frequency = "100 Hz" }\''
            " --over stack.insulator.thickness=1um:100um:10log --over drive.frequency=10Hz:10kHz:10log"
            ' --quantity "mean electrostatic_force" -o map.csv --report map.html'
        ],
        [0],
    ),
    (
        "own force law and own skin",
        [
            'electrovib --models law.py run my.toml --set force.model=Saturating --set stack.gap.thickness="5 um" -o own.nc',
            f"electrovib run my.toml --set stack.stratum_corneum.material='{SKIN}' -o skin.nc",
        ],
        [0, 0],
    ),
    ("every state of gap and attraction", ['electrovib run sliding.toml --states --voltage "100 V"'], [0]),
    ("a mistake in every table of a file", ["electrovib run mistakes.toml"], [2]),
    (
        "a Trace that needs a model which is missing",
        ["mv law.py law_away.py && electrovib run own.nc -o again.nc"],
        [2],
    ),
    ("which preset is nearest to a 3M screen", ["electrovib list scenarios 3M"], [0]),
]
"""What a user wants, what is typed, and the exit code of each command."""


def main() -> None:
    """Install, do every task, open the page, and write the table."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        copy(folder)
        rows = [install(folder)]
        rows += [done(folder, *task) for task in TASKS]
        rows += [notebook(folder), page(folder)]
    write(
        "first_minutes.md", "The first minutes", _notes(), ["task", "time", "typed", "words on screen"], rows
    )


def copy(folder: Path) -> None:
    """Copy what is committed, and the files of the tasks."""
    archive = subprocess.run(["git", "archive", "HEAD"], cwd=ROOT, capture_output=True, check=True).stdout
    subprocess.run(["tar", "-x"], cwd=folder, input=archive, check=True)
    for name, page_ in DOCUMENTED.items():
        text = (folder / page_).read_text(encoding="utf-8")
        (folder / name).write_text(re.search(rf"`{name}`.*?```\w+\n(.*?)```", text, re.DOTALL)[1], "utf-8")
    (folder / "drive.csv").write_text(VOLTAGE, encoding="utf-8")
    (folder / "mistakes.toml").write_text(MISTAKES, encoding="utf-8")


def install(folder: Path) -> list[str]:
    """Run the command of the README that installs and computes the first report."""
    text = (folder / "README.md").read_text(encoding="utf-8")
    command = re.search(r"<!-- install command -->\n```sh\n(.*?)\n```", text, re.DOTALL)[1]
    return done(folder, "install, and the first report", [command], [0])


def done(folder: Path, task: str, commands: list[str], codes: list[int]) -> list[str]:
    """Run the commands of a task; return its row."""
    path = {"PATH": f"{folder / '.venv' / 'bin'}{os.pathsep}{os.environ['PATH']}"}
    plain = {name: value for name, value in os.environ.items() if name not in ("VIRTUAL_ENV", "PYTHONPATH")}
    begin, words = perf_counter(), 0
    for command, code in zip(commands, codes, strict=True):
        found = subprocess.run(
            command, shell=True, cwd=folder, env=plain | path, capture_output=True, text=True, check=False
        )
        said = found.stdout + found.stderr
        if found.returncode != code or "Traceback" in said:
            sys.exit(f"{task}: '{command}' ended with {found.returncode}:\n{said[-3000:]}")
        words += len(said.split())
    typed = "; ".join(f"`{each}`" for each in commands).replace("|", "\\|")
    return [task, f"{perf_counter() - begin:.1f} s", typed, str(words)]


def notebook(folder: Path) -> list[str]:
    """Run the notebook of the examples, from a kernel that is started for it."""
    return done(
        folder,
        "a notebook from load to plot",
        [
            "pip install --quiet nbclient ipykernel",
            "jupyter execute examples/from_load_to_plot.ipynb",
        ],
        [0, 0],
    )


def page(folder: Path) -> list[str]:
    """Install the page in the browser, and wait until it is served."""
    command = "pip install --quiet '.[explore]'"
    begin = perf_counter()
    done(folder, "the page", [command], [0])
    process = subprocess.Popen(
        [folder / ".venv/bin/electrovib", "explore", "my.toml", "--no-browser"],
        cwd=folder,
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        address = re.search(r"http://\S+", process.stdout.readline())[0]
        while not _is_served(address):
            if process.poll() is not None:
                sys.exit("the page: its server has ended")
            sleep(0.05)
    finally:
        took = perf_counter() - begin
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=20)
    return [
        "the page in the browser, served",
        f"{took:.1f} s",
        f"`{command}`; `electrovib explore my.toml`",
        "",
    ]


def _is_served(address: str) -> bool:
    try:
        urllib.request.urlopen(address, timeout=30).close()
    except OSError:
        return False
    return True


def _notes() -> list[str]:
    tried = """Each task begins with what the one before has left, in a copy of what is committed. A wrong input has to end with
exit code 2 and sentences, never with a traceback. The time of an installation depends on the index and its cache."""
    return [tried, surroundings([])]


if __name__ == "__main__":
    if shutil.which("git") is None:
        sys.exit("git is needed to copy what is committed")
    main()
