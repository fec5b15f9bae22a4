"""Arrays of netCDF, HDF5, MATLAB and NumPy: each a column as the library that wrote it reads it, or named as not read."""

import struct

import h5py
import numpy as np
import pytest
import scipy.io
import xarray

from electrovib.core.errors import DataFileError
from electrovib.data.array_columns import table_of_arrays
from electrovib.data.registry import read_columns, read_recorded
from electrovib.recordings.importing.import_file import list_columns

pytestmark = pytest.mark.usefixtures("forked")

N = 500
FORCE = 0.3 + 0.1 * np.sin(np.arange(N) / 20)
ENGINES = pytest.mark.parametrize("engine", ["h5netcdf", "scipy"])


def column(found, name):
    return next(each.values for each in found.channels if each.name == name)


def reasons(found):
    return {each.name: each.why for each in found.not_read}


PACKINGS = {
    "whole": {"dtype": "i2", "scale_factor": 0.01, "add_offset": 5.0, "_FillValue": -32768},
    "single": {"dtype": "i2", "scale_factor": np.float32(0.01), "missing_value": np.int16(-1)},
    "unsigned": {"dtype": "i1", "_Unsigned": "true", "scale_factor": 0.5, "_FillValue": -1},
    "filled": {"dtype": "f4", "_FillValue": np.float32(-999)},
}


@ENGINES
@pytest.mark.parametrize("name", PACKINGS)
def test_packed_numbers_are_those_of_xarray_through_every_door(tmp_path, engine, name):
    path, values = tmp_path / "a.nc", 50 * FORCE
    values[[7, 30]] = np.nan
    data = xarray.Dataset({"force": ("time", values, {"units": "N"})}, {"time": np.arange(N) * 1e-3})
    data.to_netcdf(path, engine=engine, encoding={"force": PACKINGS[name]})
    expected = xarray.open_dataset(path, engine=engine)["force"].values
    assert np.isnan(expected).sum() == 2
    np.testing.assert_array_equal(column(read_recorded(path), "force"), expected)
    found = read_columns(path, {"f": ("force", "N")}, missing=True)["f"]
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize(("stated", "count"), [({"valid_range": np.array([0, 30], "i2")}, 9),
    ({"valid_min": 0.05, "valid_max": 0.25}, 19), ({"valid_max": np.int16(35)}, 4)])  # fmt: skip
def test_numbers_outside_the_valid_range_are_missing_and_counted(tmp_path, stated, count):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["force"] = np.arange(40, dtype="i2")
        file["force"].attrs.update({"scale_factor": 0.01, **stated})
    found = read_recorded(tmp_path / "a.h5")
    assert np.isnan(column(found, "force")).sum() == count
    assert reasons(found) == {f"{count} values of force": "outside the valid range that the file states"}
    assert np.nanmin(column(found, "force")) >= 0


@ENGINES
@pytest.mark.parametrize("unit", ["nanoseconds", "microseconds", "milliseconds", "days"])
def test_times_since_a_date_are_relative_to_the_first_without_loss(tmp_path, engine, unit):
    stamps = np.datetime64("2026-11-28T10:00:00", "ns") + np.arange(N) * np.timedelta64(1_000_000, "ns")
    data = xarray.Dataset({"force": ("time", FORCE)}, {"time": stamps})
    kind = {"dtype": "i8"} if engine == "h5netcdf" and unit != "days" else {"dtype": "f8"}
    if engine == "scipy":
        data = data.assign_coords(time=stamps[0] + np.arange(N) * np.timedelta64(86400, "s"))
    elif unit == "days":
        data = data.assign_coords(time=stamps[0] + np.arange(N) * np.timedelta64(6, "h"))
    since = {"time": {"units": f"{unit} since 2026-11-01", **kind}}
    data.to_netcdf(tmp_path / "a.nc", engine=engine, encoding=since)
    found = read_recorded(tmp_path / "a.nc")
    assert (found.time, found.channels[-1].unit) == ("time", "ns")
    expected = (data["time"].values - data["time"].values[0]) / np.timedelta64(1, "ns")
    np.testing.assert_array_equal(found.times(), expected)
    assert found.attributes["first_time"].startswith("2026-11-28T10:00:00")


