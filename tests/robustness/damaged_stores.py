"""Stores of studies damaged at random, and what every door answers; run as a program, one process for many cases.

``python damaged_stores.py FOLDER FIRST LAST`` prints one JSON line for each case.
"""

import json
import os
import random
import shutil
import signal
import socket
import sys
import traceback
from pathlib import Path

from stand_in_population import SPACE, stand_in

SIGNALS = ["electrostatic_force", "lateral_force"]
ASKED = {"n": 1500, "seed": 3, "quantity": SIGNALS, "exceed": "1 mN"}
WAITING = 20.0
"""Seconds after which a case counts as endless."""
GROWTH = 10**9
"""Bytes by which the process may grow."""
STORES = {"complete": True, "begun": False, "begun_draws": True}
"""Name of a store to whether it keeps the signals of every finger."""
VALUES = [
    None, True, -1, 0, 3, 10**12, 10**30, 1e308, float("nan"), "x", "", "NaN", [], {}, [[1]], ["a", 2],
    "int64", "complex128", "float16", "r8", "gzip", "zstd", "blosc", [10**12, 10**12], [-1], [10**6, 10**6],
]  # fmt: skip


def in_quarters(sizes, *_) -> None:
    """Take the place of `TileSizes.measured`: a block is four tiles."""
    sizes.wanted = 256


def asked(name: str, output: Path | None) -> dict:
    return ASKED | {"records": STORES[name], "output": output}


def make_stores(folder: Path) -> None:
    """Write one complete store and two whose studies were ended within their second block."""
    from electrovib.core.deprecation import former_values
    from electrovib.studies.population import StudyCancelledError, study

    for name in STORES:
        end = None if name == "complete" else lambda done, _: done >= 1280
        try:
            with former_values(progress=end):
                study("vezzoli_2014/fig6", SPACE, **asked(name, folder / f"{name}.zarr"))
        except StudyCancelledError:
            assert end is not None


def content(folder: Path) -> dict:
    """Return what stands in a folder, without following links or opening anything but ordinary files."""
    found = {}
    for place, folders, files in os.walk(folder):
        for each in (Path(place) / name for name in [*folders, *files]):
            if each.is_symlink():
                found[each] = f"link to {each.readlink()}"
            elif each.is_file() and each.stat().st_size < 10**8:
                found[each] = each.read_bytes()
            else:
                found[each] = each.lstat().st_mode, each.lstat().st_size * each.is_file()
    return found


def damaged(store: Path, other: Path, chance: random.Random) -> str:
    """Damage a store once, and describe how; `other` is a file beside it, which nothing may change."""
    names = sorted(each for each in store.rglob("*") if each.is_file())
    folders = sorted(each for each in store.rglob("*") if each.is_dir())
    file, folder = chance.choice(names), chance.choice(folders)
    texts = [each for each in names if each.name == "zarr.json" or each.read_bytes()[:1] == b"{"]
    kind = chance.choice([*_OF_FILES, *_OF_FOLDERS, *_OF_TEXTS, *_OF_TEXTS, *_BESIDE])
    if kind in _OF_FILES:
        target = file
        _OF_FILES[kind](file, other, chance)
    elif kind in _OF_FOLDERS:
        target = folder
        _OF_FOLDERS[kind](folder, other, chance, chance.choice(folders))
    elif kind in _OF_TEXTS:
        target = store / "zarr.json" if chance.random() < 0.4 else chance.choice(texts)
        _OF_TEXTS[kind](target, chance)
    else:
        name = chance.choice(["more", ".lock", "x.partial", "zarr.json.partial"])
        target = chance.choice([store, *folders]) / name
        _BESIDE[kind](target, other)
    return f"{kind}: {target.relative_to(store)}"


def _flipped(file, other, chance):
    raw = bytearray(file.read_bytes())
    for _ in range(chance.choice([1, 1, 3])):
        raw[chance.randrange(len(raw))] ^= 1 << chance.randrange(8)
    file.write_bytes(raw)


def _socket(place):
    place.unlink(missing_ok=True)
    here = Path.cwd()  # the name of a socket may have 100 characters
    os.chdir(place.parent)
    with socket.socket(socket.AF_UNIX) as made:
        made.bind(place.name)
    os.chdir(here)


def _exchanged(file, other, chance):
    """Exchange a file with another one of the same name: two chunks, or two descriptions."""
    store = next(each for each in file.parents if each.parent == other.parent)
    same = sorted(each for each in store.rglob(file.name) if each.is_file() and each != file) or [file]
    second = chance.choice(same)
    one, two = file.read_bytes(), second.read_bytes()
    file.write_bytes(two), second.write_bytes(one)


def _replaced(place, make):
    if place.is_dir() and not place.is_symlink():
        shutil.rmtree(place)
    else:
        place.unlink(missing_ok=True)
    make()


