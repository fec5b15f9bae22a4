"""Capacitances of a rough contact with known rms height and modulus give both back, and with them the forces."""

import functools
from dataclasses import replace

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.physics.roughness import IdleSpots, LeakingSpots
from electrovib.recordings.fit import contact
from electrovib.recordings.interval import Interval
from electrovib.solve.stack.blocking import blocking_stack

SINE = "bau_2010/sine"
ROUGH = ev.SelfAffine(rms=2e-6, hurst=0.8, longest=1e-3, roll_off=2.5e-4, shortest=2.5e-4)
SOFT = ev.Elastic(modulus=1e6)
LOADS = np.array([1.0, 0.05, 0.4, 0.1, 2.0, 0.2])
RISING = 1e-9 * LOADS**0.3


@pytest.fixture(autouse=True)
def _solved_once(monkeypatch):
    monkeypatch.setattr(contact, "solved", solved)


solved = functools.cache(contact.solved)


@functools.cache
def capacitances(scenario=SINE, rough=ROUGH, body=SOFT, seed=0):
    return np.array(
        [
            ev.rough_contact(
                ev.load(scenario, changes={"load.normal_force": load}),
                roughness=rough,
                body=body,
                voltage=0.0,
                seed=seed,
            ).capacitance[0]
            for load in LOADS
        ]
    )


def fitted(capacitance=None, load=LOADS, scenario=SINE, rough=ROUGH, body=SOFT, draws=1, **options):
    options["draws"] = draws
    values = capacitances() if capacitance is None else capacitance
    return ev.fit_contact(scenario, load=load, capacitance=values, roughness=rough, body=body, **options)


@pytest.mark.parametrize(
    ("rms", "body", "rough", "seed"),
    [
        (2e-6, SOFT, ROUGH, 0),
        (5e-6, ev.Elastic(modulus=3e5, poisson=0.3), ROUGH, 1),
        (
            1e-6,
            ev.Elastic(modulus=1e7),
            ROUGH.replace({"hurst": 0.5, "shortest": 1.25e-4, "longest": 5e-4}),
            2,
        ),
    ],
)
def test_rms_height_and_modulus_come_back_from_anywhere(rms, body, rough, seed):
    true = rough.replace({"rms": rms})
    values = capacitances(rough=true, body=body, seed=seed)
    begin = {"rough": rough.replace({"rms": 10 * rms}), "body": body.replace({"modulus": body.modulus / 30})}
    found = fitted(values, seed=seed, **begin)
    assert found.roughness == true.replace({"rms": found.rms.value})
    assert found.body == body.replace({"modulus": found.modulus.value})
    assert found.rms.value == pytest.approx(rms, rel=0.02)
    assert found.modulus.value == pytest.approx(body.modulus, rel=0.02)
    order = np.argsort(LOADS)
    np.testing.assert_array_equal([found.load, found.capacitance], [LOADS[order], values[order]])
    np.testing.assert_allclose(found.fitted, found.capacitance, rtol=0.01)


def test_a_liquid_in_the_gap_is_counted_and_the_load_of_the_scenario_is_not():
    wet = ev.load(SINE, changes={"stack.gap.material.permittivity": 3.0, "load.normal_force": "7 N"})
    assert blocking_stack(wet).filling == 3.0
    found = fitted(capacitances.__wrapped__(wet), scenario=wet)
    assert found.rms.value == pytest.approx(2e-6, rel=0.02)
    assert found.modulus.value == pytest.approx(1e6, rel=0.02)


def test_it_predicts_the_attraction_without_a_further_number():
    found = fitted(rough=ROUGH.replace({"rms": 5e-6}), body=SOFT.replace({"modulus": 1e7}))
    predicted, true = (
        ev.rough_contact(SINE, roughness=rough, body=body, voltage=[30.0, 60.0]).force
        for rough, body in ((found.roughness, found.body), (ROUGH, SOFT))
    )
    np.testing.assert_allclose(predicted, true, rtol=0.02)
    np.testing.assert_allclose(found.predict(voltage=[30.0, 60.0]).force, predicted, rtol=1e-12)


def test_the_prediction_is_that_of_each_draw_under_another_load():
    found = fitted(draws=3, seed=5)
    assert [each.seed for each in found.draws] == [5, 6, 7]
    alone = [
        ev.rough_contact(
            ev.load(SINE, changes={"load.normal_force": 0.2}),
            roughness=each.roughness,
            body=each.body,
            voltage=[-40.0, 80.0],
            seed=each.seed,
        ).force
        for each in found.draws
    ]
    predicted = found.predict(voltage=[-40.0, 80.0], load=0.2)
    np.testing.assert_allclose(predicted.forces, alone, rtol=1e-12)
    np.testing.assert_allclose(predicted.force, np.exp(np.mean(np.log(alone), axis=0)))
    assert predicted.stack.pressure == pytest.approx(0.2 / found.predict(voltage=1.0).stack.area)


