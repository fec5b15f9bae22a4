"""The file of a measurement, and the table of points that becomes one: numbers, units, folders and every mistake."""

import math
import os
import re
import tomllib
from pathlib import Path

import pytest
import tomlkit

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.data.atomic import Form, is_ours, sign
from electrovib.studies.evidence.entries import ENTRIES as SCHEMA_ENTRIES
from electrovib.studies.evidence.entries import measurement_schema, publication_files
from electrovib.studies.evidence.files import import_measurement
from electrovib.studies.evidence.measurement import numbers_of, unit_of
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
    ratio = read(per_changes={"drive": {"model": "Step", "level": "50 V"}}, values=[1, 4, 9])
    assert (ratio.unit, dict(ratio.per_changes)) == ("1", {"drive": {"model": "Step", "level": "50 V"}})
    computed = {
        "quantity": "friction coefficient",
        "per_changes": {"load.normal_force": 2.0},
        "judges": "friction",
    }
    assert read(**computed, values=[1, 4, 9]).unit == "1"
    with pytest.raises(InputError, match="unit = 'ohm': impedance magnitude is in 1"):
        read(
            quantity="impedance magnitude",
            per_changes={"load.normal_force": 2.0},
            unit="ohm",
            values=[1, 4, 9],
        )


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
        (TABLE.replace("sd (uN)", "sd"), "'sd [N]', or 'sd [%]' for one over the value"),
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
    names = "title source group scenario quantity values spread spread_of at over"
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
        ({"scale": [2], "unit": "N"}, "scale = [2]: expected a plain number"),
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
        ({"values": [True, 1, 2]}, "values = [True, 1, 2]: expected a number"),
        ({"spread": 0}, "positive numbers, unlike 0"),
        ({"spread": "5 V"}, "spread = 5 V: expected a force"),
        ({"scenario": "vezzoli_2014/fig66"}, "has no scenario 'fig66'"),
        ({"scenario": "none.toml"}, "none.toml: No such file"),
        ({"changes": {"time.durations": 1}}, "changes.time.durations: unknown parameter"),
        ({"unit": "1", "per_changes": {"time.durations": 1}}, "per_changes.time.durations: unknown parameter"),
        ({"same_as": "other"}, "same_as = other: expected another measurement of this file with the same values"),
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
        ({"made": "EffectiveMedium"}, "made = 'EffectiveMedium': expected a list of names"),
        ({"schema": 2}, "schema = 2: this version reads"),
        ({"values": [[1.0], 1, 2]}, "values = [[1.0], 1, 2]: expected a number, a text with a unit, or one list"),
        ({"made": [["a"]]}, "made.0 = ['a']: expected a text"),
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
    assert [each.path for each in caught.value.problems] == ["at", "over"]


def test_mistakes_of_several_parts_are_told_together():
    with pytest.raises(InputError) as caught:
        read(values=["1 V", 2, 3], at=["1 N", 2, 3], unknown={"stack.gap.thicknes": GAP})
    assert [each.path for each in caught.value.problems] == ["values", "at", "unknown.stack.gap.thicknes"]


def test_a_file_is_judged_alone_or_beside_others():
    found = ev.evidence(written(), n=4)
    assert list(found.measured) == ["mine"]
    assert found.of("mine")[0].score > -20
    beside = ev.evidence(["mine.toml", "vezzoli_2014/swing"], n=4)
    assert list(beside.measured) == ["mine", "vezzoli_2014/swing"]
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
    assert said[1].startswith("A law or model can miss ")
    assert "0 lie outside the interval of every candidate" in said[2]


STATED = {
    key: each for key, each in {**ENTRIES, **POINTS}.items() if key not in {"over", "at", "values", "spread"}
}


@pytest.mark.parametrize(
    ("printed", "values", "spread"),
    [
        ({"printed_range": ["2 mN", "8 mN"], "spread": "10 %"}, (4e-3,), (0.1,)),
        ({"devices": ["1 mN", "4 mN"]}, (2e-3,), (math.sqrt(math.exp(math.log(4) ** 2 / 2) - 1),)),
        (
            {"runs": [["1 mN", 2e-3], ["3 mN", 2e-3]], "over": "drive.level", "at": [50, 100], "spread": "5 %"},
            (2e-3, 2e-3),
            (math.sqrt(2) / 2, 0.05),
        ),
        (
            {"line": [1e-3, 3e-4, 1e-5, 4e-6], "over": "drive.level", "at": ["0 V", "100 V"]},
            (1e-3, 2e-3),
            (0.3, 0.25),
        ),
    ],
    ids=["range", "devices", "runs", "line"],
)  # fmt: skip
def test_what_is_printed_in_another_form_is_reduced_to_value_and_spread(printed, values, spread):
    Path("other.toml").write_text(tomlkit.dumps({"schema": 1, **STATED, **printed}), encoding="utf-8")
    found = ev.measurements("other.toml")["other"]
    assert found.values == pytest.approx(values, rel=1e-12)
    assert found.spread == pytest.approx(spread, rel=1e-12)


