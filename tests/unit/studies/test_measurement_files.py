"""The file of a measurement, and the table of points that becomes one: numbers, units, folders and every mistake."""

from __future__ import annotations

import os
import re
import tomllib
from pathlib import Path

import pytest
import tomlkit

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.data.marks import Form, is_ours, sign
from electrovib.studies.evidence.files import import_measurement
from electrovib.studies.evidence.measurement import unit_of
from electrovib.studies.evidence.predicted import predict

GAP = {"model": "LogUniform", "low": "1 um", "high": "4 um", "choice": "of this test"}
STEP = {"drive": {"model": "Step", "level": "100 V"}, "time.duration": "1 ms"}
ENTRIES = {
    "title": "made up", "source": "this test", "group": "nobody", "scenario": "vezzoli_2014/fig6_gap", "changes": STEP,
    "quantity": "final electrostatic_force", "over": "drive.level", "spread_of": "repeats",
    "unknown": {"stack.gap.thickness": GAP},
}  # fmt: skip
POINTS = {"values": ["1.1 mN", 0.0042, "9600 uN"], "at": ["50 V", 100, "0.15 kV"], "spread": "10 %"}
TABLE = "voltage (kV),force (mN),sd (uN)\n0.05,1.1,110\n0.1,4.2,840\n0.15,9.6,480\n"
COLUMNS = {"value": "force (mN)", "at": "voltage", "spread": "2"}


@pytest.fixture(autouse=True)
def _here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def written(name="mine.toml", **changes):
    content = {"schema": 1, **ENTRIES, **POINTS, **changes}
    text = tomlkit.dumps({key: each for key, each in content.items() if each is not None})
    Path(name).write_text(text, encoding="utf-8")
    return name


def read(name="mine.toml", **changes):
    (found,) = ev.measurements(written(name, **changes)).values()
    return found


def test_a_file_is_the_measurement_that_it_says():
    found = read(on="pad", note="a trap", made=["EffectiveMedium"], how="printed", status="abstract")
    assert found.values == (1.1e-3, 0.0042, 9600e-6)
    assert found.at == (50.0, 100.0, 150.0)
    assert found.spread == (0.1, 0.1, 0.1)
    assert found.scenario == ev.load("vezzoli_2014/fig6_gap", changes=STEP)
    said = (found.unit, found.group, found.on, found.note, found.made, found.how, found.status, found.judges)
    assert said == ("N", "nobody", "pad", "a trap", ("EffectiveMedium",), "printed", "abstract", "force")
    assert (read().how, read().status) == ("data file", "full text")
    assert read(spread=["10 %", 0.2, "0.96 mN"]).spread == pytest.approx((0.1, 0.2, 0.1))
    assert read(values="3 mN", at="50 V", spread="1.5 mN").spread == (0.5,)
    alone = read(values="3 mN", at=None, over=None)
    assert (alone.values, alone.over, alone.at) == ((3e-3,), "", ())
    stress = read(scale=1e4, unit="Pa", values=["11 Pa", "42 Pa", "96 Pa"])
    assert read(scale="1e4", unit="Pa", values=[1, 2, 3]).scale == 1e4  # as --set gives it
    assert (stress.scale, stress.unit, stress.values) == (1e4, "Pa", (11.0, 42.0, 96.0))


def test_a_quotient_has_the_unit_of_both():
    found = read(per="peak current", values=["1 N/A", "2 N/mA", "3 N/A"])
    assert (found.unit, found.values) == ("N/A", (1.0, 2e3, 3.0))
    for over, unit in (("peak electrostatic_force", "1"), ("rms drive_voltage", "N/V")):
        assert unit_of("mean lateral_force", over, found.scenario) == unit
    assert unit_of("peak drive_voltage", "peak current", found.scenario) == "ohm"
    assert unit_of("mean lateral_force", "mean sliding_speed", found.scenario) == "N s/m"
    assert unit_of("mean electrostatic_force", "mean gross_contact_area", found.scenario) == "Pa"
    with pytest.raises(InputError, match="no unit for N over C/m2"):
        read(per="peak displacement in gap")


