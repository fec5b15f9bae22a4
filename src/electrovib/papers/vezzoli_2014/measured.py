"""What this group measured on fingers: the change of the lateral force in 2014, and its decay in 2013."""

from __future__ import annotations

import math
from typing import Any

from electrovib.papers.vezzoli_2014.scenarios import scenarios
from electrovib.studies.evidence import Measurement, between

SKIN = {
    "stack.stratum_corneum.thickness": between(
        1e-4, 4e-4, "200 um is used; fingers and palms have 170 to 300 um"
    ),
    "stack.stratum_corneum.material.conductivity": between(
        1.8e-7, 1.8e-5, "ten times less and more than the 7.7 ms of the paper give"
    ),
    "stack.gap.thickness": between(5e-7, 1e-5, "not printed; of the order of the roughness of skin"),
    "stack.gap.material.conductivity": between(1e-12, 1e-8, "not printed; from none to a decay of some ms"),
}
"""What the publications do not print of a finger."""
ROUGH_GAP: dict[str, Any] = {
    "Persson2018RoughGap": {
        "stack.gap": None,
        "force.mean_gap": between(5e-7, 1e-5, "not printed; of the order of the roughness of skin"),
        "force.rms_gap": between(5e-7, 1e-5, "not printed; of the order of the roughness of skin"),
    }
}
"""What a law with gaps of its own takes in place of the layer."""
FRICTION = {"friction.coefficient": between(0.3, 0.6, "not printed", model="Uniform")}


def measurements() -> dict[str, Measurement]:
    """Return the change of the lateral force of eight people, and the decay after an edge."""
    group = "Vezzoli, Amberg and Giraud (Lille)"
    gap = scenarios()["fig6_gap"]
    return {
        "swing": Measurement(
            title="change of the lateral force under a trapezoidal pulse of 1 kV, eight people",
            source="Vezzoli 2014, section 4 and figure 6",
            scenario=gap,
            quantity="swing lateral_force",
            unit="N",
            values=(math.sqrt(2e-3 * 5e-3),),
            spread=(0.32,),
            spread_of="people",
            group=group,
            how="printed",
            status="full text",
            unknown=SKIN | FRICTION | {"drive.rise": between(1e-3, 5e-2, "not printed")},
            of_model=ROUGH_GAP,
            note="Printed is a range of 2 to 5 mN: its geometric mean, and the deviation that eight people with this range have."
            " Whether the force is lateral or normal is not said, nor load and speed. The 2.5 mN beside it are a model value. The"
            " same group quotes some 100 mN for its rig of 2013, without a voltage.",
        ),
        "decay": Measurement(
            title="share of the attraction that is left 6 ms after an edge",
            source="Giraud 2013, quoted by Vezzoli 2014",
            scenario=gap.replace({"drive": {"model": "Step", "level": 1000.0}, "time.duration": 6e-3}),
            quantity="final electrostatic_force",
            per="peak electrostatic_force",
            unit="1",
            values=(math.exp(-1),),
            spread=(0.08,),
            spread_of="digits",
            group=group,
            how="quoted by others",
            status="full text",
            unknown=SKIN,
            of_model=ROUGH_GAP,
            note="Printed are 6 ms, 'considering the mechanics of the measurements system', of the lateral force under a square"
            " drive, without insulator, voltage, load or speed: the film of 2014 stands in for the insulator. The paper's point"
            " of skin, 7.7 ms, was fitted to it.",
        ),
    }  # fmt: skip
