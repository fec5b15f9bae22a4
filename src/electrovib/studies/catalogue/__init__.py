"""What there is to choose from: models, papers and ready-made scenarios, with how each source was read."""

from electrovib.studies.catalogue.found import find, models, scenarios
from electrovib.studies.catalogue.items import PREDICTS, Listed, Listing, families, is_own, places, plain_text
from electrovib.studies.catalogue.pages import NAMES, bibtex, claims, parameters, ready_made, values
from electrovib.studies.catalogue.populations import spaces

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
