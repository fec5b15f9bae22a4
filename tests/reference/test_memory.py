"""Skins with a memory as long as the run, against numerical inverse Laplace transforms of the laws as declared."""

import re
from pathlib import Path

import mpmath
import numpy as np
import pytest
from scenario_parts import AREA, SETTLED, debye, diagnostics, grounded, sine, square, step, trapezium

from electrovib.core.constants import eps0
from electrovib.exports.spice.circuit import BuiltCircuit
from electrovib.papers.palmar_1995 import skins
from electrovib.physics.conduction import FieldConduction
from electrovib.physics.material import ColeCole, ConstantPhase, HavriliakNegami
from electrovib.physics.material.tabulated import Tabulated
from electrovib.scenario import load
from electrovib.solve.choice import solve
from electrovib.solve.diagnostics.memory import FORCE, _rounding, answer_errors
from electrovib.solve.diagnostics.probes import PROBES, TAIL
from electrovib.solve.expanded import worst_of
from electrovib.solve.simulate import simulate
from electrovib.solve.stack.expand import MARGIN, modes, phasors, reductions, run_band, shortest_time
from electrovib.solve.stack.keys import AmplitudeOf, FieldOf

SKIN, FILM, COATING = 200e-6, (90e-6, 3.35), (1e-6, 3.9)
DIGITS, NODES = 25, 30
QUANTITIES = ("skin", "gap", "effective")
DRY = skins()["dry_men"].material
BLOCKING = ConstantPhase(permittivity=11.82, reference_frequency=100.0, exponent=0.78009, conductivity=0.0)
"""A constant phase without conduction whose exact step response on the film is the one of the figures below."""
HELD = step(100.0)


def inverse_laplace(transforms, time):
    """Fixed Talbot contour of Abate and Valko, Int. J. Numer. Meth. Engng 60, 979 (2004), of several at once."""
    time = mpmath.mpf(time)
    radius = mpmath.mpf(2 * NODES) / (5 * time)
    rows = [[mpmath.exp(radius * time) * value / 2 for value in transforms(radius)]]
    for node in range(1, NODES):
        angle = node * mpmath.pi / NODES
        cotangent = mpmath.cot(angle)
        s = radius * angle * mpmath.mpc(cotangent, 1)
        weight = mpmath.exp(s * time) * mpmath.mpc(1, angle + (angle * cotangent - 1) * cotangent)
        rows.append([mpmath.re(weight * value) for value in transforms(s)])
    return [mpmath.re(sum(column)) * radius / NODES for column in zip(*rows, strict=True)]


def bound_permittivity(skin, s):
    """The published formulas with s in the place of j w."""
    if isinstance(skin, ConstantPhase):
        power = mpmath.mpf(skin.exponent) - 1
        ratio = s / (2 * mpmath.pi * skin.reference_frequency)
        return skin.permittivity * ratio**power / mpmath.cos(power * mpmath.pi / 2)
    if isinstance(skin, ColeCole):
        spreads = [(s * term.relaxation_time) ** (1 - mpmath.mpf(term.broadening)) for term in skin.terms]
        parts = [term.strength / (1 + spread) for term, spread in zip(skin.terms, spreads, strict=True)]
        return skin.permittivity_high + sum(parts)
    spread = (s * skin.relaxation_time) ** mpmath.mpf(skin.broadness)
    return skin.permittivity_high + skin.strength / (1 + spread) ** mpmath.mpf(skin.skewness)


def laws(skin, film, resistance, s):
    """Voltage of the skin, field of a vanishing gap and effective voltage of the law of Vezzoli et al. 2014, per volt."""
    thickness, permittivity = film
    epsilon = bound_permittivity(skin, s)
    own = SKIN / (s * eps0 * epsilon + skin.conductivity)
    other = thickness / (s * eps0 * permittivity)
    current = 1 / (own + other + resistance * AREA)
    lost = current / s - eps0 * epsilon * own * current / SKIN
    effective = (own + other) * current - lost * thickness / (eps0 * permittivity)
    return [own * current, current / (s * eps0), effective]


