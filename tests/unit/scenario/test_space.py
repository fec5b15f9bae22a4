"""Spaces are read in the units of their parameters, with every mistake in one sentence, and written again."""

from __future__ import annotations

import dataclasses
import math
import tomllib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.scenario.distributions import Empirical, LogNormal, LogUniform, Normal, Triangular, Uniform
from electrovib.scenario.space import Group, Grouping, Origin, Space, read_space
from electrovib.solve.prepare import prepare

SINE = "bau_2010/sine"
FILM, SKIN, GAP = (f"stack.{name}.thickness" for name in ("insulator", "stratum_corneum", "gap"))
MU = "friction.coefficient"
TABLE = {
    FILM: {"model": "Normal", "mean": "1 um", "deviation": "0.1 um", "low": "0.5 um", "high": "2 um"},
    SKIN: {"model": "LogNormal", "median": "200 um", "factor": 1.3},
}
GROUPS = {
    "moisture": {
        "dry": {"share": 0.25, "space": {MU: {"model": "Uniform", "low": 0.2, "high": 0.3}}},
        "moist": {"share": 0.75, "space": {MU: {"model": "Uniform", "low": 0.6, "high": 0.9}}},
    }
}


def space(**parts):
    table = TABLE | parts.pop("table", {})
    return read_space(SINE, {"space": table} | parts)


def test_a_space_is_read_in_the_units_of_its_parameters_and_feeds_a_prepared_scenario():
    found = space(relations=[f"{FILM} < {SKIN}"])
    assert found.paths == (FILM, SKIN)
    assert found.distributions[FILM] == Normal(mean=1e-6, deviation=1e-7, low=5e-7, high=2e-6)
    values = found.values({FILM: np.array([0.5, 0.9]), SKIN: np.array([0.5, 0.1])})
    assert values[FILM][0] == pytest.approx(1e-6)
    force = prepare(SINE, free=found.paths, quantities=["mean electrostatic_force"])(values)
    assert force["mean electrostatic_force"].shape == (2,)


def test_every_form_of_a_space_is_read(tmp_path):
    found = space()
    file = tmp_path / "own.toml"
    file.write_text(found.to_toml())
    nested = {
        "stack": {"insulator": {"thickness": TABLE[FILM]}, "stratum_corneum": {"thickness": TABLE[SKIN]}}
    }
    for source in (TABLE, {"space": nested}, nested, file, str(file), found, found.as_table()):
        assert ev.read_space(SINE, source) == found
    assert ev.read_space(ev.load(SINE), {MU: 0.4}).distributions == {MU: Empirical(values=(0.4,))}


def test_low_and_high_truncate_any_distribution():
    ends = {"low": "150 um", "high": "250 um"}
    found = space(
        table={SKIN: TABLE[SKIN] | ends, MU: {"model": "Empirical", "values": [0.2, 0.5, 0.9], "low": 0.3}}
    )
    assert found.distributions[SKIN] == LogNormal(median=2e-4, factor=1.3).truncated(1.5e-4, 2.5e-4)
    assert found.distributions[MU] == Empirical(values=(0.5, 0.9))


def test_measured_values_are_a_column_of_a_file(tmp_path):
    (tmp_path / "measured.csv").write_text("subject,thickness [um]\n1,150\n2,210\n3,300\n")
    file = tmp_path / "own.toml"
    file.write_text(f'[space."{SKIN}"]\nmodel = "Empirical"\nfile = "measured.csv"\ncolumn = "thickness"\n')
    found = read_space(SINE, file)
    assert found.distributions[SKIN].values == pytest.approx((1.5e-4, 2.1e-4, 3e-4))
    assert read_space(SINE, tomllib.loads(found.to_toml())) == found  # which needs the file no more


def test_relations_are_chains_of_paths():
    found = space(
        relations=[f"{FILM} < {GAP} < {SKIN}"], table={GAP: {"model": "Uniform", "low": 2e-6, "high": 3e-6}}
    )
    assert found.relations == ((FILM, GAP), (GAP, SKIN))
    values = {
        FILM: np.array([1.0, 2.0, 3.0]),
        GAP: np.array([2.0, 2.0, 2.0]),
        SKIN: np.array([3.0, 3.0, 3.0]),
    }
    assert list(found.allowed(values)) == [True, False, False]


