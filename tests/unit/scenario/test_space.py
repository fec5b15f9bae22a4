"""Spaces are read in the units of their parameters, with every mistake in one sentence, and written again."""

import dataclasses
import math
import tomllib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.physics.finger import Moisture
from electrovib.scenario.distributions import Empirical, LogNormal, LogUniform, Normal, Triangular, Uniform
from electrovib.scenario.space import Group, Grouping, Origin, Space, read_space
from electrovib.solve.prepare import prepare

SINE = ev.load("bau_2010/sine")
MU, STIFFNESS = "friction.coefficient", "finger.stiffness"
FILM, SKIN, GAP = (f"stack.{name}.thickness" for name in ("insulator", "stratum_corneum", "gap"))


def uniform(low, high, **more):
    return {"model": "Uniform", "low": low, "high": high} | more


def measured(*values, **more):
    return {"model": "Empirical", **({"values": list(values)} if values else {}), **more}


TABLE = {
    FILM: {"model": "Normal", "mean": "1 um", "deviation": "0.1 um", "low": "0.5 um", "high": "2 um"},
    SKIN: {"model": "LogNormal", "median": "200 um", "factor": 1.3},
}
DRY = {"share": 0.25, "space": {MU: uniform(0.2, 0.3)}}
MOISTURE = {"dry": DRY, "moist": {"share": 0.75, "space": {MU: uniform(0.6, 0.9)}}}


def space(table=None, /, scenario=SINE, **parts):
    return read_space(scenario, {"space": TABLE | (table or {})} | parts)


def test_a_space_is_read_in_the_units_of_its_parameters_and_feeds_a_prepared_scenario():
    found = space(relations=[f"{FILM} < {SKIN}"])
    assert found.paths == (FILM, SKIN)
    assert found.distributions[FILM] == Normal(mean=1e-6, deviation=1e-7).truncated(5e-7, 2e-6)
    values = found.values({FILM: np.array([0.5, 0.9]), SKIN: np.array([0.5, 0.1])})
    assert values[FILM][0] == pytest.approx(1e-6)
    force = prepare(SINE, free=found.paths, quantity=["mean electrostatic_force"])(values)
    assert force["mean electrostatic_force"].shape == (2,)


def test_every_form_of_a_space_is_read(tmp_path):
    found, file = space(), tmp_path / "own.toml"
    file.write_text(found.to_toml())
    layers = {"insulator": {"thickness": TABLE[FILM]}, "stratum_corneum": {"thickness": TABLE[SKIN]}}
    nested = {"stack": layers}
    for source in (TABLE, {"space": nested}, nested, file, str(file), found, found.as_table()):
        assert ev.read_space(SINE, source) == found
    assert ev.read_space(SINE, {MU: 0.4}).distributions == {MU: Empirical(values=(0.4,))}
    (tmp_path / "measured.csv").write_text("subject,thickness [um]\n1,150\n2,210\n3,300\n")
    file.write_text(f'[space."{SKIN}"]\nmodel = "Empirical"\nfile = "measured.csv"\ncolumn = "thickness"\n')
    found = read_space(SINE, file)
    assert found.distributions[SKIN].values == pytest.approx((1.5e-4, 2.1e-4, 3e-4))
    assert read_space(SINE, tomllib.loads(found.to_toml())) == found  # which needs the file no more


def test_low_and_high_truncate_any_distribution():
    table = {SKIN: TABLE[SKIN] | {"low": "150 um", "high": "250 um"}, MU: measured(0.2, 0.5, 0.9, low=0.3)}
    found = space(table).distributions
    assert found[SKIN] == LogNormal(median=2e-4, factor=1.3).truncated(1.5e-4, 2.5e-4)
    assert found[MU] == Empirical(values=(0.5, 0.9))
    # as a fit has it
    positive = space({SKIN: {"model": "Normal", "mean": 1e-4, "deviation": 1e-4, "low": 0.0}})
    assert positive.distributions[SKIN].low == 1e-10


