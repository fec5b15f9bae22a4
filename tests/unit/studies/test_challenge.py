"""The challenge: files against their schemas, the frozen split, and how a submission is scored or refused."""

from __future__ import annotations

import json
import math
import re
import tomllib
from dataclasses import replace
from pathlib import Path

import jsonschema
import numpy as np
import pytest
import tomlkit
from typer.testing import CliRunner

import electrovib as ev
from electrovib.apps.cli import app
from electrovib.core.errors import InputError
from electrovib.studies.evidence.challenge import (
    HELD_OUT,
    PUBLIC,
    SubmissionFile,
    fingerprint,
    read_submission,
    sentences,
    sets_of,
    split,
    submitted,
    table,
)
from electrovib.studies.evidence.entries import measurement_schema, publication_files
from electrovib.studies.evidence.files import of_publication
from electrovib.studies.evidence.predicted import ModelPrediction, predict
from electrovib.studies.evidence.standing import judge, shown_first

DOCS = Path(__file__).parents[3] / "docs" / "evidence"
EXAMPLE = DOCS / "one_gap.toml"
SCHEMAS = {"measurement": measurement_schema(), "submission": SubmissionFile.model_json_schema()}
MEASURED = ev.measurements()
NAME, CLUTCH, LAW = "vezzoli_2014/decay", "rauf_2025/voltage", "MaxwellStressInGap"
GAP = "stack.gap.thickness"
RANGE = {"model": "LogUniform", "low": "1 um", "high": "5 um", "choice": "of this test"}
CONTENT = {"schema": 1, "title": "t", "authors": "a", "law": {"model": LAW}, "priors": {GAP: RANGE}}


def mistakes(kind, content):
    """Return the paths of what does not fit a schema."""
    found = jsonschema.Draft202012Validator(SCHEMAS[kind]).iter_errors(content)
    return [".".join(map(str, each.absolute_path)) for each in found]


def content_of(path):
    return tomllib.loads(Path(path).read_text(encoding="utf-8"))


@pytest.fixture
def entered(tmp_path):
    """Return a function that writes a submission and reads it for some measurements."""

    def read(names=(NAME, CLUTCH), **changes):
        path = tmp_path / "mine.toml"
        content = {key: each for key, each in (CONTENT | changes).items() if each is not None}
        path.write_text(tomlkit.dumps(content), encoding="utf-8")
        return read_submission(path, {name: MEASURED[name] for name in names})

    return read


@pytest.mark.parametrize("kind", SCHEMAS)
def test_the_shipped_schema_is_that_of_the_declarations(kind):
    jsonschema.Draft202012Validator.check_schema(SCHEMAS[kind])
    shipped = (DOCS / f"{kind}.schema.json").read_text(encoding="utf-8")
    assert json.loads(shipped) == SCHEMAS[kind], f"write it anew: json.dumps({kind}_schema(), indent=1)"


@pytest.mark.parametrize("name", sorted(publication_files()))
def test_the_schema_takes_every_file_of_a_publication(name):
    assert mistakes("measurement", content_of(publication_files()[name])) == []


@pytest.mark.parametrize(
    ("within", "changes"),
    [
        ("", {"titel": "x"}),
        ("group", {"group": 3}),
        ("schema", {"schema": 2}),
        ("measurements.square_felt_at_less", {"values_": 1}),
        ("measurements.square_felt_at_less.at", {"at": [True]}),
        ("measurements.square_felt_at_less.how", {"how": "heard"}),
        ("measurements.square_felt_at_less.bound", {"bound": "more"}),
        ("measurements.square_felt_at_less.made", {"made": "EffectiveMedium"}),
        ("shared.s", {"group_": "x"}),
    ],
)
def test_the_schema_and_the_reader_refuse_the_same_mistakes(within, changes, tmp_path):
    content = content_of(publication_files()["vardar_2017"])
    target = content
    for part in re.findall(r"^(?:measurements\.\w+|shared\.\w+)", within):
        outer, inner = part.split(".")
        target = content.setdefault(outer, {}).setdefault(inner, {})
        if outer == "shared":
            content["shares"] = [inner]
    target |= changes
    assert within in mistakes("measurement", content)
    path = tmp_path / "wrong.toml"
    path.write_text(tomlkit.dumps(content), encoding="utf-8")
    with pytest.raises(InputError):
        ev.measurements(str(path))


