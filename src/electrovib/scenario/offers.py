"""Materials and stacks that a scenario names, ``author_year/name``, with the values and sources of the paper."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from electrovib.core.discovery import find_offer, offers, paper
from electrovib.core.errors import ElectrovibError
from electrovib.core.model import Model
from electrovib.physics.material import Material
from electrovib.physics.skin import Skin
from electrovib.physics.stack import Stack
from electrovib.scenario.sources import is_default


def skins() -> dict[str, Skin]:
    """Collect the skins that papers publish.

    Returns
    -------
    dict of str to Skin
        ``author_year/name``, which can stand in the place of a material, to the skin; papers in the order of their names.
    """
    return offers(("skins",))


def with_offers(changes: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, str]]:
    """Put what papers offer in the place of its names.

    Parameters
    ----------
    changes : mapping of str to value
        Dotted path to value, or the tables of a scenario. ``stack`` and the material of a layer may be a name,
        ``author_year/name``; a name that no paper offers stays as it is, for the validation to refuse.

    Returns
    -------
    changes : dict
        The same with tables in the place of such names.
    sources : dict of str to str
        Dotted path of each parameter that such a table gives, to the name and where the paper has the value from.
    """
    found, sources = dict(changes), dict[str, str]()
    for path in sorted(changes, key=lambda path: path.count(".")):
        table = path.removesuffix(".model")
        for told in [told for told in sources if f"{told}.".startswith(f"{table}.")]:
            del sources[told]  # it is set anew
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
        offer = find_offer(value, kind.offered_by)
        model = kind.from_offer(offer)
    except ElectrovibError:
        return value
    for inner, number, _ in model.parameters():
        if number is not None and not is_default(model, inner, number):
            where = f"{path}.{inner}"
            sources[where] = f"{value}: {_source(offer, value, where)}"
    return model.to_dict()


def _source(offer: Any, name: str, path: str) -> str:
    """Say where a value of an offer is from, and how that was read."""
    if isinstance(offer, Skin):
        return f"{offer.source} ({offer.status}; {offer.note})"
    module = paper(name.partition("/")[0])
    told: str = getattr(offer, "sources", {}).get(path) or f"{module.CITATION} ({module.STATUS})"
    return told
