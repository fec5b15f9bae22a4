"""Output to a terminal: only characters that it can show, and no control characters."""

from __future__ import annotations

import os
import pty
import subprocess
import sys
from pathlib import Path

import pytest

import electrovib as ev
from electrovib.apps.cli import main
from electrovib.core.errors import InputError, nearest, printable, shortened

EVIL = "a\x1b[31mred\x07\nwritten: no\u202efile"
SHOWN = r"a\x1b[31mred\x07\nwritten: no\u202efile"


@pytest.fixture
def cli(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def call(*arguments: str) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["electrovib", *arguments])
        with pytest.raises(SystemExit) as stop:
            main()
        out, err = capsys.readouterr()
        return int(stop.value.code or 0), out, err

    return call


def test_a_title_is_shown_and_not_obeyed(cli):
    changed = ev.load("vezzoli_2014/fig6").model_copy(update={"title": EVIL})
    ev.init(changed, output="evil.toml")
    for everything in ([], ["--all"]):
        code, out, _ = cli("run", "evil.toml", *everything)
        assert code == 0
        assert out.splitlines()[0] == SHOWN
        assert "\x1b" not in out


@pytest.mark.parametrize(
    "line",
    [
        'stack."\\u001b[31mred\\u0007" = 3',
        'drive = "\\u001b[31mred"',
        'drive.model = "\\u001b[31mred"',
        'stack.insulator.thickness = "\\u001b[31mred"',
        'stack.insulator.material.file = "\\u001b[31mred"',
    ],
)
def test_a_mistake_in_a_file_is_quoted_without_its_control_characters(line, cli):
    Path("bad.toml").write_text(f"schema = 1\n{line}\n")
    code, _, err = cli("run", "bad.toml")
    assert code == 2
    assert r"\x1b[31mred" in err
    assert err.replace("\n", "").isprintable()


def test_what_is_long_in_a_file_is_shortened(cli):
    long = "x" * 200_000
    Path("bad.toml").write_text(f'schema = 1\n{long} = 1\ndrive.model = "{long}"\nforce = "{long}"\n')
    code, _, err = cli("run", "bad.toml")
    assert code == 2
    assert max(map(len, err.splitlines())) < 1300
    assert sum("xxx ... xxx" in line for line in err.splitlines()) == 3


def test_many_mistakes_are_counted(cli):
    Path("bad.toml").write_text(
        "schema = 1\n[stack]\n" + "".join(f"k{number} = 1\n" for number in range(3000))
    )
    code, _, err = cli("run", "bad.toml")
    assert code == 2
    lines = err.splitlines()
    assert len(lines) == 51
    assert lines[-1].startswith("electrovib: and 29")
    assert lines[-1].endswith("more mistakes")


def test_printable_keeps_letters_and_shows_the_rest():
    assert printable("größe µm Ω …") == "größe µm Ω …"
    assert printable("a\u00a0b") == "a b"
    assert printable("\x00\x7f\x85\u2028\ufeff\udc80") == r"\x00\x7f\x85\u2028\ufeff\udc80"
    assert InputError(["a\nb"]).problems == (r"a\nb",)


def test_shortened_keeps_both_ends():
    assert shortened("x" * 60, 60) == "x" * 60
    assert shortened("a" * 50 + "b" * 50, 60) == "a" * 35 + " ... " + "b" * 20
    assert len(nearest("y" * 10**6, [f"{number}" * 50 for number in range(5000)])) < 700


PLAIN = {"PYTHONIOENCODING": "ascii"}
COMMANDS = (
    ["--help"],
    ["run", "--help"],
    ["run", "words.toml"],
    ["list"],
    ["list", "vezzoli_2014"],
    ["compare", "words.toml", "--models", "MaxwellStressInGap,MaxwellStressInStratumCorneum"],
    ["run", "words.toml", "--set", "drive.größe=1"],
)


def words(folder: Path) -> Path:
    """Return a scenario with characters that are not ASCII."""
    path = folder / "words.toml"
    changed = ev.load("vezzoli_2014/fig6_gap").model_copy(update={"title": "Größe 5 µm, 3 kΩ – τ ≤ 2 ☃"})
    ev.init(changed, output=path)
    return path


