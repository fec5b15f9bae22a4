"""The challenge that the measured data are: a version, and groups that may make a law beside those that judge it."""

from __future__ import annotations

import functools
import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Final

from pydantic import BaseModel, ConfigDict, Field

from electrovib.core.mistakes import read_entries
from electrovib.core.parsing import read_toml_file

if TYPE_CHECKING:
    from electrovib.studies.evidence.measurement import Measurement

FILE: Final = Path(__file__).with_name("split.toml")
PUBLIC, HELD_OUT = "public", "held out"
SIDES: Final = (HELD_OUT, PUBLIC)
"""Sides of the split, the one that judges first."""


class Split(BaseModel):
    """Version of the measured data, the groups on each side, and a fingerprint of the numbers of each publication."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    version: str = Field(pattern=r"^\d+\.\d+$")
    public: tuple[str, ...]
    held_out: tuple[str, ...]
    numbers: Mapping[str, str]

    def side_of(self, group: str) -> str:
        """Return the side of a group; empty for one that is not part of the challenge, as of a file of one's own."""
        return HELD_OUT if group in self.held_out else PUBLIC if group in self.public else ""


@functools.cache
def split() -> Split:
    """Read the split."""
    return read_entries(Split, read_toml_file(FILE, kind="a split", advice=""), of="a split")


def fingerprint(measured: Mapping[str, Measurement]) -> str:
    """Return a short digest of what judges in a publication: groups, quantities, values, spreads and what they count as."""
    told = [
        [name, each.group, each.named, each.unit, each.over, each.bound, each.error_of, each.judges]
        + [each.same_as, each.per, repr(sorted(each.per_changes.items()))]
        + [[f"{number:.9g}" for number in numbers] for numbers in (each.at, each.values, each.spread)]
        for name, each in sorted(measured.items())
    ]
    return hashlib.sha256(json.dumps(told).encode()).hexdigest()[:16]
