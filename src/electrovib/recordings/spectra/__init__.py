"""Materials from measured spectra of permittivity and conductivity."""

from electrovib.recordings.importing.own_material import ParallelPart as ParallelPart
from electrovib.recordings.importing.own_material import fit_parallel_part as fit_parallel_part
from electrovib.recordings.spectra.material import FORMS as FORMS
from electrovib.recordings.spectra.material import MaterialFit as MaterialFit
from electrovib.recordings.spectra.material import fit_material as fit_material