@pytest.mark.parametrize(
    ("path", "changes"),
    [
        ("", {"laws": {}}),
        ("", {"authors": None}),
        ("law", {"law": LAW}),
        ("made_from", {"made_from": "x"}),
        ("on.clutch", {"on": {"clutch": 3}}),
        ("schema", {"schema": 2}),
    ],
)
def test_the_schema_of_a_submission_refuses_what_its_reader_refuses(path, changes, entered):
    content = {key: each for key, each in (CONTENT | changes).items() if each is not None}
    assert path in mistakes("submission", content)
    with pytest.raises(InputError):
        entered(**changes)


def test_every_group_stands_on_one_side_and_every_side_names_groups_that_measured():
    """A new group is added to `split.toml` by hand."""
    sides, groups = split(), {each.group for each in MEASURED.values()}
    assert len({*sides.public, *sides.held_out}) == len(sides.public) + len(sides.held_out)
    assert {*sides.public, *sides.held_out} == groups
    assert {sides.side_of(each) for each in groups} == {PUBLIC, HELD_OUT}
    assert sides.side_of("our laboratory") == ""
    on_fingers = {each.group for each in MEASURED.values() if each.judges == "force" and "finger" in each.on}
    assert on_fingers <= {*sides.held_out}


def test_the_sides_of_version_1_are_not_changed():
    """Groups may be added to either side; to move one is another challenge, with another version."""
    assert split().version.startswith("1.")
    assert {
        "Northwestern (Colgate and Peshkin)", "Vezzoli, Amberg and Giraud (Lille)", "Koc and Delft (Basdogan and Vardar)",
        "Veijgen, Masen and van der Heide", "Dzidek, Adams and Hayward (Birmingham)", "Bolanowski (Syracuse)", "Rosell",
    } <= {*split().held_out}  # fmt: skip
    assert {
        "Follmer (Rauf and Zhang)", "pads of others, one script", "Sci. Rep. 13 (2023)", "Amish 2024", "Smith and Scott",
        "Zhang and Mak", "Taylor and Lederman", "Israr, Choi and Tan (Purdue)", "Brisben", "palmar admittance, 48 people",
        "Plutchik and Hirsch", "palmar resistance, 1964", "electrotactile display, PMC2586184",
    } <= {*split().public}  # fmt: skip


@pytest.mark.parametrize("name", sorted(publication_files()))
def test_numbers_that_judge_are_those_of_the_version(name):
    """Where a change is meant, the version grows and `[numbers]` gets the new fingerprint."""
    assert fingerprint(of_publication(name)) == split().numbers.get(name), f"{name} in split.toml"
    assert set(split().numbers) == set(publication_files())


def test_a_fingerprint_sees_each_number_and_group():
    known = of_publication("vezzoli_2014")
    name, one = next(iter(known.items()))
    own = fingerprint(known)
    for changes in (
        {"values": tuple(1.001 * each for each in one.values)},
        {"spread": tuple(1.001 * each for each in one.spread)},
        {"group": "others"},
        {"bound": "at least"},
        {"error_of": "a figure"},
    ):
        assert fingerprint(known | {name: replace(one, **changes)}) != own
    assert fingerprint(known | {name: replace(one, note="another")}) == own
    of_loads = {
        fingerprint({name: replace(one, unit="1", per_changes={"load.normal_force": load})})
        for load in (1.0, 2.0)
    }
    assert len(of_loads) == 2


def test_a_submission_with_nothing_of_its_own_predicts_what_the_shipped_law_does(entered):
    own = entered(priors=None)
    for name in (NAME, CLUTCH):
        (shipped,) = (each for each in predict(MEASURED[name], n=4)[0] if each.model == LAW)
        found, why = submitted(own, name, MEASURED[name], n=4, seed=0)
        assert (found.model, why) == ("mine", "")
        np.testing.assert_allclose(found.values, shipped.values, rtol=1e-12)


