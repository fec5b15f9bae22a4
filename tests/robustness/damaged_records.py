"""Small whole files of every format of instruments, as bytes, for damaging them at random."""

import importlib.util
import io
import struct
import zipfile
from pathlib import Path

import h5py
import numpy as np
import scipy.io
from scipy.io import wavfile

T = np.arange(40) * 1e-4
V = np.sin(600 * T)
G = np.geomspace(1e5, 10, 20)
Z = 100 + 5e4 / (1 + 2j * np.pi * G * 5e4 * 1e-9)


def _rows(separator, *columns):
    return "\n".join(separator.join(f"{value:.6e}" for value in row) for row in zip(*columns, strict=True))


def _written(write):
    found = io.BytesIO()
    write(found)
    return found.getvalue()


def _undated(raw):
    """Return a MAT-file of version 5 without the time of writing in its heading: the same bytes each day."""
    return b"MATLAB 5.0 MAT-file".ljust(116) + raw[116:]


def _isf():
    head = (
        ':WFMPRE:BYT_NR 2;BIT_NR 16;ENCDG BIN;BN_FMT RI;BYT_OR MSB;NR_PT 40;WFID "Ch1, DC";PT_FMT Y;XINCR 4.0E-6;'
        'PT_OFF 0;XZERO -1.0E-3;XUNIT "s";YMULT 0.5;YZERO 1.0;YOFF 3.0;YUNIT "V";:CURVE #280'
    )
    return head.encode() + (100 * V).astype(">i2").tobytes()


def _spice(flags, kinds, points):
    names = "".join(f"\t{number}\tv{number}\t{kind}\n" for number, kind in enumerate(kinds))
    head = f"Title: made up\nPlotname: Analysis\nFlags: {flags}\nNo. Variables: {len(kinds)}\nNo. Points: {points}\nVariables:\n"
    return head + names


def _spice_files():
    """Return raw files of ngspice, complex, in words and with two plots, and one of LTspice."""
    over_time = np.array([T, V]).T
    sweep = _spice("complex", ("frequency", "impedance"), G.size)
    head = _spice("real", ("time", "voltage"), T.size)
    words = "".join(f" {number}\t{t!r}\n\t{v!r}\n" for number, (t, v) in enumerate(over_time.tolist()))
    binary = f"{sweep}Binary:\n".encode() + np.array([G, Z]).T.astype("<c16").tobytes()
    record = np.rec.fromarrays([T, V], "<f8,<f4")
    return {
        "sweep.raw": binary + f"{head}Binary:\n".encode() + over_time.tobytes(),
        "words.raw": f"{head}Values:\n{words}".encode(),
        "wide.raw": f"{head}Binary:\n".encode("utf-16-le") + record.tobytes(),
    }


def _hdf5(file):
    with h5py.File(file, "w") as open_file:
        open_file["run/force"], open_file["run/time"] = V, T
        open_file["run/force"].attrs["units"] = "N"


def mat73(content, *, compression=None):
    """Return a MATLAB file of version 7.3: an HDF5 file behind 512 bytes of MATLAB's own, with a struct for each folder."""
    found = io.BytesIO()
    with h5py.File(found, "w", userblock_size=512) as file:
        for name, values in content.items():
            kind, turned = "double", np.asarray(values).T
            if isinstance(values, str):
                kind, turned = "char", np.frombuffer(values.encode("utf-16-le"), "<u2")[:, None]
            elif turned.dtype.kind == "c":
                parts = np.empty(turned.shape, [("real", "<f8"), ("imag", "<f8")])
                parts["real"], parts["imag"] = turned.real, turned.imag
                turned = parts
            made = file.create_dataset(name, data=turned, compression=compression)
            made.attrs["MATLAB_class"] = np.bytes_(kind)
            if "/" in name:
                made.parent.attrs["MATLAB_class"] = np.bytes_("struct")
    head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM"
    return head.ljust(512, b"\0") + found.getvalue()[512:]


def lecroy(counts=None):
    """Return a waveform of LeCroy whose descriptor follows the public template LECROY_2_3."""
    counts = np.asarray(100 * V if counts is None else counts).astype(np.int8)
    block = bytearray(346)
    block[0:8], block[16:26], block[76:88] = b"WAVEDESC", b"LECROY_2_3", b"LECROYtest\0\0"
    block[196:197], block[244:245] = b"V", b"S"
    for place, form, value in [
        (32, "<h", 0), (34, "<h", 1), (36, "<i", 346), (60, "<i", counts.size), (116, "<i", counts.size),
        (128, "<i", counts.size - 1), (144, "<i", 1), (156, "<f", 0.5), (160, "<f", 2.0), (176, "<f", 1e-6), (180, "<d", -1e-3),
    ]:  # fmt: skip
        struct.pack_into(form, block, place, value)
    return bytes(block) + counts.tobytes()