def exact(skin, film, resistance, drive, times):
    """Response of the three to a step, or to the four corners of a trapezoidal pulse, shape (3, n)."""
    bends, slopes, power = [0.0], [drive.get("level")], 1
    if drive["model"] == "Trapezium":
        bends, power = np.cumsum([0.0, drive["rise"], drive["hold"], drive["fall"]]).tolist(), 2
        up, down = (drive["high"] / mpmath.mpf(drive[side]) for side in ("rise", "fall"))
        slopes = [up, -up, -down, down]

    def transforms(s):
        return [value / s**power for value in laws(skin, film, resistance, s)]

    found = np.zeros((len(QUANTITIES), len(times)))
    with mpmath.workdps(DIGITS):
        for place, time in enumerate(times.tolist()):
            total = [mpmath.mpf(0)] * len(QUANTITIES)
            for bend, slope in zip(bends, slopes, strict=True):
                if time > bend:
                    since = mpmath.mpf(time) - mpmath.mpf(bend)
                    parts = inverse_laplace(transforms, since)
                    total = [sum_ + slope * part for sum_, part in zip(total, parts, strict=True)]
            found[:, place] = total
    return found


def laplace(transform, times):
    """One transform at several times."""
    with mpmath.workdps(DIGITS):
        values = [inverse_laplace(lambda s: [transform(s)], time)[0] for time in times.tolist()]
    return np.array(values, dtype=float)


def on(film, skin, drive, *, resistance=1000.0, force="Vezzoli2014Causal", settled=False):
    changes = {
        "stack.insulator.thickness": film[0],
        "stack.insulator.material.permittivity": film[1],
        "stack.stratum_corneum.material": skin if isinstance(skin, dict) else skin.to_dict(),
        "drive": drive,
        "circuit.return_path": grounded(resistance),
        "force": {"model": force},
    }
    return load("vezzoli_2014/fig6").replace(changes | (SETTLED if settled else {}))


def found_in(trace, quantity):
    if quantity == "skin":
        return trace.field.sel(layer="stratum_corneum").values * SKIN
    if quantity == "effective":
        return trace.effective_voltage.values
    return trace.displacement.sel(layer="insulator").values / eps0  # as MaxwellStressInGap without a gap


@pytest.mark.parametrize(
    ("skin", "drive", "times", "quantity", "expected"),
    [
        (DRY, trapezium(1000.0, 0.025, 2.0, 0.025), [0.5, 1.0, 2.0], "effective", [8.70, 5.04, 2.95]),
        (DRY, step(1000.0), [10.0], "effective", [0.865]),
        (BLOCKING, step(1.0), [1.0, 10.0, 100.0], "skin", [0.1091, 0.0684, 0.0423]),
    ],
    ids=["held for 2 s", "held for 10 s", "without conduction"],
)
def test_a_voltage_that_is_held(skin, drive, times, quantity, expected):
    """Within 1 % of the figures, and within the error that the Trace states of the transform."""
    times = np.array(times)
    trace = simulate(on(FILM, skin, drive), time=times)
    found = found_in(trace, quantity)
    np.testing.assert_allclose(found, expected, rtol=1e-2)
    truth = exact(skin, FILM, 1000.0, drive, times)[QUANTITIES.index(quantity)]
    assert np.max(np.abs(found / truth - 1)) <= trace.attrs["transfer_error"] < 1e-3


@pytest.mark.parametrize("settled", [True, False])
def test_a_slow_sine(settled):
    """0.02 Hz: the amplitude of the steady state, and of the fifth period from rest."""
    scenario = on(FILM, DRY, sine(1000.0, 0.02), settled=settled)
    trace = simulate(scenario)
    gain = scenario.force.effective_voltage(phasors(scenario, np.array([0.02])))[0]
    late = trace.effective_voltage.values[-401:]
    assert np.max(np.abs(late)) == pytest.approx(1000 * abs(gain), rel=1e-4 if settled else 1e-2)
    assert trace.attrs["transfer_error"] < 0.05  # of values next to the zeros of the sine


def random_skin(random):
    def drawn(low, high):
        return float(random.uniform(low, high))

    def power(low, high):
        return 10 ** drawn(low, high)

    kind = int(random.integers(3))
    conductivity = 0.0 if random.random() < 0.5 else power(-8, -4)
    high = drawn(2, 60)
    if kind == 0:
        return random_phase(random, conductivity)
    if kind == 1:
        terms = [
            {"strength": power(1, 5), "relaxation_time": power(-7, 1), "broadening": drawn(0.05, 0.6)}
            for _ in range(int(random.integers(1, 3)))
        ]
        return ColeCole(permittivity_high=high, terms=terms, conductivity=conductivity)
    broadness = drawn(0.3, 1)
    return HavriliakNegami(
        permittivity_high=high,
        strength=power(1, 5),
        relaxation_time=power(-7, 1),
        broadness=broadness,
        skewness=drawn(0.3, 1 / broadness),
        conductivity=conductivity,
    )


