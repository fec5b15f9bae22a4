"""The animation of one pulse: its charges and voltages against closed forms, and its sentences against its numbers."""

import dataclasses
import json
import re

import numpy as np
import pytest

import electrovib as ev
from electrovib.apps.explorer import fading_words
from electrovib.apps.explorer.computed import FADING, Further, compute
from electrovib.apps.explorer.fading import FRAMES, SIGNS, Pulse, animation, pulse_of, why_not
from electrovib.apps.explorer.fading_words import DOWN, HELD, NONE, UP, answer, sentences, stretches
from electrovib.apps.explorer.page.plots import content
from electrovib.apps.explorer.state import presets
from electrovib.core.constants import eps0
from electrovib.core.units import parse_quantity

FIG6, GAP, SINE = "vezzoli_2014/fig6", "vezzoli_2014/fig6_gap", "bau_2010/sine"
SOME = [FIG6, GAP, SINE, *presets()[::4]]


def pulse_at(name, **changes):
    return pulse_of(compute(ev.load(name).replace(changes)))


def test_two_leaky_layers_under_a_step_follow_maxwell_and_wagner():
    """The voltage is shared as by capacitors at first and as by resistors in the end, with one time constant between.

    u1 + u2 = V, and the charge between them, q = eps2 u2/d2 - eps1 u1/d1, grows by the difference of the currents,
    dq/dt = s1 u1/d1 - s2 u2/d2. With u2 = V - u1 this is du1/dt = (u1(end) - u1)/T, T = (d1 eps2 + d2 eps1)/(d1 s2 +
    d2 s1). The solver is exact up to rounding.
    """
    d1, k1, s1, d2, k2, s2, volts = 3e-6, 2.0, 4e-9, 2e-4, 1000.0, 1e-6, 100.0
    step = ev.load("nakamura_2017/rise").replace({
        "time.duration": 0.2,
        "stack.gap.material": {"model": "Constant", "permittivity": k1, "conductivity": s1},
        "stack.stratum_corneum.material": {"model": "Constant", "permittivity": k2, "conductivity": s2},
        "stack.gap.thickness": d1, "stack.stratum_corneum.thickness": d2, "drive.level": volts,
    })  # fmt: skip
    pulse = pulse_of(compute(step))
    e1, e2 = k1 * eps0, k2 * eps0
    begin = volts * d1 * e2 / (d1 * e2 + d2 * e1)
    end = volts * d1 * s2 / (d1 * s2 + d2 * s1)
    constant = (d1 * e2 + d2 * e1) / (d1 * s2 + d2 * s1)
    first = end + (begin - end) * np.exp(-pulse.time / constant)
    second = volts - first
    assert len(pulse.time) > 200
    assert pulse.time[-1] > 2 * constant
    np.testing.assert_allclose(pulse.voltages, [first, second], rtol=1e-8)
    free = [e1 * first / d1, e2 * second / d2 - e1 * first / d1, -e2 * second / d2]
    np.testing.assert_allclose(pulse.charges, free, rtol=1e-7, atol=1e-8 * np.abs(free).max())


@pytest.mark.parametrize("name", [FIG6, GAP, "vardar_2017/sine", "vezzoli_2014/fig2"])
def test_free_charge_between_layers_is_what_conduction_brought(name):
    """dq/dt = sigma1 E1 - sigma2 E2, for layers that polarise slowly too; integrated by trapezia, so within 0.2 %."""
    pulse = pulse_at(name)
    current = np.array(pulse.conductivity)[:, None] * pulse.fields
    steps = np.diff(pulse.time)
    brought = np.cumsum(
        (current[:-1, 1:] + current[:-1, :-1] - current[1:, 1:] - current[1:, :-1]) * steps / 2, 1
    )
    gained = pulse.charges[1:-1, 1:] - pulse.charges[1:-1, :1]
    assert np.abs(gained).max() > 0.3 * np.abs(pulse.charges[0]).max()
    np.testing.assert_allclose(gained, brought, atol=2e-3 * np.abs(gained).max())


