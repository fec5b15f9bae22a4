"""A table as plain text, for a terminal of any width."""

from __future__ import annotations

from electrovib.study.catalogue.columns import laid_out as as_text

__all__ = ["as_text"]
