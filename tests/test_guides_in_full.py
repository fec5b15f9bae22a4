"""Commands of the pages on single parts in full run one after the other, on files made here in the place of a reader's own."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import typer
from scipy.signal import lfilter

import electrovib as ev
from electrovib.apps.cli import app
from electrovib.physics.relaxation import release_seen_by_sensor

DOCS = Path(__file__).parent.parent / "docs"
COMMAND = re.compile(r"^(?:    )?(electrovib (?:.*\\\n)*.*)$", re.MULTILINE)
INSTRUMENTS = "--arm"
"""Option of a command that needs real instruments."""


def commands(page):
    """Return the commands in the blocks of a page, without comments."""
    text = (DOCS / page).read_text(encoding="utf-8")
    found = [match[1].replace("\\\n", " ") for match in COMMAND.finditer(text)]
    return [one for one in found if INSTRUMENTS not in one]


def run(command, folder):
    """Run a command as a user types it, with its output into a file where it is redirected."""
    words = shlex.split(command, comments=True)
    target = words[words.index(">") + 1] if ">" in words else ""
    words = words[: words.index(">")] if target else words
    typed = [sys.executable, "-m", *words]
    done = subprocess.run(typed, cwd=folder, capture_output=True, text=True, check=False, timeout=300)
    # how a simulated bench was left is always stated
    other = [line for line in done.stderr.splitlines() if not line.startswith("electrovib: simulated: ")]
    assert (done.returncode, other) == (0, []), command
    if target:
        (folder / target).write_text(done.stdout, encoding="utf-8")
    if "-o" in words:
        assert (folder / words[words.index("-o") + 1]).exists(), command
    return done.stdout


def table(file, header, *columns):
    np.savetxt(file, np.column_stack(columns), fmt="%.9g", delimiter=",", header=header, comments="")


def kept(folder, name, columns):
    ev.save(ev.import_file(folder / f"{name}.csv", columns), folder / f"{name}.nc")


def pulses(time):
    """Three pulses of different lengths, 1 within them: edges that repeat with no period."""
    return sum(((time > low) & (time < high)).astype(float) for low, high in ((3, 4), (4.7, 6), (6.9, 7.4)))


def spectrum_of_skin(folder, random):
    """Write the impedance of a layer of skin; return its frequencies and permittivities."""
    frequency = np.geomspace(10, 1e5, 41)
    turn = 2j * np.pi * frequency
    permittivity = 3 + 1500 / (1 + (turn * 1e-3) ** 0.8) + 2e-6 / (turn * 8.854e-12)
    impedance = 200e-6 / (turn * 8.854e-12 * permittivity * 1e-4)
    impedance *= 1 + 0.005 * random.standard_normal(frequency.size)
    header = "frequency [Hz],Z real [ohm],Z imag [ohm]"
    table(folder / "spectrum.csv", header, frequency, impedance.real, impedance.imag)
    table(folder / "spectra.csv", header, *np.tile((frequency, impedance.real, impedance.imag), 2))
    return frequency, permittivity


def of_instruments(folder):
    """Write what the page on files of instruments reads."""
    random = np.random.default_rng(1)
    time = np.arange(0, 9, 1e-3)
    relaxing = lfilter([0.05], [1, -0.95], pulses(time))  # 20 ms, which edges of 1 ms samples show
    noisy = 0.2 + relaxing + 2e-3 * random.standard_normal(time.size)
    table(folder / "scope.csv", "time [s],CH1 [V],Ch2 [V]", time, 5 * pulses(time), noisy)
    late = time + 0.0123
    measured = 0.4 * pulses(late) + 1e-3 * random.standard_normal(time.size)
    table(folder / "force.csv", "time [s],F [N],Sync [V]", time, measured, 5 * pulses(late))
    kept(folder, "force", {"lateral_force_measured": "F [N]", "plate_voltage": "Sync [V]"})
    ev.save(ev.simulate("vezzoli_2014/fig6"), folder / "run.nc")
    fine = np.arange(0, 0.6, 50e-6)
    voltage = np.where((fine > 0.1) & (fine < 0.5) & ((fine * 1000) % 1 < 0.5), 300.0, 2.0)
    shape = release_seen_by_sensor(fine, start=0.5, fall_time=0.1e-3, frequency=350.0, quality=3.0)
    force = 0.05 + 0.7 * shape * np.clip((fine - 0.1) / 0.1, 0, 1) + 2e-3 * random.standard_normal(fine.size)
    table(folder / "clutch.csv", "time [s],U [V],F [N]", fine, voltage, force)
    kept(folder, "clutch", {"drive_voltage": "U [V]", "lateral_force_measured": "F [N]"})
    spectrum_of_skin(folder, random)


def of_fits(folder):
    """Write what the page on fits reads: recordings, spectra and forces over voltage."""
    base = ev.load("vezzoli_2014/fig6_gap")
    (folder / "my.toml").write_text(ev.init("vezzoli_2014/fig6_gap"), encoding="utf-8")
    random = np.random.default_rng(1)
    time = np.arange(0, 0.3, 1e-3)
    for name in "abc":
        trace = ev.simulate(base, time=time)
        force, lateral = (trace[signal].values for signal in ("electrostatic_force", "lateral_force"))
        noise = 2e-4 * random.standard_normal((2, time.size))
        header = "time [s],electrostatic_force [N],lateral_force [N]"
        table(folder / f"{name}_force.csv", header, time, force + noise[0], lateral + noise[1])
        columns = {signal: f"{signal} [N]" for signal in ("electrostatic_force", "lateral_force")}
        ev.save(ev.import_file(folder / f"{name}_force.csv", columns), folder / f"{name}.nc")
    frequency, permittivity = spectrum_of_skin(folder, random)
    header = "frequency [Hz],Z real [ohm],Z imag [ohm]"
    resistor = 51e3 * (1 + 0.002 * random.standard_normal((2, frequency.size)))
    table(folder / "r.csv", header, frequency, resistor[0], resistor[1] - 51e3)
    for name, noise in (("a", 0.01), ("b", 0.02)):
        scatter = 1 + noise * random.standard_normal((2, frequency.size))
        header = "frequency [Hz],permittivity,loss factor"
        values = (permittivity.real * scatter[0], -permittivity.imag * scatter[1])
        table(folder / f"{name}.csv", header, frequency, *values)
    for name, exponent in (("monday", 2.0), ("tuesday", 2.05)):
        voltage = np.linspace(50, 300, 8)
        force = 1e-4 * voltage**exponent * (1 + 0.01 * random.standard_normal(8))
        table(folder / f"{name}.csv", "voltage (V),force (mN)", voltage, force)
    load = np.array([0.1, 0.3, 1.0, 3.0])
    table(folder / "meter.csv", "load (N),C (pF)", load, np.array([255.0, 280.0, 330.0, 420.0]))
    for name, gap in (("light", 3.2e-6), ("middle", 2.4e-6), ("firm", 1.8e-6)):
        pad = ev.simulate(
            ev.load("bau_2010/sine", changes={"stack.gap.thickness": gap}), signals=["impedance"]
        )
        impedance = pad.impedance.values
        header = "frequency [Hz],Z real [ohm],Z imag [ohm]"
        table(folder / f"{name}.csv", header, pad.frequency.values, impedance.real, impedance.imag)
    rough = ev.SelfAffine(rms=2e-6, hurst=0.8, longest=1e-3, roll_off=2.5e-4, shortest=1.25e-4)
    np.save(folder / "map.npy", rough.heights((32, 32), (1e-3, 1e-3), seed=1))


def of_the_bench(folder):
    """Write what the page on the bench reads."""
    (folder / "my.toml").write_text(ev.init("vezzoli_2014/fig6"), encoding="utf-8")


PAGES = {"importing.md": of_instruments, "fitting.md": of_fits, "bench.md": of_the_bench}


BLOCK = re.compile(r"```.*?```|^    [^\n]*$", re.DOTALL | re.MULTILINE)
INLINE = re.compile(r"`((?:electrovib |--|ev\.)[^`]+)`")
PLACEHOLDER = re.compile(r"\b[A-Z]{4,}\b(?!_)")
FIT = "electrovib fit my.toml a.nc --free stack.gap.thickness --quantity electrostatic_force"
MATERIAL = 'electrovib fit-material spectrum.csv --set area="1 cm2" --set thickness="200 um"'
SPECTRA = 'electrovib fit-material spectra.csv --set area="1 cm2" --set thickness="200 um"'
RUN = "electrovib run bau_2010/sine --set drive.amplitude='40 V'"
OPTIONS = {
    "--keep drive": FIT,
    '--gain-error electrostatic_force="2 %"': FIT,
    '--zero-error electrostatic_force="1 mN"': FIT,
    '--systematic "2 %"': MATERIAL,
    '--band "100 Hz..1 MHz"': MATERIAL,
    '--reference r.csv="51 kohm +- 1 %"': MATERIAL,
    '--set part="spectrum 2"': SPECTRA,
    """--set force='{ model = "TabulatedAttraction", file = "predicted.csv" }'""": RUN,
}
"""Options with a value in the running text, and the command that each is appended to."""
CALLS = {
    'ev.Recordings(traces=["a.nc", "b.nc"], noise={"lateral_force": 5e-3})',
    'ev.SpectrumRecipe(area="1 cm2", thickness="200 um")',
    "ev.SpectrumErrors(systematic=0.02)",
    'ev.import_file("scope.csv", {"lateral_force_measured": "Ch2 [V]"}, scale={"lateral_force_measured": "4/9 N/V"})',
    'ev.merge_traces(scope, force, edges="drive_voltage=plate_voltage")',
    'ev.measure_times(trace, quantity="lateral_force_measured", sensor=ev.Sensor(frequency=380.0, quality=3.0))',
}
"""Calls with all their arguments in the running text."""
NOT_IN_FULL = {
    "ev.measure_ring(trace, ...)",
    "ev.measure_rings(trace, ...)",
    "ev.reduce_swipes(record, channels=...)",
    "ev.plan_bench(scenario, bench=...)",
    "ev.run_bench(scenario, bench=..., simulate=True)",
}
"""Calls whose arguments are not all shown."""


def running_text(page):
    """Return the commands, options and calls in the running text of a page, without its blocks."""
    text = BLOCK.sub("", (DOCS / page).read_text(encoding="utf-8"))
    return [" ".join(found.split()) for found in INLINE.findall(text)]


def is_in_full(command):
    """Return whether a command has arguments and no placeholder such as FILE."""
    return len(command.split()) > 2 and not PLACEHOLDER.search(command)


def run_calls(calls, folder, monkeypatch):
    """Run calls on the Traces that the commands of their page have written."""
    monkeypatch.chdir(folder)
    names = {"ev": ev}
    for name, file in (("scope", "scope.nc"), ("force", "force.nc"), ("trace", "measured.nc")):
        if (folder / file).exists():
            names[name] = ev.open_trace(folder / file)
    for call in calls:
        assert eval(call, names) is not None, call


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES)
def test_the_commands_of_a_page_run_one_after_the_other(page, tmp_path, monkeypatch):
    """Those of its blocks, then those of its running text, which name the same files."""
    PAGES[page](tmp_path)
    for command in commands(page):
        run(command, tmp_path)
    shown = running_text(page)
    for command in shown:
        if command.startswith("electrovib ") and is_in_full(command):
            run(command.replace(" -o ", " --force -o "), tmp_path)
    for number, option in enumerate(option for option in shown if option in OPTIONS):
        out = f"option{number}.toml" if OPTIONS[option] in {MATERIAL, SPECTRA} else f"option{number}"
        run(f"{OPTIONS[option]} {option} -o {out}", tmp_path)
    run_calls([call for call in shown if call in CALLS], tmp_path, monkeypatch)


def test_everything_in_the_running_text_is_run_or_has_no_values():
    """An option without a value is one of the command line; a name of a function is a public one."""
    options = set()
    waiting = [typer.main.get_command(app)]
    while waiting:
        command = waiting.pop()
        waiting += getattr(command, "commands", {}).values()
        for parameter in command.params:
            options.update(parameter.opts, parameter.secondary_opts)
    found = [each for page in PAGES for each in running_text(page)]
    for each in found:
        name, *values = each.split(maxsplit=1)
        if each.startswith("--"):
            assert name in options, each
            assert not values or each in OPTIONS or PLACEHOLDER.search(values[0]), each
        elif each.startswith("ev.") and each not in CALLS | NOT_IN_FULL:
            assert callable(getattr(ev, each.removeprefix("ev."))), each
    assert CALLS | NOT_IN_FULL | set(OPTIONS) <= set(found)
    assert sum(each.startswith("electrovib ") and is_in_full(each) for each in found) == 1
    # every page with commands is run here, or by the tests of transcripts and guides
    pages = {path.name for path in DOCS.glob("*.md") if commands(path.name)}
    assert pages - {"design.md", "tutorial.md"} == set(PAGES)
    assert [len(commands(page)) for page in PAGES] == [7, 10, 4]
