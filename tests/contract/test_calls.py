"""Every public function with values of wrong types: each is read as at the command line, or refused in one sentence."""

import inspect
import pickle
import re
from pathlib import Path

import numpy as np
import pytest

import electrovib as ev
from electrovib.apps.calls import _ANYTHING, _kind
from electrovib.core.errors import ElectrovibError, InputError
from electrovib.core.mistakes import shown
from electrovib.core.signals import make_trace

SINE, FORCE, MEAN = "bau_2010/sine", "lateral_force_measured", "mean electrostatic_force"
SPACE = {"load.normal_force": {"model": "Uniform", "low": 0.4, "high": 0.6}}
LAWS = ["MaxwellStressInGap", "MaxwellStressInInsulator"]
TEXTURE = {"model": "Grating", "period": "1 mm", "amplitude": "0.01 mN"}
TIME = np.linspace(0.0, 0.4, 401)
ROSE = np.interp(TIME, [0.05, 0.06, 0.2, 0.21], [0.0, 1.0, 1.0, 0.0])
RECORD = make_trace({FORCE: (("time",), ROSE)}, {"time": TIME}, {})
FREE = {"scenario": SINE, "recordings": RECORD, "free": ["contact.area"]}
WANT = {"want": f"{MEAN} = 1 mN", "free": "drive.amplitude"}
DRAWS = {"space": SPACE, "n": 2, "seed": 1}
FILM = {"area": "1 cm2", "thickness": "200 um"}
ROUGH = {
    "roughness": ev.SelfAffine(rms=2e-6, hurst=0.8, longest=1e-3, roll_off=2.5e-4, shortest=2.5e-4),
    "body": ev.Elastic(modulus=1e7),
}
GIVEN = {
    "calibrate": {"reading": [0.0, 1.0, 2.0], "known": [0.0, 1.0, 2.0]},
    "check": {"drive": SINE},
    "compare_percepts": {"first": None, "second": None},
    "contact_capacitance": {"frequency": [1e3, 1e4], "impedance": [-6e6j, -6e5j]},
    "drive_for_force": {"target": "sine 5 Hz 1 mN", "method": "carrier"},
    "evidence": {"measured": "israr_2006/cylinder", "n": 2},
    "export": {"path": "o.cir"},
    "export_waveform": {"path": "o.csv", "edge": "line"},
    "find_value": WANT,
    "fit": FREE,
    "fit_contact": {"load": [0.1, 1.0, 3.0], "capacitance": [1e-10, 2e-10, 3e-10], **ROUGH},
    "fit_laws": FREE,
    "fit_separately": FREE,
    "fit_material": {"files": "s.csv", "recipe": ev.SpectrumRecipe(**FILM)},
    "fit_power_law": {"x": [1.0, 2.0, 3.0], "y": [1.0, 4.0, 9.0]},
    "hysteresis": {"voltages": [0.0], "surface": None, "pressure": 5e3, "electrical_thickness": 1e-6},
    "import_file": {"path": "c.csv", "columns": {FORCE: "u [N]"}, "time": "t [s]"},
    "import_material": {"path": "s.csv", "recipe": ev.SpectrumRecipe(**FILM)},
    "load": {"source": SINE},
    "measure_ring": {"record": RECORD},
    "measure_rings": {"record": RECORD},
    "measure_times": {"record": RECORD},
    "merge_traces": {"reference": RECORD, "other": RECORD, "shift": 0.0},
    "open_study": {"path": "none.zarr"},
    "open_trace": {"path": "none.nc"},
    "perceive": {"source": SINE},
    "plan_experiment": {"models": LAWS, "over": {"drive.amplitude": [10.0]}, "space": SPACE, "n": 2},
    "plan_plate": {"over": {"drive.amplitude": [50.0, 100.0]}, "refine": 0},
    "prepare": {"free": ["load.normal_force"], "quantity": [MEAN]},
    "read_recording": {"path": "c.csv", "channels": None},
    "read_space": {"source": SPACE},
    "reduce_swipe": {"recording": RECORD},
    "reduce_swipes": {"recording": RECORD},
    "report": {"traces": RECORD, "path": "o.html"},
    "rough_contact": ROUGH,
    "run_bench": {"simulate": True},
    "save": {"trace": RECORD, "path": "o.nc"},
    "scenario_of": {"trace": RECORD},
    "sensitivity": {"quantity": MEAN, **DRAWS},
    "study": DRAWS,
    "sweep": {"over": {"load.normal_force": [0.4]}},
    "texture_drive": {"texture": TEXTURE, "path": "50 mm/s", "carrier": "3 kHz"},
    "texture_stream": {"texture": TEXTURE},
    "value_for_share": {**WANT, "space": SPACE, "share": 0.5, "seed": 1, "n": 20},
}
"""Public function to what it needs besides a scenario."""
FUNCTIONS = [
    name for name in dir(ev) if callable(getattr(ev, name)) and not isinstance(getattr(ev, name), type)
]