def tektronix_wfm(values=None, *, version=3, order="<", unit=b"V", storage=0, frames=1):
    """Return a Tektronix .wfm file of versions 2 and 3, laid out as the descriptions of RigolWFM state it."""
    adc = (1000 * V).astype(f"{order}i2") if values is None else np.asarray(values, f"{order}i2")
    curve, spare = adc.tobytes() * frames, frames - 1
    density = "d" if version == 3 else "I"

    def pack(form, *numbers):
        return struct.pack(order + form, *numbers)

    def explicit(scale, offset, text):
        view = pack(f"d20sd{density}dd", 1.0, text, 0.0, 1, 0.0, 0.0)
        return pack("ddI20sddddii", scale, offset, 0, text, 0, 0, 0, 0, 0, storage) + bytes(20) + view

    def implicit(scale, offset, text):
        view = pack(f"d20sd{density}dd", 1.0, text, 0.0, 1, 0.0, 0.0)
        return pack("ddI20sddddI", scale, offset, adc.size, text, 0, 0, 0, 0, 0) + view

    header = pack(
        "iIQQiiIIIiQIIIIIHiQ", min(spare, 1), 1, 0, 0, 0, 0, 1, 1, 1, 2, 0, 1, 1, 1, frames, frames, 0, 1, 0
    )
    header += (
        explicit(2e-3, 0.25, unit)
        + explicit(1.0, 0.0, b"")
        + implicit(4e-6, -1e-3, b"s")
        + implicit(1.0, 0.0, b"")
    )
    header += pack("Iii", 1, 1, 0) * 2
    update, bounds = pack("Iddi", 0, 0.0, 0.0, 0), pack("IihIIIII", 0, 0, 0, 0, 0, *[adc.nbytes] * 3)
    header += update + bounds + update * spare + bounds * spare
    mark = b"\x0f\x0f" if order == "<" else b"\xf0\xf0"
    begin, whole = 78 + len(header), 78 + len(header) + len(curve) + 8
    info = mark + b":WFM#%03d" % version
    info += pack("BiBiifdf32sIH", 9, whole - 15, 2, begin, 0, 0.0, 0.0, 0.0, b"made up", spare, len(header))
    return info + header + curve + bytes(8)


def _xlsx(file):
    import openpyxl

    book = openpyxl.Workbook()
    for row in (["time [ms]", "force [N]"], *zip(T, V, strict=True)):
        book.active.append(list(row))
    book.save(file)


def _stored_xlsx():
    """Return a spreadsheet without compression, so that changes reach its content."""
    found = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(_written(_xlsx))) as packed, zipfile.ZipFile(found, "w") as plain:
        for entry in packed.infolist():
            plain.writestr(entry.filename, packed.read(entry))
    return found.getvalue()


def _tdms(file):
    from nptdms import ChannelObject, TdmsWriter

    with TdmsWriter(file) as open_file:
        open_file.write_segment([ChannelObject("g", "f", V, {"wf_increment": 1e-4, "wf_start_offset": 0.5})])


