"""Every command, snippet and file of README and of the pages of the documentation that show commands runs as it is shown."""

import importlib
import os
import re
import shlex
import subprocess
import sys
import time
import tomllib
import urllib.error
import urllib.request
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest

import electrovib as ev

ROOT = Path(__file__).parent.parent
README = ROOT / "README.md"
ALL = "docs/how_to/commands.md"
"""The page with one example of every command."""
PAGES = [README, ROOT / "docs" / "tutorial.md", *sorted((ROOT / "docs" / "how_to").glob("*.md"))]
TEXTS = {path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8") for path in PAGES}
BLOCK = re.compile(r"(?P<before>[^\n]*)\n+```(?P<language>\w+)\n(?P<text>.*?)```", re.DOTALL)
NAMED = re.compile(r"`([\w./]+)`:$")
COMMAND = re.compile(r"`(electrovib [^`]+)`")
PLACEHOLDER = re.compile(r"\b[A-Z]{4,}\b(?!_)|^electrovib [\w-]+$")
"""A command with NAME or SCENARIO in it, or a command that is only named."""
RUN_WITHOUT_OPTIONS = {"electrovib compare", "electrovib list scenarios"}


def blocks(text):
    return [match.groupdict() for match in BLOCK.finditer(text)]


def file_of(block):
    name = NAMED.search(block["before"])
    return name[1] if name else ""


def is_marked(block):
    """Whether a block is the marked command that installs, tests or builds the documentation."""
    return block["before"].startswith("<!-- ") and block["language"] == "sh"


def is_whole(command):
    return command in RUN_WITHOUT_OPTIONS or not PLACEHOLDER.search(command)


def commands(text):
    """Commands in lines of text and in blocks, in their order."""

    def shell_lines(match):
        shown = match["text"] if match["language"] == "sh" and not is_marked(match.groupdict()) else ""
        return f"{match['before']}\n{shown}"

    found = []
    for line in BLOCK.sub(shell_lines, text).splitlines():
        found += [line] if line.startswith("electrovib ") else filter(is_whole, COMMAND.findall(line))
    return found


OTHERS = {
    path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8")
    for path in (ROOT / "docs").rglob("*.md")
}


def unnamed(text, language):
    """Blocks of a language that are no file."""
    return [block["text"] for block in blocks(text) if block["language"] == language and not file_of(block)]


FILES = {name: block["text"] for text in TEXTS.values() for block in blocks(text) if (name := file_of(block))}
SNIPPETS = {page: unnamed(text, "python") for page, text in (OTHERS | TEXTS).items()}
"""Of every page of the documentation, those included whose commands are not run here."""
FRAGMENTS = [each for text in TEXTS.values() for each in unnamed(text, "toml") if "schema" not in each]
MARKED = [block["text"].strip() for block in blocks(TEXTS["README.md"]) if is_marked(block)]
SHOWN = {"toml", "python", "csv", "sh", "text"}


TRANSCRIPT = re.compile(
    r"^    \$ (?P<command>electrovib (?:.*\\\n)*.*)\n(?P<shown>(?:    .*\n)*)", re.MULTILINE
)
TRANSCRIPTS = [
    (match["command"].replace("\\\n", " "), match["shown"])
    for text in OTHERS.values()
    for match in TRANSCRIPT.finditer(text)
    if match["shown"]
]
"""Commands with what they print, from every page of the documentation; ``...`` stands for what is not shown."""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Return a folder with the files that the pages show."""
    monkeypatch.chdir(tmp_path)
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path


def typed(words, folder):
    command = [sys.executable, "-m", *words]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=300)


def electrovib(command, folder):
    """Run a command as a user types it."""
    program, *arguments = shlex.split(command)
    assert program == "electrovib"
    if arguments[0] == "explore":
        return served(arguments, folder)
    done = typed(["electrovib", *arguments], folder)
    # how a simulated bench was left is always stated
    other = [line for line in done.stderr.splitlines() if not line.startswith("electrovib: simulated: ")]
    assert (done.returncode, other) == (0, []), f"{command}: {done.stderr}"
    for flag in ("-o", "--report"):
        if flag in arguments:
            assert (folder / arguments[arguments.index(flag) + 1]).exists(), command
    return done.stdout


def served(arguments, folder):
    """Serve the page until it has answered, and return it."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST")}
    command = [sys.executable, "-u", "-m", "electrovib", *arguments, "--no-browser"]
    with subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, text=True, env=kept) as server:
        try:
            address = re.search(r"http://\S+", server.stdout.readline())[0]
            for _ in range(300):
                try:
                    with urllib.request.urlopen(address, timeout=20) as answer:
                        return answer.read().decode()
                except urllib.error.URLError:
                    time.sleep(0.1)
        finally:
            server.terminate()
    raise AssertionError(f"no answer from {address}")


