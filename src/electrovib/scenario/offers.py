"""Materials and stacks that a scenario takes by name, of the library or of a paper, with the sources of their values."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from electrovib.core.discovery import offers, paper
from electrovib.core.errors import ElectrovibError
from electrovib.core.model import Model
from electrovib.physics.material import Material
from electrovib.physics.material.library import Substance
from electrovib.physics.skin import Skin
from electrovib.physics.stack import Stack
from electrovib.scenario.sources import is_default


def skins() -> dict[str, Skin]:
    """Collect the skins that papers publish, by the ``author_year/name`` that a scenario may give in place of a material."""
    return offers(("skins",))


def with_offers(changes: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, str]]:
    """Replace names of materials and stacks by their tables; an unknown name is kept for the validation to refuse.

    Beside the changes, `sources` maps each parameter that such a table gives to the name, the source of the
    value and its status; the breakdown strengths of the library stand under the path of ``substance``.
    """
    found, sources = dict(changes), dict[str, str]()
    for path in sorted(changes, key=lambda path: path.count(".")):
        table = path.removesuffix(".model")
        for told in [told for told in sources if f"{told}.".startswith(f"{table}.")]:
            del sources[told]  # set again by this change
        found[path] = _read(changes[path], path, sources)
    return found, sources


def _read(value: Any, path: str, sources: dict[str, str]) -> Any:
    parts = path.split(".")
    if parts[0] == "stack" and isinstance(value, Mapping) and len(parts) < 3:
        return {key: _read(item, f"{path}.{key}", sources) for key, item in value.items()}
    kind: type[Model] | None = Stack if parts == ["stack"] else None
    if len(parts) == 3 and parts[0] == "stack" and parts[2] == "material":
        kind = Material
    if kind is None or not isinstance(value, str):
        return value
    try:
        offer = kind.offer(value)
        model = kind.from_offer(offer)
    except ElectrovibError:
        return value
    for inner, number, _ in model.parameters():
        if number is not None and not is_default(model, inner, number):
            where = f"{path}.{inner}"
            sources[where] = f"{value}: {_source(offer, value, where)}"
    if isinstance(offer, Substance) and offer.strengths:
        sources[f"{path}.substance"] = f"{value}: {offer.strength_words}"
    return model.to_dict()


def _source(offer: Any, name: str, path: str) -> str:
    """Return the source of a value of an offer, and its status."""
    if isinstance(offer, Skin):
        return f"{offer.source} ({offer.status}; {offer.note})"
    if isinstance(offer, Substance):
        return offer.origin(path.rpartition(".material.")[2])[0]
    module = paper(name.partition("/")[0])
    told: str = getattr(offer, "sources", {}).get(path) or f"{module.CITATION} ({module.STATUS})"
    return told
