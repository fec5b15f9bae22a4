"""Whether a measured permittivity and conductivity can belong to one causal, linear material."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.constants import VACUUM_PERMITTIVITY
from electrovib.core.errors import InputError, refuse

if TYPE_CHECKING:
    import numpy.typing as npt
# Relaxation times per decade of the basis: denser than the singular values below can tell apart.
PER_DECADE = 8
# Singular values below this share are noise to any skin table; it also sets what the basis resolves.
RESOLUTION = 3e-3


def kramers_kronig_residual(
    frequency: npt.ArrayLike, permittivity: npt.ArrayLike, conductivity: npt.ArrayLike
) -> float:
    r"""Compute the deviation of a table from the Kramers-Kronig relations.

    Parameters
    ----------
    frequency : array_like
        Frequencies, Hz, shape (N,), positive, distinct, in any order; about two per decade or more.
    permittivity : array_like
        Relative permittivity eps', 1, shape (N,).
    conductivity : array_like
        Total conductivity, S/m, shape (N,): that of free charge and all dielectric loss, 1/rho of a table.

    Returns
    -------
    residual : float
        Root mean square of the relative misfit of eps' and eps'' together, dimensionless; 0 for a consistent table without
        noise. A table is consistent below 2 % or twice its noise.

    Raises
    ------
    InputError
        Lists differ in length, a value is not finite, a frequency is not above 0 or is repeated, the
        permittivity and conductivity are both 0 at one frequency, or there are too few points.

    Notes
    -----
    With the time factor ``exp(+j w t)`` the table is :math:`\varepsilon = \varepsilon' - j \varepsilon''`,
    :math:`\varepsilon'' = \sigma/(\omega\varepsilon_0)`. Least squares of the relative error fits to it

    .. math:: h + \frac{g}{j\omega} + \sum_m \frac{s_m}{1 + j\omega\tau_m}

    with real :math:`h, g, s_m` of either sign [1]_ and fixed times that reach one decade beyond the band.
    Every such sum obeys the relations, so what it cannot fit does not. The residual is

    .. math:: \sqrt{\frac{1}{N - r/2}\sum_k \left|\frac{\mathrm{fit}_k}{\varepsilon_k} - 1\right|^2}

    with r the number of independent terms that the band resolves to 0.3 %, so that independent relative noise of 1 % in
    eps' and in sigma gives about 1 % for a table of any length.

    Both parts are fitted together: predicting one from the other over a finite band is ill-posed, and 1 % of
    noise spoils the prediction. Limits: a constant and a free charge cannot be distinguished from relaxations
    beyond the band and are fitted; where conduction dominates, the relative error is insensitive to eps';
    passivity is not tested; a resonance narrower than a relaxation counts as a misfit.

    References
    ----------
    .. [1] B. A. Boukamp, "A linear Kronig-Kramers transform test for immittance data validation", J.
       Electrochem. Soc. 142 (1995) 1885-1894.
    """
    hertz, values = _checked(frequency, permittivity, conductivity)
    angular = 2 * np.pi * hertz
    decades = np.log10(angular[-1] / angular[0]) + 2
    times = np.geomspace(0.1 / angular[-1], 10 / angular[0], round(PER_DECADE * decades) + 1)
    columns = np.column_stack(
        [np.ones(hertz.size), -1j / angular, 1 / (1 + 1j * angular[:, np.newaxis] * times)]
    )
    relative = columns / values[:, np.newaxis]
    matrix = np.concatenate([relative.real, relative.imag])
    matrix /= np.linalg.norm(matrix, axis=0)
    wanted = np.repeat([1.0, 0.0], hertz.size)
    weights, _, resolved, _ = np.linalg.lstsq(matrix, wanted, rcond=RESOLUTION)
    freedom = hertz.size - resolved / 2
    if freedom < 1:
        raise InputError(
            f"frequency: {hertz.size} points over {decades - 2:.1f} decades are too few to judge, "
            f"{resolved} terms follow any such table; give at least {resolved // 2 + 2} points."
        )
    return float(np.linalg.norm(matrix @ weights - wanted) / np.sqrt(freedom))


def _checked(
    frequency: npt.ArrayLike, permittivity: npt.ArrayLike, conductivity: npt.ArrayLike
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.complex128]]:
    columns = {
        "frequency": np.asarray(frequency, dtype=float),
        "permittivity": np.asarray(permittivity, dtype=float),
        "conductivity": np.asarray(conductivity, dtype=float),
    }
    shapes = {name: column.shape for name, column in columns.items()}
    hertz = columns["frequency"]
    if hertz.ndim != 1 or hertz.size == 0 or len(set(shapes.values())) > 1:
        raise InputError(f"shapes {shapes}: give three lists of equal length.")
    problems = [
        f"{name}[{int(np.argmin(np.isfinite(column)))}]: must be finite."
        for name, column in columns.items()
        if not np.isfinite(column).all()
    ]
    if not problems and (hertz.min() <= 0 or np.unique(hertz).size < hertz.size):
        problems.append("frequency: all values must be above 0 Hz and none may be repeated.")
    refuse(problems)
    order = np.argsort(hertz)
    loss = columns["conductivity"] / (2 * np.pi * hertz * VACUUM_PERMITTIVITY)
    values = (columns["permittivity"] - 1j * loss)[order]
    if (values == 0).any():
        raise InputError("permittivity and conductivity are both 0 at one frequency: omit that row.")
    return hertz[order], values
