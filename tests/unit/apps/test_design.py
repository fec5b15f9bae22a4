"""``electrovib find-value``, its sisters, and ``electrovib bench``: the answer first, files only within limits, exit codes."""

import json

import numpy as np
import pytest

import electrovib as ev
from electrovib.bench.settings import read_settings

pytestmark = pytest.mark.usefixtures("blank_pictures")

WISH = "mean electrostatic_force = 50 mN"
ASKED = f"find-value bau_2010/sine --want '{WISH}' --free drive.amplitude"


def test_the_answer_comes_first_and_its_files_hold_it(said, here):
    out = said(f"{ASKED} -o found.json")
    assert out.startswith(f"drive.amplitude = 50.8183 V gives {WISH}.\n")
    found = json.loads((here / "found.json").read_text())
    direct = ev.find_value("bau_2010/sine", want=WISH, free="drive.amplitude")
    assert found["value"] == direct.value
    assert found["elasticities"] == {each.path: each.value for each in direct.influences}
    assert found["written_by"].startswith("electrovib design as JSON, checksum ")
    said(f"{ASKED} --set 'contact.area=2 cm2' -o found.toml")
    again = ev.sweep("found.toml", {}, quantity=["mean electrostatic_force"])
    assert again["mean electrostatic_force"].item() == pytest.approx(0.05, rel=1e-9)
    assert ev.load("found.toml").contact.area == 2e-4


def test_what_can_be_played_is_written_within_limits_alone(said, refused, cli, here):
    err = refused(f"{ASKED} --edge line -o drive.csv", silent=False)
    assert "limits.voltage" in err
    assert "limits.current" in err
    low = "--set 'limits.voltage=40 V'"
    for name in ("found.toml", "drive.csv"):
        err = refused(f"{ASKED} {low} --set 'limits.current=1 mA' --edge line -o {name}", silent=False)
        assert "there is no result within the limits that could be written" in err
    code, out, _ = cli(f"{ASKED} {low}")
    assert code == 1
    assert out.startswith(f"No value of drive.amplitude from 0 V to 100 kV gives {WISH} within")
    (here / "own.toml").write_text('limits = { current = "1 mA" }\n')
    out = said(f"{ASKED} --set 'limits.voltage=60 V' --limits own.toml --edge line -o drive.csv")
    assert "written: drive.csv" in out
    assert "Nearest limit: the voltage of the plate reaches 50.8183 V, within 60 V" in out


def test_a_wrong_suffix_is_refused_before_anything_is_computed(refused, monkeypatch):
    monkeypatch.setattr(
        "electrovib.studies.design.value.find_value", lambda *_, **__: pytest.fail("computed")
    )
    forms = ".html, .pdf, .svg, .png, .tex, .txt, .csv, .pwl, .wav, .mat, .npy, .toml, .json"
    assert f"written as {forms}" in refused(f"{ASKED} -o found.xyz")


def test_a_share_and_the_values_for_others(said):
    asked = ASKED.replace("find-value", "value-for-share")
    out = said(f"{asked} --space fingers --share 0.5 -n 20 --seed 2 --all")
    assert "drive.amplitude at which a share of the draws has it: 5 %: " in out
    assert "20 draws, seed 2; the quantity of each: " in out


def test_a_parameter_is_sought_in_a_range_and_the_rest_of_the_answer_is_asked_for(said):
    """Everything of the verdict is in the rest too, in the same words; what it depends on and how are not in the verdict."""
    wanted = "find-value vezzoli_2014/fig6 --want 'peak electrostatic_force = 1 mN'"
    *verdict, more = said(f"{wanted} --free drive.high").splitlines()
    told = [line for line in verdict if not line.startswith("warning: ")]
    everything = said(f"{wanted} --free drive.high --all").splitlines()
    assert told[0].startswith("drive.high = 624.706 V gives peak electrostatic_force = 1 mN")
    assert told[1] == "Other solutions: -624.706 V."
    assert len(told) <= 5
    assert set(verdict) <= set(everything)
    rest = everything[len(verdict) :]
    assert more == f"--all prints {len(rest)} more lines."
    for words in ("Values of drive.high", "Elasticities of drive.high", "The quantity was computed at"):
        assert any(line.startswith(words) for line in everything), words
    narrow = said(f"{wanted} --free 'drive.high = 100 V:700 V'")
    assert narrow.startswith("drive.high = 624.706 V gives")
    assert "Other solutions" not in narrow


