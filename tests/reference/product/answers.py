"""What a scenario has to answer, from rest, in its periodic state and over fresh film: from the plain equations."""

import itertools

import numpy as np
from scipy.linalg import expm

from electrovib.physics.drive.parts import Linear, Tones
from electrovib.scenario import PeriodicState
from electrovib.solve.stack.expand import modes
from product.axes import REPEATS
from product.plain import EPS0, Plain, breaks_of

NODES = 8
"""Gauss points between two moments at which the answer of a place is not smooth in when it was entered."""


def answer(scenario, times):
    """Signals of a record, the attraction among them, by their names in the package."""
    plain = Plain(scenario, modes(scenario, times)[0].debye)
    if scenario.motion.renews_film:
        return _over_places(scenario, plain, times)
    settled = isinstance(scenario.time.initial_state, PeriodicState)
    found = plain.solve(times, added=_settled(plain, scenario.drive.period or REPEATS) if settled else None)
    return found | {"electrostatic_force": attraction(scenario, found)}


def scale(scenario, name, row):
    """Size of a signal: its largest value, or a share of what a few volts would make of it if it is next to nothing."""
    charge = 1e-2 * 100.0 * EPS0 / 1e-6  # 100 V across a micrometre of air, of which a hundredth counts
    kind, _, layer = name.partition(" ")
    usual = {
        "displacement": charge,
        "current": charge * scenario.contact_area / 1e-3,
        "amplifier_current": charge * scenario.contact_area / 1e-3,
        "electrostatic_force": scenario.contact_area * charge**2 / EPS0,
        "gap": 1e-6,
    }.get(kind, 1.0)
    if kind == "field":
        usual = (
            charge
            / EPS0
            / float(np.real(scenario.stack.layers[layer].material.bound_permittivity(np.array(1e3))))
        )
    return max(float(np.max(np.abs(row))), usual)


def attraction(scenario, found):
    """Pressure times area of each contact [N], by the law of the scenario."""
    layers, area = scenario.stack.layers, scenario.contact_area
    first, law = found["stack_voltage"], type(scenario.force).__name__
    if law == "MaxwellStressInGap":
        share = layers["gap"].material.pulling_share
        pressure = EPS0 * share * found["field gap"] ** 2 / 2
    elif law == "Vezzoli2014Causal":
        film, skin = layers["insulator"], layers["stratum_corneum"]
        thick = film.thickness / film.material.permittivity
        crossed = found["displacement insulator"] - found["displacement stratum_corneum"]
        effective = first - crossed * thick / EPS0
        thin = skin.thickness / skin.material.permittivity
        pressure = EPS0 * effective**2 / (2 * (thick + thin) * (film.thickness + skin.thickness))
    else:
        name = {"MaxwellStressInInsulator": "insulator", "MaxwellStressInStratumCorneum": "stratum_corneum"}[
            law
        ]
        pressure = found[f"field {name}"] * found[f"displacement {name}"] / 2
    second = scenario.circuit.return_path.second_contact(area)
    return area * pressure * (1 + (second or 0.0))


def _settled(plain, period):
    """Give what the periodic state has beside the answer from rest: it fades, and what it loses in a period comes anew."""
    sizes, still = plain.sizes(), plain.begin(0.0, (0.0, 0.0))

    def rate(state):
        both = (plain.at(0.0, state + still, (0.0, 0.0))[0], plain.at(0.0, still, (0.0, 0.0))[0])
        return (both[0] - both[1]) / sizes

    matrix = np.array([rate(size * unit) for size, unit in zip(sizes, np.eye(plain.size), strict=True)]).T
    begun, ended = (state / sizes for state in plain.follow(np.array([0.0, period]))[0])
    kept = plain.conserved(still) * sizes
    kept = kept / np.max(np.abs(kept), axis=1, keepdims=True)
    trapped = np.zeros(len(kept))
    if plain.current:  # what integrates is counted from its mean
        looks = np.linspace(0.0, period, 257)[:-1]
        trapped = -kept @ ((np.mean(plain.follow(looks)[0], axis=0) - still) / sizes)
    left = np.vstack([np.eye(plain.size) - expm(matrix * period), kept])
    right = np.concatenate([ended - begun, trapped])
    beside = np.linalg.lstsq(left, right, rcond=1e-15)[0]
    assert np.max(np.abs(left @ beside - right)) < 1e-7
    return lambda time: sizes * (expm(matrix * time) @ beside)


def _over_places(scenario, plain, times):
    """Mean over the contact, each place from when it came under the finger."""
    length, speed = scenario.contact.sliding_length(scenario.load.normal_force), scenario.motion.speed
    end = float(times[-1])
    marks = {*breaks_of(scenario.drive, None, end), *times.tolist(), *(times - length / speed).tolist()}
    fastest = max((_fastest(part) for part in scenario.drive.parts()), default=0.0)
    marks |= set(np.linspace(0.0, end, 2 + int(2 * fastest * end)).tolist())
    marks |= {time - length / speed * 0.25**power for time in times.tolist() for power in range(1, 8)}
    marks = sorted(mark for mark in marks if 0 <= mark <= end)
    points, weights = np.polynomial.legendre.leggauss(NODES)
    total = None
    entries = [(0.0, None)]
    for first, last in itertools.pairwise(marks):
        half = (last - first) / 2
        entries += [
            (first + half * (1 + p), half * w * speed / length) for p, w in zip(points, weights, strict=True)
        ]
    for entry, weight in entries:
        later = np.flatnonzero(times >= entry)
        place = speed * (times[later] - entry)
        share = np.maximum(1 - place / length, 0.0) if weight is None else weight * (place < length)
        if not np.any(share):
            continue
        found = plain.solve(times[later], start=entry, tolerance=1e-8)
        found["electrostatic_force"] = attraction(scenario, found)
        if total is None:
            total = {name: np.zeros(len(times)) for name in found}
        for name, row in found.items():
            total[name][later] += share * row
    return total


def _fastest(part):
    if isinstance(part, Linear):
        return 0.0
    return float(np.max(part.frequencies)) if isinstance(part, Tones) else part.highest_frequency