@pytest.mark.parametrize("name", SOME)
def test_charges_sum_to_zero_and_voltages_to_that_of_the_layers(name):
    found = compute(ev.load(name))
    if why_not(found):
        return
    pulse = pulse_of(found)
    most = np.abs(pulse.charges).max()
    assert np.abs(pulse.charges.sum(axis=0)).max() < 1e-12 * most
    np.testing.assert_array_equal(pulse.charges[0], pulse.displacements[0])
    np.testing.assert_array_equal(pulse.charges[-1], -pulse.displacements[-1])
    np.testing.assert_allclose(pulse.charges[1:-1], np.diff(pulse.displacements, axis=0), atol=1e-15 * most)
    kept = np.isin(found.values("time"), pulse.time)
    across = found.values("stack_voltage")[kept]
    np.testing.assert_allclose(pulse.voltages.sum(axis=0), across, atol=1e-9 * np.abs(across).max())


def test_a_gap_that_moves_has_its_voltage_at_each_time():
    found = compute(ev.load("vezzoli_2014/fig2_tremor"))
    pulse = pulse_of(found)
    assert pulse.is_moving
    across = found.values("stack_voltage")[: len(pulse.time)]
    np.testing.assert_allclose(pulse.voltages.sum(axis=0), across, atol=1e-6 * np.abs(across).max())
    assert "while the gap changes" in answer(pulse)


@pytest.mark.parametrize("name", SOME)
def test_what_is_sent_is_short_and_shows_every_extreme(name):
    found = compute(ev.load(name))
    sent = animation(found)
    assert bool(sent) != bool(why_not(found))
    if not sent:
        return
    pulse = pulse_of(found)
    count = len(sent["time"])
    assert 50 <= count <= FRAMES
    assert len(json.dumps(sent, allow_nan=False)) < 50_000
    assert np.all(np.diff(sent["time"]) > 0)
    assert (sent["time"][0], sent["time"][-1]) == pytest.approx((pulse.time[0], pulse.time[-1]), rel=1e-3)
    assert max(sent["force"]) == pytest.approx(pulse.force.max(), rel=0.01)
    layers = len(sent["layers"])
    assert len(sent["charges"]) - 1 == layers == len(sent["voltages"]) == len(sent["lines"])
    assert all(len(row) == count for key in ("charges", "voltages", "lines") for row in sent[key])
    charges, lines = np.array(sent["charges"]), np.array(sent["lines"])
    most = np.abs(charges).max()
    assert np.abs(charges.sum(axis=0)).max() < 2e-3 * most  # four digits of each
    assert SIGNS / 2 < np.abs(np.diff(lines, axis=0, prepend=0, append=0)).max() <= SIGNS + 0.01
    np.testing.assert_allclose(np.diff(lines, axis=0, prepend=0, append=0) * most, charges * np.abs(
        np.diff(lines, axis=0, prepend=0, append=0)).max(), atol=0.02 * SIGNS * most)  # fmt: skip
    assert sent["starts"][0] == 0
    assert sent["starts"] == sorted(sent["starts"])
    assert len(sent["starts"]) == len(sent["said"]) <= 20


def test_a_short_event_has_as_many_moments_as_a_long_one():
    time = np.array(animation(compute(ev.load(FIG6)))["time"])
    # a tenth of the time, in which half of the fading is
    fading = np.count_nonzero((time > 0.036) & (time < 0.056))
    assert fading > len(time) / 8


def test_axes_have_one_unit_and_a_few_round_ticks():
    axes = animation(compute(ev.load(SINE)))["axes"]
    assert axes["drive"]["words"] == "voltage [V]"
    assert [tick["text"] for tick in axes["drive"]["ticks"]] == [
        "\N{MINUS SIGN}100",
        "\N{MINUS SIGN}50",
        "0",
        "50",
        "100",
    ]
    assert [tick["at"] for tick in axes["drive"]["ticks"]] == [-100, -50, 0, 50, 100]
    assert axes["time"]["words"] == "time [ms]"
    assert [tick["at"] for tick in axes["time"]["ticks"]] == pytest.approx([0, 2e-3, 4e-3, 6e-3, 8e-3])
    assert axes["force"]["words"] == "force [mN]"
    assert axes["force"]["low"] == 0


