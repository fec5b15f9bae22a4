"""The command line as a person uses it, mistakes included."""

from __future__ import annotations

import html
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray

from electrovib.apps.cli import main
from electrovib.apps.cli.map_lines import judged
from electrovib.core.signals import without
from electrovib.core.trace import make_trace
from electrovib.core.units import format_quantity

GOOD = """
schema = 1
drive = { model = "Trapezium", high = "1 kV", rise = "36 ms", hold = "100 ms", fall = "36 ms" }
force = { model = "Vezzoli2014Causal" }
friction = { model = "Coulomb", coefficient = 0.5 }
contact = { model = "FixedArea", area = "1 cm2" }
[load]
normal_force = "0.5 N"
[circuit]
return_path = { model = "Grounded", resistance = "1 kohm" }
[stack.insulator]
thickness = "90 um"
material = { model = "Constant", permittivity = 3.35 }
[stack.stratum_corneum]
thickness = "200 um"
material = { model = "Constant", permittivity = 1560, conductivity = "1.79 uS/m" }
"""


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return an empty working folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def cli(here, capsys, monkeypatch):
    """Return a function that runs a command in this process: exit code, output and error output."""

    def call(*arguments: str) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["electrovib", *arguments])
        with pytest.raises(SystemExit) as stop:
            main()
        out, err = capsys.readouterr()
        return int(stop.value.code or 0), out, err

    return call


def test_main_job_writes_a_trace_and_says_what_came_out(cli, here):
    code, out, err = cli("run", "-o", "out.nc")
    assert (code, err) == (0, "")
    assert "2.562 mN" in out
    assert sorted(path.name for path in here.iterdir()) == ["out.nc"]


def chosen(out: str) -> str:
    """Return the line of the values that are not found in the paper of a scenario."""
    lines = [line for line in out.splitlines() if line.startswith("values not from ")]
    assert len(lines) <= 1
    return lines[0] if lines else ""


def test_a_papers_scenario_names_what_its_paper_does_not_give(cli):
    """The 36 ms were chosen to give 2.5 mN, and the conductivity is derived from the printed 7.7 ms."""
    line = chosen(cli("run")[1])
    assert line.startswith("values not from vezzoli_2014: drive.rise, drive.hold, ")
    for told in ("friction.coefficient", "return_path.resistance", "conductivity"):
        assert told in line
    for printed in ("drive.high", "contact.area", "permittivity", "thickness", "drive.low"):
        assert printed not in line
    other = chosen(cli("run", "rauf_2025/field_50")[1])
    assert other.startswith("values not from rauf_2025: friction.coefficient, load.normal_force ('")


def test_perceive_and_equilibrium_name_it_too(cli):
    assert "drive.rise" in chosen(cli("run")[1])
    skin = 'perception.compliance={ model = "ElasticSkin", stiffness = "1 kN/m" }'
    line = chosen(cli("run", "--set", "drive.rise=20ms", "--set", skin)[1])
    assert "drive.rise" not in line
    assert "drive.hold" in line
    topography = 'contact.surface={ model = "LinearSpring", stiffness = "1 GPa/m", free_gap = "10 um" }'
    solid = "stack.gap.material.conductivity=0"
    code, out, _ = cli("run", "vezzoli_2014/fig6_gap", "--states", "--set", topography, "--set", solid)
    assert code == 0
    assert "stack.gap.thickness" in chosen(out)


def test_what_a_user_sets_or_sweeps_is_not_told_as_a_choice_of_ours(cli):
    line = chosen(cli("run", "--set", "drive.rise=20 ms", "--over", "drive.hold=10ms:50ms:2")[1])
    assert "drive.rise" not in line
    assert "drive.hold" not in line
    assert "drive.fall" in line


def test_a_scenario_of_ones_own_says_nothing_of_a_paper(cli, here):
    (here / "mine.toml").write_text(GOOD)
    assert cli("init", "vezzoli_2014/fig6", "-o", "from_paper.toml")[0] == 0
    for command in (("mine.toml",), ("from_paper.toml", "-o", "out.nc"), ("out.nc",)):
        code, out, _ = cli("run", *command)
        assert (code, chosen(out)) == (0, "")
        assert "electrostatic force" in out