def whole_files():
    """Return name of a file to its bytes, of all formats whose packages are installed."""
    content = {"record": np.array([T, V]).T, "trial": {"force": V}, "note": "x"}
    preamble = "Model,MSO4104\nSample Interval,1e-04\nRecord Length,40\n\nTIME,CH1\n"
    found = {
        "preamble.csv": (preamble + _rows(",", T, V)).encode(),
        "commas.txt": ("t [s];f [N]\n" + _rows(";", T, V).replace(".", ",")).encode(),
        "wide.tsv": ("t (s)\tf (N)\n" + _rows("\t", T, V)).encode("utf-16"),
        "spectrum.csv": ("f [Hz],Z' [ohm],Z'' [ohm]\n" + _rows(",", G, Z.real, Z.imag)).encode(),
        "spectra.csv": ("f [Hz],Z' [ohm],Z'' [ohm]\n" + 2 * (_rows(",", G, Z.real, Z.imag).rstrip("\n") + "\n")).encode(),
        "steps.csv": "\n\n".join(
            f"Step No. {n}\nSpeed = 3\n\nT,Fx,Fz\nsec,g,g\n\n-1,Sat.,0\n" + _rows(",", T, V, V) for n in (1, 2)).encode(),
        "dates.csv": "\n".join(["Time;F [N]", *(f"1.2.2024 23:59:{at + 20},5;0,{at}" for at in range(40))]).encode(),
        "tables.dta": ("EXPLAIN\nTAG\tX\nA\tTABLE\t3\n\tPt\tT\n\t#\ts\n\t0\t0\n\t1\t1\nZCURVE\tTABLE\n\tFreq\tZreal\tZimag\n"
                       "\tHz\tohm\tohm\n\t" + _rows("\t", G, Z.real, Z.imag).replace("\n", "\n\t")).encode("latin-1"),
        "a.s1p": ("! made up\n# Hz S RI R 50\n" + _rows(" ", G, V[:20], V[20:])).encode(),
        "a.ts": ("[Version] 2.0\n# Hz S RI\n[Number of Ports] 1\n[Number of Frequencies] 20\n[Reference]\n75\n[Network Data]\n"
                 + _rows(" ", G, V[:20], V[20:]) + "\n[End]\n").encode(),
        "a.isf": _isf(),
        "words.isf": _isf().partition(b"#")[0].replace(b"BIN;", b"ASC;") + ",".join(f"{v:.0f}" for v in 100 * V).encode(),
        **_spice_files(),
        "a.wav": _written(lambda file: wavfile.write(file, 8000, (V * 2**14).astype(np.int16))),
        "a.npy": _written(lambda file: np.save(file, np.array([T, V]).T)),
        "packed.mat": _undated(_written(lambda file: scipy.io.savemat(file, content, do_compression=True))),
        "plain.mat": _undated(_written(lambda file: scipy.io.savemat(file, content))),
        "a.h5": _written(_hdf5),
        "new.mat": mat73({"record": np.array([T, V]).T, "trial/force": V[:, None], "trial/note": "x"}),
    }  # fmt: skip
    if importlib.util.find_spec("nptdms"):
        found["a.tdms"] = _written(_tdms)
    if importlib.util.find_spec("openpyxl"):
        found |= {"a.xlsx": _written(_xlsx), "stored.xlsx": _stored_xlsx()}
    if importlib.util.find_spec("RigolWFM"):
        found["a.trc"] = lecroy()
        found["a.wfm"] = tektronix_wfm()
    if importlib.util.find_spec("impedance"):
        head = "ZPLOT2 ASCII\n  Freq(Hz)\tAmpl\tBias\tTime(Sec)\tZ'(a)\tZ''(b)\nEnd Comments\n"
        found["a.z"] = (head + _rows("\t", G, 0 * G, 0 * G, 0 * G, Z.real, Z.imag)).encode()
    return found


def read_damaged(path: Path):
    """Read a file as a user does; return ``read`` or ``refused``."""
    from electrovib.core.errors import InputError
    from electrovib.data.registry import read_recorded
    from electrovib.data.spectrum import spectrum_of
    from electrovib.recordings.importing.import_file import import_file

    try:
        recorded = read_recorded(path)
        column = next(each for each in recorded.channels if each.name != recorded.time)
        try:
            spectrum_of(recorded)
        except InputError:
            scale = {"drive_voltage": f"2 V/{column.unit or '1'}"}
            even = None if recorded.time else 1e-4
            import_file(path, {"drive_voltage": column.name}, scale=scale, step=even)
    except InputError as error:
        if any("\n" in problem.replace(str(path), "") for problem in error.problems):
            raise AssertionError(f"more than one line: {error.problems}") from None
        return "refused"
    return "read"


def mutated(raw, random):
    """Return bytes with one to three changes, as by transfers, editors and forgery."""
    found = bytearray(raw)
    for _ in range(int(random.choice([1, 1, 2, 3]))):
        place = int(random.integers(0, max(1, len(found))))
        size = int(random.integers(1, 1 + int(random.choice([1, 1, 4, 8, 64]))))
        match int(random.integers(0, 8)):
            case 0 | 1:
                if found:
                    found[place] ^= 1 << int(random.integers(0, 8))
            case 2:
                found[place : place + size] = random.bytes(size)
            case 3:
                del found[place : place + size]
            case 4:
                found[place:place] = found[place : place + size]
            case 5:
                del found[place:]
            case 6:
                number = int(random.choice([-1, 0, 1, 2**31 - 1, 2**31, 2**40, 2**62]))
                width = int(random.choice([2, 4, 8]))
                found[place : place + width] = (number % 256**width).to_bytes(width, "little")
            case _:
                text = str(
                    random.choice(
                        ["[", '"', "9" * 400, "nan", ",", ";", "\n", "1e999", "-", "µ", "\0", "1,5"]
                    )
                )
                found[place:place] = (text * int(random.choice([1, 1, 1, 300]))).encode()
    return bytes(found)