def random_phase(random, conductivity):
    return ConstantPhase(
        permittivity=float(10 ** random.uniform(1, 4)),
        reference_frequency=float(10 ** random.uniform(0, 4)),
        exponent=float(random.uniform(0.3, 0.97)),
        conductivity=conductivity,
    )


def random_run(random):
    """Durations of 1 ms to 100 s, steps and trapezoidal pulses, on the film and on the coating."""
    skin, lasts = random_skin(random), float(10 ** random.uniform(-3, 2))
    film, resistance = (FILM, COATING)[int(random.integers(2))], (0.0, 1000.0)[int(random.integers(2))]
    drive = HELD
    if random.random() < 0.5:
        rise, fall = (10 ** random.uniform(-3, -1, 2) * lasts).tolist()
        drive = trapezium(100.0, rise, float(random.uniform(0.05, 0.5)) * lasts, fall)
    return skin, film, resistance, drive, np.geomspace(1e-3 * lasts, lasts, 5)


def largest_error(found, truth):
    told = np.abs(truth) > TAIL * np.max(np.abs(truth))
    return float(np.max(np.abs(found - truth)[told] / np.abs(truth)[told]))


def study(seed, runs):
    """True and stated errors of the three quantities in random runs."""
    random, found = np.random.default_rng(seed), []
    for _ in range(runs):
        skin, film, resistance, drive, times = random_run(random)
        trace = simulate(on(film, skin, drive, resistance=resistance), time=times)
        truths = exact(skin, film, resistance, drive, times)
        for quantity, truth in zip(QUANTITIES, truths, strict=True):
            found.append((largest_error(found_in(trace, quantity), truth), trace.attrs["transfer_error"]))
    true, stated = np.array(found).T
    above = true > 1e-6
    return true, stated, stated[above] / true[above]


@pytest.mark.parametrize(("seed", "runs"), [(7, 4), pytest.param(8, 200, marks=pytest.mark.slow)])
def test_random_skins(seed, runs):
    true, stated, ratio = study(seed, runs)
    assert np.all(stated >= true)
    assert len(ratio) >= runs
    assert np.median(ratio) < 30
    assert np.median(true) < 1e-4


def wide_run(random):
    """Blocking and conducting constant phases at a few times over up to 12 decades, and other times among them."""
    first, last = 10 ** random.uniform(-9, -5), 10 ** random.uniform(0, 3)
    skin = random_phase(random, 0.0)
    if random.random() >= 0.5:
        skin = skin.model_copy(update={"conductivity": float(10 ** random.uniform(-8, -4))})
    inside = np.exp(random.uniform(np.log(first), np.log(last), (2, 2)))
    few, more = (np.sort([first, *each, 1e-3 * last]) for each in inside)
    return skin, few, np.union1d(few, [*more, last])


def within_what_is_stated(skin, film, resistance, some, all_, *, drive):
    """Return the worst of true over stated errors, and of the change by further times over both stated errors."""
    worst, change = [], []
    traces = [simulate(on(film, skin, drive, resistance=resistance), time=times) for times in (some, all_)]
    for times, trace in zip((some, all_), traces, strict=True):
        for name, truth in zip(QUANTITIES, exact(skin, film, resistance, drive, times), strict=True):
            worst.append(largest_error(found_in(trace, name), truth) / trace.attrs["transfer_error"])
    both = sum(trace.attrs["transfer_error"] for trace in traces)
    for name in QUANTITIES:
        one, other = (found_in(trace, name) for trace in traces)
        change.append(largest_error(one, other[np.isin(all_, some)]) / both)
    return max(worst), max(change)


@pytest.mark.parametrize("skin", [DRY, BLOCKING], ids=["conducting", "blocking"])
def test_two_times_nine_decades_apart(skin):
    """A time of 1e-9 of the last one is after the step at 0, not at it."""
    times = np.array([1e-9, 1.0])
    trace = simulate(on(FILM, skin, HELD, resistance=0.0), time=times)
    truths = zip(QUANTITIES, exact(skin, FILM, 0.0, HELD, times), strict=True)
    errors = [largest_error(found_in(trace, name), truth) for name, truth in truths]
    assert max(errors) <= trace.attrs["transfer_error"] < 2e-3