def test_every_command_writes_ascii_where_only_that_is_wanted(tmp_path):
    """All in one process, with an output in ASCII."""
    words(tmp_path)
    code = f"""
import sys
from electrovib.apps.cli import main
for arguments in {COMMANDS!r}:
    sys.argv = ["electrovib", *arguments]
    try:
        main()
    except SystemExit as stop:
        print("code", stop.code, flush=True)
"""
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, check=False, cwd=tmp_path, env=os.environ | PLAIN
    )
    out, err = done.stdout.decode("ascii"), done.stderr.decode("ascii")
    assert "Traceback" not in err
    assert [line for line in out.splitlines() if line.startswith("code")] == [
        *["code 0"] * (len(COMMANDS) - 1),
        "code 2",
    ]
    assert "Grosse 5 um, 3 kohm - tau <= 2 ?" in out
    assert "'grosse'" in err.lower()


def test_a_scenario_printed_as_ascii_reads_back_equal(tmp_path):
    path = words(tmp_path)
    arguments = [sys.executable, "-m", "electrovib", "init", str(path)]
    done = subprocess.run(arguments, capture_output=True, check=True, env=os.environ | PLAIN)
    again = tmp_path / "again.toml"
    again.write_bytes(done.stdout)
    assert again.read_text(encoding="ascii")
    assert ev.load(again) == ev.load(path)
    assert ev.load(again).title == ev.load(path).title


@pytest.mark.parametrize(
    ("name", "value", "ascii_only"), [("LC_ALL", "C", True), ("LC_ALL", "C.UTF-8", False)]
)
def test_the_terminal_of_the_c_locale_gets_ascii(name, value, ascii_only, tmp_path):
    words(tmp_path)
    ours, theirs = pty.openpty()
    kept = {key: text for key, text in os.environ.items() if not key.startswith(("LC_", "LANG", "PYTHONIO"))}
    code = "import sys; from electrovib.apps.cli.terminal import prepare, say; prepare(); say('5 µm')"
    subprocess.run([sys.executable, "-c", code], check=True, stdout=theirs, env=kept | {name: value})
    os.close(theirs)
    shown = os.read(ours, 100).decode().strip()
    os.close(ours)
    assert shown == ("5 um" if ascii_only else "5 µm")


def test_commands_print_through_one_door():
    """What is printed does not end a command that still has files to write."""
    folder = Path(ev.__file__).parent / "apps"
    printing = {path.name for path in folder.rglob("*.py") if "print(" in path.read_text(encoding="utf-8")}
    assert printing == {"terminal.py"}


@pytest.mark.skipif(
    not Path("/dev/full").exists(), reason="a device that is always full is a matter of Linux"
)
@pytest.mark.parametrize(
    ("where", "code", "words"),
    [
        ("2>&-", 0, ""),
        ("1>&- 2>&- <&-", 0, ""),
        ("2>/dev/full", 0, ""),
        (">/dev/full", 4, "the output could not be printed completely: No space left on device"),
        ("| true", 4, "the output could not be printed completely: Broken pipe"),
    ],
)
def test_an_output_that_takes_nothing_costs_no_run(where, code, words, tmp_path):
    """Each file is written, also the one that follows the first printed line, and holds no text of the terminal."""
    study = "-m electrovib study vezzoli_2014/fig6_gap --space fingers -n 2 --seed 1 -o s.zarr -o b.csv"
    script = f'( "{sys.executable}" {study}; echo $? >code ) {where}'
    done = subprocess.run(["sh", "-c", script], capture_output=True, check=False, cwd=tmp_path, text=True)
    assert (tmp_path / "code").read_text() == f"{code}\n"
    assert done.stderr == (f"electrovib: {words}\n" if words else "")
    assert (tmp_path / "b.csv").read_text().startswith("#")


@pytest.mark.skipif(
    not Path("/dev/full").exists(), reason="a device that is always full is a matter of Linux"
)
@pytest.mark.parametrize("arguments", [["--help"], ["run", "--help"], ["init"]])
def test_what_cannot_be_printed_is_told(arguments):
    with Path("/dev/full").open("w") as full:
        command = [sys.executable, "-m", "electrovib", *arguments]
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, check=False, text=True)
    assert done.returncode == 4
    assert done.stderr.count("\n") == 1
    assert "No space left on device" in done.stderr


def test_a_program_without_an_error_output_computes(monkeypatch):
    monkeypatch.setattr(sys, "stderr", None)
    assert ev.run("vezzoli_2014/fig6_gap").attrs["solver"]