def test_every_block_is_run_by_one_of_these_tests():
    scenarios, tables = (
        {"my.toml", "screen.toml", "sliding.toml"},
        {"skin.csv", "drive.csv", "force.csv", "press.csv", "points.csv"},
    )
    others = {"law.py", "record.py", "bench.toml", "points.toml", "example_2099.py", "pyproject.toml"}
    others |= {"published/example_2099.toml"}
    assert set(FILES) == scenarios | tables | others
    counted = 0
    for page, text in TEXTS.items():
        shown = blocks(text)
        toctrees = text.count("```{toctree}")
        assert len(shown) + toctrees == text.count("```") // 2, page
        assert {block["language"] for block in shown} <= SHOWN, page
        names = [file_of(block) for block in shown if file_of(block)]
        assert len(names) == len(set(names)), page
        counted += len(names)
        for line in "".join(block["text"] for block in shown if block["language"] == "sh").splitlines():
            assert line.startswith("electrovib ") or "install" in line or line == "python record.py", line
    assert counted == len(FILES)
    assert all(commands(text) for page, text in TEXTS.items() if not page.endswith(("index.md", "sweeps.md")))
    assert len(TEXTS["README.md"].split()) <= 600
    known = commands(TEXTS[ALL])
    rows = [line for line in TEXTS[ALL].splitlines() if line.startswith("| `electrovib")]
    assert len(rows) > 10
    assert all(sum(f"`{command}`" in row for command in known) == 1 for row in rows)


def test_a_command_with_a_placeholder_is_not_run():
    text = "`electrovib init NAME -o my.toml` or `electrovib times`, then `electrovib compare` and `electrovib run a.toml`"
    assert commands(text) == ["electrovib compare", "electrovib run a.toml"]
    shown = "as\n\n```sh\nelectrovib run b\nelectrovib run NAME\n```"
    assert commands(shown) == ["electrovib run b", "electrovib run NAME"]
    assert commands("<!-- install -->\n```sh\nelectrovib run b\n```") == []


@pytest.mark.parametrize(
    "page",
    [
        pytest.param(page, marks=pytest.mark.slow if page == "docs/evidence.md" else ())
        for page in sorted(SNIPPETS)
        if SNIPPETS[page]
    ],
)
def test_the_python_blocks_run(page, tmp_path, monkeypatch, capsys):
    mpl.use("Agg")
    monkeypatch.chdir(tmp_path)
    for snippet in SNIPPETS[page]:
        exec(compile(snippet, page, "exec"), {})
    said = capsys.readouterr().out.splitlines()
    for picture in re.findall(r'savefig\("(.*?)"\)', "".join(SNIPPETS[page])):
        assert (tmp_path / picture).stat().st_size > 5000
    if page == "README.md":
        assert said == re.findall(r"\)  # ([\d.]+ mN)$", TEXTS[page], re.MULTILINE)
    if page == ALL:
        assert float(said[0]) == pytest.approx(1.0e-3, rel=0.5)
    if page == "docs/how_to/sweeps.md":
        mean, judged = said
        trace = ev.simulate("bau_2010/sine")  # one period, both ends among its even times
        assert float(mean) == pytest.approx(float(trace.electrostatic_force[:-1].mean()), rel=1e-3)
        assert "insulator" in judged


def test_the_first_scenario_and_its_fragments_run(folder):
    # 2.56 mN at the end of a 36 ms ramp with tau 7.75 ms
    assert float(ev.run(folder / "my.toml").electrostatic_force.max()) == pytest.approx(2.57e-3, rel=1e-2)
    assert FRAGMENTS
    for fragment in FRAGMENTS:
        (folder / "my.toml").write_text(f"{FILES['my.toml']}{fragment}", encoding="utf-8")
        trace = ev.run("my.toml")
        assert "the declared limit (limits.voltage)" in trace.attrs["validity"]


@pytest.mark.slow
def test_the_second_scenario_runs(folder):
    trace = ev.run(folder / "sliding.toml")
    # 300 V over 27 um and a gap of 5 um, which does not leak: eps0 A V^2/(2 (K + g)^2)
    assert float(trace.electrostatic_force.max()) == pytest.approx(38.9e-3, rel=2e-2)
    assert trace.attrs["energy_residual"] < 1e-6


def test_what_installs_and_tests_is_run_as_written_before_a_change_lands():
    script = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    text = TEXTS["README.md"]
    marked = re.findall(r"<!-- (\w+) command -->\n```sh\n(.*?)\n```\n<!-- end -->", text, flags=re.DOTALL)
    assert [name for name, _ in marked] == ["install", "test", "docs"]
    assert [shown for _, shown in marked] == MARKED
    assert all(re.search(rf"readme_(command|text) {name}\b", script) for name, _ in marked)
    # a matter of seconds first
    assert script.index("ruff format --check") < script.index("${test_command##* && }")