def test_groups_replace_the_distribution_of_the_space():
    groups = {"moisture": {"dry": GROUPS["moisture"]["dry"], "moist": {"share": 0.75}}}
    found = space(table={MU: {"model": "Uniform", "low": 0.6, "high": 0.9}}, groups=groups)
    shares = {MU: np.array([0.5, 0.5]), "groups of moisture": np.array([0.2, 0.3])}
    assert list(found.values(shares)[MU]) == pytest.approx([0.25, 0.75])


def test_a_positive_parameter_of_a_fit_is_read():
    found = space(table={SKIN: {"model": "Normal", "mean": 1e-4, "deviation": 1e-4, "low": 0.0}})
    assert found.distributions[SKIN].low == 1e-10


def test_a_space_shows_itself_in_few_lines():
    values = {"model": "Empirical", "values": [1e-6 * i for i in range(1, 9)], "source": "a table"}
    shown = repr(
        space(table={GAP: values}, groups=GROUPS, correlation={f"{FILM} ~ {SKIN}": 0.5})
    ).splitlines()
    assert shown[0] == "Space: without a title"
    assert f"  {SKIN}: LogNormal, median 200 um, factor 1.3" in shown
    assert f"  {GAP}: Empirical, values (8 of them)" in shown
    assert f"  {FILM} ~ {SKIN} = 0.5" in shown
    assert shown[-2:] == ["  moisture: moist, 0.75 of all", f"    {MU}: Uniform, low 0.6, high 0.9"]


def test_optional_entries_that_the_scenario_cannot_take_are_omitted_and_reported():
    table = {"finger.stiffness": {"model": "Uniform", "low": 1.0, "high": 2.0, "optional": True}}
    found = space(
        table=table,
        relations=[f"finger.stiffness < {SKIN}"],
        correlation={f"{FILM} ~ finger.stiffness": 0.5},
    )
    assert found.paths == (FILM, SKIN)
    assert not found.relations
    assert not found.correlations
    assert found.remarks == ("finger.stiffness is not drawn: the scenario has no such parameter",)


def test_what_moisture_sets_is_omitted_where_it_is_optional():
    wet = {
        "level": 0.5,
        "dry_gap_resistivity": 1e12,
        "wet_gap_resistivity": 1e6,
        "dry_coefficient": 0.4,
        "wet_coefficient": 0.8,
    }
    scenario = ev.load(SINE).replace({"moisture": wet})
    own = {MU: {"model": "Uniform", "low": 0.2, "high": 0.3, "optional": True}}
    found = read_space(scenario, {"space": TABLE | own})
    assert found.paths == (FILM, SKIN)
    assert "is set by moisture" in found.omitted[MU]
    # what refers to it goes with it: a correlation, a relation, and groups that set nothing else
    linked = {
        "correlation": {f"{FILM} ~ {MU}": 0.5, f"{FILM} ~ {SKIN}": 0.3},
        "relations": [f"{FILM} < {MU}"],
    }
    found = read_space(scenario, {"space": TABLE | own} | linked)
    assert (found.correlations, found.relations) == ({(FILM, SKIN): 0.3}, ())
    assert set(found.draw(1, 0, 10)) == {FILM, SKIN}
    members = {
        label: {"share": group["share"], "space": {MU: group["space"][MU] | {"optional": True}}}
        for label, group in GROUPS["moisture"].items()
    }
    found = read_space(scenario, {"space": TABLE, "groups": {"moisture": members}})
    assert (found.groupings, set(found.draw_groups(1, 0, 10))) == ({}, set())
    assert set(found.draw(1, 0, 10)) == {FILM, SKIN}
    own[MU] = own[MU] | {"optional": False}
    with pytest.raises(InputError, match="is set by moisture"):
        read_space(scenario, {"space": TABLE | own})