@pytest.mark.parametrize(
    ("printed", "words"),
    [
        ({"printed_range": [2, 1], "spread": 0.1}, "printed_range: expected the least and the largest value"),
        ({"printed_range": [1, 2], "values": 3, "spread": 0.1}, "values: printed_range stands in their place; state one of both"),
        ({"printed_range": [1, 2]}, "spread: missing"),
        ({"runs": [[1, 2]], "over": "drive.level", "at": [50, 100]}, "runs: expected two or more rows"),
        ({"devices": [1]}, "devices: expected two or more values"),
        ({"line": [1, 2], "over": "drive.level", "at": [50, 100]}, "line: expected start, its error"),
        ({"runs": [[1, 2], [3, 4]]}, "over: missing"),
        ({"values": 1, "spread": 0.1, "quantity": "impedance magnitude", "unit": "N"}, "unit = 'N': impedance magnitude is in"),
        ({"values": 1, "spread": 0.1, "quantity": "grigorii_2020/friction"}, "Did you mean 'grigorii_2020/friction_per"),
    ],
)  # fmt: skip
def test_each_mistake_in_another_form_is_named(printed, words):
    Path("other.toml").write_text(tomlkit.dumps({"schema": 1, **STATED, **printed}), encoding="utf-8")
    with pytest.raises(InputError, match=re.escape(words)):
        ev.measurements("other.toml")


def several(**changes):
    level = {"model": "Uniform", "low": "50 V", "high": "60 V", "choice": "of this test"}
    own = {
        "a": {**POINTS, "note": "alone"},
        "b": {**POINTS, "shares": ["loud"], "unknown": {"drive.level": level}},
    }
    content = {
        "schema": 1, **ENTRIES, "note": "all", "measurements": own,
        "shared": {"loud": {"changes": {"drive.level": "9 V"}, "note": "loud", "spread_of": "people"}},
    }  # fmt: skip
    Path("lab").mkdir(exist_ok=True)
    Path("lab/several.toml").write_text(tomlkit.dumps(content | changes), encoding="utf-8")
    return "lab/several.toml"


def test_a_file_of_several_measurements_states_once_what_they_share():
    found = ev.measurements(several())
    assert list(found) == ["lab/several/a", "lab/several/b"]
    a, b = found.values()
    assert (a.note, b.note) == ("all alone", "all loud")
    assert (a.spread_of, b.spread_of) == ("repeats", "people")
    assert a.scenario.drive.level == 100.0
    assert b.scenario == a.scenario.replace({"drive.level": 9.0})
    assert set(a.unknown) == {"stack.gap.thickness"}
    assert set(b.unknown) == {"stack.gap.thickness", "drive.level"}
    assert ev.measurements("lab/") == found
    twice = {"a": {**POINTS, "title": "a"}, "b": {**POINTS, "title": "b", "same_as": "a"}}
    both = ev.measurements(several(measurements=twice))
    assert len({each for name, one in both.items() for each in numbers_of(name, one)}) == 3
    with pytest.raises(InputError, match="with the same values"):
        ev.measurements(several(measurements=twice | {"a": {**twice["a"], "values": ["1.2 mN", 1, 2]}}))
    with pytest.raises(InputError, match="a folder without files of measurements"):
        ev.measurements("none/")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"measurements": {"b": {**POINTS, "values": ["1 V", 1, 2]}}},
            "several.toml: measurements.b.values = 1 V: expected a force",
        ),
        (
            {"measurements": {"b": {**POINTS, "shares": ["lod"]}}},
            "several.toml: measurements.b.shares: no shared entries are called 'lod'. Did you mean 'loud'?",
        ),
        (
            {"measurements": {"b": {**POINTS, "shares": ["israr_2005/slope"]}}},
            "no file of measurements is called 'israr_2005'. Did you mean 'israr_2006'?",
        ),
        ({"measurements": {"b": {**POINTS, "shares": "loud"}}}, "measurements.b.shares = 'loud': expected a list of names"),
        ({"measurements": {"b": 3}}, "measurements.b = 3: expected a table"),
        ({"measurements": 3}, "measurements = 3: expected a table"),
        ({"shared": {"loud": 3}}, "shared.loud = 3: expected a table"),
        ({"titel": "x", "measurements": {"b": dict(POINTS)}}, "measurements.b.titel: no entry of a measurement."),
        ({"measurements": {}}, "measurements: empty"),
    ],
)  # fmt: skip
def test_a_mistake_in_one_of_several_names_the_file_and_the_entry(changes, words):
    with pytest.raises(InputError, match=re.escape(words)):
        ev.measurements(several(**changes))


def test_a_publication_is_a_file_in_a_folder_that_needs_no_python(monkeypatch):
    home = Path("papers")
    (home / "measured").mkdir(parents=True)
    (home / "measured" / "own_2099.toml").write_text(Path(several()).read_text("utf-8"), encoding="utf-8")
    publication_files.cache_clear()
    monkeypatch.setattr("electrovib.studies.evidence.entries.paper_folders", lambda: (home,))
    assert list(publication_files()) == ["own_2099"]
    monkeypatch.undo()
    publication_files.cache_clear()
    assert "israr_2006" in publication_files()


@pytest.mark.parametrize("name", publication_files())
def test_a_copy_of_a_shipped_file_is_one_of_your_own(name, tmp_path):
    path = tmp_path / "mine.toml"
    path.write_bytes(publication_files()[name].read_bytes())
    found = ev.measurements(str(path))
    shipped = {key: each for key, each in ev.measurements().items() if key.startswith(f"{name}/")}
    assert [each.title for each in found.values()] == [each.title for each in shipped.values()]


def test_every_entry_is_described_in_the_schema():
    schema = measurement_schema()
    assert set(schema["properties"]) == {*SCHEMA_ENTRIES, "shared", "shares", "measurements"}
    assert all(each.get("description") for each in schema["properties"].values())
