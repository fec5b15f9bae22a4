"""The command line as a person uses it: runs, sweeps, repetitions, comparisons, and what is printed of them."""

import html
import json
import re
from pathlib import Path

import numpy as np
import pytest
import xarray

import electrovib as ev
from electrovib.apps.cli.run import _range
from electrovib.core.budget import BudgetError, allowed
from electrovib.core.signals import make_trace
from electrovib.core.units import format_quantity

pytestmark = pytest.mark.usefixtures("blank_pictures")


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def test_main_job_writes_a_trace_and_says_what_came_out(said, here):
    assert "2.562 mN" in said("run -o out.nc")
    assert names(here) == ["out.nc"]
    assert said("run -o out.csv").splitlines()[-1] == "written: out.csv"
    assert names(here) == ["out.csv", "out.nc"]
    assert "peak drive_voltage: 1 kV\n" in said("run --quantity 'peak drive_voltage'")


def chosen(out):
    """Return the line of the values that are not found in the paper of a scenario."""
    lines = [line for line in out.splitlines() if line.startswith("values not from ")]
    assert len(lines) <= 1
    return lines[0] if lines else ""


def test_a_papers_scenario_names_what_its_paper_does_not_give(said):
    """The 36 ms were chosen to give 2.5 mN, and the conductivity is derived from the printed 7.7 ms."""
    line = chosen(said("run"))
    assert line.startswith("values not from vezzoli_2014: drive.rise, drive.hold, ")
    for told in ("friction.coefficient", "return_path.resistance", "conductivity"):
        assert told in line
    for printed in ("drive.high", "contact.area", "permittivity", "thickness", "drive.low"):
        assert printed not in line
    other = chosen(said("run rauf_2025/field_50"))
    assert other.startswith("values not from rauf_2025: friction.coefficient, load.normal_force ('")
    solid = "--set stack.gap.material.conductivity=0"
    surface = '--set \'contact.surface={model="LinearSpring", stiffness="1 GPa/m", free_gap="10 um"}\''
    rough = '--set contact.surface=\'{ model = "FittedSurface", modulus = "20 MPa", rms_height = "5 um", rms_slope = 0.3 }\''
    assert 'force = { model = "Persson2018RoughGap", mean_gap = ' in said(
        f"run bau_2010/sine --states --voltage '40 V' {rough}"
    )
    states = said(f"run vezzoli_2014/fig6_gap --states {solid} {surface}")
    assert "stack.gap.thickness" in chosen(states)


def test_the_states_of_a_gap_are_written_as_any_answer(said, here):
    spring = '{ model = "LinearSpring", stiffness = "1 GPa/m", free_gap = "10 um" }'
    asked = f"run bau_2010/sine --states --voltage '9 V' --set contact.surface='{spring}'"
    for name in ("states.csv", "states.html", "states.txt", "states"):
        assert f"written: {name}" in said(f"{asked} -o {name}")
    assert "4.987 um,1.304 mN,1 cm2,stable" in (here / "states.csv").read_text()
    assert (here / "states/report.html").exists()


def test_what_a_user_sets_or_sweeps_or_writes_is_not_told_as_a_choice_of_ours(said):
    line = chosen(said("run --set 'drive.rise=20 ms' --over drive.hold=10ms:50ms:2"))
    assert "drive.rise" not in line
    assert "drive.hold" not in line
    assert "drive.fall" in line
    said("init vezzoli_2014/fig6 -o own.toml")
    for command in ("own.toml -o out.nc", "out.nc"):
        out = said(f"run {command}")
        assert chosen(out) == ""
        assert "electrostatic force" in out


def test_a_trace_repeats_its_run_and_its_sweep(said):
    said("run --set 'drive.high=500 V' --over drive.rise=5ms:50ms:3log -o a.nc")
    said("run a.nc -o b.nc")
    with xarray.open_dataset("a.nc") as first, xarray.open_dataset("b.nc") as second:
        xarray.testing.assert_equal(first, second)
        np.testing.assert_allclose(first["drive.rise"], np.geomspace(5e-3, 50e-3, 3), rtol=1e-12)