def test_sources_are_kept_and_unverified_ones_are_reported():
    origin = {"source": "own memory", "status": "unverified", "confidence": "low", "choice": "the shape"}
    found = space(table={SKIN: TABLE[SKIN] | origin})
    assert found.origins == {SKIN: Origin(**origin)}
    assert found.remarks == (
        f"{SKIN}: the distribution is unverified, cited from memory; low confidence; own memory; a choice: the shape",
    )


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        (
            {"table": {"stack.insulator.thicknes": {"model": "Uniform"}}},
            "Did you mean 'stack.insulator.thickness'",
        ),
        ({"table": {FILM: {"model": "Norml"}}}, "Did you mean 'Normal'"),
        ({"table": {FILM: {"model": "Truncated"}}}, "Known: Empirical"),
        ({"table": {FILM: {"model": "Normal", "mean": "1 um"}}}, "deviation: missing"),
        ({"table": {FILM: {"model": "Uniform", "low": "1 um", "hihg": "2 um"}}}, "Did you mean 'high'"),
        ({"table": {FILM: {"model": "Uniform", "low": "2 um", "high": "1 um"}}}, "expected more than low"),
        ({"table": {FILM: {"model": "Uniform", "low": "1 V", "high": "2 um"}}}, "low = 1 V"),
        ({"table": {FILM: {"model": "Uniform", "low": True, "high": "2 um"}}}, "low = True"),
        ({"table": {FILM: {"model": "Uniform", "low": math.nan, "high": "2 um"}}}, "finite number"),
        (
            {"table": {FILM: {"model": "Uniform", "low": "1 um", "high": "2 km"}}},
            "truncate .* high = '100 mm'",
        ),
        ({"table": {MU: {"model": "Normal", "mean": 0.5, "deviation": 0.1}}}, "truncate .* low = '0'"),
        ({"table": {FILM: TABLE[FILM] | {"status": "read"}}}, "status = read: expected one of full text"),
        ({"table": {FILM: TABLE[FILM] | {"optional": "yes"}}}, "expected true or false"),
        ({"table": {FILM: {"model": "Empirical", "values": [1e-6], "file": "a.csv"}}}, "omit one of them"),
        ({"table": {FILM: {"model": "Empirical", "file": "nowhere.csv"}}}, "nowhere.csv"),
        ({"table": {FILM: {"model": "Empirical", "file": "a.csv", "column": 1.5}}}, "expected the heading"),
        ({"relations": [f"{FILM} > {SKIN}"]}, "expected PATH < PATH"),
        ({"relations": [f"{FILM} < contact.area"]}, "'contact.area' is not in the space"),
        ({"relations": [f"{SKIN} < {FILM}"]}, "a share of 0 of the draws fulfils this relation"),
        ({"relations": "A < B"}, "expected a list of texts"),
        ({"correlation": {f"{FILM} ~ contact.area": 0.5}}, "'contact.area' is not in the space"),
        ({"correlation": {f"{FILM} ~ {SKIN}": 1.5}}, "coefficient from -1 to 1"),
        ({"correlation": {f"{FILM} ~ {SKIN}": 0.5, f"{SKIN} ~ {FILM}": 0.4}}, "each pair of two different"),
        ({"correlation": {f"{FILM} ~ {FILM}": 1.0}}, "each pair of two different"),
        ({"correlation": {f"{FILM} {SKIN}": 0.5}}, "PATH ~ PATH"),
        (
            {"groups": {"sex": {"women": {"share": 0.5}, "men": {"share": 0.4}}}},
            r"0.5 \(women\) \+ 0.4 \(men\) = 0.9",
        ),
        ({"groups": {"sex": {"women": {"share": 1.5}}}}, "women.share = 1.5"),
        ({"groups": {"sex": {"women": {"shares": 1}}}}, "Did you mean 'share'"),
        ({"groups": {"sex": {"women": {}}}}, "expected a part of 1"),
        ({"groups": {"sex": 1.0}}, "expected a table for each group"),
        ({"groups": {"sex": {"women": 1.0}}}, "expected a table with the share"),
        ({"groups": GROUPS | {"sex": GROUPS["moisture"]}}, "is set by groups.moisture too"),
        ({"groups": {"moisture": GROUPS["moisture"] | {"moist": {"share": 0.75}}}}, "groups that have none"),
        ({"space": {}}, "it has no parameter"),
        ({"spce": {}}, "Did you mean 'space'"),
        ({"schema": 2}, "reads schema = 1"),
    ],
)
def test_mistakes_are_one_sentence(parts, words):
    with pytest.raises(InputError, match=words) as caught:
        space(**parts)
    assert all(len(problem) < 400 for problem in caught.value.problems)


def test_all_mistakes_are_listed_at_once():
    with pytest.raises(InputError) as caught:
        space(
            table={FILM: {"model": "Norml"}, SKIN: {"model": "Uniform"}}, relations=["A"], groups={"sex": 1.0}
        )
    assert len(caught.value.problems) == 4


@pytest.mark.parametrize(
    ("source", "words"),
    [
        ("finger", "Did you mean 'fingers'"),
        ("nowhere.toml", "No such file"),
        (3, "expected a .toml file"),
    ],
)
def test_a_source_that_is_no_space_is_refused(source, words):
    with pytest.raises(InputError, match=words):
        read_space(SINE, source)