@pytest.mark.slow
def test_the_commands_of_the_readme_run_one_after_the_other(folder):
    said = {command: electrovib(command, folder) for command in commands(TEXTS["README.md"])}
    assert len(said) >= 3


def install(folder):
    """Lay the project of `pyproject.toml` down as an installer does, with its entry points in a dist-info folder."""
    project = tomllib.loads(FILES["pyproject.toml"])["project"]
    name, version = project["name"].replace("-", "_"), project["version"]
    about = folder / f"{name}-{version}.dist-info"
    about.mkdir()
    metadata = f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n"
    about.joinpath("METADATA").write_text(metadata, encoding="utf-8")
    groups = [
        "\n".join([f"[{group}]", *(f"{entry} = {module}" for entry, module in entries.items())])
        for group, entries in project["entry-points"].items()
    ]
    about.joinpath("entry_points.txt").write_text("\n".join(groups), encoding="utf-8")


NUMBERS = {
    "docs/how_to/commands.md": {"--states": "4.956 um  "},
    "docs/how_to/my_paper.md": {
        "force.model=Saturating": "electrostatic force: 0 N to 208.2 mN",
        "reproduce": "276.3 mN",
        "list example_2099": "attraction at 500 V [N]: 0.28 within 5 %",
    },
    "docs/how_to/my_screen.md": {"--states": "4.956 um  "},
    "docs/how_to/my_bench.md": {
        "bench.toml --set": "limits, the strictest of scenario and bench: voltage 600 V, current 250 uA",
        " fit ": "friction.coefficient: 0.4999",
        "bench run my.toml": "peak 1 kV at the plate",
    },
}
"""A word of a command of a page, and a number that this command prints."""


@pytest.mark.slow
@pytest.mark.parametrize(
    "page", [page for page in TEXTS if page.startswith("docs/how_to") and commands(TEXTS[page])]
)
def test_the_commands_of_a_guide_run_one_after_the_other(page, folder):
    install(folder)
    said = {command: electrovib(command, folder) for command in commands(TEXTS[page])}
    for word, number in NUMBERS.get(page, {}).items():
        assert any(word in command and number in text for command, text in said.items()), word
    if page == "docs/how_to/my_bench.md":
        with pytest.raises(AssertionError, match=r"above 600 V: limits\.voltage of the bench"):
            electrovib("electrovib bench run my.toml --bench bench.toml", folder)
        steps = np.diff(np.unique(ev.open_trace("played.nc").lateral_force))
        assert steps.min() == pytest.approx(1e-3, rel=1e-6)  # as the page states


@pytest.mark.slow
@pytest.mark.parametrize(("command", "shown"), TRANSCRIPTS)
def test_a_command_prints_what_the_page_shows(command, shown, tmp_path):
    done = typed(shlex.split(command), tmp_path)
    assert done.returncode == ("No value of" in shown), done.stderr
    printed = " ".join(done.stdout.split())
    for line in shown.splitlines():
        for part in line.split("..."):
            assert " ".join(part.split()) in printed, printed


def test_every_transcript_is_found():
    """One command of design.md reads a file of the reader and shows no output."""
    assert sum(text.count("    $ electrovib") for text in OTHERS.values()) == len(TRANSCRIPTS) + 1 >= 7


@pytest.mark.slow
def test_the_tutorial_finds_the_thickness_that_the_recording_was_made_with(folder, monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "_ext"))
    text = TEXTS["docs/tutorial.md"]
    subprocess.run([sys.executable, "record.py"], cwd=folder, check=True, timeout=120)
    (folder / "my.toml").unlink()  # the tutorial writes its own
    said = {command: electrovib(command, folder) for command in commands(text)}
    (shown,) = (block["text"].strip() for block in blocks(text) if block["language"] == "text")
    fit, both = (text for command, text in said.items() if " fit " in command)
    assert fit.splitlines()[0] == shown
    value, low, high = (float(number) for number in re.findall(r"([\d.]+) um", shown))
    assert low < 75 < high
    assert value == pytest.approx(75, abs=0.3)
    computed = importlib.import_module("computed")  # draws the figure of the page
    assert value == pytest.approx(1e6 * computed.FITTED, abs=1e-9)
    table = np.loadtxt("recording.csv", delimiter=",", skiprows=1)
    assert table[:, 2] == pytest.approx(1e3 * computed.recording().recorded, abs=0.51e-4)
    (quarter,) = re.findall(r"attraction, ([\d.]+) mN", text)
    half = float(ev.open_trace("half.nc").electrostatic_force.max())
    assert 1e3 * half == pytest.approx(float(quarter), abs=0.005)
    assert "not determine" in both
