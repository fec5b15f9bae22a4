"""What there is to choose from: models and papers, with how each was read and how often it is checked."""

from electrovib.study.catalogue.described import NAMES, bibtex, claims, parameters, ready_made, values
from electrovib.study.catalogue.families import PREDICTS, families, plain_text
from electrovib.study.catalogue.listing import Listed, find, is_own, models, tables

__all__ = [
    "NAMES",
    "PREDICTS",
    "Listed",
    "bibtex",
    "claims",
    "families",
    "find",
    "is_own",
    "models",
    "parameters",
    "plain_text",
    "ready_made",
    "tables",
    "values",
]
