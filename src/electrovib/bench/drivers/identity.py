"""The model that an instrument states of itself."""

from __future__ import annotations

from typing import TYPE_CHECKING

from electrovib.bench.faults import BenchError

if TYPE_CHECKING:
    from collections.abc import Collection

    from electrovib.bench.link import Link


def identify(link: Link, models: Collection[str], also: str, setting: str) -> str:
    """Ask an instrument for its maker and model, and refuse a model that the driver was not written for.

    `models` are those of the driver, as the second field of the reply to ``*IDN?``; `also` is a further one
    that the user has named, empty for none, and `setting` the dotted path of the setting that names it. The
    whole reply is returned.
    """
    reply = link.ask("*IDN?")
    fields = [field.strip() for field in reply.split(",")]
    model = fields[1] if len(fields) > 1 else ""
    known = {name.upper().replace(" ", "") for name in (*models, *([also] if also else []))}
    if model.upper().replace(" ", "") not in known:
        raise BenchError(
            f"the {link.name} states '{reply[:80]}', which is not the model of this driver ({', '.join(models)}); to use"
            f' it with this driver on your own judgement, set {setting} = "{model or reply[:20]}"'
        )
    return reply
