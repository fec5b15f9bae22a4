"""Former names are read with a warning that says what to use; here they are those of a test, put into the tables."""

import importlib
import inspect
import re
from dataclasses import replace

import numpy as np
import pytest

import electrovib as ev
from electrovib.core import deprecation
from electrovib.core.deprecation import Former
from electrovib.core.errors import InputError
from electrovib.core.paths import quantity_at, value_at
from electrovib.physics.force import ForceLaw
from electrovib.scenario import Scenario
from electrovib.studies.population import StudyCancelledError

GAP, FIG6 = "vezzoli_2014/fig6_gap", "vezzoli_2014/fig6"


def former(now):
    return Former(now, since="1.1.0", goes="2.0.0")


def warns(name, now, since="1.1.0"):
    text = f"{name} is deprecated since electrovib {since} and goes in 2.0.0: use {now}"
    return pytest.warns(DeprecationWarning, match=f"^{re.escape(text)}$")


@pytest.fixture
def load(monkeypatch):
    """Give a load whose parameter and whose place in a scenario have former names."""
    found = ev.load(GAP).load
    monkeypatch.setattr(Scenario, "former", {"weight": former("load")})
    monkeypatch.setattr(type(found), "former", {"newtons": former("normal_force")})
    return found


def test_nothing_has_a_former_name_before_a_release_has_had_it():
    assert not deprecation.FORMER
    with pytest.raises(AttributeError, match="no attribute 'simulate_scenario'"):
        _ = ev.simulate_scenario


def test_a_former_name_of_the_package_warns_where_it_is_used(monkeypatch):
    monkeypatch.setitem(deprecation.FORMER, "simulate_scenario", former("simulate"))
    with warns("electrovib.simulate_scenario", "simulate") as told:
        assert ev.simulate_scenario is ev.simulate
    assert told[0].filename == __file__
    with warns("electrovib.simulate_scenario", "simulate") as told:
        from electrovib import simulate_scenario
    assert (simulate_scenario, told[0].filename) == (ev.simulate, __file__)
    assert "simulate_scenario" not in dir(ev)


def test_a_former_parameter_is_read_in_a_table_and_as_an_attribute(load):
    with warns("Load.newtons", "normal_force") as told:
        assert type(load)(newtons=2.0).normal_force == 2
    assert {each.filename for each in told} == {__file__}
    with warns("Load.newtons", "normal_force"):
        assert load.newtons == load.normal_force
    table = ev.load(GAP).to_dict()
    table["weight"] = table.pop("load")
    with warns("Scenario.weight", "load"):
        assert ev.load(table) == ev.load(GAP)
    with pytest.raises(AttributeError):
        _ = load.pounds


def test_a_former_parameter_is_a_path(load):
    scenario = ev.load(GAP)
    with warns("Scenario.weight", "load"), warns("Load.newtons", "normal_force"):
        changed = scenario.replace({"weight.newtons": "2 N"})
    assert changed == scenario.replace({"load.normal_force": 2.0})
    with warns("Load.newtons", "normal_force"):
        assert value_at(changed, "load.newtons") == 2
    with warns("Load.newtons", "normal_force"):
        assert quantity_at(changed, "load.newtons") is quantity_at(changed, "load.normal_force")
    with warns("Load.newtons", "normal_force"):
        swept = ev.sweep(scenario, {"load.newtons": [1.0, 2.0]}, quantity=["mean lateral_force"])
    assert swept["mean lateral_force"].size == 2


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_both_names_at_once_are_a_mistake(load):
    with pytest.raises(InputError, match="unknown parameter 'newtons' of Load"):
        ev.load(GAP, changes={"load": {"newtons": 2.0, "normal_force": 1.0}})
    with pytest.raises(InputError, match="unknown parameter 'newtons'"):
        ev.load(GAP).replace({"load.newtons": 2.0, "load.normal_force": 1.0})


def test_a_former_model_is_read_by_its_name(monkeypatch):
    law = ev.load(GAP).force
    monkeypatch.setattr(ForceLaw, "former", {"StressInGap": former(type(law).__name__)})
    with warns("ForceLaw.StressInGap", type(law).__name__):
        found = ev.load("vezzoli_2014/fig6", changes={"force": {"model": "StressInGap"}})
    assert found.force == law