def test_priors_take_the_place_of_what_is_open_and_what_is_printed_stays(entered):
    film = "stack.insulator.thickness"
    narrow = RANGE | {"low": "2 um", "high": "2.1 um"}
    own = entered(priors={GAP: RANGE, film: RANGE}, on={"rauf_2025": {GAP: narrow}}, names=[*MEASURED])
    everywhere, there = (own.applied(name, MEASURED[name]).unknown for name in (NAME, CLUTCH))
    assert everywhere[GAP] == RANGE
    assert there[GAP] == narrow
    assert film not in MEASURED[CLUTCH].unknown
    assert film not in there
    rough = entered(law={"model": "Persson2018RoughGap"}, priors={"force.rms_gap": RANGE})
    assert rough.applied(CLUTCH, MEASURED[CLUTCH]).of_model["Persson2018RoughGap"] == {
        **MEASURED[CLUTCH].of_model["Persson2018RoughGap"], "force.rms_gap": RANGE,
    }  # fmt: skip
    without = entered(law={"model": "Persson2018RoughGap"}, priors={"stack.gap": False})
    assert without.applied(NAME, MEASURED[NAME]).of_model["Persson2018RoughGap"]["stack.gap"] is None


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"law": {"model": "MaxwellStresInGap"}}, "expected the name of a ForceLaw; a law of your own is imported by --models"),
        ({"law": {}}, "law.model"),
        ({"judges": "forc"}, "judges = forc: nothing is measured of it. Did you mean 'force'?"),
        ({"made_from": ["Vezzoli, Amberg and Giraud (Lille)"]}, "is held out, so that its numbers judge every submission"),
        ({"made_from": ["Folmer (Rauf and Zhang)"]}, "no group of the measured data is called 'Folmer (Rauf and Zhang)'. Did"),
        ({"on": {"nowhere": {GAP: RANGE}}}, "on.nowhere: no measurement that is judged has this in its name, title or group"),
        ({"priors": {GAP: {"model": "Uniform", "low": 0, "high": 1}}}, "a prior states its source, or calls itself a choice"),
        ({"priors": {GAP: RANGE | {"high": "5 V"}}}, "priors.stack.gap.thickness"),
        ({"priors": {GAP: 3}}, "expected a distribution, or false"),
        ({"priors": {"stack.gap.thicknes": RANGE}}, "no set-up leaves it open, and it is no parameter of MaxwellStressInGap."),
        ({"priors": {"contact.area": RANGE}}, "no set-up leaves it open"),
        ({"on": {"lille": {"stack.gap.thicknes": RANGE}}}, "on.lille"),
        ({"law": {"model": "Persson2018RoughGap"}}, "stack.gap.thickness: Persson2018RoughGap replaces it wherever it is open"),
        ({"titel": "x"}, "titel: no entry of a submission. Did you mean 'title'?"),
    ],
)  # fmt: skip
def test_a_wrong_submission_is_refused_in_a_sentence(changes, words, entered):
    with pytest.raises(InputError, match=re.escape(words)) as caught:
        entered(**changes)
    assert len(caught.value.problems) == 1


def test_another_file_is_named_as_what_it_is(tmp_path):
    path = publication_files()["vezzoli_2014"]
    with pytest.raises(InputError, match="is a measurement, not a submission"):
        read_submission(path, MEASURED)
    with pytest.raises(InputError, match="is a submission, not a measurement; 'electrovib evidence --laws"):
        ev.measurements(str(EXAMPLE))
    with pytest.raises(InputError, match="No such file"):
        read_submission(tmp_path / "none.toml", MEASURED)


def test_a_law_is_not_judged_by_the_groups_that_made_it_and_one_that_predicts_nothing_is_refused(
    entered, tmp_path
):
    own = entered(made_from=["Follmer (Rauf and Zhang)"])
    assert submitted(own, CLUTCH, MEASURED[CLUTCH], n=2, seed=0) == (None, "it was made from these numbers")
    made = replace(MEASURED[NAME], made=(LAW,))
    assert submitted(own, NAME, made, n=2, seed=0)[1] == "it was made from these numbers"
    with pytest.raises(InputError, match="laws: no measurement that is named judges force"):
        ev.evidence("israr_2006", laws=tmp_path / "mine.toml", n=2)
    with pytest.raises(InputError, match="mine predicts no measurement: it was made from these numbers"):
        ev.evidence(CLUTCH, laws=tmp_path / "mine.toml", n=2)


def test_a_wider_prediction_scores_less_and_so_does_a_wrong_narrow_one():
    """About the measured value, ten times the range costs nearly ln 10; a tenth of it, beside the value, costs more."""
    one = replace(MEASURED[NAME], values=(1.0,), spread=(0.1,), bound="", at=(), over="")
    steps = np.linspace(-0.5, 0.5, 64)[:, None]

    def score(decades, ratio=1.0):
        return judge("m", one, ModelPrediction("law", ratio * 10 ** (decades * steps))).score

    assert score(1.0) - score(10.0) == pytest.approx(math.log(10), abs=0.1)
    assert score(0.1) > score(1.0) > score(10.0) > score(0.1, ratio=100.0)


