"""What electrovibration is and what the page shows, for a person who has not met it."""

from __future__ import annotations

from typing import Final

ABOUT: Final = (
    "A voltage between the electrode of a plate and a finger attracts the skin to the plate. The attraction adds to the force"
    " with which the finger presses, so the friction of a sliding finger follows the voltage, and the finger feels a vibration or"
    " a texture on a smooth surface: electrovibration. A finger at rest feels nothing of it.",
    "The attraction is caused by the electric field between plate and skin. The voltage is shared between the layers: at fast"
    " changes as between capacitors, under a constant voltage as between resistors. Charge that passes through the skin and the"
    " gap therefore makes the force fade within the time constant of these layers, although the voltage stays. 'Voltage across"
    " each layer', and 'Over frequency', show this.",
    "Move a slider, or type a value with its unit into the field beside it; an empty field gives the value of the scenario back."
    " The pointer on a parameter shows its meaning, range and source. The button 'back' of the browser takes the last change"
    " back, and the address of the page reproduces what is shown.",
    "'Validity' states whether the models hold for this result: 'ok', 'warning' (outside the range in which a model was"
    " verified, or above a strength), or 'unknown' where no statement is possible.",
)
"""What the page shows, for a person who has not met electrovibration, a paragraph each."""
