"""Studies of a population: bands of a signal over all fingers that a space of parameters describes.

The fingers are drawn and evaluated in tiles, in this process or on a Dask cluster, and reduced to statistics in blocks
of 1024 fingers that are merged in the order of their index, so that every number is the same for any size of the tiles
and any number of threads or workers. What is complete stands in a zarr store, from which an interrupted study resumes.
"""

from electrovib.study.population.opened import open_study as open_study
from electrovib.study.population.run import StudyCancelledError as StudyCancelledError
from electrovib.study.population.run import study as study
