"""Output to a terminal: only characters that it can show, no control characters, and what cannot be printed."""

import io
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
LONG = "x" * 200_000
RED = '"\\u001b[31mred"'
KEYS = "".join(f"k{number} = 1\n" for number in range(3000))


def test_a_title_is_shown_and_not_obeyed(said):
    ev.init(ev.load("vezzoli_2014/fig6").model_copy(update={"title": EVIL}), output="evil.toml")
    for everything in ("", "--all"):
        out = said(f"run evil.toml {everything}")
        assert out.splitlines()[0] == SHOWN
        assert "\x1b" not in out


@pytest.mark.parametrize(
    "line",
    [
        f"stack.{RED[:-1]}\\u0007{RED[-1]} = 3",
        f"drive = {RED}",
        f"drive.model = {RED}",
        f"stack.insulator.thickness = {RED}",
        f"stack.insulator.material.file = {RED}",
    ],
)
def test_a_mistake_in_a_file_is_quoted_without_its_control_characters(line, here, refused):
    (here / "bad.toml").write_text(f"schema = 1\n{line}\n")
    err = refused("run bad.toml")
    assert r"\x1b[31mred" in err
    assert err.replace("\n", "").isprintable()


def test_what_is_long_is_shortened_and_many_mistakes_are_counted(here, refused):
    (here / "bad.toml").write_text(f'schema = 1\n{LONG} = 1\ndrive.model = "{LONG}"\nforce = "{LONG}"\n')
    lines = refused("run bad.toml").splitlines()
    assert max(map(len, lines)) < 1300
    assert sum("xxx ... xxx" in line for line in lines) == 3
    (here / "bad.toml").write_text(f"schema = 1\n[stack]\n{KEYS}")
    lines = refused("run bad.toml").splitlines()
    assert len(lines) == 51
    assert lines[-1].startswith("electrovib: and 29")
    assert lines[-1].endswith("more mistakes")


def test_printable_keeps_letters_and_shows_the_rest_and_shortened_keeps_both_ends():
    assert printable("größe µm Ω …") == "größe µm Ω …"
    assert printable("a\u00a0b") == "a b"
    assert printable("\x00\x7f\x85\u2028\ufeff\udc80") == r"\x00\x7f\x85\u2028\ufeff\udc80"
    assert InputError(["a\nb"]).problems == (r"a\nb",)
    assert shortened("x" * 60, 60) == "x" * 60
    assert shortened("a" * 50 + "b" * 50, 60) == "a" * 35 + " ... " + "b" * 20
    assert len(nearest("y" * 10**6, [f"{number}" * 50 for number in range(1000)])) < 700


COMMANDS = (
    "--help",
    "run --help",
    "run words.toml",
    "list",
    "list vezzoli_2014",
    "init words.toml",
    "compare words.toml --models MaxwellStressInGap,MaxwellStressInStratumCorneum",
    "run words.toml --set drive.größe=1",
)


def test_every_command_writes_ascii_where_only_that_is_wanted(here, monkeypatch):
    """A scenario that is printed so reads back equal."""
    titled = ev.load("vezzoli_2014/fig6_gap").model_copy(update={"title": "Größe 5 µm, 3 kΩ – τ ≤ 2 ☃"})
    ev.init(titled, output="words.toml")
    said, codes = {}, []
    for line in COMMANDS:
        for name in ("stdout", "stderr"):
            monkeypatch.setattr(sys, name, io.TextIOWrapper(io.BytesIO(), encoding="ascii"))
        monkeypatch.setattr(sys, "argv", ["electrovib", *line.split()])
        with pytest.raises(SystemExit) as stop:
            main()
        codes.append(stop.value.code or 0)
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
            said[line, stream is sys.stdout] = stream.buffer.getvalue().decode("ascii")
    monkeypatch.undo()
    assert codes == [*[0] * (len(COMMANDS) - 1), 2]
    assert "Grosse 5 um, 3 kohm - tau <= 2 ?" in said["run words.toml", True]
    assert "'grosse'" in said[COMMANDS[-1], False].lower()
    (here / "again.toml").write_text(said["init words.toml", True])
    assert ev.load(here / "again.toml") == ev.load(here / "words.toml")
    assert ev.load(here / "again.toml").title == titled.title


@pytest.mark.parametrize(("value", "expected"), [("C", "5 um"), ("C.UTF-8", "5 µm")])
def test_the_terminal_of_the_c_locale_gets_ascii(value, expected):
    ours, theirs = pty.openpty()
    kept = {key: text for key, text in os.environ.items() if not key.startswith(("LC_", "LANG", "PYTHONIO"))}
    code = "import sys; from electrovib.apps.cli.terminal import prepare, say; prepare(); say('5 µm')"
    subprocess.run([sys.executable, "-c", code], check=True, stdout=theirs, env=kept | {"LC_ALL": value})
    os.close(theirs)
    shown = os.read(ours, 100).decode().strip()
    os.close(ours)
    assert shown == expected


def test_commands_print_through_one_door():
    """What is printed does not end a command that still has files to write."""
    folder = Path(ev.__file__).parent / "apps"
    printing = {path.name for path in folder.rglob("*.py") if "print(" in path.read_text(encoding="utf-8")}
    assert printing == {"terminal.py"}


LINUX = pytest.mark.skipif(
    not Path("/dev/full").exists(), reason="a device that is always full is one of Linux"
)


RUN = "run vezzoli_2014/fig6_gap -o b.csv"
STUDY = "study vezzoli_2014/fig6_gap --space fingers -n 2 --seed 1 -o s.zarr -o b.csv"
"""Its second file follows the first printed line."""


@LINUX
@pytest.mark.parametrize(
    ("line", "where", "code", "words"),
    [
        pytest.param(RUN, "1>&- 2>&- <&-", 0, "", marks=pytest.mark.slow),
        pytest.param(RUN, "2>/dev/full", 0, "", marks=pytest.mark.slow),
        (STUDY, ">/dev/full", 4, "the output could not be printed completely: No space left on device"),
        (RUN, "| true", 4, "the output could not be printed completely: Broken pipe"),
    ],
)
def test_an_output_that_takes_nothing_costs_no_run(line, where, code, words, tmp_path):
    """Each file is written, and holds no text of the terminal."""
    script = f'( "{sys.executable}" -m electrovib {line}; echo $? >code ) {where}'
    done = subprocess.run(["sh", "-c", script], capture_output=True, check=False, cwd=tmp_path, text=True)
    assert (tmp_path / "code").read_text() == f"{code}\n"
    assert done.stderr == (f"electrovib: {words}\n" if words else "")
    assert (tmp_path / "b.csv").read_text().startswith("#")


@LINUX
@pytest.mark.parametrize("line", ["--help", "run --help", "init"])
def test_what_cannot_be_printed_is_told(line):
    with Path("/dev/full").open("w") as full:
        command = [sys.executable, "-m", "electrovib", *line.split()]
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, check=False, text=True)
    assert done.returncode == 4
    assert done.stderr.count("\n") == 1
    assert "No space left on device" in done.stderr


def test_a_mistake_of_usage_has_code_2_and_a_program_without_an_error_output_computes(cli, monkeypatch):
    code, out, err = cli("run one.toml two.toml")
    assert (code, out) == (2, "")
    assert "Traceback" not in err
    monkeypatch.setattr(sys, "stderr", None)
    assert ev.run("vezzoli_2014/fig6_gap").attrs["solver"]
