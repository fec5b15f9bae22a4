"""What each part of a scenario may be, what does not go together, and a choice of scenarios that covers the product.

All time constants lie between 0.05 and 2 ms and every drive happens within 8 ms, so that every part of a
scenario leaves a mark on its answer.
"""

import itertools
import random

import numpy as np
import scenario_parts as parts

from electrovib.core.model import read_model
from electrovib.scenario import Scenario

AREA, END, SPEED = 1e-4, 8e-3, 3.0
"""Contact [m2], length of a record [s], speed of a finger that slides over fresh film [m/s]."""
REPEATS = 5e-3
"""Common period of all drives that repeat [s]."""
SINE = parts.sine(60.0, 200.0, phase=0.4)
TONES = [parts.sine(30.0, 200.0), parts.sine(20.0, 400.0, phase=1.0)]
ONCE = parts.trapezium(80.0, 2e-3, 3e-3, 1e-3, delay=0.3e-3)
MODULATED = {"amplitude": 40.0, "carrier": 600.0, "modulation": 200.0, "depth": 0.7}
UNEVEN = {"time_samples": [0, 0.7e-3, 3e-3, 3.3e-3, 6e-3], "voltage_samples": [15, 60, 40, -50, 10]}


def controlled(command):
    return parts.model("CurrentAmplifier", sense_resistance=1e7, command=command)


DRIVES = {
    "constant": parts.step(70.0),
    "square": parts.square(60.0, 200.0, low=-25.0),
    "edges": parts.square(60.0, 200.0, low=-25.0, edge=0.4e-3),
    "pulses": parts.model("PulseTrain", high=70.0, low=5.0, width=1e-3, frequency=200.0),
    "once": ONCE,
    "trapezium": ONCE | {"low": -20.0, "hold": 1e-3, "repeat": REPEATS},
    "sine": SINE,
    "burst": parts.model("Burst", amplitude=60.0, frequency=400.0, cycles=2, delay=1.7e-3),
    "modulated": parts.model("AmplitudeModulation", **MODULATED),
    "root": parts.model("SquareRootModulation", **MODULATED),
    "chirp": parts.model("Chirp", amplitude=60.0, first=50.0, last=500.0, length=7e-3),
    "offset": parts.model("Offset", drive=SINE, level=30.0),
    "sum": parts.model("Sum", drives=[parts.square(25.0, 200.0), *TONES]),
    "sampled": parts.model("Sampled", **UNEVEN),
    "current sine": parts.model("CurrentSine", amplitude=5e-6, frequency=200.0, phase=0.4),
    "current": controlled(parts.model("Sum", drives=TONES)),
    "current once": controlled(ONCE),
}
CURRENTS = {"current sine", "current", "current once"}
REPEATING = set(DRIVES) - {"once", "burst", "chirp", "sampled", "current once"}