def test_distributions_and_what_a_law_replaces_are_read_in_both_spellings():
    table = {"model": "Uniform", "low": 1e-6, "high": 2e-6}
    nested = {"stack": {"gap": False}, "force": {"mean_gap": table, "rms_gap": table}}
    dotted = {"stack.gap": False, "force.mean_gap": table, "force.rms_gap": table}
    for own in (nested, dotted):
        found = read(of_model={"Persson2018RoughGap": own}, unknown={"stack": {"gap": {"thickness": GAP}}})
        assert found.of_model == {
            "Persson2018RoughGap": {"stack.gap": None, "force.mean_gap": table, "force.rms_gap": table}
        }
        assert found.unknown == {"stack.gap.thickness": GAP}
    assert "Persson2018RoughGap" in {each.model for each in predict(found, n=2)[0]}
    assert "Persson2018RoughGap" not in {each.model for each in predict(read(), n=2)[0]}


def test_the_files_that_it_names_lie_beside_it(tmp_path):
    folder = tmp_path / "lab"
    folder.mkdir()
    (folder / "gaps.csv").write_text("gap [um]\n1.5\n2.5\n", encoding="utf-8")
    (folder / "setup.toml").write_text(ev.load("vezzoli_2014/fig6_gap").to_toml(), encoding="utf-8")
    gaps = {"model": "Empirical", "file": "gaps.csv", "column": "gap"}
    found = read("lab/mine.toml", scenario="setup.toml", unknown={"stack.gap.thickness": gaps})
    drawn = predict(found, n=16)[0]
    assert len(set(drawn[0].values[:, 0].tolist())) == 2
    os.chdir(folder)
    assert (
        predict(ev.measurements("mine.toml")["mine"], n=16)[0][0].values.tolist() == drawn[0].values.tolist()
    )


def test_points_become_a_file_that_reads_back_to_the_same_numbers(tmp_path):
    (tmp_path / "points.csv").write_text(TABLE, encoding="utf-8")
    (tmp_path / "setup.toml").write_text(ev.load("vezzoli_2014/fig6_gap").to_toml(), encoding="utf-8")
    (tmp_path / "lab").mkdir()
    imported = import_measurement("points.csv", COLUMNS, folder="lab", **ENTRIES | {"scenario": "setup.toml"})
    assert imported.measurement.values == (0.0011, 0.0042, 0.0096)
    assert imported.measurement.at == (50.0, 100.0, 150.0)
    assert imported.measurement.spread == pytest.approx((0.1, 0.2, 0.05))
    assert imported.lines[2] == "drive.level = 50 V: 1.1 mN, spread 10 %"
    text = imported.to_toml()
    (tmp_path / "lab" / "mine.toml").write_text(text, encoding="utf-8")
    assert ev.measurements("lab/mine.toml") == {"lab/mine": imported.measurement}
    content = tomllib.loads(text)
    assert content["values"] == ["1.1 mN", "4.2 mN", "9.6 mN"]
    assert content["scenario"] == str(Path("..") / "setup.toml")
    assert "3 points of points.csv: values from 'force' [mN]" in text
    sign(tmp_path / "lab" / "mine.toml", Form.MEASUREMENT)
    assert is_ours(tmp_path / "lab" / "mine.toml", Form.MEASUREMENT)
    again = import_measurement("points.csv", COLUMNS, **content | {"scenario": "setup.toml"})
    assert again.measurement == imported.measurement