def test_one_period_is_shown_or_a_run_until_little_changes_or_a_few_turns():
    sine = pulse_at(SINE)
    assert (sine.time[0], sine.time[-1]) == pytest.approx((0, 8e-3))
    assert sine.caption == "Shown is one period, 8 ms"
    pulse = pulse_at(FIG6)
    assert pulse.caption == "Shown are the first 209 ms of 272 ms, after which little changes"
    assert pulse.force[-1] < 1e-2 * pulse.force.max()
    short = pulse_at("vezzoli_2014/fig6", **{"time.duration": "150 ms"})
    assert short.caption == "Shown is the whole run, 150 ms"
    many = pulse_at("kang_2017/modulated")
    turns = np.count_nonzero(np.diff(np.sign(np.diff(many.drive))))
    assert 8 <= turns <= 9
    assert many.caption == "Shown are the first 1.5 ms of 30 ms"


def test_at_a_jump_no_moment_has_the_voltage_of_after_and_the_fields_of_before():
    square = pulse_at("vardar_2017/square")
    assert np.all(square.voltages.sum(axis=0) * square.drive > 0)
    assert np.ptp(square.drive) == 200


def test_a_scenario_without_animation_says_why():
    found = compute(ev.load("kim_2015/current"))
    assert "prescribes a current" in why_not(found)
    shown = content(FADING, found, Further())
    assert (shown.pulse, shown.figures) == ({}, [])
    assert "prescribes a current" in shown.above
    found = compute(ev.load(FIG6))
    assert why_not(found) == ""
    assert content(FADING, found, Further()).pulse == animation(found)
    variables = {name: each for name, each in found.found.variables.items() if name != "displacement"}
    lacking = dataclasses.replace(found, found=dataclasses.replace(found.found, variables=variables))
    assert "it needs displacement at every time" in why_not(lacking)
    assert animation(lacking) == {}
    still = compute(ev.load(FIG6).replace({"drive.high": 0}))
    assert "no layer is charged" in why_not(still)


def test_a_layer_without_lines_is_without_field_unless_it_polarises_slowly():
    words = "a layer that no line crosses has hardly any field"
    assert words in animation(compute(ev.load(FIG6)))["caption"]
    assert words not in animation(compute(ev.load("vardar_2017/sine")))["caption"]


# sentences


def test_a_pulse_is_divided_by_what_the_voltage_does():
    time = np.linspace(0, 1, 1001)
    drive = np.interp(time, [0, 0.1, 0.2, 0.5, 0.6, 0.7, 0.8, 0.9, 1], [0, 0, 5, 5, 0, 0, -5, -5, 0])
    found = stretches(time, drive)
    assert [each.kind for each in found] == [NONE, UP, HELD, DOWN, NONE, UP, HELD, DOWN]
    edges = [0, 0.1, 0.2, 0.5, 0.6, 0.7, 0.8, 0.9]
    assert [time[each.first] for each in found] == pytest.approx(edges, abs=0.002)
    assert [each.kind for each in stretches(time, np.sin(2 * np.pi * time))] == [UP, DOWN, UP, DOWN]
    assert [each.kind for each in stretches(time, 0 * time)] == [NONE]


