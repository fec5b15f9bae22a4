"""Release of a clutch: a fit of the fall of the force and of the damped oscillation after it to a record."""

from electrovib.recordings.release.fit import FittedRelease, fit_release

__all__ = ["FittedRelease", "fit_release"]
