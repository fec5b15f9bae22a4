"""What a scenario is made of, as rows."""

from electrovib.core.discovery import papers
from electrovib.scenario import load
from electrovib.view.summary import (
    DEFAULT,
    NOT_GIVEN,
    model_rows,
    parameter_rows,
    readable_equation,
    references,
    walk_models,
)


def rows_of(scenario, swept=None):
    return {row.path: row for row in parameter_rows({"a": scenario}, {"a": swept or {}})}


def test_every_physical_parameter_has_a_row_with_value_and_meaning(scenario):
    found = rows_of(scenario)
    assert list(found) == [path for path, _, _ in scenario.parameters()]
    assert found["stack.gap.thickness"].values == ("5 µm",)
    assert found["stack.gap.thickness"].meaning == "thickness of the layer"
    assert found["stack.gap.breakdown_field"].values == ("–",)


def test_sources_are_those_of_the_file_else_default_or_not_given(scenario):
    found = rows_of(scenario)
    assert found["drive.high"].sources == ("printed",)
    assert found["stack.insulator.material.permittivity"].sources == ("data sheet of the film",)
    assert found["drive.low"].sources == (DEFAULT,)
    assert found["stack.gap.breakdown_field"].sources == (DEFAULT,)
    assert found["drive.rise"].sources == (NOT_GIVEN,)
    assert found["circuit.return_path.resistance"].sources == (NOT_GIVEN,)
    changed = scenario.replace({"drive.rise": "1 ms"})
    assert rows_of(changed)["drive.rise"].sources == ("set by the user",)


def test_a_parameter_that_follows_a_swept_one_shows_no_value(scenario):
    square = scenario.replace({"drive": {"model": "Square", "high": 75, "low": -75, "frequency": 60}})
    found = rows_of(square, {"drive.amplitude": "10 V … 20 V (3 values)"})
    for path in ("drive.high", "drive.low"):
        assert (found[path].values, found[path].sources) == (("follows drive.amplitude",), ("swept",))
    assert found["drive.frequency"].values == ("60 Hz",)
    found = rows_of(square, {"drive.high": "10 V … 20 V (3 values)"})
    assert found["drive.high"].values == ("10 V … 20 V (3 values)",)
    assert found["drive.low"].values == ("follows drive.high",)
    row = rows_of(scenario, {"drive.rise": "1 ms … 9 ms (3 values)"})["drive.rise"]
    assert (row.values, row.sources) == (("1 ms … 9 ms (3 values)",), ("swept",))
    both = rows_of(square, {"drive.high": "10 V … 20 V (3 values)", "drive.low": "-1 V … 0 V (2 values)"})
    assert both["drive.low"].values == ("-1 V … 0 V (2 values)",)
    assert rows_of(square, {"no.such": "1 … 2 (2 values)"})["drive.low"].values[0].endswith("75 V")


def test_what_differs(scenario):
    changed = scenario.replace({"force": {"model": "EffectiveMedium"}, "stack.gap.thickness": "1 um"})
    rows = parameter_rows({"a": scenario, "b": changed}, {})
    differing = {row.path: row.values for row in rows if row.differs}
    assert differing == {
        "force.model": ("MaxwellStressInGap", "EffectiveMedium"),
        "stack.gap.thickness": ("5 µm", "1 µm"),
    }
    assert not any(row.differs for row in parameter_rows({"a": scenario, "b": scenario}, {}))


def test_terms_of_a_sum_have_rows(scenario):
    terms = [{"strength": 900, "relaxation_time": "2 ms"}, {"strength": 300, "relaxation_time": "20 us"}]
    skin = {"model": "Prony", "permittivity_high": 50, "terms": terms, "conductivity": 1e-6}
    changed = scenario.replace({"stack.stratum_corneum.material": skin})
    row = rows_of(changed)["stack.stratum_corneum.material.terms.1.relaxation_time"]
    assert row.values == ("20 µs",)
    assert "stack.stratum_corneum.material.terms.0" in dict(walk_models(changed))


def test_models_are_those_that_were_chosen(scenario):
    found = {row.path: row for row in model_rows(scenario)}
    chosen = (
        "drive force friction contact load.time_profile motion.time_profile circuit.return_path time.initial_state"
        " stack.insulator.material stack.gap.material stack.stratum_corneum.material"
    )
    assert set(found) == set(chosen.split())
    law = found["force"]
    assert law.name == "MaxwellStressInGap"
    assert law.equations == ("pressure = ε₀·E²/2",)
    assert law.facts == ("Maxwell stress evaluated in: gap", "source status: derived")
    assert law.notes.startswith("p = eps0 E^2/2, equal to the virtual work")
    assert "``" not in law.notes


def test_equations_are_written_for_people():
    assert readable_equation("eps0*E**2/2") == "ε₀·E²/2"
    assert readable_equation("pixel**20") == "pixel^20"
    found = readable_equation("a/(1 + (2*pi*I*frequency*tau)**(1 - b))")
    assert found == "a/(1 + (2·π·j·frequency·tau)^(1 - b))"


def test_references_are_publications_with_what_is_from_each(scenario):
    """Neither a choice of ours nor a number, a material or a change of the user."""
    medium = scenario.replace({"force": {"model": "EffectiveMedium"}})
    told = {
        "contact.area": "Nobody 1999, table 2",
        "load.normal_force": "air",
        "drive.high": "set by the user to glass of 2019",
        "drive.rise": "10000000.0",
        "drive.fall": "not printed; the pulse of vezzoli_2014",
    }
    medium = medium.model_copy(update={"sources": told})
    found = dict(references({"a": medium, "b": medium}))
    vezzoli = str(papers()["vezzoli_2014"].CITATION)
    assert found == {
        type(medium.force).reference: "EffectiveMedium",
        "Nobody 1999, table 2": "2 values",
        vezzoli: "2 values",
    }
    own = dict(references({"": load("vezzoli_2014/fig6").replace({"drive.high": "500 V"})}))
    assert own == {vezzoli: "Vezzoli2014Causal, the set-up, 6 values"}