def test_the_scenario_of_the_design_runs_from_a_file(cli, here):
    (here / "touchscreen.toml").write_text(GOOD)
    code, out, _ = cli("run", "touchscreen.toml", "-o", "out.csv")
    assert code == 0
    assert {path.name for path in here.iterdir()} == {"touchscreen.toml", "out.csv", "out.frequency.csv"}
    assert "electrostatic force" in out


def test_a_trace_repeats_its_run_and_its_sweep(cli):
    assert cli("run", "--set", "drive.high=500 V", "--over", "drive.rise=5ms:50ms:3log", "-o", "a.nc")[0] == 0
    assert cli("run", "a.nc", "-o", "b.nc")[0] == 0
    with xarray.open_dataset("a.nc") as first, xarray.open_dataset("b.nc") as second:
        xarray.testing.assert_equal(first, second)
        np.testing.assert_allclose(first["drive.rise"], np.geomspace(5e-3, 50e-3, 3), rtol=1e-12)


def test_numbers_of_a_sweep_as_a_table_and_again(cli, here):
    asked = ["--quantity", "mean electrostatic force", "--quantity", "peak current"]
    code, out, _ = cli("run", "--over", "drive.rise=5ms:50ms:3log", *asked, "-o", "a.csv")
    assert code == 0
    assert "mean electrostatic_force: " in out
    assert "(at drive.rise = 5 ms)" in out
    printed = out
    rows = [line for line in (here / "a.csv").read_text().splitlines() if not line.startswith("#")]
    assert rows[0] == "drive.rise [s],mean electrostatic_force [N],peak current [A]"
    assert len(rows) == 4
    assert cli("run", "a.csv", "-o", "b.csv")[0] == 0
    assert (here / "b.csv").read_text() == (here / "a.csv").read_text()
    ranges = next(line for line in printed.splitlines() if "mean electrostatic_force: " in line)
    code, out, _ = cli("report", "a.csv", "-o", "a.html")
    assert code == 0
    assert "Over drive.rise" in (here / "a.html").read_text()
    first = out.splitlines()[0]
    assert "Mean electrostatic force: " in first
    assert ranges.partition(": ")[2].split(" (")[0] in first


MAP = ["--over", "stack.insulator.thickness=1um:100um:3log", "--over", "drive.high=100:1000:2"]


def test_a_map_prints_a_few_lines_and_where_the_rest_is(cli):
    """Names of the parameters once; of a limit its name, its largest value with the place, and the number of cases."""
    code, out, _ = cli("run", *MAP, "-o", "map.nc")
    assert code == 0
    with xarray.open_dataset("map.nc") as trace:
        warnings = [each for each in json.loads(trace.attrs["validity"]) if each["state"] == "warning"]
        force = trace["peak electrostatic_force"]
        peak = format_quantity(float(force.max()), "N", digits=4)
    lines = out.splitlines()
    assert len(out.split()) < 200
    assert out.count("stack.insulator.thickness") == 1
    assert any(line.endswith(f" to {peak} (at 1 um, 1 kV)") for line in lines)
    stated = [line for line in lines if line.startswith("warning: ")]
    assert len(stated) == len(warnings) > 1
    for line, each in zip(stated, warnings, strict=True):
        value, limit = (format_quantity(each[name], each["unit"], digits=3) for name in ("value", "limit"))
        assert line.startswith(f"warning: {each['name']} (in {each['cases']} of 6 cases): up to {value} at ")
        assert line.endswith(f", above {limit}")
    assert any(line.startswith("not judged: ") and "reaches" not in line for line in lines)
    assert "reasons and advice: 'electrovib report map.nc'" in lines
    code, out, _ = cli("run", *MAP)
    assert "reasons and advice: the same command with --report map.html" in out.splitlines()
    code, out, _ = cli("report", "map.nc", "-o", "map.html")
    assert code == 0
    page = html.unescape(Path("map.html").read_text(encoding="utf-8"))
    assert all(each["text"].split(";")[0].split(",")[0].split(" reaches ")[0] in page for each in warnings)


def test_a_map_without_a_diagnostic_names_no_other_place(cli):
    code, out, _ = cli("run", *MAP, "--report", "map.html")
    assert code == 0
    assert "reasons and advice: map.html" in out.splitlines()
    trace = make_trace({}, {}, {"validity": "[]", "over": "[]"})
    assert judged(trace, None, None) == []


