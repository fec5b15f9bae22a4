"""Words of other commands, of Python and of other tools, and files of another kind: each is answered with what was meant."""

import shlex
import sys
from pathlib import Path

import pytest

import electrovib as ev
from electrovib.apps.cli import main
from electrovib.apps.cli.meant import command_meant, done_by
from electrovib.core.file_kinds import foreign

SINE = "bau_2010/sine"
CONTENTS = {
    "a.xls": b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1rows",
    "a.zip": b"PK\x03\x04rows",
    "a.docx": b"PK\x03\x04rows",
    "a.pdf": b"%PDF-1.7",
    "a.png": b"\x89PNG\r\n\x1a\n123",
    "a.html": b"<html></html>",
    "zipped.dat": b"PK\x03\x04rows",
    "photo.csv": b"\xff\xd8\xff\xe0rows",
    "own.py": b"x = 1\n",
    "m.csv": b"t,u\n" + b"".join(b"%d,%d\n" % (at, at % 7) for at in range(60)),
    "lab.toml": b'time = "t [s]"\n[columns]\ndrive_voltage = "u [V]"\n',
    "space.toml": b'[space]\n"load.normal_force" = { model = "Uniform", low = 0.4, high = 0.6 }\n',
    "points.toml": b'schema = 1\ntitle = "x"\nvalues = [1.0]\nspread = "10 %"\nspread_of = "repeats"\n',
    "limits.toml": b'[limits]\nvoltage = "1 kV"\n',
    "channels.toml": b'clock = "t"\n',
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("sentences")
    for name, content in CONTENTS.items():
        (place / name).write_bytes(content)
    ev.init(SINE, output=place / "ok.toml")
    ev.save(ev.simulate(SINE), place / "t.nc")
    (place / "bench.toml").write_text(
        'schema = 1\n[current_limiter]\nname = "x"\n[generator]\ndriver = "x"\n'
    )
    (place / "st.zarr").mkdir()
    return place


@pytest.fixture
def answer(folder, monkeypatch, capsys):
    """Return a function that runs a command line: its exit code, and what it says."""

    def call(line):
        monkeypatch.chdir(folder)
        monkeypatch.setattr(sys, "argv", ["electrovib", *shlex.split(line)])
        before = sorted(folder.iterdir())
        with pytest.raises(SystemExit) as stop:
            main()
        out, err = capsys.readouterr()
        assert sorted(folder.iterdir()) == before
        return int(stop.value.code or 0), out, err

    return call


STUDY = "study ok.toml --space fingers --seed 1 -o x.zarr"
WORDS = """
# words of Python
simulate ok.toml => electrovib run'
sweep => electrovib run --over PATH=FROM:TO:N'
fit_material => electrovib fit-material
# words of other tools, and of people
Version => electrovib --version'
PLOT t.nc => electrovib report'
scan => electrovib run --over
monte_carlo => electrovib study'
RUN ok.toml => electrovib run
runn => Did you mean 'run'?
reprot => Did you mean 'report'?
zzz => Known: bench, check
bench runn ok.toml => Did you mean 'run'? && 'electrovib bench -h'
# a file in the place of a command
ok.toml => 'electrovib run ok.toml'
t.nc => 'electrovib run t.nc'
bau_2010/sine => 'electrovib run bau_2010/sine'
m.csv => 'electrovib import m.csv'
st.zarr => 'electrovib report st.zarr'
# a scenario without its ending
run ok => 'ok' && but 'ok.toml' is a file
check ok => but 'ok.toml' is a file
init ok => but 'ok.toml' is a file
compare ok => but 'ok.toml' is a file
explore ok => but 'ok.toml' is a file
# options before the command, of other tools, in words of Python
--set drive.amplitude=5 run => '--set' && electrovib COMMAND --set
-o x.nc run => '-o' && electrovib COMMAND -o
-v => --version
-V => --version
run ok.toml --out x.nc => '--out' && takes '--output'
run ok.toml --scan drive.amplitude=1:2:3 => takes '--over'
run ok.toml -f => takes '--force'
run ok.toml --html r.html => takes '--report'
compare ok.toml --law MaxwellStressInGap => takes '--models'
study ok.toml --samples 5 => takes '-n'
study ok.toml --signal lateral_force => takes '--quantity'
import m.csv --crop 1 => no option '--crop' of 'electrovib import'; 'import' takes '--set'
run ok.toml --budget 1 => '--budget' stands before the command: electrovib --budget ... run
check ok.toml --seperately => 'check' has no such option.
fit-material t.csv --gain-error x => takes '--systematic'
find-value ok.toml --maximise x => takes '--want'
run ok.toml --quantities x => takes '--quantity'
study ok.toml -n 4 --seed 1 --space m.csv -o s.zarr => a table of numbers, not a space && 'electrovib import m.csv' reads it
export ok.toml --as x -o w.csv => no such instrument
run ok.toml --outptu x.nc => Did you mean '--output'?
run ok.toml -O x.nc => Did you mean '-o'?
run ok.toml -x => 'electrovib run -h' shows
init ok.toml --report x => '--report' belongs to 'run'
init ok.toml --over x => '--over' && takes '--set'
bench init -o x => 'electrovib bench init' prints && > FILE
find-value want=x => 'want=x' && --want 'x'
drive-for-force ok.toml 'target=sine 5 Hz 1 mN' => --target 'sine 5 Hz 1 mN'
study ok.toml signal=lateral_force => --quantity 'lateral_force'
study ok.toml n=4 => -n '4'
fit ok.toml t.nc free=contact.area => --free 'contact.area'
run ok.toml over=drive.amplitude=1:2:3 => --over
compare ok.toml models=MaxwellStressInGap => --models 'MaxwellStressInGap'
run ok.toml drive.amplitude=5 => --set 'drive.amplitude=5'
run ok.toml --force drive.amplitude=5 => --set 'drive.amplitude=5'
check ok.toml limits.voltage=5 => --set 'limits.voltage=5'
# what a word processor makes of a dash and of quotation marks
run ok.toml —set drive.amplitude=5 => '—set' && --set
run ok.toml –-set drive.amplitude=5 => --set
run ok.toml −−set=drive.amplitude=5 => --set
—version => '—version' && --version
run ok.toml --set 'drive.amplitude=“5 V”' => quotation marks of a word processor
run ok.toml --set 'drive.amplitude = „5 V“' => quotation marks of a word processor
# one argument too many, or too few
run ok.toml ok.toml => 'ok.toml' is one argument too many && electrovib report
run ok.toml --set drive.amplitude 5 => expected PATH=VALUE | '5' is one argument too many
init ok.toml x => 'x' is one argument too many && SCENARIO
bench init ok.toml => 'ok.toml' is one argument too many && no argument
run ok.toml --set => '--set' && 'electrovib run -h'
study => Missing argument 'scenario'. && 'electrovib study -h'
study ok.toml => Missing option '-n'
check ok.toml --all=yes => '--all' does not take a value
# counts and shares
STUDY -n 1,000 => -n = 1,000 && 1000 and as 1
STUDY -n 1.000 => -n = 1.000 && 1000 and as 1
STUDY -n 12,000,000 => 12000000 and as 12
STUDY -n 4.5 => -n = 4.5 && whole number, such as 1000 or 1e3
STUDY -n many => -n = many && whole number
STUDY -n inf => -n = inf && whole number
STUDY -n 4 --percentiles 0.05,0.95 => in per cent; write 5, 95
STUDY -n 4 --percentiles 0.5 => in per cent; write 50
times t.nc --levels 0.1:0.9 => --levels 0.1:0.9 && in per cent; write 10:90
times t.nc --levels 0.2:0.8 => write 20:80
times t.nc --levels 10-90 => such as 10:90
explore --port 80a => --port = 80a && whole number
fit ok.toml t.nc --free contact.area=1um:5um => --free contact.area=1um:5um && --free contact.area; && --set contact.area=1um
fit ok.toml t.nc --free 'contact.area=1 cm2' => --set contact.area=1 cm2
# values within tables
run ok.toml --set 'drive={ model = "Sine", amplitude = 1000 # V }' => '#' begins a comment && amplitude = 1000
run ok.toml --set 'drive={ model = "Sine", amplitude = 1/2 }' => amplitude = "1/2"
run ok.toml --set 'drive={ model = "Sine", amplitude = 100 V }' => amplitude = "100 V"
run ok.toml --set 'drive={ model = "Sine", amplitude = True }' => small letters: amplitude = true
run ok.toml --set force=EffectiveMedum => 'EffectiveMedium' (
run ok.toml --set drive=Trapezium => drive.high | drive: missing
# files of electrovib in the place of another one
run bench.toml => bench.toml: is a bench file, not a scenario && electrovib bench run SCENARIO --bench bench.toml
check bench.toml => is a bench file
explore bench.toml => is a bench file
report bench.toml => is a bench file
bench run bench.toml => is a bench file
run lab.toml => lab.toml: is a recipe && electrovib import FILE --recipe lab.toml
evidence lab.toml => is a recipe, not a measurement
run points.toml => points.toml: is a measurement && electrovib evidence points.toml
run space.toml => space.toml: is a space && electrovib study SCENARIO --space space.toml
run limits.toml => limits.toml: is a file of limits && electrovib check SCENARIO --limits limits.toml
bench run ok.toml --bench ok.toml => ok.toml: is a scenario, not a bench file
evidence ok.toml => ok.toml: is a scenario, not a measurement && electrovib run ok.toml
study ok.toml --space ok.toml -n 2 --seed 1 -o x.zarr => is a scenario, not a space
check ok.toml --limits points.toml => is a measurement, not a file of limits
import m.csv --recipe ok.toml => is a scenario, not a recipe
run st.zarr => st.zarr: is a study store && electrovib report st.zarr
init st.zarr => is a study store
times st.zarr => st.zarr: is a
run none.zarr => 'none.zarr' is neither a file
report none.zarr => 'none.zarr' is neither a file
report none.csv => 'none.csv' is neither a file
times none.zarr => none.zarr: there is no such file
run own.py => own.py: is Python && electrovib --models own.py
import own.py => electrovib --models own.py
import ok.toml => 'electrovib run ok.toml'
run m.csv => m.csv: && 'electrovib import m.csv'
# files of others
run a.xls => a.xls: is a spreadsheet && save it as .csv or .xlsx
import a.xls => a.xls: is a spreadsheet && save it as .csv or .xlsx
fit ok.toml a.xls --free contact.area => is a spreadsheet
import a.zip => a.zip: is an archive; unpack it
run a.zip => is an archive
import zipped.dat => zipped.dat: is an archive
import photo.csv => photo.csv: is a picture
run a.docx => is a document
import a.pdf => is a document
import a.png => a.png: is a picture && .csv
run a.png => is a picture
times a.png => is a picture, not a Trace
import a.html => is a page of the web
import https://example.org/a.csv => is a web address; download
run https://example.org/a.toml => is a web address && download
times http://example.org/t.nc => is a web address; download
evidence https://example.org/a.toml => web address
"""
"""What is typed, and what the answer names: all of what && separates, one of what | separates."""
CASES = [line.split(" => ") for line in WORDS.replace("STUDY", STUDY).splitlines() if " => " in line]


def test_each_is_another_mistake_and_with_the_words_for_commands_they_are_200():
    assert len({line for line, _ in CASES}) == len(CASES) >= 200 - len(done_by())


def test_every_word_for_a_command_is_answered_with_it():
    for word, command in done_by().items():
        assert f"'{word}' is no command; this is done by 'electrovib {command}'" in command_meant(
            word, "electrovib", ()
        )


KINDS = {
    "a spreadsheet": ".xls .ods .xlsb",
    "an archive": ".zip .gz .rar .7z",
    "a document": ".docx .pptx .pdf",
    "a picture": ".png .jpg .gif .svg",
}


@pytest.mark.parametrize("kind", KINDS)
def test_a_file_of_others_is_known_by_its_name(kind):
    for suffix in KINDS[kind].split():
        assert foreign(Path(f"a{suffix}")).startswith(f"is {kind}")


@pytest.mark.parametrize(("line", "words"), CASES, ids=[line for line, _ in CASES])
def test_what_was_meant_is_said(line, words, answer):
    code, out, err = answer(line)
    assert (code, out) == (2, "")
    assert all(each.startswith("electrovib: ") for each in err.splitlines()), err
    assert all(any(one.strip() in err for one in each.split(" | ")) for each in words.split(" && ")), err
    assert "Traceback" not in err


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("help", "Usage: electrovib [OPTIONS] COMMAND"),
        ("help run", "Usage: electrovib run"),
        ("run --version", "numpy "),
        ("run ok.toml --version", "numpy "),
        ("run ok.toml --set force=EffectiveMedium", "electrostatic force"),
        ("compare ok.toml --models ALL", "MaxwellStressInGap"),
        ("check ok.toml --limits bench.toml --set limits.voltage=1", ""),
    ],
)
def test_what_is_clear_is_done(line, words, answer):
    code, out, err = answer(line)
    if words:
        assert (code, err) == (0, "")
    assert words in out


def test_a_count_in_powers_of_ten_is_read(folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    monkeypatch.setattr("electrovib.studies.population.study", lambda *_, n, **__: pytest.fail(f"n is {n}"))
    monkeypatch.setattr(sys, "argv", ["electrovib", *shlex.split(f"{STUDY} -n 1e3")])
    with pytest.raises(pytest.fail.Exception, match="n is 1000"):
        main()