def test_a_typical_factor_and_both_slopes():
    """Measured forces 2 and 1/2 times the predicted ones, at voltages a factor of 2 apart: the slope is less by 2."""
    found = fitted()
    own = found.predict(voltage=[10.0, 20.0]).force
    predicted = found.predict(voltage=[10.0, 20.0], measured=own * [2.0, 0.5])
    assert predicted.typical_factor == pytest.approx(2.0)
    steep, seen = predicted.slopes
    assert steep == pytest.approx(np.log2(own[1] / own[0]))
    assert seen == pytest.approx(steep - 2)
    first, second = predicted.document.sentences
    assert "at 20 V" in first
    assert "typical factor of 2;" in second
    assert f"power {steep:.3g} of the voltage, measured {seen:.3g}" in second
    rows = [each for each in predicted.content("prediction.csv").splitlines() if not each.startswith("#")]
    assert rows[0] == "voltage,force,attraction,draw 1,measured"
    columns = np.array([each.split(",") for each in rows[1:]], dtype=float).T
    np.testing.assert_allclose(columns[4], own * [2.0, 0.5])
    np.testing.assert_allclose(columns[2], own / predicted.stack.area)


def test_a_prediction_without_measured_forces_compares_nothing():
    predicted = fitted().predict(voltage=[10.0])
    assert np.isnan(predicted.typical_factor)
    assert np.isnan(predicted.slopes).all()
    assert len(predicted.document.sentences) == 1


def test_films_are_judged_where_the_contact_is_closed():
    found = {each.name: each for each in fitted().predict(voltage=[10.0, -900.0]).diagnostics}
    film = found["film strength, insulator"]
    assert film.state == "warning"
    assert film.value == pytest.approx(900 / 1e-6, rel=0.01)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"voltage": [0.0, 10.0]}, "0 V attracts nothing"),
        ({"voltage": [np.nan]}, r"at most 1e\+06 V"),
        ({"voltage": [1e9]}, r"at most 1e\+06 V"),
        ({"voltage": [[1.0]]}, "in a row"),
        ({"voltage": [10.0], "measured": [1.0, 2.0]}, "for each of the 1 voltages"),
        ({"voltage": [10.0], "measured": [0.0]}, "a force above 0"),
        ({"voltage": [10.0], "load": 0.0}, "rests under a load"),
    ],
)
def test_what_cannot_be_predicted_is_refused(given, said):
    with pytest.raises(InputError, match=said):
        fitted().predict(**given)


@pytest.mark.slow
def test_the_interval_over_draws_holds_other_phases():
    """Capacitances of 12 other draws: the interval that four draws give holds the true numbers of most of them."""
    held = {"rms": 0, "modulus": 0}
    for seed in range(20, 32):
        found = fitted(capacitances(seed=seed), draws=4)
        held["rms"] += found.rms.lower <= 2e-6 <= found.rms.upper
        held["modulus"] += found.modulus.lower <= 1e6 <= found.modulus.upper
        alone = fitted(capacitances(seed=seed))
        assert found.rms.upper / found.rms.lower > alone.rms.upper / alone.rms.lower
    assert held["rms"] >= 10
    assert held["modulus"] >= 10


def test_the_interval_over_draws_is_that_of_one_more_and_of_the_noise():
    """Two numbers a factor of e apart without noise: sqrt(1/2) about the middle, times sqrt(3/2), t with 1 degree of freedom."""
    low, high = (Interval(value=each, lower=each, upper=each, standard_error=0.0) for each in (1.0, np.e))
    found = contact.over_draws([low, high], 4)
    assert found.value == pytest.approx(np.exp(0.5))
    assert np.log(found.upper / found.value) == pytest.approx(12.7062 * np.sqrt(0.75), rel=1e-5)
    assert found.value**2 == pytest.approx(found.lower * found.upper)
    noisy = contact.over_draws([replace(low, standard_error=0.1)] * 3, 4)
    assert np.log(noisy.upper) == pytest.approx(2.77645 * 0.1, rel=1e-5)


@pytest.mark.parametrize("draws", [0, 33])
def test_a_number_of_draws_that_is_none_is_refused(draws):
    with pytest.raises(InputError, match=f"draws = {draws}"):
        fitted(draws=draws)