def test_records_of_a_sweep_are_kept_on_request(cli):
    run = ["run", "--set", "time.samples=11", "--over", "drive.rise=5ms:50ms:2"]
    assert cli(*run, "--records", "-o", "a.nc")[0] == 0
    assert cli("run", "a.nc", "-o", "b.nc")[0] == 0
    with xarray.open_dataset("a.nc") as first, xarray.open_dataset("b.nc") as second:
        assert first["electrostatic_force"].dims == ("drive.rise", "sample")
        xarray.testing.assert_identical(first, second)


def test_numbers_of_one_case(cli):
    code, out, _ = cli("run", "--quantity", "peak drive_voltage")
    assert code == 0
    assert "peak drive_voltage: 1 kV\n" in out


def test_the_report_of_a_scenario_without_a_title_is_named_after_its_file(cli, here):
    (here / "my touchscreen.toml").write_text(GOOD)
    assert cli("run", "my touchscreen.toml", "--report", "out.html")[0] == 0
    assert "<title>my touchscreen</title>" in (here / "out.html").read_text()


def test_init_prints_a_scenario_that_reads_back_equal(cli, here):
    code, out, _ = cli("init", "vezzoli_2014/fig7")
    assert code == 0
    (here / "again.toml").write_text(out)
    from electrovib import load

    assert load("again.toml") == load("vezzoli_2014/fig7")


def test_init_does_not_overwrite(cli, here):
    (here / "mine.toml").write_text("precious")
    code, _, err = cli("init", "-o", "mine.toml")
    assert code == 2
    assert "exists already" in err
    assert (here / "mine.toml").read_text() == "precious"


def test_version_names_the_parts(cli):
    code, out, _ = cli("--version")
    assert code == 0
    assert {line.split()[0] for line in out.splitlines()} >= {
        "electrovib",
        "python",
        "numpy",
        "xarray",
        "pydantic",
    }


TRAPEZIUM = 'model = "Trapezium", high = "1 kV", rise = "36 ms", hold = "100 ms", fall = "36 ms"'

MISTAKES = {
    "unknown key": (GOOD.replace('thickness = "90 um"', 'thicknes = "90 um"'), ["stack.insulator.thicknes", "'thickness'"]),
    "misspelt model": (GOOD.replace("Trapezium", "Trapezum"), ["drive", "'Trapezum'", "Did you mean 'Trapezium' ("]),
    "wrong unit": (GOOD.replace("90 um", "2 V"), ["stack.insulator.thickness = '2 V': expected a length, for instance '90 um'"]),
    "tower of powers": (GOOD.replace("90 um", "9**9**9"), ["stack.insulator.thickness = '9**9**9': expected a length"]),
    "negative thickness": (GOOD.replace("90 um", "-90 um"), ["stack.insulator.thickness", "between 100 pm and 100 mm"]),
    "not a number": (GOOD.replace('"0.5 N"', "nan"), ["load.normal_force = nan", "finite"]),
    "empty file": ("", ["empty", "electrovib init"]),
    "broken TOML": (GOOD + "\n[stack", ["not valid TOML"]),
    "no schema": (GOOD.replace("schema = 1", ""), ["schema = 1"]),
    "table where a number belongs": (GOOD.replace('"90 um"', "{}"), ["stack.insulator.thickness", "expected a length"]),
    "empty stack": (GOOD[: GOOD.index("[stack.insulator]")] + "[stack]\n", ["stack", "layer"]),
    "layer missing for the law": (
        GOOD.replace("[stack.insulator]", "[stack.insulater]"),
        ["stack.insulater.role", "Did you mean 'insulator'?"],
    ),
    "drive file missing": (
        GOOD.replace(TRAPEZIUM, 'model = "Sampled", file = "none.csv"'),
        ["drive", "none.csv"],
    ),
}  # fmt: skip


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_in_a_file_is_told_in_one_line_and_nothing_is_written(mistake, cli, here):
    text, words = MISTAKES[mistake]
    (here / "bad.toml").write_text(text)
    code, out, err = cli("run", "bad.toml", "-o", "out.nc", "--report", "out.html")
    assert code == 2
    assert out == ""
    assert "Traceback" not in err
    assert all(line.startswith("electrovib: ") for line in err.splitlines())
    for word in words:
        assert word in err
    assert {path.name for path in here.iterdir()} == {"bad.toml"}