def test_relations_are_chains_of_paths_and_groups_replace_the_distribution_of_the_space():
    found = space({GAP: uniform(2e-6, 3e-6)}, relations=[f"{FILM} < {GAP} < {SKIN}"])
    assert found.relations == ((FILM, GAP), (GAP, SKIN))
    values = dict(zip((FILM, GAP, SKIN), np.array([[1.0, 2, 3], [2, 2, 2], [3, 3, 3]]), strict=True))
    assert list(found.allowed(values)) == [True, False, False]
    found = space({MU: uniform(0.6, 0.9)}, groups={"moisture": {"dry": DRY, "moist": {"share": 0.75}}})
    shares = {MU: np.array([0.5, 0.5]), "groups of moisture": np.array([0.2, 0.3])}
    assert list(found.values(shares)[MU]) == pytest.approx([0.25, 0.75])


def test_a_space_shows_itself_in_few_lines_and_reports_unverified_sources():
    origin = {"source": "own memory", "status": "unverified", "confidence": "low", "choice": "the shape"}
    values = measured(*(1e-6 * i for i in range(1, 9)), source="a table")
    groups = {"moisture": MOISTURE}
    found = space(
        {GAP: values, SKIN: TABLE[SKIN] | origin}, groups=groups, correlation={f"{FILM} ~ {SKIN}": 0.5}
    )
    shown = repr(found).splitlines()
    assert shown[0] == "Space: without a title"
    assert any(line.startswith(f"  {SKIN}: LogNormal, median 200 um, factor 1.3") for line in shown)
    assert f"  {GAP}: Empirical, values (8 of them)" in shown
    assert f"  {FILM} ~ {SKIN} = 0.5" in shown
    assert "  moisture: moist, 0.75 of all" in shown
    assert f"    {MU}: Uniform, low 0.6, high 0.9" in shown
    assert found.origins[SKIN] == Origin(**origin)
    told = (
        "the distribution is unverified, cited from memory; low confidence; own memory; a choice: the shape"
    )
    assert f"{SKIN}: {told}" in found.remarks


def test_optional_entries_that_the_scenario_cannot_take_are_omitted_and_reported():
    relations, correlation = [f"{STIFFNESS} < {SKIN}"], {f"{FILM} ~ {STIFFNESS}": 0.5}
    found = space({STIFFNESS: uniform(1.0, 2.0, optional=True)}, relations=relations, correlation=correlation)
    assert found.paths == (FILM, SKIN)
    assert not found.relations
    assert not found.correlations
    assert found.remarks == (f"{STIFFNESS} is not drawn: the scenario has no such parameter",)


def test_what_moisture_sets_is_omitted_where_it_is_optional():
    scenario = SINE.replace({"moisture": dict(Moisture.example)})
    own = {MU: uniform(0.2, 0.3, optional=True)}
    found = space(own, scenario)
    assert found.paths == (FILM, SKIN)
    assert "is set by moisture" in found.omitted[MU]
    # what refers to it goes with it: a correlation, a relation, and groups that set nothing else
    correlation = {f"{FILM} ~ {MU}": 0.5, f"{FILM} ~ {SKIN}": 0.3}
    found = space(own, scenario, correlation=correlation, relations=[f"{FILM} < {MU}"])
    assert (found.correlations, found.relations) == ({(FILM, SKIN): 0.3}, ())
    assert set(found.draw(1, 0, 10)) == {FILM, SKIN}
    members = {label: {"share": group["share"], "space": own} for label, group in MOISTURE.items()}
    found = space(None, scenario, groups={"moisture": members})
    assert (found.groupings, set(found.draw_groups(1, 0, 10))) == ({}, set())
    assert set(found.draw(1, 0, 10)) == {FILM, SKIN}
    with pytest.raises(InputError, match="is set by moisture"):
        space({MU: uniform(0.2, 0.3)}, scenario)