def test_what_is_largest_in_a_plate_is_a_wish_within_limits(said, here):
    (here / "limits.toml").write_text('limits = { voltage = "35 V" }\n')
    grid, smallest, largest = "drive.amplitude=20V:40V:2", "mean electrostatic_force", "peak voltage"
    wishes = f"--minimise '{smallest}' --maximise '{largest}' --materials 'silica,PET'"
    out = said(f"plan-plate bau_2010/sine --over {grid} {wishes} --limits limits.toml")
    asked = {"maximise": [largest], "minimise": [smallest], "limits": {"voltage": "35 V"}}
    found = ev.plan_plate("bau_2010/sine", [grid], materials=["silica", "PET"], **asked)
    assert out.splitlines()[: len(found.document.sentences)] == list(found.document.sentences)


GRATING = '{ model = "Grating", period = "1 mm", amplitude = "0.5 mN" }'
DRAWN = f"texture-drive vezzoli_2014/fig6 --texture '{GRATING}' --carrier '3 kHz' --rate '96 kHz'"
HELD = "--set 'limits.voltage=1 kV'"


def test_the_drive_of_a_texture_is_that_of_the_function(said, here):
    out = said(f"{DRAWN} --path '100 mm/s' {HELD} --edge line -o drive.csv")
    asked = {"texture": GRATING, "path": "100 mm/s", "carrier": "3 kHz", "rate": "96 kHz"}
    drive = ev.texture_drive("vezzoli_2014/fig6", **asked, set={"limits.voltage": "1 kV"})
    skipped = 1 + (here / "drive.csv").read_text().count("#")
    written = np.loadtxt("drive.csv", delimiter=",", skiprows=skipped)
    np.testing.assert_array_equal(written, np.stack([drive.times, drive.voltages], axis=-1))
    for words in ("carrier of 3 kHz", drive.misfit_in_words, "largest attraction 4.6", "peak current"):
        assert words in out
    assert out.splitlines()[-1] == "written: drive.csv"


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ("--path '100 mm/s' --edge line -o drive.csv", "limits.voltage"),
        (f"{HELD} --path path.csv --edge line -o path.csv --force", "path.csv"),
        (f"{HELD} --path path.csv --edge line -o drive.gif --force", "drive.gif"),
        (f"{HELD} --path path.csv -o drive.csv", "how the samples follow each other where a CSV is played"),
    ],
)
def test_no_texture_is_written_without_limits_or_over_an_input_or_half_stated(options, words, here, refused):
    (here / "path.csv").write_text("time,x\n0,0\n0.02,0.002\n", encoding="utf-8")
    assert words in refused(f"{DRAWN} {options}", silent=False)


BENCH = "bench run vezzoli_2014/fig6"


def test_without_arm_the_plan_is_printed_and_nothing_is_sent(said, here):
    out = said(f"{BENCH} -o t.nc")
    for words in (
        "hardware that limits the current: safety system of the amplifier",
        "one burst of 272 ms, from 0 V to 0 V, peak 1 kV",
        "nothing was sent",
    ):
        assert words in out
    assert not list(here.iterdir())
    (here / "bench.toml").write_text(said("bench init"), encoding="utf-8")
    assert read_settings(here / "bench.toml") == read_settings()


def test_the_simulated_run_writes_a_trace(cli):
    code, out, err = cli(f"{BENCH} --simulate -o t.nc")
    assert code == 0
    assert err == "electrovib: simulated: the generator is at 0 V; SWITCH THE HIGH VOLTAGE OFF BY HAND\n"
    steps = [line.removeprefix("step: ") for line in out.splitlines() if line.startswith("step: ")]
    order = [steps.index(each) for each in ("read back", "enable", "low-voltage burst", "full burst")]
    assert order == sorted(order)
    assert "written: t.nc" in out
    assert "lateral_force" in ev.open_trace("t.nc")


def test_a_drive_above_the_limit_is_refused(refused):
    err = refused(f"{BENCH} --set drive.high=1200V --simulate -o t.nc")
    assert err.startswith("electrovib: the voltage of the plate reaches 1.2 kV, above 1 kV")
    assert err.count("\n") == 1