def test_the_sentences_of_a_pulse_that_fades():
    said = [words for _, words in sentences(pulse_at(GAP))]
    begins = ("The voltage goes from 0 V to 1 kV: charge flows onto the plate, the opposite charge into the finger",
              "The voltage stays at 1 kV, but charge passes through the stratum corneum and the gap and gathers between"
              " insulator and gap: the voltage across the gap goes from 7.84 V to 1.73 V",
              "The voltage stays at 1 kV, and the force is now less than 1 % of its largest value: the field of the plate"
              " ends on the charge between insulator and gap, before the gap.",
              "The voltage goes back from 1 kV to 0 V, and the plate gives its charge back, but the charge between insulator"
              " and gap cannot leave as fast. The voltage across the gap turns round, to \N{MINUS SIGN}7.84 V",
              "There is no voltage, but charge leaks off through the stratum corneum and the gap",
              "There is no voltage, and the force is now less than 1 %")  # fmt: skip
    assert len(said) == len(begins)
    for words, begin in zip(said, begins, strict=True):
        assert words.startswith(begin)


def test_the_answer_names_half_the_time_in_which_the_force_fades():
    """The force follows the squared voltage of one relaxation, so half of it is gone after T ln(2)/2."""
    pulse = pulse_at(FIG6)
    held = next(each for each in stretches(pulse.time, pulse.drive) if each.kind == HELD)
    across = pulse.voltages[1]
    later = held.first + 20
    constant = (pulse.time[later] - pulse.time[held.first]) / np.log(across[held.first] / across[later])
    seconds = float(re.search(r"Half of it is gone after ([\d.]+) ms\.", answer(pulse))[1]) / 1e3
    assert seconds == pytest.approx(constant * np.log(2) / 2, rel=5e-3)  # three digits


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("vezzoli_2014/fig2", "The force does not fade. The voltage stays at 1 kV, and the force stays at 27.5 mN: the gap keeps"
         " its voltage, 788 V. Charge passes through the stratum corneum and gathers between gap and stratum corneum, without"),
        ("nakamura_2017/rise", "The force does not fade. The voltage stays at 100 V, but charge passes through the stratum"
         " corneum and gathers between gap and stratum corneum: the voltage across the gap goes from 96.1 V to 100 V, and the"
         " force grows from 454 mN to 492 mN."),
        (SINE, "The force does not fade before the voltage turns: when the plate holds most charge, the charge between gap and"
         " stratum corneum is 2.6 % of that on the plate, and the force is 387 mN."),
        ("aliabbasi_2024/chain", "Between the turns of the voltage there is time for charge to gather"),
        ("strong_1970/display", "The voltage never stays, and hardly any charge passes a layer before it turns"),
        ("shultz_2015/insulated", "The voltage stays at 100 V, but charge passes through the stratum corneum and the gap"),
    ],
)  # fmt: skip
def test_the_answer(name, words):
    assert answer(pulse_at(name)).startswith(words)


def test_charge_that_was_left_adds_to_a_voltage_of_the_other_sign():
    pulse = pulse_at("kaczmarek_2006/biphasic")
    said = dict(sentences(pulse))
    (at,) = [at for at, words in said.items() if "has the sign of that on the plate, and adds to it" in words]
    assert pulse.charges[0, at] < 0 > pulse.charges[1, at]
    assert "the force is at its largest, 10.6 mN" in said[at]
    (first,) = [
        at for at, words in said.items() if "they share the voltage as capacitors: insulator 96.1 V" in words
    ]
    assert np.abs(pulse.charges[1:-1, first]).max() < 0.05 * pulse.charges[0, first]


VALUE = r"((?:\N{MINUS SIGN})?[\d.]+ [a-zµ]*[NV])"


def number(text):
    return parse_quantity(text.replace("\N{MINUS SIGN}", "-").replace("µ", "u"), text[-1])