def test_the_table_is_looked_up_only_for_a_name_that_is_unknown(monkeypatch):
    monkeypatch.setitem(deprecation.FORMER, "simulate", former("load"))
    assert importlib.import_module("electrovib").simulate is not ev.load


def test_former_parameters_of_a_function_are_read_with_a_warning():
    changes = {"drive.high": [100.0]}
    with warns("sweep(quantities=)", "quantity", since="1.0.0"):
        former_ = ev.sweep("vezzoli_2014/fig6", changes, quantities=["peak current"])
    assert former_.identical(ev.sweep("vezzoli_2014/fig6", changes, quantity=["peak current"]))
    with pytest.raises(TypeError, match="quantities"):
        ev.sweep("vezzoli_2014/fig6", changes, quantities=["peak current"], quantity=["peak current"])


def test_every_former_parameter_stands_for_a_present_one():
    for name, parameters in deprecation.FORMER_PARAMETERS.items():
        present = inspect.signature(getattr(ev, name)).parameters
        for old, new in parameters.items():
            assert old not in present
            assert new.now in present


SINE = "bau_2010/sine"
WAVE = {"set": {"limits.voltage": "1 kV", "limits.current": "10 mA"}, "edge": "line", "ramp": 1e-3}
CODES = WAVE | {"instrument": "hp_33120a", "edge": 1e-5}
SLOW = {"drive": {"model": "Trapezium", "high": 500.0, "rise": 1e-7, "hold": 5e-3, "fall": 1e-7}}
SLOW |= {"circuit.amplifier": {"bandwidth": 1.0}, "limits": {"voltage": "1 kV", "current": "250 uA"}}
RIDGES = {"model": "Grating", "period": "2 mm", "amplitude": "0.5 mN"}
TEXTURE = {"texture": RIDGES, "limits": {"voltage": "300 V", "current": "10 mA"}, "rate": 1e4}
FILM = {"area": "1 cm2", "thickness": "200 um"}


def written(scenario=SINE, name="a.csv", **options):
    return ev.export_waveform(scenario, name, force=True, **options)


def stream(**options):
    return ev.texture_stream("vezzoli_2014/fig6", **TEXTURE, **options).largest_force


def drive(**options):
    return ev.texture_drive("vezzoli_2014/fig6", path="0.5 m/s", **TEXTURE, **options).largest_force


def studied(**options):
    return ev.study(SINE, "fingers", n=2, seed=1, **options)


def cancelled():
    with pytest.raises(StudyCancelledError) as ended:
        ev.study(SINE, "fingers", n=2000, seed=1, progress=lambda done, _: done >= 1)
    return str(ended.value)


def told():
    steps = []
    ev.run_bench("vezzoli_2014/fig6", simulate=True, report=steps.append)
    return steps


def impedance(name, file="z.csv", **values):
    """What a parameter of the recipe of a spectrum stands for, as a call of before and one of today."""
    recipe = ev.SpectrumRecipe(**FILM)
    return (
        lambda: ev.import_material(file, recipe, **{name: values["old"]}).to_toml(),
        lambda: ev.import_material(file, replace(recipe, **{name: values["old"]})).to_toml(),
    )


def too_little():
    with pytest.raises(InputError, match="the signals of a block") as refused:
        studied(budget_memory="16 kB")
    return str(refused.value)