@pytest.mark.parametrize(
    ("table", "spread"),
    [
        (TABLE.replace("sd (uN)", "sd (%)"), (1.1, 8.4, 4.8)),
        (TABLE.replace("sd (uN)", "sd"), "no unit; write 'sd [%]' for one over the value, or 'sd [N]'"),
        (TABLE.replace("force (mN)", "force"), "no unit; write it behind the name: 'force [N]'"),
        (TABLE.replace("(mN)", "(mV)"), "is in 'mV', but a force is needed"),
        (TABLE.replace("(mN)", "(foo)"), "Did you mean 'force (foo)'?"),
        (TABLE.replace("4.2", "0"), "1 of 3 values are not above 0, the first is 0 N"),
        (TABLE.replace("4.2", "-4.2"), "1 of 3 values are not above 0, the first is -4.2 mN"),
        (TABLE.replace("4.2", ""), "nan is not a finite number"),
        (TABLE.replace(",840", ",0"), "values and spread are positive numbers, unlike 0"),
        (TABLE.replace("0.15", "1e9"), "drive.level"),
    ],
)
def test_units_and_mistakes_of_a_table(table, spread, tmp_path):
    (tmp_path / "points.csv").write_text(table, encoding="utf-8")
    columns = COLUMNS | {"value": "force"}
    if isinstance(spread, str):
        with pytest.raises(InputError, match=re.escape(spread)) as caught:
            import_measurement("points.csv", columns, **ENTRIES)
        assert len(caught.value.problems) == 1
    else:
        assert import_measurement("points.csv", columns, **ENTRIES).measurement.spread == spread


def test_all_that_is_missing_is_said_at_once(tmp_path):
    (tmp_path / "points.csv").write_text(TABLE, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        import_measurement("points.csv", {})
    told = list(map(str, caught.value.problems))
    names = "title source group scenario quantity values spread spread_of over at"
    assert [each.partition(":")[0] for each in told] == names.split()
    assert all("missing, for instance " in each for each in told)
    assert '--column value="force [mN]"' in told[5]
    with pytest.raises(InputError, match=r"columns.vale: no column of a measurement. Did you mean 'value'\?"):
        import_measurement("points.csv", {"vale": "force"})
    (tmp_path / "empty.toml").write_text("schema = 1\n", encoding="utf-8")
    with pytest.raises(InputError) as caught:
        ev.measurements("empty.toml")
    assert [each.path for each in caught.value.problems] == names.split()[:-2]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"over": "drive.levl"}, "over = drive.levl: no physical parameter has this path. Did you mean 'drive.level'?"),
        ({"over": None}, 'over: missing, for instance over = "drive.high"'),
        ({"at": None}, "at: missing"),
        ({"scale": [2], "unit": "N"}, "scale = [[2]]: expected one list of numbers"),
        ({"at": ["50 V", "100 V"]}, "one number for each point; they have 3, 3 and 2"),
        ({"at": ["50 N", 1, 2]}, "at = 50 N: expected a voltage"),
        ({"at": ["1 GV", 1, 2]}, "drive.level = 1000000000.0"),
        ({"quantity": "final electrostatic_forces"}, "Did you mean 'electrostatic_force'?"),
        ({"unit": "V"}, "unit = 'V': final electrostatic_force is in N; give the values in it, or scale"),
        ({"unit": "mN"}, "unit = 'mN': expected 'N', because"),
        ({"unit": "foo"}, "unit = 'foo': expected a unit."),
        ({"scale": 2.0}, "unit: missing beside scale"),
        ({"values": ["1 V", 1, 2]}, "values = 1 V: expected a force"),
        ({"values": [0, 1, 2]}, "positive numbers, unlike 0"),
        ({"values": [-1.0, 1, 2]}, "positive numbers, unlike -1"),
        ({"values": [float("nan"), 1, 2]}, "expected a finite number"),
        ({"values": [True, 1, 2]}, "values = True: expected"),
        ({"spread": 0}, "positive numbers, unlike 0"),
        ({"spread": "5 V"}, "spread = 5 V: expected a force"),
        ({"scenario": "vezzoli_2014/fig66"}, "has no scenario 'fig66'"),
        ({"scenario": "none.toml"}, "none.toml: No such file"),
        ({"changes": {"time.durations": 1}}, "changes.time.durations: unknown parameter"),
        ({"unknown": {"stack.gap.thicknes": GAP}}, "unknown.stack.gap.thicknes: no physical parameter"),
        ({"unknown": {"stack.gap.thickness": 1e9}}, "unknown.stack.gap.thickness: "),
        ({"judges": "forc"}, "judges = 'forc': the set-up has no model there"),
        ({"judges": "drive.level"}, "judges = 'drive.level': the set-up has no model there"),
        ({"made": ["EffectiveMediums"]}, "EffectiveMediums: no model of force. Did you mean 'EffectiveMedium'?"),
        ({"of_model": {"Persson": {"stack.gap": False}}}, "Persson: no model of force."),
        ({"of_model": {"Persson2018RoughGap": 3}}, "of_model.Persson2018RoughGap: expected MODEL.PATH"),
        ({"how": "heard"}, "how = 'heard': one of printed"),
        ({"status": "derived"}, "neither derived nor cited from memory"),
        ({"titel": "x"}, "titel: no entry of a measurement. Did you mean 'title'?"),
        ({"title": 3}, "title = 3: expected a text"),
        ({"scale": "big", "unit": "N"}, "scale = big: expected a plain number"),
        ({"made": "EffectiveMedium"}, "made = 'EffectiveMedium': expected a list of names"),
        ({"schema": 2}, "schema = 2: this version reads"),
        ({"values": [[1.0], 1, 2]}, "values = [[1.0], 1, 2]: expected one list of numbers"),
        ({"spread": [[], 1, 2]}, "spread = [[]]: expected one list of numbers"),
        ({"made": [["a"]]}, "['a']: no model of force."),
        ({"scenario": "a" * 300}, "is neither a file nor a paper's scenario"),
        ({"unknown": {"stack.gap.thickness": {"model": ["a"]}}}, "unknown.stack.gap.thickness: expected a table"),
        (
            {"unknown": {"stack.gap.thickness": GAP | {"high": [1]}}},
            "unknown.stack.gap.thickness: expected numbers, not lists",
        ),
    ],
)  # fmt: skip
def test_each_mistake_is_one_sentence(changes, words):
    with pytest.raises(InputError, match=re.escape(words)) as caught:
        read(**changes)
    assert len(caught.value.problems) == 1


