"""Rows, figures and tables of the report: their words are data, ``words.toml``, into which numbers are put."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from electrovib.papers.vezzoli_2014.values import PAPER
from electrovib.studies.reproduction import Words

_WORDS: Final = Words(
    Path(__file__).with_suffix(".toml"), {name: each.value for name, each in PAPER.stated.values.items()}
)
row, panel, table = _WORDS.row, _WORDS.panel, _WORDS.table