def test_fields_of_records_are_columns_and_all_else_is_named(tmp_path):
    table = np.zeros(N, [("time", "f8"), ("force", "f4"), ("axes", "f8", 2), ("note", "S4")])
    table["time"], table["force"], table["axes"] = np.arange(N), FORCE, np.array([FORCE, -FORCE]).T
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["run/table"], file["words"], file["rate"] = table, ["a", "b"], 1e4
        file["z"], file["cube"], file["few"], file["none"] = FORCE * 1j, np.zeros((2, 3, 4)), FORCE[:9], []
        file["wide"] = np.zeros((70, 80))
    found = read_recorded(tmp_path / "a.h5")
    names = ["run/table.time", "run/table.force", "run/table.axes[0]", "run/table.axes[1]"]
    assert [each.name for each in found.channels] == names
    assert found.time == "run/table.time"
    np.testing.assert_array_equal(column(found, "run/table.axes[1]"), -FORCE)
    told = reasons(found)
    assert set(told) == {"run/table.note", "words", "rate", "z", "cube", "few", "none", "wide"}
    assert told["rate"] == "is the single value 10000.0"
    assert told["few"].startswith("it has 9 rows, those that are read 500")
    assert (told["z"], told["cube"]) == ("holds complex numbers", "has 3 dimensions (2 x 3 x 4)")
    np.testing.assert_array_equal(read_columns(tmp_path / "a.h5", {"f": ("run/table.force", "N")})["f"],
                                  FORCE.astype("f4"))  # fmt: skip


def test_a_filter_that_is_not_there_is_named(tmp_path):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        plan = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
        plan.set_chunk((N,))
        plan.set_filter(32015, h5py.h5z.FLAG_OPTIONAL, (3,))
        space = h5py.h5s.create_simple((N,))
        made = h5py.Dataset(h5py.h5d.create(file.id, b"force", h5py.h5t.IEEE_F64LE, space, plan))
        made.id.write_direct_chunk((0,), b"packed by a library that is not here", 0)
        file["other"] = FORCE
    words = r"is compressed with filter 32015 \(zstd\), which the HDF5 library here does not have"
    with pytest.raises(DataFileError, match=f"column 'force' {words}"):
        read_columns(tmp_path / "a.h5", {"f": ("force", "N")})
    found = read_recorded(tmp_path / "a.h5")
    assert [each.name for each in found.channels] == ["other"]
    assert "32015 (zstd)" in reasons(found)["force"]


def test_structs_and_cells_of_matlab_are_columns_with_their_own_times(tmp_path):
    trials = np.zeros(3, [("time", "O"), ("force", "O"), ("name", "O")])
    for at in range(3):
        trials[at] = (np.arange(N) * 1e-3 * (at + 1), FORCE * at, "left")
    cell = np.empty(2, object)
    cell[:] = [FORCE, "a word"]
    content = {"trials": trials, "cell": cell, "z": FORCE * 1j, "cube": np.zeros((2, 3, 4))}
    scipy.io.savemat(tmp_path / "a.mat", content)
    found = read_recorded(tmp_path / "a.mat")
    assert [each.name for each in found.channels][1::2] == [
        "trials[0].force",
        "trials[1].force",
        "trials[2].force",
    ]
    np.testing.assert_array_equal(column(found, "trials[2].force"), 2 * FORCE)
    assert found.time == "trials[0].time"
    assert found.clocks["trials[2].force"].time == "trials[2].time"
    assert "trials[0].force" not in found.clocks
    assert {"trials[1].name", "cell{2}", "z", "cube"} <= set(reasons(found))
    second = read_recorded(tmp_path / "a.mat", part="trials[1]")
    assert [each.name for each in second.channels] == ["trials[1].time", "trials[1].force"]
    assert reasons(second)["cell{1}"] == "it belongs to another part; read it with part = cell{1}"


def test_matrices_of_version_4_and_a_row_for_each_signal(tmp_path):
    wide = np.stack([FORCE, 2 * FORCE, 3 * FORCE])
    scipy.io.savemat(tmp_path / "a.mat", {"wide": wide, "t": np.arange(N) * 1e-3}, format="4")
    scipy.io.savemat(tmp_path / "b.mat", {"wide": wide, "t": np.arange(N) * 1e-3})
    for name in ("a.mat", "b.mat"):
        found = read_recorded(tmp_path / name)
        np.testing.assert_array_equal(column(found, "wide[2]"), 3 * FORCE)
        assert found.attributes["arrangement"] == "a row per signal: wide[0] is the first row of wide"
        assert "wide[0] is the first row of wide" in "\n".join(list_columns(tmp_path / name))
    (tmp_path / "a.mat").write_bytes((tmp_path / "a.mat").read_bytes()[:5000])
    with pytest.raises(DataFileError, match="damaged"):
        read_recorded(tmp_path / "a.mat")


def test_structs_and_cells_of_version_73(tmp_path):
    with h5py.File(tmp_path / "a.mat", "w") as file:
        for at in range(2):
            file[f"#refs#/{at}"] = FORCE[None] * (at + 1)
            file[f"#refs#/{at}"].attrs["MATLAB_class"] = np.bytes_("double")
        targets = np.array([[file[f"#refs#/{at}"].ref] for at in range(2)], h5py.ref_dtype)
        for name, kind in {"trials/force": "", "cell": "cell"}.items():
            made = file.create_dataset(name, data=targets, dtype=h5py.ref_dtype)
            if kind:
                made.attrs["MATLAB_class"] = np.bytes_(kind)
        file["trials"].attrs["MATLAB_class"] = np.bytes_("struct")
    found = read_recorded(tmp_path / "a.mat")
    assert [each.name for each in found.channels] == [
        "cell{1}",
        "cell{2}",
        "trials[0].force",
        "trials[1].force",
    ]
    np.testing.assert_array_equal(column(found, "trials[1].force"), 2 * FORCE)


