"""What there is to choose from: models, papers and ready-made scenarios, with how each source was read."""

from electrovib.study.catalogue.described import NAMES, bibtex, claims, parameters, ready_made, values
from electrovib.study.catalogue.families import PREDICTS, families, places, plain_text
from electrovib.study.catalogue.found import find, models, scenarios
from electrovib.study.catalogue.items import is_own
from electrovib.study.catalogue.listed import Listed, Listing
from electrovib.study.catalogue.populations import spaces

__all__ = [
    "NAMES",
    "PREDICTS",
    "Listed",
    "Listing",
    "bibtex",
    "claims",
    "families",
    "find",
    "is_own",
    "models",
    "parameters",
    "places",
    "plain_text",
    "ready_made",
    "scenarios",
    "spaces",
    "values",
]