FIELD = parts.model("FieldConduction", conductivity=1e-5, onset_field=1e4)
LEAKS = {
    "none": {},
    "gap": {"gap": parts.polarity(4e-8, 1e-8)},
    "skin": {"stratum_corneum": FIELD},
    "film": {"insulator": parts.polarity(1e-8, 8e-8)},
    "two": {"gap": parts.polarity(1e-8, 4e-8), "stratum_corneum": FIELD},
}
AMPLIFIERS = {
    "none": None,
    "gain": {"gain": -1.5},
    "pole": {"gain": 1.2, "bandwidth": 500.0, "stray_capacitance": 2e-11},
    "saturation": {"gain": 2.0, "saturation": 45.0},
    "pole and saturation": {"gain": 2.0, "bandwidth": 800.0, "saturation": 45.0},
    "current": {"source_current": 12e-6, "sink_current": 8e-6},
    "current and stray": {"gain": 1.5, "source_current": 15e-6, "stray_capacitance": 5e-11},
    "everything": {"gain": 1.8, "bandwidth": 1500.0, "saturation": 70.0, "stray_capacitance": 3e-11}
    | {"source_current": 12e-6, "sink_current": 9e-6},
}
LIMITED = {"saturation", "pole and saturation", "current", "current and stray", "everything"}
GAPS = ("none", "still", "trembles", "touches", "closes")
TOUCH = {"far": 20e-6, "near": 2e-6, "begin": 0.5e-3, "approach": 2e-3, "touch": 1.5e-3, "lift": 3e-3}
DISTANCES = {
    "trembles": parts.model("TremblingDistance", mean=3e-6, amplitude=1e-6, frequency=150.0),
    "touches": parts.model("TouchAndLift", **TOUCH),
}
RELIEF = parts.model("LinearSpring", stiffness=2e10, free_gap=3e-6)
AIRS = {
    "dry": parts.constant(1.0),
    "leaky": parts.constant(1.0, 2e-8),
    "bridged": parts.model("BridgedAir", bridged_share=0.2, spot_conductivity=1e-7),
}
CHARGES = {"none": (0.0, 0.0), "film": (1e-4, 0.0), "two": (-6e-5, 1e-4)}
PATHS = {
    "strap": parts.grounded(2e4),
    "bare": parts.grounded(),
    "slow": parts.grounded(2e6),
    "floating": parts.floating(resistance=1e6),
    "floating and leaking": parts.floating(resistance=0.0, leak=1e7),
    "second": parts.model("SecondElectrode", area=0.5e-4, resistance=1e6),
    "second bare": parts.model("SecondElectrode", area=2e-4, resistance=0.0),
}
SECOND = {"second", "second bare"}
BROAD = {"strength": 900.0, "relaxation_time": 0.3e-3, "broadening": 0.3}
SKINS = {
    "conducts": parts.constant(1500.0, 1.3e-5),
    "blocks": parts.constant(300.0),
    "relaxes": parts.debye(100.0, 900.0, 0.5e-3, 1e-5),
    "disperses": parts.model("ColeCole", permittivity_high=100.0, terms=[BROAD], conductivity=1e-5),
}
LAWS = (
    "MaxwellStressInGap",
    "MaxwellStressInInsulator",
    "MaxwellStressInStratumCorneum",
    "Vezzoli2014Causal",
)
AXES = {
    "drive": tuple(DRIVES),
    "leak": tuple(LEAKS),
    "amplifier": tuple(AMPLIFIERS),
    "gap": GAPS,
    "air": tuple(AIRS),
    "charge": tuple(CHARGES),
    "path": tuple(PATHS),
    "skin": tuple(SKINS),
    "law": LAWS,
    "start": ("rest", "periodic"),
    "film": ("stays", "renews"),
}


def is_scenario(case):
    """Tell whether such layers and such a law can be written down at all."""
    if case["law"] == "Vezzoli2014Causal" and (
        case["gap"] != "none" or case["skin"] in {"relaxes", "disperses"}
    ):
        return False  # its closed form is known without a gap and without dispersion
    if case["gap"] != "none":
        return True
    return (
        case["law"] != "MaxwellStressInGap"
        and case["leak"] not in {"gap", "two"}
        and case["air"] == "dry"
        and case["charge"] != "two"
    )


def refusals(case):
    """Give the words of which one has to be in the refusal of a case; none if it has to be answered."""
    found = []
    currents, settled = case["drive"] in CURRENTS, case["start"] == "periodic"
    moves = case["gap"] in {"trembles", "touches", "closes"}
    if case["charge"] != "none" and case["path"] in SECOND:
        found.append("initial_charge")
    if case["leak"] != "none" and case["path"] in SECOND:
        found.append(".leak")
    if settled and (
        case["drive"] not in REPEATING or case["leak"] != "none" or case["amplifier"] in LIMITED or moves
    ):
        found.append("time.initial_state")
    if currents and case["amplifier"] != "none":
        found.append("circuit.amplifier")
    if currents and (moves or case["leak"] == "two"):
        found.append("drive")
    if case["gap"] == "closes" and (case["path"] in SECOND or case["law"] != "MaxwellStressInGap"):
        found.append("contact.closing")
    if case["film"] == "renews":
        others = {
            "time.initial_state": settled,
            "current": currents,
            ".leak": case["leak"] != "none",
            "circuit.amplifier": case["amplifier"] != "none",
            "contact.closing": case["gap"] == "closes",
            "distance": case["gap"] in DISTANCES,
            "circuit.return_path": case["path"] not in {"strap", "bare", "slow"},
        }
        found += [word for word, applies in others.items() if applies]
    return found