def test_records_of_a_sweep_are_kept_on_request(said):
    said("run --set time.samples=11 --over drive.rise=5ms:50ms:2 --records -o a.nc")
    said("run a.nc -o b.nc")
    with xarray.open_dataset("a.nc") as first, xarray.open_dataset("b.nc") as second:
        assert first["electrostatic_force"].dims == ("drive.rise", "sample")
        xarray.testing.assert_identical(first, second)


def test_numbers_of_a_sweep_as_a_table_and_again(said, here):
    asked = "--quantity 'mean electrostatic force' --quantity 'peak current'"
    printed = said(f"run --over drive.rise=5ms:50ms:3log {asked} -o a.csv")
    assert "(at drive.rise = 5 ms)" in printed
    rows = [line for line in (here / "a.csv").read_text().splitlines() if not line.startswith("#")]
    assert rows[0] == "drive.rise [s],mean electrostatic_force [N],peak current [A]"
    assert len(rows) == 4
    said(f"run --over drive.rise=5ms:50ms:3log {asked} -o a.nc")
    said("run a.nc -o b.csv")
    assert (here / "b.csv").read_text() == (here / "a.csv").read_text()
    ranges = next(line for line in printed.splitlines() if "mean electrostatic_force: " in line)
    first = said("report a.nc -o a.html").splitlines()[0]
    assert "Over the rise of the drive" in (here / "a.html").read_text()
    assert "Mean electrostatic force: " in first
    assert ranges.partition(": ")[2].split(" (")[0] in first


MAP = "run --over stack.insulator.thickness=1um:100um:3log --over drive.high=100:1000:2"


def test_a_map_prints_a_few_lines_with_the_sentences_of_its_report(said):
    """A line for each limit, with the place of the largest value and the number of cases; of what is unknown the names."""
    out = said(f"{MAP} -o map.nc")
    with xarray.open_dataset("map.nc") as trace:
        warnings = [each for each in json.loads(trace.attrs["validity"]) if each["state"] == "warning"]
        peak = format_quantity(float(trace["peak electrostatic_force"].max()), "N", digits=4)
    lines = out.splitlines()
    assert len(lines) < 15
    assert any(line.endswith(f" to {peak} (at 1 um, 1 kV)") for line in lines)
    stated = [line for line in lines if line.startswith("warning: ")]
    assert stated == [f"warning: {each['text']}" for each in warnings]
    assert len(stated) > 1
    assert all(f"warning in {each['cases']} of 6 cases" in each["text"] for each in warnings)
    assert any(line.startswith("not judged: ") and "reaches" not in line for line in lines)
    printed = said("report map.nc -o map.html").splitlines()
    page = html.unescape(Path("map.html").read_text(encoding="utf-8"))
    for line in stated:
        assert line in printed
        assert line.removeprefix("warning: ").split(";")[0].split(",")[0].split(" reaches ")[0] in page


def test_a_scenario_without_a_title_is_called_as_its_file(said, here):
    ev.init(ev.load("vezzoli_2014/fig6").replace({"title": ""}), output="my touchscreen.toml")
    said("run 'my touchscreen.toml' --report out.html")
    assert "<title>my touchscreen</title>" in (here / "out.html").read_text()


def test_init_writes_a_scenario_changed_or_not_and_names_what_can_be_added(said, here):
    text = said("init vezzoli_2014/fig7")
    (here / "again.toml").write_text(text)
    assert ev.load("again.toml") == ev.load("vezzoli_2014/fig7")
    assert "#   finger: one of MassSpringDamper" in text
    assert "#   circuit.amplifier: gain, bandwidth" in text
    assert "#   rig:" not in ev.init("vezzoli_2014/fig2_tremor")
    said("init vezzoli_2014/fig6 --set \"stack.gap={ thickness = '5 um' }\" -o my.toml")
    assert "[stack.gap]" in (here / "my.toml").read_text(encoding="utf-8")
    said("run my.toml --set force.model=MaxwellStressInGap")


