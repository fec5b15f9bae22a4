"""What there is to choose from: models, papers and ready-made scenarios, with how each source was read."""

from electrovib.studies.catalogue.found import find as find
from electrovib.studies.catalogue.found import models as models
from electrovib.studies.catalogue.found import overview as overview
from electrovib.studies.catalogue.found import scenarios as scenarios
from electrovib.studies.catalogue.pages import bibtex as bibtex
