"""Studies of a population: bands of a signal over all fingers that a space of parameters describes.

The fingers are drawn and evaluated in tiles, in this process or on a Dask cluster. Percentiles are taken by column from
the signals of all fingers, or beyond the memory from a histogram. What is complete stands in a zarr store, from which an
interrupted study resumes.
"""

from electrovib.studies.population.run import StudyCancelledError as StudyCancelledError
from electrovib.studies.population.run import study as study
from electrovib.studies.population.store import open_study as open_study
