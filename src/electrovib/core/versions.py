"""Versions of the packages with which a result was computed."""

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
    """Return the versions of Python, electrovib and the installed packages on which a result depends, without imports."""
    import platform
    from contextlib import suppress
    from importlib.metadata import PackageNotFoundError, version

    found = {}
    for part in PARTS:
        with suppress(PackageNotFoundError):
            found[part] = version(part)
    return {"electrovib": found.pop("electrovib", "unknown"), "python": platform.python_version()} | found