def junk():
    """Return values of types that hardly any parameter has."""
    yield from (b"bytes", {1, 2}, object(), 1j, len, int, np.array(["a"]), [None], [[1], [2, 3]], {1: 2})
    yield from (7, True, np.float64(0.5))


@pytest.fixture(scope="module")
def records(tmp_path_factory):
    folder = tmp_path_factory.mktemp("records")
    ev.save(RECORD, folder / "t.nc")
    ev.save(ev.simulate(SINE), folder / "run.nc")
    rows = "".join(f"{at / 1000},{at}\n" for at in range(30))
    (folder / "c.csv").write_text(f"t,u\n{rows}")
    (folder / "s.csv").write_text(f"frequency [Hz],z' [ohm],z'' [ohm]\n{rows}")
    return folder


@pytest.fixture
def here(records, monkeypatch):
    """Return the folder of the records; pages are not served."""
    monkeypatch.chdir(records)
    monkeypatch.setattr("nicegui.ui.run", lambda **_: None)
    monkeypatch.setattr("nicegui.app.add_middleware", lambda *_, **__: None)
    return records


def refused(name, parameter, value):
    """Call a function with one value of a wrong type: the error, None where it takes it."""
    function = getattr(ev, name)
    needed = {"scenario": SINE} if "scenario" in inspect.signature(function).parameters else {}
    try:
        function(**{**needed, **GIVEN.get(name, {}), parameter: value})
    except ElectrovibError as error:
        return error
    return None


def is_taken(kind, value):
    """Tell whether an annotation allows a value, or one that it can be read as."""
    try:
        return kind.holds(value) or kind.convert(value) is not None
    except (ValueError, TypeError, OverflowError):
        return False


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_wrong_type_is_refused_with_function_argument_and_value(name, here):
    function = getattr(ev, name)
    for parameter, each in inspect.signature(function).parameters.items():
        if each.kind is each.VAR_KEYWORD:
            continue
        kind = _kind(each.annotation, "1")
        for value in junk():
            if kind is _ANYTHING:
                refused(name, parameter, value)  # by the function itself, if it is
            elif not is_taken(kind, value):
                (problem,) = (
                    each for each in refused(name, parameter, value).problems if each.path == parameter
                )
                assert problem.value == shown(value)
                assert problem.reason.startswith(f"{name} takes ")


MOST = 10
"""Parameters of a public function, of which nobody keeps more apart."""


@pytest.mark.parametrize("name", FUNCTIONS)
def test_no_function_has_more_parameters_than_one_keeps_apart(name):
    assert len(inspect.signature(getattr(ev, name)).parameters) <= MOST, (
        "what is one thing becomes one model, such as Scaling or SpectrumRecipe"
    )


def test_every_annotation_is_understood():
    """A parameter that stands for several types is refused by its function, in tests/contract/test_doors.py and above."""
    anything = {
        str(each.annotation)
        for name in FUNCTIONS
        for each in inspect.signature(getattr(ev, name)).parameters.values()
        if _kind(each.annotation, "1") is _ANYTHING
    }
    assert all(re.search("Any$|Source|Amount|AllLimits", annotation) for annotation in anything), anything