def test_all_mistakes_of_a_file_are_listed_at_once(cli, here):
    text = (
        GOOD.replace("90 um", "2 V")
        .replace("Trapezium", "Trapezum")
        .replace("1 cm2", "-1 cm2")
        .replace("0.5 N", "x")
    )
    (here / "bad.toml").write_text(text)
    code, _, err = cli("run", "bad.toml")
    assert code == 2
    lines = err.splitlines()
    assert len(lines) == 4
    for path in ("drive", "contact.area", "load.normal_force", "stack.insulator.thickness"):
        assert sum(line.startswith(f"electrovib: {path} =") for line in lines) == 1


DRIVES = {
    "text in a number column": ("time,voltage\n0,0\n1e-3,ten\n2e-3,0\n", ["ten"]),
    "one row": ("time,voltage\n0,0\n", ["row"]),
    "repeated stamp": ("time,voltage\n0,0\n1e-3,1\n1e-3,2\n2e-3,0\n", ["repeats", "KeepIncreasing"]),
    "decreasing stamp": ("time,voltage\n0,0\n2e-3,1\n1e-3,2\n3e-3,0\n", ["goes back", "KeepIncreasing"]),
    "empty": ("", ["empty"]),
    "wrong column": ("t,voltage\n0,0\n1,1\n", ["time"]),
}


@pytest.mark.parametrize("fault", DRIVES)
def test_a_faulty_drive_file_is_told_with_its_place(fault, cli, here):
    content, words = DRIVES[fault]
    (here / "drive.csv").write_text(content)
    text = GOOD.replace(TRAPEZIUM, 'model = "Sampled", file = "drive.csv"')
    (here / "bad.toml").write_text(text)
    code, _, err = cli("run", "bad.toml", "-o", "out.nc")
    assert code == 2
    assert len(err.splitlines()) == 1
    assert err.startswith("electrovib: drive = ")
    for word in words:
        assert word in err
    assert not (here / "out.nc").exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run", "vezzoli_2014/fig5"], ["Did you mean 'vezzoli_2014/fig"]),
        (["run", "vezzoli_2013/fig6"], ["neither a file nor a paper", "vezzoli_2014"]),
        (["run", "missing.toml"], ["missing.toml"]),
        (["run", "--set", "drive.hihg=1"], ["drive.hihg", "Did you mean 'high'?"]),
        (["run", "--set", "drive.high=2 mm"], ["drive.high = '2 mm': expected a voltage"]),
        (["run", "--set", "drive.high"], ["PATH=VALUE"]),
        (["run", "--over", "drive.rise=1ms:2ms"], ["PATH=FROM:TO:N"]),
        (["run", "--over", "drive.rise=0:1ms:5log"], ["above 0"]),
        (["run", "--over", "drive.rise=1V:2V:5"], ["expected a time"]),
        (["run", "--over", "drive.rize=1ms:2ms:5"], ["drive.rise"]),
        (["run", "-o", "nowhere/out.nc"], ["nowhere"]),
        (["run", "-o", "out.xyz"], [".nc, .csv, .mat"]),
        (["run", "--report", "out.pdf"], [".html"]),
        (["run", "--over", "drive.rise=1ms:2ms:3", "--records", "-o", "out.csv"], [".nc"]),
        (["run", "--records"], ["--over"]),
        (["run", "--quantity", "peak curent"], ["Did you mean 'current'?"]),
        (["run", "--set", "force.model=Vezzoli2014PerFrequency"], ["not causal", "Vezzoli2014Causal"]),
        (["report", "missing.nc"], ["missing.nc"]),
        (["reproduce", "vezzoli_2015"], ["vezzoli_2014"]),
        (["init", "vezzoli_2014/figg6"], ["fig6"]),
        (["reproduce", __file__], ["is a file, not a paper"]),
        (["times", "--swipes", "."], [".: is a folder; give the name of a file in it."]),
        (
            ["times", "--swipes", "vezzoli_2014/fig6"],
            ["not from 'vezzoli_2014/fig6'; 'electrovib run' makes one"],
        ),
        (["times", "--swipes", "a.nc", "--trim", "50"], ["trim = 50 %: expected 0 to 40 %"]),
        (
            ["fit", "a.csv", "a.csv", "--column", "x=x", "--column", "y=y"],
            ["a.csv: is given twice; omit one"],
        ),
        (
            ["fit", "a", "b", "--free", "c", "--gain-error", "current=-2 %"],
            ["error of current = -0.02: expected"],
        ),
        (
            ["fit", "a", "b", "--free", "c", "--zero-error", "current=-1 A"],
            ["error of current = -1: expected"],
        ),
        (["fit", "a.csv", "--column", "x=x", "--column", "y=x"], ["both are the column 'x'"]),
    ],
)
def test_a_mistake_in_an_option_is_told_in_one_line(arguments, words, cli, here):
    code, _, err = cli(*arguments)
    assert code == 2
    assert "Traceback" not in err
    for word in words:
        assert word in err
    assert list(here.iterdir()) == []