def scenario_of(case):
    """Write a case down."""
    film, face = CHARGES[case["charge"]]
    layers = {
        "insulator": parts.layer(2e-6, parts.constant(3.35), initial_charge=film),
        "gap": parts.layer(2e-6, AIRS[case["air"]], initial_charge=face),
        "stratum_corneum": parts.layer(200e-6, SKINS[case["skin"]]),
    }
    if case["gap"] == "none":
        del layers["gap"]
    for name, leak in LEAKS[case["leak"]].items():
        layers[name]["leak"] = leak
    contact = parts.model("FixedArea", area=AREA)
    if case["gap"] == "closes":
        contact |= {"surface": RELIEF, "closing": {"damping": 2e7}}
    content = {
        "drive": DRIVES[case["drive"]],
        "force": {"model": case["law"]},
        "friction": parts.COULOMB,
        "contact": contact,
        "load": {"normal_force": 0.5},
        "circuit": {"return_path": PATHS[case["path"]]},
        "stack": layers,
    }
    if case["gap"] in DISTANCES:
        content["motion"] = {"distance": DISTANCES[case["gap"]]}
    if case["film"] == "renews":
        content["motion"] = content.get("motion", {}) | {"speed": SPEED, "renews_film": True}
    if AMPLIFIERS[case["amplifier"]]:
        content["circuit"]["amplifier"] = AMPLIFIERS[case["amplifier"]]
    if case["start"] == "periodic":
        content["time"] = {"initial_state": {"model": "PeriodicState"}}
    return read_model(Scenario, content)


def output_times(case):
    """Uneven times of a record, corners of the drives among them; a third of the records begin late."""
    luck = random.Random(name_of(case))
    marks = [0.0, 0.3e-3, 0.4e-3, 1e-3, 2.5e-3, 5e-3, 7.5e-3]
    found = np.array(sorted({*marks, *(luck.uniform(0, END) for _ in range(16)), END}))
    return found[luck.choice([0, 0, 3]) :]


def name_of(case):
    return ", ".join(f"{axis} {case[axis]}" for axis in AXES)


def cases(*, count, long, seed=7):
    """Choose cases that have to be answered so that each further one shows as many new pairs of choices as can be.

    All of them take long, or none does; the seed is that of the order of equals.
    """
    luck = random.Random(seed)
    shown, found, names = set(), [], set()
    while len(found) < count:
        best, most = None, -1
        for _ in range(60):
            case = next(each for each in iter(lambda: _answered(luck), None) if takes_long(each) == long)
            new = len(_pairs(case) - shown)
            if new > most and name_of(case) not in names:
                best, most = case, new
        found.append(best)
        names.add(name_of(best))
        shown |= _pairs(best)
    return found


def takes_long(case):
    """Tell whether a case goes to the general solver, or is solved place by place."""
    together = (case["leak"] != "none") + (case["amplifier"] in LIMITED) + (case["gap"] in DISTANCES)
    before = case["leak"] != "none" and case["amplifier"] != "none"
    return (
        together > 1 or before or case["leak"] == "two" or case["gap"] == "closes" or case["film"] == "renews"
    )


def _answered(luck):
    """A case that has to be answered; the less goes together with a choice, the more often it is made."""
    while True:
        case = {axis: luck.choice(levels) for axis, levels in AXES.items()}
        case |= luck.choice(
            [{"start": "rest", "film": "stays"}] * 7 + [{"start": "periodic"}] * 3 + [{"film": "renews"}] * 2
        )
        for axis in luck.sample(["leak", "amplifier", "gap", "charge"], luck.randrange(4)):
            case[axis] = AXES[axis][0] if axis != "gap" else "still"
        if case["film"] == "renews":
            case |= {"start": "rest", "leak": "none", "amplifier": "none"}
        if case["start"] == "periodic":
            case |= {"leak": "none", "gap": luck.choice(GAPS[:2])}
        if case["skin"] == "disperses" and luck.random() < 0.7:
            case["skin"] = "relaxes"  # fourteen relaxations take the general solver long
        if is_scenario(case) and not refusals(case):
            return case


def _pairs(case):
    return set(itertools.combinations(sorted(case.items()), 2))


def refused_cases(*, count, seed=5):
    """Give for each pair of choices that does not go together one case which is otherwise plain, and a few wild ones."""
    plain = {axis: levels[0] for axis, levels in AXES.items()} | {"gap": "still", "drive": "sine"}
    found = []
    for one, other in itertools.combinations(AXES, 2):
        for first, second in itertools.product(AXES[one], AXES[other]):
            case = plain | {one: first, other: second}
            if is_scenario(case) and refusals(case):
                found.append(case)
    luck = random.Random(seed)
    while count > 0:
        case = {axis: luck.choice(levels) for axis, levels in AXES.items()}
        if is_scenario(case) and refusals(case):
            found.append(case)
            count -= 1
    return found
