"""Studies of a population: bands of a signal over all fingers that a space of parameters describes.

The fingers are drawn and evaluated in tiles, in this process or on a Dask cluster. Percentiles are taken by column from the
signals of all fingers, or beyond the memory from a histogram. Sums are formed tile by tile: tiles, workers and interruptions
change results by 1e-12 and not more.

What is complete stands in a zarr store, from which an interrupted study resumes. zarr writes no chunk that holds only the
fill value, so chunks cannot tell what is complete: the file `checkpoint/sums` does, with the checksums of all files that it
relies on. It is replaced by a rename after whole blocks, which are never written again; files are compared with it before
zarr opens them.
"""

from electrovib.studies.population.run import StudyCancelledError as StudyCancelledError
from electrovib.studies.population.run import study as study
from electrovib.studies.population.store import open_study as open_study