LEFT = {
    "export_waveform.amplifier_present": (
        lambda: written(
            ev.load(FIG6, changes=SLOW), edge="line", rate=1e7, amplifier_present=True
        ).check.value("peak current"),
        lambda: written(
            ev.load(FIG6, changes=SLOW).replace({"circuit.amplifier.hardware": "ours, 1 Hz"}),
            edge="line",
            rate=1e7,
        ).check.value("peak current"),
    ),
    "export_waveform.largest_error": (
        lambda: written(**WAVE, rate=1500.0, largest_error="50 %").waveform.share > 0.01,
        lambda: True,
    ),
    "export_waveform.full_scale": (
        lambda: written(name="a.wav", **WAVE, full_scale="400 V").full_scale,
        lambda: written(name="a.wav", **WAVE, scaling=ev.Scaling(full_scale="400 V")).full_scale,
    ),
    "export_waveform.gain": (
        lambda: written(**CODES, gain=20).notes,
        lambda: written(**CODES, scaling=ev.Scaling(gain=20)).notes,
    ),
    "export_waveform.remarks": (
        lambda: "by hand" in written(**WAVE, remarks=["by hand"]).notes,
        lambda: True,
    ),
    "import_file.title": (
        lambda: ev.import_file("z.csv", title="mine").title,
        lambda: ev.import_file("z.csv").assign_attrs(title="mine").title,
    ),
    "import_material.area": impedance("area", old="2 cm2"),
    "import_material.thickness": impedance("thickness", old="100 um"),
    "import_material.series_resistance": impedance("series_resistance", old="100 ohm"),
    "import_material.parallel_capacitance": impedance("parallel_capacitance", old="1 pF"),
    "import_material.columns": impedance(
        "columns", "mute.csv", old={"frequency": "a [Hz]", "real": "b [ohm]", "imaginary": "c [ohm]"}
    ),
    "import_material.reader": impedance("reader", old="text"),
    "import_material.delimiter": impedance("delimiter", old=","),
    "import_material.decimal_comma": impedance("decimal_comma", old=False),
    "import_material.part": impedance("part", old="spectrum 1"),
    "run_bench.report": (lambda: told()[0], lambda: "identify"),
    "study.budget_memory": (lambda: "they may take 0.016 MB" in too_little(), lambda: True),
    "study.progress": (lambda: "the same call continues" in cancelled(), lambda: True),
    "texture_drive.frequency": (lambda: drive(frequency="100 Hz"), drive),
    "texture_stream.frequency": (lambda: stream(frequency="100 Hz"), stream),
}
"""What is called with a parameter that has left the signature, and the same today."""


@pytest.fixture
def spectra(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    frequency = np.geomspace(10.0, 1e5, 30)
    impedance = 1 / (1e-6 + 2j * np.pi * frequency * 20e-12)
    rows = "".join(
        f"{at!r},{each.real!r},{each.imag!r}\n"
        for at, each in zip(frequency.tolist(), impedance.tolist(), strict=True)
    )
    (tmp_path / "z.csv").write_text(f"frequency [Hz],z' [ohm],z'' [ohm]\n{rows}")
    (tmp_path / "mute.csv").write_text(f"a,b,c\n{rows}")


@pytest.mark.usefixtures("spectra")
@pytest.mark.parametrize("name", LEFT)
def test_a_parameter_that_has_left_a_signature_still_counts_and_warns(name):
    function, _, parameter = name.partition(".")
    before, today = LEFT[name]
    now = deprecation.GONE_PARAMETERS[function][parameter].now
    with warns(f"{function}({parameter}=)", now, since="1.0.0") as said:
        found = before()
    assert {each.filename for each in said} == {__file__}
    assert found == today()


def test_the_frequency_of_a_texture_without_a_carrier_counts():
    for call in (drive, stream):
        with pytest.warns(DeprecationWarning, match="frequency="):
            assert call(frequency="1 kHz") != call()


@pytest.mark.usefixtures("spectra")
def test_what_export_passes_on_counts_and_warns_too():
    with warns(
        "export_waveform(remarks=)", "the title of the scenario, which the file states", since="1.0.0"
    ):
        path = ev.export(SINE, "a.csv", remarks=["by hand"], **WAVE)
    assert "# by hand\n" in path.read_text(encoding="utf-8")


@pytest.mark.filterwarnings("ignore:export_waveform")
def test_a_wrong_value_of_what_has_left_is_refused_as_before():
    with pytest.raises(InputError) as error:
        written(amplifier_present="no", largest_error=b"1")
    assert list(error.value.problems) == [
        "amplifier_present = 'no': export_waveform takes True or False",
        "largest_error = b'1': export_waveform takes a plain number",
    ]


def test_what_has_left_a_signature_is_listed_once_and_tried():
    names = {f"{function}.{name}" for function, each in deprecation.GONE_PARAMETERS.items() for name in each}
    assert names == LEFT.keys()
    for function, each in deprecation.GONE_PARAMETERS.items():
        assert not each.keys() & inspect.signature(getattr(ev, function)).parameters.keys()


def test_a_value_of_what_has_left_holds_for_its_call_alone():
    """A function that is called within, by its public name too, takes its own."""
    expected = stream()
    with deprecation.former_values(frequency="1 kHz"):
        assert deprecation.former_value("frequency", 1) == "1 kHz"
        assert stream() == expected
        assert deprecation.former_value("frequency", 1) == "1 kHz"
    assert deprecation.former_value("frequency", 1) == 1
