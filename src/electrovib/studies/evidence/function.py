"""Every law on every measurement that it can predict."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from electrovib.core.budget import each_item
from electrovib.core.errors import InputError
from electrovib.scenario.space.relations import checked_draws, checked_seed
from electrovib.solve.meter import Meter
from electrovib.solve.quantities.answer import validity
from electrovib.studies.evidence.calibrated import calibrated_predictions
from electrovib.studies.evidence.challenge import read_submissions, refuse_idle, submitted
from electrovib.studies.evidence.files import measurements
from electrovib.studies.evidence.measurement import Measurement
from electrovib.studies.evidence.predicted import DRAWS, NUMBERS, WIDTHS, null_predictions, predict
from electrovib.studies.evidence.result import Evidence, nobody
from electrovib.studies.evidence.standing import judge


def evidence(
    measured: str | Sequence[str] | Mapping[str, Measurement] = "",
    *,
    laws: str | Path | Sequence[str | Path] = (),
    n: int = DRAWS,
    seed: int = 0,
) -> Evidence:
    """Compare every law with what was measured: the distribution that it predicts, and the measured value in it.

    Parameters
    ----------
    measured : str, sequence of str or mapping of str to Measurement
        Part of a name, a title or a group of the declared measurements, all by default; the file of a measurement of your
        own; several of these; or measurements by name.
    laws : str, Path or sequence of these
        Files (.toml), each with a law and its priors, which are judged beside the others on what is measured of their place;
        calibrations are then left out.
    n : int
        Draws of what was not printed, for each measurement, >= 2.
    seed : int
        Of the draws.

    Returns
    -------
    Evidence
        Scores of all laws on all measurements; `electrovib.save` writes them as a page or a folder.

    Raises
    ------
    InputError
        If no measurement is called so, no law or model can predict any of them, or a file of a law cannot be read.

    Notes
    -----
    What a publication does not print is drawn from ranges with a source. A law is judged by the predictive density of the
    measured value over that of the best null model, which knows nothing of the set-up, each group counting once; a law
    without the parameters that a set-up needs cannot predict it, which is not a score. The best scores say which law to
    believe in these set-ups, not which one is true.

    Examples
    --------
    >>> found = ev.evidence("israr_2006/cylinder", n=4)
    >>> found.document.sentences[0]
    'A law or model can miss 1 of 1 number: its 90 % interval spans less than a decade.'
    """
    words = [measured] if isinstance(measured, str) else measured or [""]
    several = [measured] if isinstance(measured, Mapping) else [measurements(word) for word in words]
    chosen = {name: each for found in several for name, each in found.items()}
    entered = read_submissions([laws] if isinstance(laws, (str, Path)) else laws, measurements() | chosen)
    if places := {each.stated.judges for each in entered}:
        chosen = {name: each for name, each in chosen.items() if each.judges in places}
        if not chosen:
            raise InputError(f"laws: no measurement that is named judges {' or '.join(sorted(places))}")
    of, points = f"{checked_draws(n):.6g} draws", sum(len(each.values) for each in chosen.values())
    count = len(WIDTHS) * n * points
    Meter.of_cases("this comparison", of, count, numbers=NUMBERS, remedy="draw fewer (-n)")
    checked_seed(seed)
    scores, refused, predicted = [], {}, {}
    names = each_item(list(chosen))
    for name, (_, each) in zip(names, chosen.items(), strict=True):
        found, refused[name] = predict(each, n=n, seed=seed)
        for law in (law for law in entered if law.stated.judges == each.judges):
            one, why = submitted(law, name, each, n=n, seed=seed)
            found += [one] if one else []
            refused[name] |= {law.name: why} if why else {}
        if not entered and (each.calibrated_by or each.calibrated_at):
            predicted[name] = found
        scores += [judge(name, each, one) for one in found]
    if not scores:
        raise InputError(f"{name}: {nobody(why)}" for name, why in refused.items())
    refuse_idle(entered, scores, refused)
    warned = {
        name: [one for one in validity(each.scenario) if one.state == "warning"]
        for name, each in chosen.items()
    }
    nulls = null_predictions(chosen, measurements(), n=n)
    own = {name: chosen[name] for name in predicted}
    return Evidence(
        measured=chosen,
        scores=tuple(scores),
        calibrated=tuple(calibrated_predictions(own, predicted, n=n, seed=seed)),
        nulls=tuple(judge(name, chosen[name], one) for name, one in nulls),
        refused={name: why for name, why in refused.items() if why},
        warned={name: told for name, told in warned.items() if told},
        n=n,
        seed=seed,
        submissions=entered,
    )
