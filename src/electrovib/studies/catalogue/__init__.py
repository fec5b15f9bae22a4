"""What there is to choose from: models, papers and ready-made scenarios, with how each source was read."""

from electrovib.studies.catalogue.found import find as find
from electrovib.studies.catalogue.found import models as models
from electrovib.studies.catalogue.found import overview as overview
from electrovib.studies.catalogue.found import scenarios as scenarios
from electrovib.studies.catalogue.items import families as families
from electrovib.studies.catalogue.items import is_own as is_own
from electrovib.studies.catalogue.items import places as places
from electrovib.studies.catalogue.pages import bibtex as bibtex
from electrovib.studies.catalogue.pages import claims as claims
from electrovib.studies.catalogue.pages import parameters as parameters
from electrovib.studies.catalogue.pages import ready_made as ready_made
from electrovib.studies.catalogue.pages import values as values