@pytest.mark.parametrize("content", [b"\xff\xfe", b"space = "])
def test_a_file_that_is_no_toml_is_refused(tmp_path, content):
    (tmp_path / "own.toml").write_bytes(content)
    with pytest.raises(InputError, match=r"not a text in UTF-8|not valid TOML"):
        read_space(SINE, tmp_path / "own.toml")


def test_correlations_that_contradict_each_other_name_the_nearest_mistake():
    mu = {MU: {"model": "Uniform", "low": 0.2, "high": 0.9}}
    pairs = {f"{FILM} ~ {SKIN}": 0.9, f"{SKIN} ~ {MU}": 0.8, f"{FILM} ~ {MU}": 0.3}
    # with 0.8 and 0.3 given the third is at most 0.24 + sqrt(0.36*0.91) = 0.812, and the others have to change more
    with pytest.raises(InputError, match=rf"'{FILM} ~ {SKIN}' = 0\.81 in place of 0\.9"):
        space(table=mu, correlation=pairs)
    pairs[f"{FILM} ~ {SKIN}"] = 0.81
    assert space(table=mu, correlation=pairs).correlations[FILM, SKIN] == 0.81


def test_correlations_that_no_single_change_reconciles_are_scaled():
    force, area = "load.normal_force", "contact.area"
    more = {path: {"model": "Uniform", "low": 1e-4, "high": 0.9} for path in (MU, force, area)}
    paths = [FILM, SKIN, *more]
    pairs = {f"{a} ~ {b}": -0.9 for i, a in enumerate(paths) for b in paths[i + 1 :]}
    # the smallest eigenvalue of equal coefficients r is 1 + 4 r: at most -0.25 is possible
    with pytest.raises(InputError, match=r"all of them times 0\.27 are possible"):
        space(table=more, correlation=pairs)


NUMBERS = st.floats(1e-7, 1e-2)
ORIGINS = st.builds(
    Origin,
    source=st.text(st.characters(codec="utf-8", exclude_categories=["Cs", "Cc"]), max_size=8),
    status=st.sampled_from(["", "abstract", "unverified"]),
    optional=st.booleans(),
)
DISTRIBUTIONS = st.one_of(
    st.builds(lambda a, b: Uniform(low=a, high=a + b), NUMBERS, NUMBERS),
    st.builds(lambda a, b: LogUniform(low=a, high=a + b), NUMBERS, NUMBERS),
    st.builds(lambda a, b: Normal(mean=a, deviation=b, low=1e-9, high=2e-2), NUMBERS, NUMBERS),
    st.builds(lambda a, b: LogNormal(median=a, factor=1.1 + b), NUMBERS, NUMBERS),
    st.builds(lambda a, b: LogNormal(median=a, factor=1.1 + b).truncated(a / 2, math.inf), NUMBERS, NUMBERS),
    st.builds(lambda a, b, c: Triangular(low=a, likely=a + b, high=a + b + c), NUMBERS, NUMBERS, NUMBERS),
    st.builds(lambda values: Empirical(values=tuple(values)), st.lists(NUMBERS, min_size=1, max_size=4)),
)


@st.composite
def spaces(draw):
    paths = draw(st.lists(st.sampled_from([FILM, SKIN, GAP]), min_size=1, unique=True))
    found = {path: draw(DISTRIBUTIONS) for path in paths}
    shares = draw(st.sampled_from([(0.25, 0.75), (1.0,)]))
    groups = {
        f"group_{number}": Group(share=share, distributions={MU: draw(DISTRIBUTIONS)})
        for number, share in enumerate(shares)
    }
    where = [*paths, "groups.moisture.group_0", f"groups.moisture.group_0.{MU}"]
    origins = {each: draw(ORIGINS) for each in where}
    return Space(
        distributions=found,
        groupings={"moisture": Grouping(groups=groups)},
        correlations={(paths[0], MU): draw(st.floats(-1, 1))},
        title=draw(st.sampled_from(["", "own"])),
        units=dict.fromkeys(paths, "m") | {MU: "1"},
        origins={each: origin for each, origin in origins.items() if origin != Origin()},
    )


@settings(deadline=None, max_examples=30)
@given(spaces())
def test_a_space_reads_back_equal_from_toml(ours):
    scenario = ev.load(SINE)
    assert read_space(scenario, tomllib.loads(ours.to_toml())) == ours
    assert read_space(scenario, ours.as_table()) == ours
    again = read_space(scenario, dataclasses.replace(ours, omitted={"a": "b"}))
    assert again.omitted == {"a": "b"}