def test_mistakes_of_file_options_and_outputs_are_told_together(cli, here):
    (here / "bad.toml").write_text(GOOD.replace("90 um", "2 V"))
    code, _, err = cli(
        "run", "bad.toml", "--set", "drive.high", "-o", "nowhere/out.nc", "--report", "out.pdf"
    )
    assert code == 2
    words = ("--set drive.high: expected PATH=VALUE", "stack.insulator.thickness", "'nowhere'", ".html")
    assert [word in line for word, line in zip(words, err.splitlines(), strict=True)] == [True] * 4
    assert {path.name for path in here.iterdir()} == {"bad.toml"}


def test_a_hint_helps_or_is_left_out(cli, here):
    _, _, err = cli("run", "bau_2010/sine", "--set", "drive.frequency=0")
    assert err == "electrovib: drive.frequency = '0': must lie between 1 mHz and 100 MHz\n"
    (here / "rig.toml").touch()
    assert "Did you mean" not in cli("run", "nothing.toml")[2]
    assert "Did you mean" not in cli("times", "nothing.toml")[2]
    assert "Did you mean 'rig.toml'?" in cli("run", "rigg.toml")[2]
    code, _, err = cli("times", "rig.csv", "--recipe", "rig.toml")
    assert code == 2
    (line,) = err.splitlines()
    assert line.startswith("electrovib: rig.toml: ")
    assert all(f"'{name}'" in line for name in ("normal", "lateral", "clock"))


def test_a_column_that_only_its_unit_tells_may_be_a_sensor(cli, here):
    (here / "a.csv").write_text("time (s),CH2 (V)\n" + "".join(f"{at},{at}\n" for at in range(20)))
    assert "if 'CH2' is the output of a sensor" in cli("import", "a.csv")[1]
    (here / "a.csv").write_text((here / "a.csv").read_text().replace("CH2", "voltage"))
    assert "is the output of a sensor" not in cli("import", "a.csv")[1]
    assert (
        "the file does not consist of parts with names; omit it"
        in cli("import", "a.csv", "--set", "part=2")[2]
    )


@pytest.mark.parametrize("signal", ["plate_voltage", "amplifier_current"])
def test_a_signal_behind_an_amplifier_is_named_as_such(signal):
    assert "declare circuit.amplifier, or name the signals to fit" in without(signal, ["current"])


@pytest.mark.parametrize(
    ("option", "first", "second"),
    [
        ("--set", "drive.high=1 V", "drive.high=2 V"),
        ("--over", "drive.rise=1ms:2ms:2", "drive.rise=1ms:3ms:2"),
    ],
)
def test_a_parameter_given_twice_is_refused(option, first, second, cli):
    code, _, err = cli("run", option, first, option, second)
    assert code == 2
    assert err.startswith(f"electrovib: {option} {second}: ")
    assert "twice" in err
    assert len(err.splitlines()) == 1


def test_changes_may_be_texts_for_the_public_function_too():
    from electrovib import run

    told = run(set=["drive.high=500 V", 'force={ model = "MaxwellStressInGap" }'])
    assert told.equals(run(set={"drive.high": 500, "force": {"model": "MaxwellStressInGap"}}))


def test_both_files_of_a_csv_are_named(cli, here):
    _, out, _ = cli("run", "-o", "out.csv")
    assert out.splitlines()[-2:] == ["written: out.csv", "written: out.frequency.csv"]
    assert all((here / name).exists() for name in ("out.csv", "out.frequency.csv"))


def test_an_interrupt_is_told_and_leaves_nothing(cli, here, monkeypatch):
    from electrovib.apps import run as module

    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(module, "simulate", interrupted)
    code, out, err = cli("run", "-o", "out.nc")
    assert (code, out) == (130, "")
    assert err == "electrovib: interrupted, nothing was left half written\n"
    assert list(here.iterdir()) == []


def test_usage_errors_are_one_line_and_code_2():
    result = subprocess.run(
        [sys.executable, "-m", "electrovib", "run", "--nonsense"], capture_output=True, text=True, check=False
    )
    assert result.returncode == 2
    assert "Traceback" not in result.stderr


