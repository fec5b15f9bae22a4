"""Stories for visitors of the page: steps, each a scenario with changes, a tab, and the sentence that says what to see."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from electrovib.apps.explorer.computed import FELT, FREQUENCY, LAWS, SAFETY, TIME

_PULSE, _SCREEN = "vezzoli_2014/fig6_gap", "bau_2010/sine"
_RIG: Final = (
    '{ model = "Tribometer", normal = { natural_frequency = "2 kHz", damping_ratio = 0.02, time_constant = "10 s" },'
    ' lateral = { natural_frequency = "500 Hz", damping_ratio = 0.05 } }'
)


@dataclass(frozen=True)
class Step:
    """One state of the page; `name` is that of its story with its number, as in an address."""

    name: str
    preset: str
    changes: Mapping[str, str]
    tab: str
    sentence: str


@dataclass(frozen=True)
class Story:
    """Steps for one kind of visitor."""

    title: str
    reader: str
    steps: tuple[Step, ...]


def _story(name: str, reader: str, title: str, *steps: tuple[str, Mapping[str, str], str, str]) -> Story:
    numbered = (Step(f"{name}.{number}", *each) for number, each in enumerate(steps, 1))
    return Story(title, reader, tuple(numbered))


STORIES: Final = (
    _story(
        "student",
        "student",
        "What electrovibration is",
        (
            _PULSE,
            {},
            TIME,
            "A plate under a plastic film is charged to 1000 V and attracts a finger with up to 27 mN, the weight of 2.8 g."
            " A voltage becomes a force: electrovibration begins here.",
        ),
        (
            _PULSE,
            {"drive.hold": "300 ms"},
            TIME,
            "The voltage now stays at 1000 V for 300 ms, but 20 ms after its rise 0.7 % of the attraction is left: charge leaks"
            " onto the film, and attracts again when the voltage falls.",
        ),
        (
            _SCREEN,
            {},
            TIME,
            "Plus attracts as minus does: a sine of 125 Hz attracts with a peak 250 times a second, and the friction of a"
            " sliding finger follows.",
        ),
        (
            _SCREEN,
            {"drive.amplitude": "200 V"},
            TIME,
            "Twice the voltage attracts four times as strongly: with up to 1.55 N at 200 V, where 100 V gave 0.39 N.",
        ),
        (
            _SCREEN,
            {},
            FELT,
            "The bar at 250 Hz is how strongly the friction vibrates, the curve the weakest vibration that is felt. The bar"
            " stands 63 dB above the curve: felt.",
        ),
    ),
    _story(
        "engineer",
        "touchscreen engineer",
        "How strongly a screen attracts",
        (
            _SCREEN,
            {},
            TIME,
            "A screen with a coating of 1 µm of silica, driven with 100 V, attracts a finger with up to 0.39 N, and the friction"
            " swings between 0.25 N and 0.44 N.",
        ),
        (
            _SCREEN,
            {"stack.insulator.thickness": "10 µm"},
            TIME,
            "With 10 µm of coating instead of 1 µm, 35 % of the attraction is left: the coating now takes 45 V of the 100 V. With"
            " hafnia instead of silica, 92 % would be left.",
        ),
        (
            _SCREEN,
            {},
            FREQUENCY,
            "Fingers differ: of 200 drawn ones on the same screen, nine in ten are attracted at 125 Hz with a mean force between"
            " 0.047 N and 0.86 N.",
        ),
        (
            _SCREEN,
            {"drive.amplitude": "10 V"},
            FELT,
            "At 10 V the vibration lies 23 dB above published thresholds, with a spread from 2 to 44 dB: felt. At 5 V the"
            " spread includes 0 dB, and the answer is open.",
        ),
        (
            _SCREEN,
            {
                "drive": '{ model = "Square", high = 100, low = -100, frequency = 125 }',
                "limits.current": "250 µA",
            },
            SAFETY,
            "A square wave of 100 V draws 200 mA at each edge, 800 times the limit of 250 µA, because the body's 1 kΩ alone"
            " limits it: the amplifier has to.",
        ),
    ),
    _story(
        "researcher",
        "haptics researcher",
        "Why models and measurements differ",
        (
            _PULSE,
            {},
            LAWS,
            "Five force laws of the literature on the same finger and plate: from 0.018 mN to 183 mN. They evaluate the stress in"
            " different layers, as the table says.",
        ),
        (
            _PULSE,
            {"drive.rise": "5 ms"},
            TIME,
            "After a rise of 5 ms the attraction falls to half within 2.8 ms, although the voltage holds: the gap leaks with a"
            " time constant of 7.7 ms.",
        ),
        (
            _PULSE,
            {},
            FREQUENCY,
            "The same leak over frequency: a sine of 1000 V attracts with 0.057 N at 10 Hz, 0.27 N at 100 Hz and 0.28 N at"
            " 1000 Hz, which leaves no time to leak.",
        ),
        (
            _SCREEN,
            {"stack.gap.thickness": "1 µm"},
            TIME,
            "On a thin coating the gap decides: 1 µm of air instead of 3 µm multiplies the attraction by 6, to 2.3 N, and the"
            " abstract of the paper prints no gap.",
        ),
        (
            _SCREEN,
            {"rig": _RIG},
            TIME,
            "What a recording would show: a tribometer with its resonance at 500 Hz reads the friction that varies at 250 Hz"
            " 1.33 times as large. Drop yours in the tab Recording.",
        ),
    ),
)
"""Every number and statement of a sentence is computed by a test."""
STEPS: Final = {step.name: step for story in STORIES for step in story.steps}
"""All steps by name, a story after the other."""