def test_changes_may_be_texts_for_the_public_function_too():
    told = ev.run(set=["drive.high=500 V", 'force={ model = "MaxwellStressInGap" }'])
    assert told.equals(ev.run(set={"drive.high": 500, "force": {"model": "MaxwellStressInGap"}}))


def test_version_names_the_parts(said):
    parts = {line.split()[0] for line in said("--version").splitlines()}
    assert parts >= {"electrovib", "python", "numpy", "xarray", "pydantic"}


def test_numbers_of_a_force_are_those_that_a_person_can_use(said):
    computed = xarray.Dataset({"electrostatic_force": ("time", [6e-36, 0.0052])})
    assert _range(computed, "electrostatic_force", {}) == "0 N to 5.2 mN at the output times"
    assert _range(computed + 1e-9, "electrostatic_force", {}) == "1 nN to 5.2 mN at the output times"
    out = said("run bau_2010/sine --set 'drive.amplitude=10 mV'")
    assert re.search(r"^lateral force: 250 mN to 250 mN \(a change of \d[\d.]* nN\)$", out, re.MULTILINE)


def test_a_comparison_prints_the_surfaces_explains_and_writes_a_page(said, here):
    surfaces = said("compare")
    for shown in ("56.55 mN", "607.6 mN", "31.05 N", "(unverified)"):
        assert shown in surfaces
    laws = "--models MaxwellStressInGap,MaxwellStressInStratumCorneum"
    out = said(f"compare vezzoli_2014/fig6_gap {laws} -o page.html")
    assert out.startswith("Believe MaxwellStressInGap here, 564.9 mN at 1 kV: plate and finger separate only")
    assert "permittivity 1560" not in out
    page = (here / "page.html").read_text()
    assert "Step response" in page
    assert "10.74" in page
    asked = f"compare vezzoli_2014/fig6 {laws} --set \"stack.gap={{ thickness = '5 um' }}\""
    out = said(f"{asked} --all --over stack.gap.thickness=1um:9um:3 -o page.html")
    for shown in ("432.5 mN", "permittivity 1560", "Where other papers contradict each other"):
        assert shown in out
    assert "Static force over the thickness of the gap" in (here / "page.html").read_text()