def test_compare_without_a_scenario_prints_the_surfaces(cli):
    code, out, _ = cli("compare")
    assert code == 0
    for shown in ("56.55 mN", "607.6 mN", "31.05 N", "(unverified)"):
        assert shown in out


def test_compare_explains_and_writes_a_page(cli, here):
    code, out, _ = cli(
        "compare",
        "vezzoli_2014/fig6_gap",
        "--models",
        "MaxwellStressInGap,MaxwellStressInStratumCorneum",
        "-o",
        "page.html",
    )
    assert code == 0
    assert out.startswith(
        "Believe MaxwellStressInGap here, 564.9 mN at 1 kV: plate and finger separate only in the gap"
    )
    assert "permittivity 1560" not in out
    page = (here / "page.html").read_text()
    assert "Step response" in page
    assert "10.74" in page


def test_compare_explains_on_request_and_takes_changes(cli, here):
    gap = "stack.gap={ thickness = '5 um' }"
    options = ["--models", "MaxwellStressInGap,MaxwellStressInStratumCorneum", "--set", gap]
    code, out, _ = cli("compare", "vezzoli_2014/fig6", *options, "--all")
    assert code == 0
    assert "432.5 mN" in out
    assert "permittivity 1560" in out
    assert "Where other papers contradict each other" in out
    over = ["--over", "stack.gap.thickness=1um:9um:3", "-o", "page.html"]
    assert cli("compare", "vezzoli_2014/fig6", *options, *over)[0] == 0
    assert "Static force over stack.gap.thickness" in (here / "page.html").read_text()


def test_models_are_listed_and_shown(cli):
    code, out, _ = cli("list")
    assert code == 0
    for word in ("stack.LAYER.material", "Vezzoli2014Causal", "Unverified", "vezzoli_2014"):
        assert word in out
    code, out, _ = cli("list", "HavriliakNegami")
    assert code == 0
    assert "broadness" in out
    assert "permittivity_high" in out
    code, out, _ = cli("list", "Vezzoli2014Causal", "--bibtex")
    assert out.startswith("@inproceedings{vezzoli_2014,")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["list", "MaxwellStressInGp"], ["no model, material", "Did you mean 'MaxwellStressInGap' ("]),
        (
            ["compare", "vezzoli_2014/fig6", "--models", "MaxwellStressInGp"],
            ["Did you mean 'MaxwellStressInGap' (", "'MaxwellStressInInsulator' ("],
        ),
        (["compare", "vezzoli_2014/fig6", "-o", "page.pdf"], [".html"]),
        (["compare", "nothing.toml"], ["nothing.toml"]),
        (["compare", "-o", "page.html"], ["--output: needs a scenario"]),
        (["compare", "--set", "stack.gap.thickness=5um"], ["--set: needs a scenario"]),
        (["compare", "vezzoli_2014/fig6", "--over", "stack.gap.thickness=1um:9um:3"], ["--set stack.gap='{"]),
        (["compare", "--models", "MaxwellStressInGap"], ["--models: needs a scenario"]),
        (["compare", "vezzoli_2014/fig6", "--models", ","], ["names no force law"]),
        (["compare", "vezzoli_2014/fig6", "--models", "Persson2018RoughGap"], ["mean_gap: missing"]),
    ],
)
def test_mistakes_in_compare_and_models(arguments, words, cli, here):
    code, _, err = cli(*arguments)
    assert code == 2
    assert "Traceback" not in err
    for word in words:
        assert word in err
    assert list(here.iterdir()) == []


def test_init_names_what_can_be_added():
    import electrovib as ev

    text = ev.init("vezzoli_2014/fig6")
    assert "#   finger: one of MassSpringDamper" in text
    assert "#   circuit.amplifier: gain, bandwidth" in text
    assert "#   rig:" not in ev.init("vezzoli_2014/fig2_tremor")


def test_init_writes_a_changed_scenario(cli, here):
    gap = "stack.gap={ thickness = '5 um' }"
    assert cli("init", "vezzoli_2014/fig6", "--set", gap, "-o", "my.toml")[0] == 0
    assert "[stack.gap]" in (here / "my.toml").read_text(encoding="utf-8")
    assert cli("run", "my.toml", "--set", "force.model=MaxwellStressInGap")[0] == 0
