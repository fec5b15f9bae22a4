"""What a result states about its origin."""

from __future__ import annotations

import hashlib
import json
from typing import TYPE_CHECKING, Any

from electrovib.solve.quantities.answer import validity
from electrovib.study.population.declared import FORMAT
from electrovib.study.population.result import BINNED, EXACT
from electrovib.study.population.texts import own_model_files, scenario_text
from electrovib.study.population.worker import computing_versions

if TYPE_CHECKING:
    from electrovib.study.population.declared import DeclaredStudy
    from electrovib.study.population.tile import Evaluator


def attributes(evaluator: Evaluator) -> dict[str, Any]:
    """Return what a result states about its origin: scenario, space, seed, versions, kernel and methods.

    Its ``validity`` is that of the scenario with its own values; single fingers are not judged.
    """
    declared = evaluator.declared
    return {
        "format": FORMAT,
        "title": declared.scenario.title,
        "fingers": declared.fingers,
        "seed": declared.seed,
        "signals": list(declared.signals),
        "definition": definition(declared),
        "method": evaluator.method,
        "kernel": evaluator.kernel,
        "percentiles_from": EXACT if evaluator.exact else BINNED,
        "versions": computing_versions(),
        "scenario": declared.scenario.to_json(),
        "scenario_toml": scenario_text(declared.scenario),
        "space_toml": declared.space.to_toml(),
        "space_remarks": list(declared.space.remarks),
        "own_models": own_model_files(declared.scenario),
        "validity": json.dumps([each.to_dict() for each in validity(declared.scenario)]),
    }


def definition(declared: DeclaredStudy) -> dict[str, Any]:
    """Return what distinguishes a study from others; long texts as their SHA-256."""
    found = declared.identity()
    return found | {name: hashlib.sha256(found[name].encode()).hexdigest() for name in ("scenario", "space")}