@pytest.mark.slow
def test_the_example_is_shown_as_it_is_and_scored_on_both_sides():
    page = (DOCS / "challenge.md").read_text(encoding="utf-8")
    shown = re.search(r"```toml\n(.*?)```", page, re.DOTALL)[1]
    assert tomllib.loads(shown) == content_of(EXAMPLE)
    assert mistakes("submission", content_of(EXAMPLE)) == []
    words = ["vezzoli_2014", "zhang_a", "cacucciolo_2022"]
    found = ev.evidence(words, laws=EXAMPLE, n=8)
    assert ([each.name for each in found.submissions], found.calibrated) == (["one_gap"], ())
    held_out, public = found.document.sentences[:2]
    assert held_out.startswith("one_gap on groups that are held out, 2 numbers of 1 group: skill ")
    assert "no interval from one group" in held_out
    assert public.startswith("one_gap on groups that are public, ")
    rows, sides = found.document.numbers[0].rows, found.sides(found.submissions[0])
    (standing,) = (each for each in sides[HELD_OUT][0].standings if each.model == "one_gap")
    assert rows[0][3] == f"{standing.skill:.2f}"
    assert rows[0][6] == f"{standing.width:.2f}"
    better = sum(each.skill > standing.skill for each in sides[HELD_OUT][0].standings)
    assert rows[0][8] == f"{1 + better} of {len(sides[HELD_OUT][0].standings)}"
    assert {each.group for each in found.scores if each.model == "one_gap"} == {
        "Vezzoli, Amberg and Giraud (Lille)", "pads of others, one script",
    }  # fmt: skip
    assert found.refused["rauf_2025/zhang_a"]["one_gap"] == "it was made from these numbers"


@pytest.mark.slow
def test_the_table_has_a_row_for_each_common_set_and_says_where_there_is_none(entered):
    own = entered()
    found = {name: predict(MEASURED[name], n=4)[0] for name in (NAME, CLUTCH)}
    scores = [judge(name, MEASURED[name], each) for name, all_ in found.items() for each in all_]
    nulls = [replace(each, model="null", score=each.score - 1) for each in scores if each.model == LAW]
    mine = [replace(each, model="mine", score=each.score + 1) for each in scores if each.model == LAW][:1]
    sides = sets_of(own, [*scores, *mine], nulls)
    assert [len(sides[side]) for side in (HELD_OUT, PUBLIC)] == [1, 0]
    assert len(table(own, sides).rows) == 1
    first, second = sentences(own, sides)
    assert "skill 2.00 (no interval from one group) over 'null'" in first
    assert second == "mine on groups that are public: it predicts none of them."
    (one,) = sides[HELD_OUT]
    of_three = replace(one, numbers=7, groups=3)
    assert "held out, 7 numbers of 3 groups" in sentences(own, {HELD_OUT: [one, of_three]})[0]
    assert shown_first([one, one]) is one
    assert sentences(own, {HELD_OUT: []}) == [
        "mine on groups that are held out: it predicts none of them and has no rank."
    ]


def test_the_command_scores_a_submission(tmp_path):
    done = CliRunner().invoke(app, ["evidence", NAME, "--laws", str(EXAMPLE), "-n", "4"])
    assert done.exit_code == 0, done.output
    assert done.output.startswith("one_gap on groups that are held out, 1 number of 1 group: skill ")
    assert f"Challenge {split().version}: one_gap" in done.output


def test_several_submissions_stand_beside_each_other_and_none_has_the_name_of_a_model(tmp_path):
    for name in ("first", "second", LAW):
        (tmp_path / f"{name}.toml").write_text(tomlkit.dumps(CONTENT), encoding="utf-8")
    paths = [tmp_path / f"{name}.toml" for name in ("first", "second")]
    found = ev.evidence(NAME, laws=paths, n=4)
    assert [each.partition(" ")[0] for each in found.document.sentences[:4]] == [
        "first",
        "first",
        "second",
        "second",
    ]
    assert {"first", "second"} < {each.model for each in found.scores}
    for wrong in ([*paths, paths[0]], [tmp_path / f"{LAW}.toml"]):
        with pytest.raises(InputError, match="another law or file has this name") as caught:
            ev.evidence(NAME, laws=wrong, n=4)
        assert len(caught.value.problems) == 1