def test_whole_numbers_that_floats_do_not_keep_apart_are_counted_from_the_first_or_named(tmp_path):
    stamps = 1_764_324_000_000_000_001 + np.arange(N) * 7
    arrays = [("t", "ns", stamps), ("mixed", "", stamps[::-1]), ("f", "N", FORCE)]
    found = table_of_arrays(arrays)
    np.testing.assert_array_equal(column(found, "t"), np.arange(N) * 7)
    assert found.attributes["first_time"] == "1764324000000000001"
    assert "beyond 9007199254740992" in reasons(found)["mixed"]


def test_where_no_array_is_a_column_the_reasons_are_given(tmp_path):
    with pytest.raises(DataFileError, match=r"no column of two .* Not read: word \(holds text\)"):
        table_of_arrays([("word", "", np.array(["a", "b"]))])


def test_archives_of_numpy(tmp_path):
    objects = np.array([{"a": 1}], dtype=object)
    stamps = np.datetime64("2026-11-28", "us") + np.arange(N) * np.timedelta64(250, "us")
    content = {
        "t": stamps,
        "force [N]": FORCE,
        "both": np.array([FORCE, -FORCE]).T,
        "o": objects,
        "n": FORCE[:7],
    }
    for save in (np.savez, np.savez_compressed):
        save(tmp_path / "a.npz", **content)
        found = read_recorded(tmp_path / "a.npz")
        assert [(each.name, each.unit) for each in found.channels] == [
            ("t", "us"), ("force", "N"), ("both[0]", ""), ("both[1]", "")]  # fmt: skip
        np.testing.assert_array_equal(column(found, "t"), np.arange(N) * 250)
        assert (found.time, set(reasons(found))) == ("t", {"o", "n"})
        assert "not unpickled" in reasons(found)["o"]
        np.testing.assert_array_equal(read_columns(tmp_path / "a.npz", {"f": ("force", "N")})["f"], FORCE)
    whole = (tmp_path / "a.npz").read_bytes()
    for size in (60, len(whole) // 2, len(whole) - 9):
        (tmp_path / "a.npz").write_bytes(whole[:size])
        with pytest.raises(DataFileError, match="damaged or not a NumPy file of arrays"):
            read_recorded(tmp_path / "a.npz")
    np.savez_compressed(tmp_path / "b.npz", a=np.zeros(40_000_000))
    with pytest.raises(DataFileError, match="would unfold to 320 MB"):
        read_recorded(tmp_path / "b.npz")


def test_a_long_sound_file_is_read_and_another_is_named(tmp_path):
    counts = np.arange(-300, 300, dtype="<i2")
    form = b"fmt " + struct.pack("<IHHIIHH", 16, 1, 1, 8000, 16000, 2, 16)
    sizes = b"ds64" + struct.pack("<IQQQI", 28, 0, counts.nbytes, counts.size, 0)
    data = (
        b"data" + struct.pack("<I", 0xFFFFFFFF) + counts.tobytes() + b"LIST" + struct.pack("<I", 4) + b"INFO"
    )
    (tmp_path / "a.wav").write_bytes(b"RF64\xff\xff\xff\xffWAVE" + sizes + form + data)
    found = read_recorded(tmp_path / "a.wav")
    np.testing.assert_array_equal(found.channels[0].values, counts / 2**15)
    assert found.step == 1 / 8000


@pytest.mark.parametrize(("head", "words"), [
    (b"FORM\0\0\1\0AIFFCOMM", "a sound file in a format that is not read; convert it to .wav"),
    (b"fLaC\0\0\0\x22", "a sound file in a format"), (b"riff\x2e\x91\xcf\x11\xa5\xd6", "a sound file in a format"),
    (b"CDF\x05" + bytes(28), "netCDF in the form CDF-5, which is not read; convert it with 'nccopy -k nc4"),
])  # fmt: skip
@pytest.mark.parametrize("suffix", [".dat", ".wav", ".nc"])
def test_formats_that_are_not_read_are_named_and_not_called_damaged(tmp_path, head, words, suffix):
    (tmp_path / f"a{suffix}").write_bytes(head + bytes(90))
    with pytest.raises(DataFileError, match=words) as caught:
        read_recorded(tmp_path / f"a{suffix}")
    assert "damaged" not in str(caught.value)
