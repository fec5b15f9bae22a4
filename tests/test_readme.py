"""Every command, snippet and file of the README runs, on the very files that it shows."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path

import matplotlib as mpl
import pytest

import electrovib as ev

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCK = re.compile(r"(?P<before>[^\n]*)\n+```(?P<language>\w+)\n(?P<text>.*?)```", re.DOTALL)
NAMED = re.compile(r"`([\w.]+)`:$")
BLOCKS = [match.groupdict() for match in BLOCK.finditer(README)]
FILES = {name[1]: block["text"] for block in BLOCKS if (name := NAMED.search(block["before"]))}
SNIPPETS = [
    block["text"] for block in BLOCKS if block["language"] == "python" and not NAMED.search(block["before"])
]
FRAGMENTS = [
    block["text"] for block in BLOCKS if block["language"] == "toml" and "schema" not in block["text"]
]
SHELL = [block["text"].strip() for block in BLOCKS if block["language"] == "sh"]
COMMANDS = [
    command for command in re.findall(r"`(electrovib [^`]+)`", README) if command != "electrovib report"
]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Return a folder with the files of the README."""
    monkeypatch.chdir(tmp_path)
    for name, text in FILES.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path


def test_every_block_is_run_by_one_of_these_tests():
    assert set(FILES) == {"my.toml", "sliding.toml", "skin.csv", "drive.csv", "law.py"}
    assert len(FILES) + len(SNIPPETS) + len(FRAGMENTS) + len(SHELL) == README.count("```") // 2
    assert len(COMMANDS) > 15
    rows = [line for line in README.splitlines() if line.startswith("| `electrovib")]
    assert len(rows) > 10
    assert all(sum(f"`{command}`" in row for command in COMMANDS) == 1 for row in rows)


def test_the_python_blocks_run(tmp_path, monkeypatch, capsys):
    mpl.use("Agg")
    monkeypatch.chdir(tmp_path)
    assert SNIPPETS
    for snippet in SNIPPETS:
        exec(compile(snippet, "README.md", "exec"), {})
    swing, mean, judged = capsys.readouterr().out.splitlines()
    assert float(swing) == pytest.approx(1.0e-3, rel=0.5)
    trace = ev.simulate("bau_2010/sine")  # one period, both ends among its even times
    assert float(mean) == pytest.approx(float(trace.electrostatic_force[:-1].mean()), rel=1e-3)
    assert "insulator" in judged
    assert (tmp_path / "force.png").stat().st_size > 5000


def test_the_first_scenario_runs(folder):
    # 2.56 mN at the end of a 36 ms ramp with tau 7.75 ms
    assert float(ev.run(folder / "my.toml").electrostatic_force.max()) == pytest.approx(2.57e-3, rel=1e-2)


@pytest.mark.slow
def test_the_second_scenario_runs(folder):
    trace = ev.run(folder / "sliding.toml")
    # 300 V over 27 um and a gap of 5 um, which does not leak: eps0 A V^2/(2 (K + g)^2)
    assert float(trace.electrostatic_force.max()) == pytest.approx(38.9e-3, rel=2e-2)
    assert trace.attrs["energy_residual"] < 1e-6


def test_a_fragment_is_part_of_a_scenario(folder):
    assert FRAGMENTS
    for fragment in FRAGMENTS:
        (folder / "my.toml").write_text(f"{FILES['my.toml']}{fragment}", encoding="utf-8")
        trace = ev.run("my.toml")
        assert "the declared limit (limits.voltage)" in trace.attrs["validity"]


def test_what_installs_and_tests_is_run_as_written_before_a_change_lands():
    script = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    marked = re.findall(r"<!-- (\w+) command -->\n```sh\n(.*?)\n```\n<!-- end -->", README, flags=re.DOTALL)
    assert [text for _, text in marked] == SHELL
    assert all(f"readme_command {name}" in script for name, _ in marked)


@pytest.mark.slow
def test_the_commands_run_one_after_the_other(folder):
    """In the order of the README, each as a user types it: some read what an earlier one has written."""
    said = {}
    for command in COMMANDS:
        program, *arguments = shlex.split(command)
        assert program == "electrovib"
        done = subprocess.run(
            [sys.executable, "-m", "electrovib", *arguments],
            cwd=folder,
            capture_output=True,
            text=True,
            check=False,
            timeout=300,
        )
        assert (done.returncode, done.stderr) == (0, ""), command
        said[command] = done.stdout
        for flag in ("-o", "--report"):
            if flag in arguments:
                assert (folder / arguments[arguments.index(flag) + 1]).exists(), command
    (own,) = (text for command, text in said.items() if "force.model=Saturating" in command)
    assert "electrostatic force: 0 N to 208.2 mN" in own
    (states,) = (text for command, text in said.items() if " equilibrium " in command)
    assert "gap 4.956 um" in states
