"""C. D. Shultz, M. A. Peshkin, J. E. Colgate: electrical impedance of sliding fingertips, Haptics Symposium 2018.

"On the electrical characterization of electroadhesive displays and the prominent interfacial gap impedance
associated with sliding fingertips".

Claims: skin, body, coating, electrode and an interfacial gap are impedances in series; sliding raises the total
by 100 to 1000 %, only the gap explains the rise, and it vanishes when the finger stops; linear only at high
frequency or small current. Does not claim: values of the elements, a gap, a force (none was read). With
capacitors alone a gap g multiplies the impedance by r = 1 + g/K, K the electrical thickness without gap, and the
same r divides the gap field at fixed voltage: the attraction by the Maxwell stress in the gap is that of contact over r^2.
"""

from __future__ import annotations

import functools

import numpy as np

from electrovib.core.citation import derived
from electrovib.papers import cited_as, not_read, preset_notes
from electrovib.papers.vezzoli_2014 import values
from electrovib.scenario import AIR, Scenario, preset

CITATIONS, CITATION = cited_as(__name__)
STATUS = "abstract"
PRESETS = preset_notes(__name__)
NOT_READ = not_read(__name__)

CHOICE = "not printed in the abstract; a choice"
COATING = "not printed in the abstract; a thin coating, as in vezzoli_2014 for its figure 7"
SKIN = "not printed in the abstract; the skin of vezzoli_2014, section 3.1"

_CARRIER = 1e5
"""Frequency at which the skin's conduction is negligible, the linear regime of the abstract [Hz]."""


@functools.cache
def scenarios() -> dict[str, Scenario]:
    """Return one finger at rest, and one sliding with a gap inside the range of the abstract."""
    body = "body and electrode together, not printed in the abstract; a choice"
    gap = (1e-6, "not printed; inside the 100 to 1000 % of the abstract")
    common = {
        "drive": ({"model": "Sine", "amplitude": 100.0, "frequency": 1e4}, CHOICE),
        "circuit.return_path.resistance": (1000.0, body),
        "time.initial_state.model": "PeriodicState",
    }
    coating = {"insulator": (values.COATING, COATING)}
    skin = {"stratum_corneum": values.point_layer(SKIN)}
    at_rest = preset(
        title="Shultz 2018: finger at rest, no gap",
        unchanged=CHOICE,
        changes={**common, "stack": coating | skin, "motion.speed": (0.0, "Shultz 2018: a finger at rest")},
    )
    sliding = preset(
        title="Shultz 2018: sliding finger, impedance 3.6 times that at rest",
        unchanged=CHOICE,
        changes={**common, "stack": {**coating, "gap": {"thickness": gap, "material": AIR}, **skin}},
    )
    return {"at_rest": at_rest, "sliding": sliding}


def sliding_over_rest(*, gap: float) -> tuple[float, float]:
    """Compare a sliding finger with a resting one at 100 kHz, without body and electrode.

    Ratios, sliding over rest: magnitude of the impedance, and mean attraction in the gap.
    """
    from electrovib.solve.electrics.attraction import mean_force
    from electrovib.solve.stack.expand import phasors

    at = np.array([_CARRIER])
    found = []
    for name, changes in (("sliding", {"stack.gap.thickness": gap}), ("at_rest", {})):
        scenario = scenarios()[name].replace({**changes, "circuit.return_path.resistance": 0.0})
        section = phasors(scenario, at)
        found.append(
            (1 / abs(section.current_density[0]), float(mean_force(scenario, section, amplitude=100.0)[0]))
        )
    (impedance, force), (impedance_at_rest, force_at_rest) = found
    return float(impedance / impedance_at_rest), force / force_at_rest


CHECKS = (
    derived(
        "impedance with a gap of 0.385 um over that at rest",
        expect=2.0,
        rtol=2e-3,
        source="abstract: a rise of 100 %; gap of K computed by hand, three digits",
        compute=lambda: sliding_over_rest(gap=0.385e-6)[0],
    ),
    derived(
        "impedance with a gap of 3.846 um over that at rest",
        expect=11.0,
        rtol=1e-3,
        source="abstract: a rise of 1000 %; gap of 10 K computed by hand, four digits",
        compute=lambda: sliding_over_rest(gap=3.846e-6)[0],
    ),
    derived(
        "attraction of contact over that with twice its impedance",
        expect=4.0,
        rtol=3e-3,
        source="identity: at fixed voltage the gap field is inversely proportional to the impedance",
        compute=lambda: 1 / sliding_over_rest(gap=0.385e-6)[1],
    ),
)
