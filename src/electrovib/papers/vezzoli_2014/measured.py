"""What this group measured on fingers: the change of the lateral force in 2014, its decay in 2013, and which laws reach them."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.answer import REFERENCE, Curve, Panel, Table
from electrovib.papers.vezzoli_2014.values import FORCE_MEASURED
from electrovib.studies.evidence.standing import LEVEL, Score, judge
from electrovib.studies.reproduction import Row, overlap

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.studies.evidence import Measurement
    from electrovib.studies.evidence.predicted import ModelPrediction

OWN: Final = {
    "law_1": ("Vezzoli2014Causal", "law (1)"),
    "gap": ("MaxwellStressInGap", "Maxwell stress in a leaky gap"),
}
"""Names in rows, and in words, of the two laws that every number of the paper is compared under."""
PRINTED: Final = {"swing": (*FORCE_MEASURED, "mN"), "decay": (0.34, 0.4, "1")}
"""What is printed, with the unit of its row; 6 ms to one digit leave 34 to 40 % after 6 ms."""
SHORT: Final = {"swing": "change of the lateral force", "decay": "share of the force left after 6 ms"}
DRAWN: Final = 5
"""Laws that a figure shows, the best ones; its file has all."""
LEFT_OPEN: Final = (
    f"{100 * LEVEL:.0f} % of draws of conductivity (that of published skins), gap, friction and ramp"
)


@functools.cache
def judged() -> dict[str, list[tuple[ModelPrediction, Score]]]:
    """Return what every law predicts of each measurement over what is not printed, the best first."""
    from electrovib.studies.evidence.predicted import predict

    found = {}
    for name, each in _measured().items():
        both = [(one, judge(name, each, one)) for one in predict(each)[0]]
        found[name] = sorted(both, key=lambda one: -one[1].score)
    return found


def _measured() -> Mapping[str, Measurement]:
    """Return what the publication measured."""
    from electrovib.studies.evidence.files import of_publication

    return of_publication("vezzoli_2014")


def rows() -> tuple[Row, ...]:
    """Compare both measured numbers with the intervals of two laws over what the paper does not print."""
    found = []
    for name, measured in _measured().items():
        low, high, unit = PRINTED[name]
        size = 1e-3 if unit == "mN" else 1.0
        drawn = {one.model: ends(one) for one, _ in judged()[name]}
        bands = {one.model: score.band[:, 0] / size for one, score in judged()[name]}
        printed = (low / size, high / size)
        reached = [model for model, each in drawn.items() if overlap((low, high), each)]
        for short, (model, words) in OWN.items():
            ours = (float(bands[model][0]), float(bands[model][-1]))
            found.append(
                Row(f"measured_{name}_{short}", f"{SHORT[name]}, measured; {words}", printed, ours, unit,
                    "open", f"Here, {LEFT_OPEN}, which are not printed. Of {len(drawn)} laws these reach it in some draw:"
                    f" {', '.join(reached)}. {measured.note}", place="section 4", inputs="drawn"),
            )  # fmt: skip
    return tuple(found)


def ends(drawn: ModelPrediction) -> tuple[float, float]:
    """Return the least and the largest value of a law over all draws, which an end of a 90 % interval depends on less."""
    return float(drawn.values.min()), float(drawn.values.max())


def table() -> Table:
    """List every law on both measurements."""
    cells = [
        (
            SHORT[name],
            one.model,
            f"{score.band[1, 0]:.3g}",
            f"{score.band[0, 0]:.3g} to {score.band[-1, 0]:.3g}",
            f"{score.ratio:.2g}",
            "yes" if score.covered == 1 else "no",
        )
        for name, found in judged().items()
        for one, score in found
    ]
    return Table(
        "What was measured, and every law",
        ("measured", "law", "median, in SI", "90 % of the draws", "median over measured", "within 90 %"),
        tuple(cells),
        caption="Skin, gap, friction and ramp are drawn from ranges with a source or by choice: electrovib evidence vezzoli.",
        id="measured_by_law",
        on_page=False,
        looks=dict.fromkeys(range(2, 5), "number"),
    )


def panels() -> tuple[Panel, ...]:
    """Draw for each measurement the share of the draws below a value, for every law, beside the measured range."""
    laws, found = [one.model for one, _ in judged()["swing"]], []
    for name, measured in _measured().items():
        low, high, _ = PRINTED[name]
        curves = [
            Curve(
                label="measured",
                x=np.array([low, high]),
                y=np.zeros(2),
                upper=np.ones(2),
                kind="band",
                look=REFERENCE,
            )
        ]
        for one, _ in judged()[name]:
            x, look = np.sort(one.values[:, 0]), laws.index(one.model)
            y = (np.arange(x.size) + 0.5) / x.size
            curves.append(Curve(label=one.model, x=x, y=y, look=look, drawn=look < DRAWN))
        found.append(
            Panel(
                id=f"measured_{name}",
                title=f"Measured, and every law: {SHORT[name]}",
                caption="Each curve is a law over skin, gap, friction and ramp, which are not printed. A law with 95 % on one"
                " side of the band misses.",
                x=(SHORT[name], measured.unit),
                y=("share of the draws below", "1"),
                curves=tuple(curves),
                log_x=name == "swing",
            )
        )
    return tuple(found)