PAIR, PLURAL = f"{FILM} ~ {SKIN}", "each pair of two different"
SUM = r"0.5 \(women\) \+ 0.4 \(men\) = 0.9"
WRONG_FILM = [
    ({"model": "Norml"}, "Did you mean 'Normal'"),
    ({"model": "Truncated"}, "Known: Empirical"),
    ({"model": "Normal", "mean": "1 um"}, "deviation: missing"),
    ({"model": "Uniform", "low": "1 um", "hihg": "2 um"}, "Did you mean 'high'"),
    (uniform("2 um", "1 um"), "expected more than low"),
    (uniform("1 V", "2 um"), "low = 1 V"),
    (uniform(math.nan, "2 um"), "finite number"),
    (uniform("1 um", "2 km"), "truncate .* high = '100 mm'"),
    (TABLE[FILM] | {"status": "read"}, "status = read: expected one of full text"),
    (TABLE[FILM] | {"optional": "yes"}, "expected true or false"),
    (measured(1e-6, file="a.csv"), "omit one of them"),
    (measured(file="nowhere.csv"), "nowhere.csv"),
    (measured(file="a.csv", column=1.5), "expected the heading"),
]
WRONG_PARTS = [
    (
        {"space": {"stack.insulator.thicknes": {"model": "Uniform"}}},
        "Did you mean 'stack.insulator.thickness'",
    ),
    ({"space": {MU: {"model": "Normal", "mean": 0.5, "deviation": 0.1}}}, "truncate .* low = '0'"),
    ({"relations": [f"{FILM} > {SKIN}"]}, "expected PATH < PATH"),
    ({"relations": [f"{FILM} < contact.area"]}, "'contact.area' is not in the space"),
    ({"relations": [f"{SKIN} < {FILM}"]}, "a share of 0 of the draws fulfils this relation"),
    ({"relations": "A < B"}, "expected a list of texts"),
    ({"correlation": {f"{FILM} ~ contact.area": 0.5}}, "'contact.area' is not in the space"),
    ({"correlation": {PAIR: 1.5}}, "coefficient from -1 to 1"),
    ({"correlation": {PAIR: 0.5, f"{SKIN} ~ {FILM}": 0.4}}, PLURAL),
    ({"correlation": {f"{FILM} ~ {FILM}": 1.0}}, PLURAL),
    ({"correlation": {f"{FILM} {SKIN}": 0.5}}, "PATH ~ PATH"),
    ({"groups": {"sex": {"women": {"share": 0.5}, "men": {"share": 0.4}}}}, SUM),
    ({"groups": {"sex": {"women": {"share": 1.5}}}}, "women.share = 1.5"),
    ({"groups": {"sex": {"women": {}}}}, "expected a part of 1"),
    ({"groups": {"sex": 1.0}}, "expected a table for each group"),
    ({"groups": {"sex": {"women": 1.0}}}, "expected a table with the share"),
    ({"groups": {"moisture": MOISTURE, "sex": MOISTURE}}, "is set by groups.moisture too"),
    ({"groups": {"moisture": MOISTURE | {"moist": {"share": 0.75}}}}, "groups that have none"),
    ({"space": {}}, "it has no parameter"),
    ({"spce": {}}, "Did you mean 'space'"),
    ({"schema": 2}, "reads schema = 1"),
]


@pytest.mark.parametrize(
    ("parts", "words"), [*(({"space": {FILM: wrong}}, words) for wrong, words in WRONG_FILM), *WRONG_PARTS]
)
def test_mistakes_are_one_sentence(parts, words):
    with pytest.raises(InputError, match=words) as caught:
        read_space(SINE, {"space": TABLE} | parts)
    assert all(len(problem) < 400 for problem in caught.value.problems)


def test_all_mistakes_are_listed_at_once():
    with pytest.raises(InputError) as caught:
        space({FILM: {"model": "Norml"}, SKIN: {"model": "Uniform"}}, relations=["A"], groups={"sex": 1.0})
    assert len(caught.value.problems) == 4


@pytest.mark.parametrize(
    ("source", "words"),
    [
        ("finger", "Did you mean 'fingers'"),
        ("nowhere.toml", "No such file"),
        (3, "expected a .toml file"),
        (b"\xff\xfe", "not a text in UTF-8"),
        (b"space = ", "not valid TOML"),
    ],
)
def test_a_source_that_is_no_space_is_refused(tmp_path, source, words):
    if isinstance(source, bytes):
        (tmp_path / "own.toml").write_bytes(source)
        source = tmp_path / "own.toml"
    with pytest.raises(InputError, match=words):
        read_space(SINE, source)