def test_two_values_need_what_was_varied():
    with pytest.raises(InputError) as caught:
        read(values=["1 mN", "2 mN"], over=None, at=None)
    assert [each.path for each in caught.value.problems] == ["over", "at"]


def test_mistakes_of_several_parts_are_told_together():
    with pytest.raises(InputError) as caught:
        read(values=["1 V", 2, 3], at=["1 N", 2, 3], unknown={"stack.gap.thicknes": GAP})
    assert [each.path for each in caught.value.problems] == ["values", "at", "unknown.stack.gap.thicknes"]


def test_a_file_is_judged_alone_or_beside_others():
    found = ev.evidence(written(), n=4)
    assert list(found.measured) == ["mine"]
    assert found.of("mine")[0].score > -20
    beside = ev.evidence(["mine.toml", "rauf_2025/voltage"], n=4)
    assert list(beside.measured) == ["mine", "rauf_2025/voltage"]
    assert beside.of("mine")[0].score == found.of("mine")[0].score
    with pytest.raises(InputError, match=r"nofile\.toml: No such file"):
        ev.evidence("nofile.toml")


def test_what_no_law_predicts_is_refused_with_the_reason_or_said_beside_the_others():
    gap = written(quantity="final gap", values=["1 um", "2 um", "3 um"])
    with pytest.raises(
        InputError, match=r"mine: no law or model can predict it: .*no signal 'gap'"
    ) as caught:
        ev.evidence(gap)
    assert len(caught.value.problems) == 1
    found = ev.evidence([gap, written("other.toml", spread=20.0)], n=4)
    said = found.document.sentences
    assert said[0].startswith("mine: no law or model can predict it: ")
    assert said[1] == "Every other measurement lies in the 90 % interval of some law or model."