PLAUSIBLE = {
    "one time": (
        lambda: list(ev.simulate(SINE, time=0.1, signals="electrostatic_force").time.values),
        lambda: [0.1],
    ),
    "times as texts": (
        lambda: list(ev.simulate(SINE, time=["1 ms", "2 ms"]).time.values),
        lambda: [0.001, 0.002],
    ),
    "a list of times": (lambda: list(ev.simulate(SINE, time=[0, 1]).time.values), lambda: [0.0, 1.0]),
    "a rate": (lambda: exported("192 kHz").tolist(), lambda: exported(192e3).tolist()),
    "a window": (
        lambda: repr(ev.measure_times(RECORD, window="60 ms")),
        lambda: repr(ev.measure_times(RECORD, window=0.06)),
    ),
    "levels in per cent": (
        lambda: repr(ev.measure_times(RECORD, levels=["10 %", "90 %"])),
        lambda: repr(ev.measure_times(RECORD, levels=(0.1, 0.9))),
    ),
    "a Trace by its file": (lambda: ev.scenario_of("run.nc"), lambda: ev.load(SINE)),
    "a Trace by its path": (lambda: ev.scenario_of(Path("run.nc")), lambda: ev.load(SINE)),
    "a range of a sweep": (
        lambda: list(ev.sweep(SINE, "drive.amplitude=1V:2V:3")["drive.amplitude"].values),
        lambda: [1.0, 1.5, 2.0],
    ),
    "values with units": (
        lambda: list(
            ev.compare(SINE, models=LAWS[0], over={"drive.amplitude": ["1 V", "2 V"]}).panels[-1].curves[0].x
        ),
        lambda: [1.0, 2.0],
    ),
    "one parameter to fit": (
        lambda: [*ev.prepare(SINE, free="load.normal_force", quantity=MEAN)({"load.normal_force": 1.0})],
        lambda: [MEAN],
    ),
    "a count as a text": (
        lambda: ev.study(SINE, SPACE, n="1e1", seed="3").attrs["fingers"],
        lambda: ev.study(SINE, SPACE, n=10, seed=3).attrs["fingers"],
    ),
    "a whole number as a float": (
        lambda: ev.study(SINE, SPACE, n=10.0, seed=np.int64(3)).attrs["fingers"],
        lambda: ev.study(SINE, SPACE, n=10, seed=3).attrs["fingers"],
    ),
    "a truth as a number": (
        lambda: ev.init(SINE, output="i.toml", force=1),
        lambda: ev.init(SINE, output="i.toml", force=True),
    ),
    "a list in place of an array": (
        lambda: repr(ev.fit_power_law([1, 2, 3], [1, 4, 9])),
        lambda: repr(ev.fit_power_law(np.arange(1.0, 4.0), np.arange(1.0, 4.0) ** 2)),
    ),
    "a voltage": (lambda: refusal(voltage="100 V"), lambda: refusal(voltage=100.0)),
}
"""What a person may well write, and the same as it is declared."""


def exported(rate):
    limits = {"voltage": "1 kV", "current": "10 mA"}
    ev.export_waveform(SINE, "a.csv", limits=limits, edge="line", rate=rate, force=True)
    return np.loadtxt("a.csv", delimiter=",", skiprows=12)


def refusal(**options):
    with pytest.raises(InputError) as error:
        ev.equilibrium(SINE, **options)
    return str(error.value)


@pytest.mark.parametrize("what", PLAUSIBLE)
def test_what_a_person_may_well_write_is_read(what, here):
    written, declared = PLAUSIBLE[what]
    assert written() == declared()


def test_all_wrong_arguments_are_told_at_once_with_what_is_taken():
    with pytest.raises(InputError) as error:
        ev.export_waveform(SINE, "a.csv", rate="192 V", ramp=b"1", scaling=20.0, force="yes", limits=None)
    assert list(error.value.problems) == [
        "rate = '192 V': export_waveform takes a frequency, for instance '1 kHz'",
        "ramp = b'1': export_waveform takes a time, for instance '36 ms'",
        "scaling = 20.0: export_waveform takes a Scaling",
        "force = 'yes': export_waveform takes True or False",
    ]
    with pytest.raises(InputError, match="n = '1,000': study takes a whole number"):
        ev.study(SINE, SPACE, n="1,000", seed=1)
    with pytest.raises(InputError, match="edges = 'up': measure_times takes 'both' or 'rising' or 'falling'"):
        ev.measure_times(RECORD, edges="up")
    with pytest.raises(InputError, match=r"over = .*: sweep takes a list of a text or a table of"):
        ev.sweep(SINE, {"drive.amplitude": ["40 V", "80 q", None]})
    with pytest.raises(InputError, match=r"noise = .*: plan_experiment takes 2 values"):
        ev.plan_experiment(SINE, LAWS, over={}, space=SPACE, noise=(1, 2, 3))


def test_a_name_that_is_unknown_or_missing_is_told_as_python_does():
    with pytest.raises(TypeError, match="unexpected keyword argument 'tim'"):
        ev.simulate(SINE, tim=1)
    with pytest.raises(TypeError, match="missing 1 required positional argument: 'scenario'"):
        ev.simulate()


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_function_shows_its_own_signature_and_can_be_pickled(name):
    function = getattr(ev, name)
    assert function is getattr(ev, name)
    assert inspect.signature(function) == inspect.signature(function.__wrapped__)
    assert (function.__module__, function.__name__) == ("electrovib", name)
    assert function.__doc__ == function.__wrapped__.__doc__
    assert pickle.loads(pickle.dumps(function)) is function