def test_correlations_that_contradict_each_other_name_the_nearest_mistake():
    mu = {MU: uniform(0.2, 0.9)}
    pairs = {PAIR: 0.9, f"{SKIN} ~ {MU}": 0.8, f"{FILM} ~ {MU}": 0.3}
    # with 0.8 and 0.3 given the third is at most 0.24 + sqrt(0.36*0.91) = 0.812, and the others have to change more
    with pytest.raises(InputError, match=rf"'{PAIR}' = 0\.81 in place of 0\.9"):
        space(mu, correlation=pairs)
    assert space(mu, correlation=pairs | {PAIR: 0.81}).correlations[FILM, SKIN] == 0.81
    more = dict.fromkeys((MU, "load.normal_force", "contact.area"), uniform(1e-4, 0.9))
    paths = [FILM, SKIN, *more]
    pairs = {f"{a} ~ {b}": -0.9 for i, a in enumerate(paths) for b in paths[i + 1 :]}
    # the smallest eigenvalue of equal coefficients r is 1 + 4 r: at most -0.25 is possible
    with pytest.raises(InputError, match=r"all of them times 0\.27 are possible"):
        space(more, correlation=pairs)


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
    st.builds(lambda a, b: Normal(mean=a, deviation=b).truncated(1e-9, 2e-2), NUMBERS, NUMBERS),
    st.builds(lambda a, b: LogNormal(median=a, factor=1.1 + b), NUMBERS, NUMBERS),
    st.builds(lambda a, b: LogNormal(median=a, factor=1.1 + b).truncated(a / 2, math.inf), NUMBERS, NUMBERS),
    st.builds(lambda a, b, c: Triangular(low=a, likely=a + b, high=a + b + c), NUMBERS, NUMBERS, NUMBERS),
    st.builds(lambda values: Empirical(values=tuple(values)), st.lists(NUMBERS, min_size=1, max_size=4)),
)


@st.composite
def spaces(draw):
    paths = draw(st.lists(st.sampled_from([FILM, SKIN, GAP]), min_size=1, unique=True))
    shares = draw(st.sampled_from([(0.25, 0.75), (1.0,)]))
    members = [Group(share=share, distributions={MU: draw(DISTRIBUTIONS)}) for share in shares]
    grouping = Grouping(groups={f"group_{number}": group for number, group in enumerate(members)})
    origins = {
        each: draw(ORIGINS) for each in (*paths, "groups.moisture.group_0", f"groups.moisture.group_0.{MU}")
    }
    return Space(
        distributions={path: draw(DISTRIBUTIONS) for path in paths},
        groupings={"moisture": grouping},
        correlations={(paths[0], MU): draw(st.floats(-1, 1))},
        title=draw(st.sampled_from(["", "own"])),
        units=dict.fromkeys(paths, "m") | {MU: "1"},
        origins={each: origin for each, origin in origins.items() if origin != Origin()},
    )


@settings(deadline=None, max_examples=30)
@given(spaces())
def test_a_space_reads_back_equal_from_toml(ours):
    assert read_space(SINE, tomllib.loads(ours.to_toml())) == ours
    assert read_space(SINE, ours.as_table()) == ours
    again = read_space(SINE, dataclasses.replace(ours, omitted={"a": "b"}))
    assert again.omitted == {"a": "b"}


@pytest.mark.parametrize(
    "table",
    [
        {"model": "Triangular", "low": 1e-6, "likely": 2e-6, "high": 1e308},
        {"model": "Triangular", "low": -1e308, "likely": 0.0, "high": "1e308 N"},
        {"model": "Uniform", "low": -1e308, "high": 1e308},
        {"model": "LogUniform", "low": 1e-300, "high": 1e101},
        {"model": "LogNormal", "median": 1.0, "factor": 1e308},
        {"model": "Normal", "mean": 1e308, "deviation": 1e308},
        {"model": "Empirical", "values": [1.0, 1e308]},
    ],
)
def test_a_number_whose_square_is_infinite_is_refused(table):
    with pytest.raises(InputError, match=r"normal_force\.\w+ = .*expected a number .* at most 1e\+100"):
        ev.read_space("vezzoli_2014/fig6", {"load.normal_force": table})