_OF_FILES = {
    "cut": lambda file, _, chance: os.truncate(file, chance.randrange(file.stat().st_size)),
    "longer": lambda file, _, chance: file.write_bytes(file.read_bytes() + chance.randbytes(9)),
    "a terabyte of zeros": lambda file, *_: os.truncate(file, 10**12),
    "flipped": _flipped,
    "flipped again": _flipped,
    "random bytes": lambda file, _, chance: file.write_bytes(chance.randbytes(file.stat().st_size)),
    "other bytes": lambda file, _, chance: file.write_bytes(chance.randbytes(chance.choice([1, 30, 10**6]))),
    "empty": lambda file, *_: file.write_bytes(b""),
    "missing": lambda file, *_: file.unlink(),
    "folder for file": lambda file, *_: _replaced(file, file.mkdir),
    "link to zeros": lambda file, *_: _replaced(file, lambda: file.symlink_to("/dev/zero")),
    "link to other": lambda file, other, _: _replaced(file, lambda: file.symlink_to(other)),
    "link to itself": lambda file, *_: _replaced(file, lambda: file.symlink_to(file.name)),
    "link to nothing": lambda file, *_: _replaced(file, lambda: file.symlink_to("nothing")),
    "pipe": lambda file, *_: _replaced(file, lambda: os.mkfifo(file)),
    "socket": lambda file, *_: _socket(file),
    "unreadable": lambda file, *_: file.chmod(0) if os.getuid() else file.unlink(),
    "files exchanged": _exchanged,
}  # fmt: skip


def _folders_exchanged(folder, other, chance, second):
    if second in (folder, *folder.parents) or folder in second.parents:
        shutil.rmtree(folder)
        return
    aside = folder.with_name("aside")
    folder.rename(aside)
    second.rename(folder)
    aside.rename(second)


def _values(folder, other, chance, second):
    """Write other numbers into an array as another program would, with its codecs."""
    import zarr

    arrays = [each for each in (folder, *folder.parents) if (each / "zarr.json").exists()]
    group = next((each for each in arrays if "shape" in (each / "zarr.json").read_text()), None)
    if group is None:
        shutil.rmtree(folder)
        return
    array = zarr.open_array(str(group), mode="r+")
    values = array[...]
    number = chance.choice([float("nan"), float("inf"), 1e30, 7])
    values.flat[chance.randrange(values.size)] = number if values.dtype.kind == "f" else 10**9
    array[...] = values


_OF_FOLDERS = {
    "missing folder": lambda folder, *_: shutil.rmtree(folder),
    "file for folder": lambda folder, *_: _replaced(folder, lambda: folder.write_text("x")),
    "pipe for folder": lambda folder, *_: _replaced(folder, lambda: os.mkfifo(folder)),
    "link to itself for folder": lambda folder, *_: _replaced(folder, lambda: folder.symlink_to(folder.name)),
    "link to parent for folder": lambda folder, *_: _replaced(folder, lambda: folder.symlink_to("..")),
    "folder elsewhere": lambda folder, other, *_: (
        folder.rename(other.parent / "elsewhere"), folder.symlink_to(other.parent / "elsewhere")),
    "folders exchanged": _folders_exchanged,
    "folder copied": lambda folder, _, __, second: shutil.copytree(folder, second / "more"),
    "values": _values,
    "values again": _values,
}  # fmt: skip


def _places(node, path=()):
    yield path
    if isinstance(node, (dict, list)):
        for key, inner in node.items() if isinstance(node, dict) else enumerate(node):
            yield from _places(inner, (*path, key))


def _changed(file, chance, change):
    table = json.loads(file.read_text())
    places = [each for each in _places(table) if each]
    groups = {}
    for each in places:
        groups.setdefault(each[:2] if each[0] == "attributes" else each[:1], []).append(each)
    path = chance.choice(groups[chance.choice(sorted(groups, key=str))])
    node = table
    for key in path[:-1]:
        node = node[key]
    change(node, path[-1])
    file.write_text(json.dumps(table))


def _set(file, chance):
    value = chance.choice(VALUES)
    _changed(file, chance, lambda node, key: node.__setitem__(key, value))


def _text(file, chance):
    """Change a letter of a long text, such as the scenario, or a number."""

    def change(node, key):
        if isinstance(node[key], str) and node[key]:
            at = chance.randrange(len(node[key]))
            node[key] = node[key][:at] + chance.choice("0x[\"'=\n") + node[key][at + 1 :]
        elif isinstance(node[key], (int, float)):
            node[key] = node[key] + chance.choice([1, -1, 10**9])
        else:
            node[key] = None

    _changed(file, chance, change)