def test_intervals_hold_under_noise():
    rng = np.random.default_rng(3)
    load, exact, noise = np.tile(LOADS, 4), np.tile(fitted().fitted[np.argsort(np.argsort(LOADS))], 4), 0.02
    many = [fitted(exact * np.exp(noise * rng.normal(size=load.size)), load) for _ in range(60)]
    assert np.sqrt(np.mean([each.scatter**2 for each in many])) == pytest.approx(noise, rel=0.1)
    for name, true in (("rms", fitted().rms.value), ("modulus", fitted().modulus.value)):
        numbers = [getattr(each, name) for each in many]
        assert 53 <= sum(each.lower <= true <= each.upper for each in numbers) <= 60
        spread = np.std([each.value for each in numbers])
        assert np.mean([each.standard_error for each in numbers]) == pytest.approx(spread, rel=0.25)


def test_it_says_what_it_found_and_writes_it():
    found = fitted()
    height, modulus, scatter = found.document.sentences
    assert height == f"rms height of the roughness {found.rms.in_words('m')}"
    assert modulus == f"Young's modulus {found.modulus.in_words('Pa')}"
    assert f"{100 * found.scatter:.2g} %" in scatter
    lines = [each for each in found.content("contact.csv").splitlines() if not each.startswith("#")]
    rows = np.array([each.split(",") for each in lines[1:]], dtype=float)
    assert lines[0] == "load,capacitance,fitted"
    np.testing.assert_allclose(rows.T, [found.load, found.capacitance, found.fitted])


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"load": [1.0, 2.0]}, "two rows of the same length"),
        ({"load": [1.0, 2.0], "capacitance": [1e-10, 2e-10]}, "at least 3"),
        ({"load": [0.0, *LOADS[1:]]}, "load: 0 N is not finite and above 0"),
        ({"load": [1e-6, *LOADS[1:]]}, "less than a factor of 1e6"),
        ({"capacitance": -RISING}, "F is not finite and above 0; omit the point, or subtract"),
        ({"capacitance": RISING * 4}, "is not below 3.453 nF, that of insulator on 1 cm2 without a gap"),
        ({"capacitance": np.full(6, 1e-9)}, "do not determine rms height and modulus"),
        ({"capacitance": RISING[::-1]}, "do not determine rms height and modulus"),
        ({"load": np.ones(6)}, "do not determine rms height and modulus"),
        ({"points": 16}, "points = 16"),
        (
            {
                "scenario": ev.load(
                    SINE,
                    changes={
                        "contact": {
                            "model": "GrowingArea",
                            "area": "1 cm2",
                            "at_force": "1 N",
                            "exponent": 0.3,
                        }
                    },
                )
            },
            "grows with the force",
        ),
    ],
)
def test_what_does_not_determine_it_is_refused(given, said):
    with pytest.raises(InputError, match=said):
        fitted(**given)


def test_one_draw_has_no_range():
    found = fitted().predict(voltage=[20.0, 40.0]).document
    (curve,) = found.figures[0].curves
    assert curve.label == "predicted"
    assert "of one surface" in found.sentences[0]
    assert " to " not in found.sentences[0]


MAP = ev.MeasuredHeights(values=ROUGH.heights((32, 40), (1e-3, 1.25e-3), seed=4), spacing=1e-3 / 32)


@functools.cache
def of_map():
    return capacitances.__wrapped__(rough=MAP)


def test_a_measured_map_gives_the_modulus_and_keeps_its_heights():
    found = fitted(of_map(), rough=MAP, body=ev.Elastic(modulus=3e4), draws=None)
    assert found.free == ("modulus",)
    assert found.modulus.value == pytest.approx(1e6, rel=0.02)
    assert [found.rms.lower, found.rms.value, found.rms.upper] == [MAP.rms] * 3
    np.testing.assert_allclose(found.roughness.level(), MAP.level())
    first, second, _ = found.document.sentences
    assert first == f"rms height of the roughness {MAP.rms * 1e6:.4g} um, as declared"
    assert second == f"Young's modulus {found.modulus.in_words('Pa')}"
    assert any("the map is one place" in each for each in found.document.remarks)
    alone = ev.rough_contact(SINE, roughness=found.roughness, body=found.body, voltage=[-20.0, 40.0]).force
    np.testing.assert_allclose(found.predict(voltage=[-20.0, 40.0]).forces, [alone], rtol=1e-12)


