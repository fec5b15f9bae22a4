"""Which versions of the parts made a result."""

from __future__ import annotations

PARTS = (
    "electrovib",
    "numpy",
    "scipy",
    "numba",
    "xarray",
    "h5netcdf",
    "h5py",
    "pydantic",
    "pint",
    "matplotlib",
)


def versions() -> dict[str, str]:
    """Give the versions of electrovib, Python and the packages a result depends on, without importing them.

    Returns
    -------
    dict of str to str
        Name to version; a package that is not installed is left out.
    """
    import platform
    from importlib.metadata import PackageNotFoundError, version

    found = {}
    for part in PARTS:
        try:
            found[part] = version(part)
        except PackageNotFoundError:
            continue
    return {"electrovib": found.pop("electrovib", "unknown"), "python": platform.python_version()} | found