def test_materials_are_compared_in_a_table(said, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    out = said("compare vezzoli_2014/fig6 --materials 'pet, Kapton'")
    recommended, _, table = out.partition("\n\n")
    assert recommended.startswith("Take none yet: no coating is shown to be safe.\n")
    lines = table.splitlines()
    assert lines[0] == "Materials of the layer 'insulator', 90 um thick"
    assert [line.split("  ")[0] for line in lines[3:6]] == ["as it is", "polyimide", "pet"]
    assert "unverified: permittivity, conductivity; full text: strength" in lines[4]


ANSWER = "felt, Pacinian channel: +35.4 dB (+15.3 to +55.5 dB) relative to published detection thresholds"


def test_a_run_says_whether_it_is_felt_and_all_that_this_assumes_on_request(said):
    out = said("run vardar_2017/square -o a.nc")
    title, attraction, friction, felt = out.splitlines()[:4]
    assert title == "Vardar 2017: square, 30 Hz"
    assert (attraction.split(":")[0], friction.split(":")[0]) == ("electrostatic force", "lateral force")
    assert felt == f"{ANSWER} (--all lists assumptions)"
    assert out.count("across 'stratum_corneum' reaches 109 V") == 1
    assert len(out.splitlines()) - out.count("\nwarning: ") - out.count("\nnot judged: ") == 8  # one: written
    (own,) = [line for line in out.splitlines() if line not in said("run a.nc").splitlines()][:-1]
    assert own.startswith("values not from vardar_2017")  # a Trace is a file of one's own
    everything = said("run vardar_2017/square --all")
    assert everything.count("across 'stratum_corneum' reaches 109 V") == everything.count(title) == 1
    lines = everything.splitlines()
    assert ANSWER in lines
    (strongest,) = [line for line in lines if line.startswith("strongest channel Pacinian: -14.3 dB")]
    assert strongest.endswith("; -14.4 to -13.6 dB under other assumptions")
    (assumed,) = [line for line in lines if line.startswith("assumed from publications: a detection")]
    assert "perception.threshold of your own leaves +-12.1 dB" in assumed
    assert assumed.endswith("perception.compliance of your own leaves +-8.0 dB")


def test_every_level_and_assumption_is_printed_on_request(said):
    out = said("run vardar_2017/sine --set 'drive.frequency=125 Hz' --all")
    assert "+0.0 dB relative" in out or "-0.0 dB relative" in out
    for words in (
        "NonPacinian: nothing",  # 250 Hz lies outside its band
        "(cited from memory, unverified)",
        "assumed threshold, Pacinian: 30 nm at 150 Hz, grasped cylinder, tangential, whole hand (second-hand: ",
        "assumed compliance, softest: 323 N/m",
        "channel weights: derived, not measured",
        "left out: summation over time and area, masking",
        "12 dB per octave: an assumption",
        "Sci. Rep. 8, 4555 (2018)",
        "numerical error",
    ):
        assert words in out


OF_ONES_OWN = "felt, Pacinian channel: +6.3 dB (+0.3 to +12.3 dB) relative to the detection threshold"
UNDECIDED = (
    "felt or not: undecided within the spread, Pacinian channel: +2.8 dB (-3.2 to +8.8 dB) relative to"
)
WEAKER = "not felt, Pacinian channel: -13.7 dB (-19.7 to -7.7 dB) relative to the detection threshold"


def test_a_calibrated_person_has_a_threshold_and_a_skin(said):
    threshold = (
        "run vardar_2017/sine --set perception.threshold_uncertainty=6 --set 'perception.threshold={} nm'"
    )
    skin = '--set \'perception.compliance={ model = "ElasticSkin", stiffness = "1 N/mm" }\''
    for size, answer in ((20, OF_ONES_OWN), (30, UNDECIDED), (200, WEAKER)):
        assert said(f"{threshold.format(size)} {skin}").splitlines()[3].startswith(answer)
    out = said(f"{threshold.format(20)} --all")
    assert "a compliance of the skin; perception.compliance of your own leaves +-6.0 dB" in out
    assert "published detection thresholds" not in out


def test_where_nothing_is_felt_or_it_is_not_known_the_reason_is_stated(said, monkeypatch):
    rests = said("run shultz_2018/at_rest").splitlines()
    (line,) = [line for line in rests if line.startswith("felt or not: ")]
    assert line.startswith("felt or not: not known: motion.speed: the finger rests, where its friction is")
    assert "lateral force: not known (the finger rests)" in rests
    still = said("run vardar_2017/sine --set 'drive={ model = \"Step\", level = 0 }'")
    assert "not felt: nothing moves the skin" in still
    assert "felt" not in said("run vardar_2017/sine --over drive.frequency=30Hz:60Hz:2")
    monkeypatch.setattr("electrovib.studies.perceive.perceived", too_long := TooLong())
    line = "felt or not: takes more than 30 s to compute (--all takes that time)"
    assert line in said("run vardar_2017/sine").splitlines()
    assert "felt or not: not known: too long" in said("run vardar_2017/sine --all").splitlines()
    assert too_long.allowed == [30.0, 600.0]


class TooLong:
    """What is felt, which takes longer than is allowed."""

    def __init__(self):
        self.allowed = []

    def __call__(self, *_, diagnostics):
        assert diagnostics == ()  # the run has been judged
        self.allowed.append(allowed().time)
        raise BudgetError("too long")


def test_the_file_of_a_measurement_is_perceived(said, refused):
    time = np.arange(1000) / 1000
    force = 0.3 + 0.1 * np.sin(2 * np.pi * 100 * time)
    ev.save(make_trace({"lateral_force": (("time",), force)}, {"time": time}, {"title": "measured"}), "m.nc")
    assert said("run m.nc").startswith("measured\nfelt, Pacinian channel: +")
    assert "--report: does not belong to a measured Trace" in refused("run m.nc --report m.html")
    assert "evaluated: lateral force" in said("run m.nc --all")
