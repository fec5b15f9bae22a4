"""What a file is that stands in the place of another, in one sentence with what takes it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from electrovib.core.files import kind_of

_OWN: Final = {
    "a bench file": ({"current_limiter", "generator", "oscilloscope"}, "bench run SCENARIO --bench {}"),
    "a submission": ({"law", "priors", "made_from"}, "evidence --laws {}"),
    "a measurement": ({"values", "spread_of", "made", "measurements"}, "evidence {}"),
    "a scenario": ({"drive", "stack", "force"}, "run {}"),
    "a space": ({"space", "groups", "relations"}, "study SCENARIO --space {}"),
    "a recipe": ({"columns", "values", "quantity"}, "import FILE --recipe {}"),
    "a file of limits": ({"limits"}, "check SCENARIO --limits {}"),
}
"""Files that electrovib reads: the tables that tell each, and the command that takes it."""
_ARCHIVE: Final = "an archive; unpack it, and give the file in it"
_DOCUMENT: Final = "a document; save the table in it as .csv or .xlsx"
_PICTURE: Final = "a picture; save the data that it shows as .csv"
_SOUND: Final = (
    "a sound file in a format that is not read; convert it to .wav, such as with 'ffmpeg -i {} NEW.wav'"
)
_CDF_5: Final = "netCDF in the form CDF-5, which is not read; convert it with 'nccopy -k nc4 {} NEW.nc'"
_SPREADSHEET: Final = "a spreadsheet in a format that is not read; save it as .csv or .xlsx"
_IMPEDANCE: Final = "a file of a potentiostat or impedance analyser in its own form; export the spectrum there as .csv or .txt"
_WEB: Final = "a page of the web (HTML); save the table that it shows as .csv"
_DATABASE: Final = "a database (SQLite); write the table in it to a .csv"
_PARQUET: Final = "a table in the format Parquet, which is not read; write it as .csv, such as with pandas"
_PICKLE: Final = "a pickle of Python, which may run any program and is not read; save the numbers with numpy.save or as .csv"
_MDF: Final = (
    "measurement data in the format MDF (.mf4), which is not read; export the channels as .csv or .mat"
)
_XML: Final = "a file of XML, such as TDM of DIAdem, which is not read; save the table there as .csv or .tdms"
_JSON: Final = "JSON, which holds no table of its own; write the arrays in it as .csv or .npz"
_TABLE: Final = "a table of numbers; 'electrovib import {}' reads it"
_TABLES: Final = ".csv .txt .dat .tsv .xlsx .xlsm .tdms .wav .isf .h5 .hdf5 .mat .nc"
_WORDS: Final = {
    _ARCHIVE: ".zip .gz .rar .7z .tar .bz2 .xz",
    _DOCUMENT: ".doc .docx .odt .pdf .ppt .pptx .rtf",
    _PICTURE: ".png .jpg .jpeg .gif .bmp .tif .tiff .svg .webp",
    _IMPEDANCE: ".idf .ids .isw .dfr .i2b .pssession .mpr",
    _SPREADSHEET: ".xls .xlsb .ods .numbers .gsheet",
    _SOUND: ".aif .aiff .aifc .flac .w64 .ogg .opus .mp3 .m4a .caf .au",
    _WEB: ".html .htm",
    _DATABASE: ".sqlite .sqlite3 .db",
    _PARQUET: ".parquet .feather .arrow",
    _PICKLE: ".pkl .pickle",
    _MDF: ".mf4 .mdf",
    _XML: ".tdm .xml",
    _JSON: ".json",
    "a study store; 'electrovib report {}' shows it": ".zarr",
    "Python; models of your own are named before the command: 'electrovib --models {} ...'": ".py",
    "a file of electrovib; a scenario is simulated by 'electrovib run {}'": ".toml",
}
_BY_SUFFIX: Final = {suffix: words for words, suffixes in _WORDS.items() for suffix in suffixes.split()}
_BEGINNINGS: Final = {
    b"\xd0\xcf\x11\xe0": _SPREADSHEET, b"PK\x03\x04": _ARCHIVE, b"\x1f\x8b": _ARCHIVE, b"Rar!": _ARCHIVE,
    b"7z\xbc\xaf": _ARCHIVE, b"%PDF": _DOCUMENT, b"\x89PNG": _PICTURE, b"\xff\xd8\xff": _PICTURE, b"GIF8": _PICTURE,
    b"fLaC": _SOUND, b"riff\x2e\x91": _SOUND, b"OggS": _SOUND, b"caff": _SOUND, b".snd": _SOUND, b"CDF\x05": _CDF_5,
    b"SQLite format 3": _DATABASE, b"PAR1": _PARQUET, b"MDF ": _MDF, b"<?xml": _XML,
}  # fmt: skip


def is_address(path: Path) -> bool:
    """Tell whether a name is the address of a page or file of the web."""
    return str(path).startswith(("http:", "https:", "ftp:"))


def foreign(path: Path, head: bytes = b"") -> str:
    """Say what a file is that no reader of numbers takes, by its name and its first bytes; empty for any other."""
    if is_address(path):
        return "is a web address; download the file, and give its name"
    begun = next((words for start, words in _BEGINNINGS.items() if head.startswith(start)), "")
    if head[:4] == b"FORM" and head[8:11] == b"AIF":
        begun = _SOUND
    if head.lstrip(b"\xef\xbb\xbf \t\r\n")[:20].lower().startswith((b"<!doctype html", b"<html", b"<table")):
        begun = _WEB
    if (head.startswith(b"PK") and b".npy" in head) or b"xl/" in head or b"[Content_Types]" in head:
        begun = ""
    words = begun if begun == _WEB else _BY_SUFFIX.get(path.suffix.lower(), begun)
    is_text = path.suffix.lower() == ".xls" and head and not begun  # as instruments call a table with tabs
    return f"is {words.replace('{}', str(path))}" if words and not is_text else ""


def other_kind(path: Path, kind: str, content: Mapping[str, Any] | None = None) -> str:
    """Say what a file is where one of another kind is wanted, and what takes it; empty if that is not known."""
    if content and _OWN.get(kind, (set(), ""))[0] & content.keys():
        return ""
    if not content and not is_address(path) and not kind_of(path):
        return ""  # a file that is not there is missing, whatever its name says
    found = next((own for own, (tables, _) in _OWN.items() if content and tables & content.keys()), "")
    if not found and path.suffix.lower() == ".toml" and not is_address(path):
        return ""
    table = f"is {_TABLE}" if not content and path.suffix.lower() in _TABLES.split() else ""
    problem = f"is {found}; 'electrovib {_OWN[found][1]}' takes it" if found else foreign(path) or table
    what, sign, does = problem.replace("{}", str(path)).partition(";")
    return f"{what}, not {kind}{sign}{does}" if problem else ""