def test_a_map_is_scaled_where_that_is_asked_for():
    scaled = ev.MeasuredHeights(values=4 * MAP.level(), spacing=MAP.spacing)
    found = fitted(of_map(), rough=scaled, free=["modulus", "rms"], draws=1)
    assert found.free == ("rms", "modulus")
    assert found.rms.value == pytest.approx(MAP.rms, rel=0.02)
    assert found.modulus.value == pytest.approx(1e6, rel=0.02)
    np.testing.assert_allclose(found.roughness.level(), MAP.level(), rtol=0.02, atol=1e-8)


@pytest.mark.parametrize(
    ("free", "other"), [("modulus", "rms"), pytest.param("rms", "modulus", marks=pytest.mark.slow)]
)
def test_what_is_known_is_not_fitted(free, other):
    """With the true value of the other, the one that is free comes back, with a smaller interval than both together."""
    wrong = {"modulus": {"body": ev.Elastic(modulus=2e5)}, "rms": {"rough": ROUGH.replace({"rms": 7e-6})}}[
        free
    ]
    noisy = capacitances() * np.exp([0.02, -0.02, 0.01, -0.01, 0.02, -0.02])
    found = fitted(noisy, free=[free], **wrong)
    value, true = getattr(found, free), {"rms": 2e-6, "modulus": 1e6}
    assert value.lower <= true[free] <= value.upper
    assert value.value == pytest.approx(true[free], rel=0.1)
    assert getattr(found, other).value == true[other]
    assert getattr(found, other).standard_error == 0
    assert value.standard_error < getattr(fitted(noisy), free).standard_error
    assert found.scatter == pytest.approx(np.sqrt(np.sum(np.log(found.capacitance / found.fitted) ** 2) / 5))
    beside = [
        capacitances(rough=ROUGH.replace({"rms": 2e-6 * factor}))
        if free == "rms"
        else capacitances(body=ev.Elastic(modulus=1e6 * factor))
        for factor in (0.98, 1.02)
    ]
    slope = np.log(beside[1] / beside[0]) / np.log(1.02 / 0.98)
    error = found.scatter * value.value / np.sqrt(np.sum(slope**2))
    assert value.standard_error == pytest.approx(error, rel=0.05)
    several = fitted(noisy, free=[free], draws=2, **wrong)
    assert getattr(several, other).value == pytest.approx(true[other])
    alone = [getattr(fitted(noisy, free=[free], seed=seed, **wrong), free) for seed in (0, 1)]
    assert getattr(several, free) == contact.over_draws(alone, 5)


@pytest.mark.slow
def test_film_and_half_space_keep_the_ratio_of_their_moduli():
    skin = ev.Coated(film=ev.Elastic(modulus=2e7), thickness=5e-5, below=ev.Elastic(modulus=5e5, poisson=0.4))
    softer = skin.replace({"film.modulus": 1e6, "below.modulus": 2.5e4})
    found = fitted(capacitances(body=skin), body=softer)
    assert found.modulus.value == pytest.approx(2e7, rel=0.02)
    assert found.rms.value == pytest.approx(2e-6, rel=0.02)
    assert found.body.film.modulus == found.modulus.value
    assert found.body.below.modulus == pytest.approx(found.modulus.value / 40)
    assert found.body.below.poisson == 0.4


def test_spots_of_the_prediction_are_those_of_a_rough_contact():
    found, asked = fitted(), {"voltage": [30.0, 60.0], "frequency": 200.0}
    for spots in (IdleSpots(), LeakingSpots(resistivity=1e8)):
        predicted = found.predict(spots=spots, **asked)
        whole = ev.rough_contact(SINE, roughness=found.roughness, body=found.body, spots=spots, **asked)
        np.testing.assert_allclose(predicted.force, whole.force, rtol=1e-12)
        assert predicted.field_share == whole.field_share
        assert "of spots that insulate" in predicted.document.sentences[-1]
        assert predicted.document.sentences[-1] in str(whole)
        assert (predicted.force < found.predict(voltage=[30.0, 60.0]).force).all()
    with pytest.raises(InputError, match=r"frequency = -1\.0: finite and not below 0"):
        found.predict(voltage=[30.0], frequency=-1.0)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"free": ["gap"]}, r"free = .'gap'.: expected one or both of rms, modulus"),
        ({"free": []}, r"free = .*: expected one or both"),
        ({"rough": MAP, "draws": 2}, "draws = 2: a measured map has no phases"),
        ({"rough": MAP, "draws": None, "points": 64}, "points = 64: a measured surface has its own points"),
    ],
)
def test_what_a_map_or_a_fit_has_not_is_refused(given, said):
    with pytest.raises(InputError, match=said):
        fitted(**given)