_OF_TEXTS = {
    "set": _set,
    "set again": _set,
    "set once more": _set,
    "text": _text,
    "removed": lambda file, chance: _changed(file, chance, lambda node, key: node.__delitem__(key)),
    "deep": lambda file, _: file.write_text(
        file.read_text().replace(":", ":" + "[" * 10**5 + "]" * 10**5 + ',"x":', 1)),
    "large": lambda file, _: file.write_text("{" + " " * 3 * 10**7 + file.read_text()[1:]),
    "list": lambda file, _: file.write_text(f"[{file.read_text()}]"),
}  # fmt: skip

_BESIDE = {
    "pipe beside": lambda place, _: os.mkfifo(place),
    "link beside": lambda place, other: place.symlink_to(other),
    "zeros beside": lambda place, _: place.symlink_to("/dev/zero"),
    "folder with a pipe beside": lambda place, _: (place.mkdir(), os.mkfifo(place / "zarr.json")),
    "text beside": lambda place, _: place.write_text("mine"),
}


class Endless(BaseException):
    """A case that does not end."""


def _endless(*_):
    raise Endless


def opened(name: str, path: Path):
    import electrovib as ev

    return ev.open_study(path).load()


def studied(name: str, path: Path):
    import electrovib as ev

    return ev.study("vezzoli_2014/fig6", SPACE, **asked(name, path)).load()


def reported(name: str, path: Path):
    import electrovib as ev

    page = path.parent / "page.html"
    return ev.report(path, page, force=True).read_text(encoding="utf-8")


def same(found, expected) -> bool:
    """Whether two results are the same but for rounding: a study that was continued formed its sums of other tiles."""
    import xarray

    try:
        xarray.testing.assert_allclose(found, expected, rtol=1e-12, atol=0.0)
    except AssertionError:
        return False
    return found.attrs == expected.attrs and all(
        found[name].attrs == expected[name].attrs for name in expected.variables
    )


DOORS = {"open": opened, "report": reported, "study": studied}


def answer(door, name: str, path: Path, expected) -> list[str]:
    """Return what a door did with a damaged store, and what it said."""
    from electrovib.core.errors import InputError

    signal.setitimer(signal.ITIMER_REAL, WAITING)
    try:
        found = door(name, path)
    except Endless:
        return ["endless", ""]
    except InputError as error:
        said = str(error)
        one_line = "\n" not in said and len(said) < 700
        return ["refused" if one_line else "long", said]
    except MemoryError:
        return ["grown", ""]
    except BaseException:  # noqa: BLE001  # whatever comes is what this looks for
        return ["crashed", traceback.format_exc()[-900:]]
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
    if not isinstance(found, str):
        return ["accepted" if same(found, expected) else "wrong", ""]
    return ["accepted" if found == expected else "wrong", ""]


def cases(folder: Path, first: int, last: int, growth: int = 0):
    """Yield number, store, damage, and the answer of every door; a process of its own may be kept from growing."""
    import electrovib as ev

    stores = folder / "whole"
    if not stores.exists():
        stores.mkdir(parents=True)
        make_stores(stores)
    (folder / "case").mkdir(exist_ok=True)
    expected = {}
    for name in STORES:
        done = ev.study("vezzoli_2014/fig6", SPACE, **asked(name, None))
        expected[name] = {"open": done, "study": done}
    whole = folder / "case" / "a.zarr"
    shutil.copytree(stores / "complete.zarr", whole)
    expected["complete"]["report"] = reported("", whole)
    shutil.rmtree(whole)
    (folder / "case" / "page.html").unlink()
    signal.signal(signal.SIGALRM, _endless)
    if growth:
        import resource

        size = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (size + growth, size + growth))
    for number in range(first, last):
        chance = random.Random(number)
        name = chance.choice(["complete", "complete", "begun", "begun_draws"])
        place = folder / "case" / str(number)
        place.mkdir()
        other = place / "other"
        other.write_bytes(b'{"mine": 1}' * 100)
        path = place / "a.zarr"
        shutil.copytree(stores / f"{name}.zarr", path)
        how = damaged(path, other, chance)
        before, found = content(place), {}
        for each, door in DOORS.items():
            found[each] = answer(door, name, path, expected[name].get(each))
            (place / "page.html").unlink(missing_ok=True)
            if found[each][0] == "refused" and content(place) != before:
                found[each][0] = "changed"
        shutil.rmtree(place)
        yield number, name, how, found


def main() -> None:
    from electrovib.solve import population
    from electrovib.studies.population import tiles

    population.population = stand_in
    tiles.TileSizes.measured = in_quarters
    for case in cases(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]), growth=GROWTH):
        print(json.dumps(case), flush=True)
    os._exit(0)  # threads of a case that did not end may still wait


if __name__ == "__main__":
    main()