@pytest.mark.parametrize("name", [each for each in presets() if not each.startswith("kim")][::2])
def test_every_sentence_holds_for_the_numbers(name):
    """Each value that a sentence states is read back, and compared with the run at the ends of the part that it is about."""
    pulse = pulse_at(name)
    told = sentences(pulse)
    ends = [start for start, _ in told[1:]] + [len(pulse.time) - 1]
    peak = np.abs(pulse.force).max()
    for (first, words), last in zip(told, ends, strict=True):
        force = pulse.force[first : last + 1]
        assert "None" not in words
        assert words.endswith(".")
        for verb, start, end in re.findall(
            rf"the force (grows|falls) from (?:nearly )?{VALUE} to (?:nearly )?{VALUE}", words
        ):
            assert (number(end) > number(start)) == (verb == "grows")
            assert np.abs(force[: 1 + len(force) // 30] - number(start)).min() < 0.06 * peak
            assert np.abs(force[-2:] - number(end)).min() < 0.06 * peak  # the last can be that after a jump
        for top in re.findall(rf"rises up to {VALUE} and then falls", words):
            assert number(top) == pytest.approx(force.max(), rel=6e-3)
        if "less than 1 % of its largest" in words:
            assert np.abs(force[-2:]).min() < 0.01 * peak
        if "There is no voltage" in words:
            assert np.abs(pulse.drive[first + 1 : last]).max() < 2e-3 * np.abs(pulse.drive).max()
        for volts in re.findall(rf"voltage stays at {VALUE}", words):
            np.testing.assert_allclose(pulse.drive[first + 1 : last], number(volts), rtol=0.05)
        if "the opposite charge into the finger" in words:
            assert pulse.charges[-1, last] * pulse.charges[0, last] < 0
        for layer, volts in re.findall(rf"across the ([a-z ]+) turns round, to {VALUE}", words):
            across = pulse.voltages[pulse.layers.index(layer)]
            assert number(volts) * pulse.drive[first + 1] < 0
            assert across[last] == pytest.approx(number(volts), rel=0.05)
        for one, other, part in re.findall(
            r"between ([a-z ]+) and ([a-z ]+?)(?: by .*)?: ([\d.]+) % of that", words
        ):
            place = pulse.layers.index(one) + 1
            assert pulse.layers[place] == other
            between, plate = pulse.charges[place, first : last + 1], pulse.charges[0, first : last + 1]
            assert np.any((np.abs(100 * between + float(part) * plate) < 0.6 * np.abs(plate)) & (plate != 0))


def made(force, drive, *, between=0.0, conductivity=(0.0, 1e-6), followed=1):
    """Make a pulse of two layers from its force, voltage and charge between the layers."""
    time = np.linspace(0, 1, len(force))
    plate = np.asarray(drive, dtype=float)
    displacements = np.array([plate, plate + between * np.ones(len(time))])
    return Pulse(
        layers=("film", "skin"), time=time, drive=plate, force=np.asarray(force, dtype=float), fields=displacements,
        voltages=displacements, displacements=displacements, conductivity=conductivity, followed=followed,
        is_moving=False, caption="",
    )  # fmt: skip


def test_nothing_is_said_that_does_not_hold():
    time = np.linspace(0, 1, 501)
    fades, held = np.exp(-5 * time), np.ones(501)
    gathers = np.expm1(-5 * time)
    assert "but charge passes through the skin and gathers between film and skin" in answer(
        made(fades, held, between=gathers)
    )
    unknown = made(fades, held, between=gathers, conductivity=(np.nan, np.nan))  # either side may conduct
    assert answer(unknown).startswith("The voltage stays at 1 V, and the force falls from 1 N to")
    uncharged = made(fades, held, between=0.001 * gathers)
    assert answer(uncharged).startswith("The voltage stays at 1 V, and the force falls")
    assert "passes" not in answer(uncharged)
    below = made(fades, held, between=gathers, conductivity=(1e-6, 0.0))
    assert "through the film" in answer(below)
    assert "across the" not in answer(made(fades, held, between=gathers, followed=None))
    assert answer(made(0.97 * held, held, between=0 * time)).startswith("The force does not fade.")
    slow = answer(made(1 - 0.3 * time, held, between=gathers))
    assert "Half of it" not in slow
    assert "the force falls from 1 N to 700 mN" in slow


def test_a_small_number_beside_a_large_one_is_nearly_nothing():
    values = np.array([1e-5, 0.0, 2e-3, -1.0])
    said = [fading_words._quantity(values, at, "V") for at in range(4)]
    assert said == ["nearly 0 V", "0 V", "2 mV", "\N{MINUS SIGN}1 V"]