def test_times_just_after_a_late_corner():
    times = 1.001 + np.array([1e-9, 1e-6, 1e-3, 1.0])
    drive = trapezium(100.0, 1e-3, 1.0, 1e-3)
    assert within_what_is_stated(DRY, FILM, 1000.0, times[:3], times, drive=drive)[0] <= 1


def many_wide_runs():
    random = np.random.default_rng(4)
    return [pytest.param(case, wide_run(random), marks=pytest.mark.slow) for case in range(30)]


@pytest.mark.parametrize(("case", "run"), [(1, wide_run(np.random.default_rng(3))), *many_wide_runs()])
def test_sets_of_times_over_twelve_decades(case, run):
    skin, few, more = run
    film, resistance = (FILM, COATING)[case % 2], (0.0, 1000.0)[case // 2 % 2]
    assert max(within_what_is_stated(skin, film, resistance, few, more, drive=HELD)) <= 1


def test_many_output_times_are_judged_between_the_probes():
    """The stated error of 2001 times bounds the true one at times that are no probes."""
    drive = trapezium(100.0, 0.01, 0.05, 0.01)
    trace = simulate(on(COATING, DRY, drive))
    times = trace.time.values
    assert len(times) > PROBES
    size = np.abs(trace.effective_voltage.values)
    told = np.flatnonzero(size > TAIL * np.max(size))
    smallest = told[np.argsort(size[told])[:8]]  # next to where it crosses zero: the largest errors of all
    some = np.append(smallest, np.random.default_rng(1).choice(told, 12))
    truth = exact(DRY, COATING, 1000.0, drive, times[some])[QUANTITIES.index("effective")]
    error = np.abs(trace.effective_voltage.values[some] / truth - 1)
    assert np.max(error) <= trace.attrs["transfer_error"]
    assert np.max(error) > 2 * np.max(error[8:])
    force = trace.electrostatic_force.values
    true = force[some] * (truth / trace.effective_voltage.values[some]) ** 2
    of_peak = np.max(np.abs(force[some] - true)) / np.max(force)
    assert of_peak <= trace.attrs["attraction_error"] < 30 * max(of_peak, 1e-6)
    assert trace.attrs["attraction_error"] < trace.attrs["transfer_error"]


DOCUMENTED = Path(__file__).parents[2] / "docs" / "how_to" / "my_recording.md"


@pytest.mark.parametrize("every", [1, 4])
def test_the_documented_table_is_known_to_its_stated_share_of_the_peak(tmp_path, every):
    """It was made of a Cole-Cole dispersion, whose own response stands in for the truth; every fourth row misses it."""
    block = re.findall(r"```csv\n(frequency.*?)```", DOCUMENTED.read_text(encoding="utf-8"), re.DOTALL)[0]
    told = np.array([[float(each) for each in row.split(",")] for row in block.splitlines()[1:]])
    law = 1000 + 9000 / (1 + (1j * told[:, 0] / 0.5) ** 0.6)
    conducted = 1.8e-6 - law.imag * 2 * np.pi * told[:, 0] * eps0
    np.testing.assert_allclose(told[:, 1:], np.column_stack([law.real, 1 / conducted]), rtol=5e-3)
    table = np.column_stack([told[:, 0], law.real, conducted])[::every]
    rows = ["frequency (Hz),permittivity,conductivity (S/m)"]
    rows += [",".join(map(repr, row)) for row in table.tolist()]
    (tmp_path / "skin.csv").write_text("\n".join(rows))
    skin = {"model": "Tabulated", "file": str(tmp_path / "skin.csv"), "conductivity": 1.8e-6}
    terms = [{"strength": 9000.0, "relaxation_time": 1 / np.pi, "broadening": 0.4}]
    declared = ColeCole(permittivity_high=1000.0, terms=terms, conductivity=1.8e-6)
    trace, truth = (
        simulate(load("vezzoli_2014/fig6").replace({"stack.stratum_corneum.material": each}))
        for each in (skin, declared)
    )
    judged = trace.time.values <= 1 / (2 * np.pi * told[0, 0])
    missed = np.abs(trace.electrostatic_force.values - truth.electrostatic_force.values)[judged]
    stated = trace.attrs["attraction_error"]
    assert (
        np.max(missed) <= (stated + truth.attrs["attraction_error"]) * truth.electrostatic_force.values.max()
    )
    words = diagnostics(trace)["memory"]["text"]
    if every == 1:
        assert stated < 0.05
    else:
        assert (
            "with three rows a decade or more, or fit a dispersion to it (electrovib fit-material)" in words
        )


def judged(scenario, times):
    """The answer of the solver, and the errors that are stated of each of its quantities."""
    section, _ = modes(scenario, times)
    answer = solve(scenario, section, times)
    known = TABLE.band if scenario.stack.layers["stratum_corneum"].material == TABLE else (0.0, np.inf)
    return answer, answer_errors([scenario], section, answer, times[None], known=known)[0]


def test_each_quantity_has_an_error_of_its_own():
    """Field of the vanishing gap, its square the attraction, and the voltage of the skin: bounds within four times."""
    drive, times = trapezium(100.0, 0.01, 0.5, 0.01), np.geomspace(1e-3, 1.0, 9)
    scenario = on(COATING, DRY, drive, force="MaxwellStressInGap")
    answer, errors = judged(scenario, times)
    skin, gap, _ = exact(DRY, COATING, 1000.0, drive, times)
    pairs = {
        FieldOf("stratum_corneum"): (answer.found[FieldOf("stratum_corneum")], skin / SKIN),
        FieldOf("interface"): (answer.found["interface_field"], gap),
        FORCE: (answer.force, scenario.contact_area * eps0 * gap**2 / 2),
    }
    for name, (found, truth) in pairs.items():
        true = largest_error(found, truth)
        assert true <= errors[name].error < 4 * true, name
        assert errors[name].share <= errors[name].error
        assert errors[name].lost == np.inf


def test_an_error_is_not_relative_to_rounding():
    """Behind a film that blocks, the fields of a constant voltage are 0 but for the last digits of 100 V."""
    changes = {"stack.stratum_corneum.material": DRY, "drive": {"model": "Step", "level": 100}}
    held = load("vezzoli_2014/fig6_gap").replace(changes | {"time.duration": 0.02, **SETTLED})
    trace = simulate(held)
    assert trace.field.sel(layer="gap").values.max() < 1e-12 * trace.field.sel(layer="insulator").values.max()
    assert trace.attrs["attraction_error"] == 0.0
    assert trace.attrs["transfer_error"] < 1e-3
    assert diagnostics(trace)["memory"]["state"] == "ok"


def test_an_attraction_is_rounding_where_all_amplitudes_of_its_law_are():
    scenario = load("vezzoli_2014/fig6_gap", changes={"force.model": "MaxwellStressInStratumCorneum"})
    section, _ = modes(scenario, scenario.time.times(scenario.drive))
    one, other = (AmplitudeOf(name) for name in "ED")
    rows = {one: np.array([0.0, 1e-30]), other: np.array([0.0, 1e-3])}
    assert _rounding([scenario], section, rows) == {one}
    assert _rounding([scenario], section, rows | {other: np.zeros(2)}) == {one, other, FORCE}


def test_the_current_is_judged_apart():
    """It falls by three decades here; the transform of its charge over that of the field is eps0 times the area."""
    times = np.geomspace(1e-3, 1.0, 7)
    answer, errors = judged(on(COATING, DRY, HELD, force="MaxwellStressInGap"), times)
    gap = QUANTITIES.index("gap")
    truth = laplace(lambda s: 100.0 * AREA * eps0 * laws(DRY, COATING, 1000.0, s)[gap], times)
    true = largest_error(answer.found["current"], truth)
    assert true <= errors["current"].error < 4 * true
    assert worst_of(errors) == max(found.error for name, found in errors.items() if name != "current")


def test_the_band_follows_from_the_run():
    """Ten times beyond 1/(2 pi t) of the last output, the shortest piece and the first output after a corner."""
    low, high = run_band(on(FILM, DRY, trapezium(1.0, 2e-8, 3.0, 0.1)), np.linspace(0, 50.0, 11))
    assert low == pytest.approx(1 / (2 * np.pi * 50.0 * MARGIN))
    assert high == pytest.approx(MARGIN / (2 * np.pi * 2e-8))
    short, two = np.array([0.0, 1e-9, 1e-8]), np.array([0.0, 1.0])
    assert shortest_time(on(FILM, DRY, HELD), short) == pytest.approx(1e-9)
    assert run_band(on(FILM, DRY, HELD), short)[1] == pytest.approx(MARGIN / (2 * np.pi * 1e-9))
    assert run_band(on(FILM, DRY, sine(1.0, 0.02), settled=True), two)[0] == 0.02 / MARGIN
    assert run_band(on(FILM, DRY, sine(1.0, 3e6), settled=True), two) == (1.0, 3e6 * MARGIN)
    slow = run_band(on(FILM, DRY, square(1.0, 0.1, low=0.0), settled=True), two)
    assert slow[0] == pytest.approx(0.1 / MARGIN)


def test_runs_that_differ_little_share_a_reduction_and_a_netlist_takes_that_of_its_run():
    one, other = (
        reductions(on(FILM, DRY, step(1.0)), np.array([0.0, end]))["stratum_corneum"] for end in (4.0, 5.0)
    )
    assert one is other
    scenario = on(FILM, DRY, trapezium(1.0, 0.02, 5.0, 0.02))
    section, _ = modes(scenario)
    assert BuiltCircuit.of(scenario).reductions["stratum_corneum"].debye == section.debye["stratum_corneum"]
    assert max(section.debye["stratum_corneum"].relaxation_times) > 5.0


def test_what_the_diagnostic_says_of_the_memory():
    declared = simulate(on(FILM, debye(50, 900, 1e-3, 1e-6), step(1.0)))
    assert "memory" not in diagnostics(declared)
    assert declared.attrs["transfer_error"] < 1e-12
    # the mean that a blocking power law has held for ever decays without end: no sum of relaxations does
    offset = {"model": "Offset", "drive": sine(10, 100), "level": 100}
    trace = simulate(on(FILM, BLOCKING, offset, settled=True))
    assert diagnostics(trace)["memory"]["state"] == "warning"
    assert trace.attrs["transfer_error"] > 1
    held = simulate(on(FILM, BLOCKING, HELD))
    assert diagnostics(held)["memory"]["state"] == "ok"
    assert diagnostics(held)["memory"]["value"] <= held.attrs["transfer_error"] < 0.01
    leak = {"model": "FieldConduction", **FieldConduction.example}
    leaky = on(FILM, DRY, HELD, force="MaxwellStressInGap").replace({"stack.insulator.leak": leak})
    told = diagnostics(simulate(leaky, time=np.linspace(0, 1e-2, 11)))["memory"]
    assert told["state"] == "unknown"
    assert "nonlinear branch" in told["text"]


TABLE = Tabulated.model_validate(dict(Tabulated.example))  # from 10 Hz to 100 kHz


def banded(skin, drive, **more):
    """What a Trace says of the band of a table, or None."""
    return diagnostics(simulate(on(FILM, skin, drive, **more))).get("measured band")


def test_a_table_is_not_known_for_longer_than_its_lowest_frequency():
    told = banded(TABLE, trapezium(1.0, 0.01, 0.1, 0.01))
    assert told["state"] == "unknown"
    assert told["limit"] == pytest.approx(1 / (2 * np.pi * 10.0))
    assert "from 15.9 ms on" in told["text"]
    assert banded(TABLE, trapezium(1.0, 1e-3, 5e-3, 1e-3)) is None
    assert "within 1.59 us after a corner" in banded(TABLE, trapezium(1.0, 1e-6, 5e-3, 1e-3))["text"]
    assert "5 Hz" in banded(TABLE, sine(1.0, 5.0), settled=True)["text"]
    fine = {"model": "Offset", "drive": sine(1.0, 20.0), "level": 1.0}
    assert banded(TABLE, fine, settled=True) is None
    # without conduction the mean rests on polarisation slower than the table
    blocking = TABLE.to_dict() | {"conductivity": 0.0}
    assert banded(blocking, fine, settled=True, force="MaxwellStressInGap") is not None
    # from 15.9 ms on a table from 10 Hz says nothing; before that its answer is judged
    scenario = on(FILM, TABLE, trapezium(1.0, 1e-3, 0.1, 1e-3))
    assert judged(scenario, np.array([0.017, 0.05]))[1] == {}
    assert judged(scenario, np.array([0.015, 0.05]))[1][FORCE].error > 0


def test_materials_are_known_where_all_tables_are():
    """One table from 1 Hz to 10 kHz, one from 10 Hz to 100 kHz: known from 10 Hz to 10 kHz."""
    rows = len(TABLE.frequency_samples)
    other = TABLE.to_dict() | {
        "frequency_samples": np.geomspace(1.0, 1e4, rows).tolist(),
        "permittivity_samples": np.geomspace(4.0, 3.0, rows).tolist(),
        "loss_samples": np.full(rows, 0.3).tolist(),
        "conductivity": 0.0,
    }
    scenario = on(FILM, TABLE, sine(1.0, 5.0), settled=True, force="MaxwellStressInGap")
    scenario = scenario.replace({"stack.insulator.material": other})
    trace = simulate(scenario)
    assert "from 10 Hz to 10 kHz only" in diagnostics(trace)["measured band"]["text"]
    section, _ = modes(scenario)
    frequency = trace.frequency.values
    inside = (frequency >= 10.0) & (frequency <= 1e4)
    declared = scenario.force.amplitudes(phasors(scenario, frequency))["E"]
    reduced = scenario.force.amplitudes(section)["E"].at(frequency)
    errors = np.abs(declared - reduced) / np.max(np.abs(declared))
    assert trace.attrs["transfer_error"] == pytest.approx(np.max(errors[inside]), rel=1e-9)
    assert np.max(errors) > 1.5 * np.max(errors[inside])


@pytest.mark.parametrize("resistance", [0.0, 1e6])
def test_what_initial_charge_leaves_behind(resistance):
    """Charge on the face of the film, 0 V: the voltage of the skin against its Laplace transform, and the stated error."""
    charge, times = 1e-5, np.geomspace(1e-3, 1.0, 7)
    scenario = on(COATING, DRY, step(0.0), resistance=resistance, force="MaxwellStressInGap")
    scenario = scenario.replace({"stack.insulator.initial_charge": charge})
    section, _ = modes(scenario, times)
    before, between = section.modes.charges[:2].tolist()  # on the plate, and with the charge added
    assert between - before == pytest.approx(charge)

    def skin_voltage(s):
        own = SKIN / (s * eps0 * bound_permittivity(DRY, s) + DRY.conductivity)
        other = COATING[0] / (s * eps0 * COATING[1])
        current = -(other * before + own * between) / (own + other + resistance * AREA)
        return own * (between + current)

    trace = simulate(scenario, time=times)
    error = largest_error(found_in(trace, "skin"), laplace(skin_voltage, times))
    assert error <= trace.attrs["transfer_error"] < 30 * max(error, 1e-6)
    assert error < 1e-3


@pytest.mark.parametrize("count", [81, 4001])
def test_right_at_a_step_the_error_is_that_at_infinite_frequency(count):
    """There film and skin, with the permittivity far above its relaxation, share the voltage of a source without resistance."""
    skin = {"model": "ColeCole", "permittivity_high": 4.0, "conductivity": 1e-6} | {
        "terms": [{"strength": 3e4, "relaxation_time": 1.6e-3, "broadening": 0.2}]
    }
    changes = {"drive": {"model": "Step", "level": 100.0}, "force": {"model": "MaxwellStressInGap"}}
    changes |= {"stack.stratum_corneum.material": skin, "circuit.return_path.resistance": 0.0}
    scenario, times = load("vezzoli_2014/fig6", changes=changes), np.linspace(0.0, 20e-3, count)
    trace, field = simulate(scenario, time=times), 100.0 / (FILM[0] / FILM[1] + SKIN / 4.0)
    found = trace.electrostatic_force.values
    missed = abs(found[0] - AREA * eps0 / 2 * field**2) / found.max()
    assert missed > 5e-3
    assert trace.attrs["attraction_error"] == pytest.approx(missed, rel=0.01)
    assert trace.attrs["transfer_error"] >= missed / 2
    said = diagnostics(trace)["memory"]
    assert ("right at a discontinuity of the drive" in said["text"]) == (trace.attrs["transfer_error"] > 0.01)
    assert simulate(scenario, time=times[1:]).attrs["attraction_error"] < 1e-4
    for amplifier in ({"bandwidth": 1e5}, {"source_current": 1e-3, "stray_capacitance": 1e-10}):
        behind = scenario.replace({"circuit.amplifier": amplifier})
        assert simulate(behind, time=times[:81]).attrs["attraction_error"] < 1e-4
