"""The words of the report: what the paper computes, what its text leaves open, and what this computation adds."""

from __future__ import annotations

import tomllib
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from electrovib.core.answer import Page
from electrovib.papers.vezzoli_2014 import compute, falling_edge, measured, values
from electrovib.papers.vezzoli_2014.population import SKIN, predicted
from electrovib.studies.reproduction import COMPARED, Part, Row, group, overlap

_TEXTS: Final[dict[str, Any]] = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))
KINDS: Final = {
    "dispersive skin": "a dispersive skin",
    "positive pulses": "polarity",
    "sliding": "sliding",
    "amplifier": "an amplifier that sinks less than it sources",
}
"""Beginnings of the names of causes, and what they are."""


def finding(rows: Mapping[str, Row]) -> str:
    """Sum the report up."""
    of = Counter(row.verdict for row in rows.values())
    against = ", ".join(row.what for row in rows.values() if row.verdict == "disagrees")
    return (
        f"{against or 'Nothing'} that follows from the paper's own printed inputs disagrees with it. Of"
        f" {sum(of[name] for name in COMPARED)} comparisons {of['reproduced']} are reproduced, {of['consistent']} consistent and"
        f" {of['open']} open: an input is not printed."
    )


def parts(rows: Mapping[str, Row]) -> tuple[Part, ...]:
    """Return the report in its order, each group of rows in a sentence with the numbers of this run."""
    numbers = _of_the_paper(rows) | _of_ours(rows)
    return tuple(
        Part(
            part["title"],
            part.get("words", ""),
            tuple(group(each["words"], rows, each["rows"], **numbers) for each in part["groups"]),
            tuple(part.get("panels", ())),
        )
        for part in _TEXTS["parts"]
    )


def _of_the_paper(rows: Mapping[str, Row]) -> dict[str, object]:
    """Return the numbers in the words on what the paper computes and leaves open, besides those of rows."""
    shapes = {
        name: shape for name, shape in compute.figure_7().items() if name != values.skins()["point"].name
    }
    rises = [shape.rise for shape in shapes.values() if shape.words.startswith("consistent")]
    frequencies = (compute.USUAL, 10.0, compute.SLOWEST)
    longest = [f"{compute.time_constants(each)[1] * 1e3:.3g} ms at {each:g} Hz" for each in frequencies]
    return {
        "exact": max(_one(rows[f"equation_{number}"]) for number in (1, 2, 4, 5, 6)),
        "thick_film": 100 * (_one(rows["equation_3"]) - 1),
        "drift": 100 * abs(_one(rows["suspended_force_constant"]) - 1),
        "ramp": values.RAMP * 1e3,
        "rising": len(rises),
        "published": len(shapes),
        "least": min(rises),
        "most": max(rises),
        "longest": ", ".join(longest),
        "by_voltage": compute.BY_VOLTAGE.decay * 1e3,
        "friction": "{:g} to {:g}".format(*values.FRICTION),
        "thicknesses": " to ".join(f"{each * 1e6:g}" for each in values.THICKNESSES),
        "spread": values.FORCE_MEASURED[1] / values.FORCE_MEASURED[0],
    }


def _of_ours(rows: Mapping[str, Row]) -> dict[str, object]:
    """Return the numbers in the words on what this computation adds, besides those of rows."""
    ramp, hold = (falling_edge.causes(reading) for reading in ("ramp", "hold"))
    kinds = [next((word for start, word in KINDS.items() if each.startswith(start)), each) for each in ramp]
    return {
        "early": " to ".join(f"{100 * each:.0f}" for each in _ends(rows["causality_residual"])),
        "thickness": 100 * _one(rows["variance_thickness"]),
        "resistivity": 100 * _one(rows["variance_resistivity"]),
        "in_gap": 100 * (_one(rows["thickness_spread_gap"]) - 1),
        "causes": len(falling_edge.candidates()) - 1,
        "of_ramp": len(ramp),
        "of_hold": len(hold),
        "kinds": ", ".join(dict.fromkeys(kinds)),
        "sensor": "among" if "sensor relaxes" in hold else "not among",
    }


def page(rows: Mapping[str, Row]) -> Page:
    """Write the explanations with the numbers of this run."""
    pulses = [falling_edge.outcomes()[f"positive pulses {word}"].ratio for word in ("weaker", "stronger")]
    swing = measured.judged()["swing"]
    reached = [one.model for one, _ in swing if overlap(values.FORCE_MEASURED, measured.ends(one))]
    numbers = {
        "dry": 100 * predicted("dry")[0].shares[SKIN][0],
        "polarity": " or ".join(f"{each:.2f}" for each in pulses),
        "reached": " and ".join(reached),
        "medians": ", ".join(f"{each.model} {each.ratio:.2g}" for _, each in swing),
    }
    explained = _TEXTS["explanations"]
    words = tuple(each.format_map({**rows, **numbers}) for each in explained["paragraphs"])
    return Page(explained["title"], words, id="open_questions")


def _one(row: Row) -> float:
    assert not isinstance(row.ours, tuple)
    return row.ours


def _ends(row: Row) -> tuple[float, float]:
    assert isinstance(row.ours, tuple)
    return row.ours
