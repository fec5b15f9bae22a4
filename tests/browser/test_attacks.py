"""A running server, attacked through its own protocol: malformed links and files, leaving, stopping."""

from __future__ import annotations

import asyncio
import io
import os
import signal
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("nicegui")  # its client library is that of the visitor

from tests.browser.conftest import started
from tests.browser.visitor import Visitor
from tests.unit.apps.explorer.test_state import MALFORMED

pytestmark = pytest.mark.slow

FIRST = "vezzoli_2014/fig6"


def _zip(size: int) -> bytes:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("[Content_Types].xml", "<a/>")
        archive.writestr("xl/worksheets/sheet1.xml", bytes(size))
    return packed.getvalue()


def _objects() -> bytes:
    file = io.BytesIO()
    np.save(file, np.array([{1: 2}], dtype=object))
    return file.getvalue()


def _drive(text: str) -> bytes:
    return f"schema = 1\ndrive = {text}".encode()


RANDOM = np.random.default_rng(1).integers(0, 256, 3000, dtype=np.uint8).tobytes()
HUGE = b"{'descr': '<f8', 'fortran_order': False, 'shape': (100000000000,), }"
FILES = [
    (b"a.csv", b""),
    (b"a.csv", b"\0"),
    (b"a.csv", b"x"),
    (b"a.csv", b"1,2"),
    (b"a.csv", b"1," * 9_000_000),
    (b"a.csv", b"\n" * 19_000_000),
    (b"a.csv", bytes(19_900_000)),
    (b"a.csv", b'"' * 100_000),
    (b"a.csv", b"t," + b"<b>" * 1000 + b"\n1,2\n2,3\n"),
    (b"a.csv", b"\xff\xfe" + b"\xd8" * 99),
    (b"a.csv", RANDOM),
    (b"a.xlsx", _zip(300_000_000)),
    (b"a.xlsx", _zip(1000)),
    (b"a.xlsx", b"PK\x03\x04" + RANDOM),
    (b"a.npy", _objects()),
    (b"a.npy", b"\x93NUMPY\x01\0v\0" + HUGE.ljust(117) + b"\n"),
    (b"a.npy", b"\x93NUMPY" + RANDOM),
    (b"a.nc", b"\x89HDF\r\n\x1a\n" + bytes(100)),
    (b"a.nc", b"\x89HDF\r\n\x1a\n" + RANDOM),
    (b"a.nc", b"CDF\x01" + RANDOM),
    (b"a.h5", b"\x89HDF\r\n\x1a\n" + b"\xff" * 4000),
    (b"a.mat", b"MATLAB 5.0 MAT-file" + bytes(120)),
    (b"a.mat", (b"MATLAB 5.0 MAT-file".ljust(124) + b"\0\1IM") + RANDOM),
    (b"a.mat", b"MATLAB 7.3 MAT-file" + RANDOM),
    (b"a.wav", b"RIFF" + b"\xff" * 4 + b"WAVEfmt " + RANDOM),
    (b"a.isf", b":WFMP:BYT_N 2;:CURVE #9999999999" + RANDOM),
    (b"a.tdms", b"TDSm" + RANDOM),
    (b"a.trc", b"WAVEDESC" + RANDOM),
    (b"a.s1p", b"# Hz S MA R 50\n1 x y\n"),
    (b"a.dta", b"EXPLAIN\nTAG\n"),
    (b"../../../a.csv", b"x"),
    (b"/etc/passwd", RANDOM),
    (b"..\\..\\a.csv", b"x"),
    (b"a\0b.csv", b"x"),
    (b"x" * 1500 + b".csv", b"x"),
    (b"<img src=x onerror=alert(1)>.csv", b"x"),
    (b"\xff\xfe.csv", b"x"),
    (b"a.exe", b"MZ" + RANDOM),
    (b"a", b"#!/bin/sh\necho 1"),
    (b"a.py", b"import os"),
    (b"a.pkl", b"\x80\x04\x95cos\nsystem\n(S'id'\ntR."),
    (b"a.toml", b""),
    (b"a.toml", b"\xff"),
    (b"a.toml", b"#" * 600_000),
    (b"a.toml", b"a = " + b"[" * 100_000),
    (b"a.toml", b"a." * 200_000 + b"a = 1"),
    (b"a.toml", b"a = " + b"9" * 100_000),
    (b"a.toml", b"a = 1\na = 2"),
    (b"a.toml", b"schema = 1979-05-27"),
    (b"a.toml", b"schema = 99999"),
    (b"a.toml", b'"__class__" = 1'),
    (b"a.toml", _drive('{ model = "Sampled", file = "/etc/passwd" }')),
    (b"a.toml", _drive('{ model = "Sampled", file = "~/.bashrc" }')),
    (b"a.toml", _drive('{ model = "Sampled", file = "$HOME/a.csv" }')),
    (b"a.toml", _drive('{ model = "__import__", command = "id" }')),
    (b"a.toml", _drive('{ model = "Sine", amplitude = nan, frequency = inf }')),
    (b"a.toml", _drive('{ model = "Sine", amplitude = 1e999, frequency = 1 }')),
    (b"a.toml", _drive("{ model = \"Sine\", amplitude = \"__import__('os').system('id')\", frequency = 1 }")),
    (b"a.TOML", _drive('"/etc/passwd"')),
]
LINKS = [
    *MALFORMED,
    "set=drive.high=1e999",
    "set=drive.high=inf V",
    "set=drive.high=-inf",
    "set=drive.high=NaN V",
    "set=drive.high=三 V",
    "set=drive.high=$HOME",
    "set=drive.high=~",
    "set=drive.high=<script>alert(1)</script>",
    "set=drive.high={{7*7}}",
    "set=drive.high=1&set=drive.high.x=1",
    "set=drive.high.__class__.__init__=1",
    "set=__init__.__globals__=1",
    "set=stack.insulator.material=~/a.toml",
    "set=stack.insulator.material=$HOME/a.toml",
    "set=stack.insulator.material=%00",
    'set=stack.insulator.material={ model = "Tabulated", \'file\' = "a.csv" }',
    'set=stack.insulator.material.file="a.csv"',
    "set=friction={ model = 5 }",
    "set=friction=[1, 2]",
    "set=limits=1",
    "set=time=1",
    "set=time.samples=1e9",
    "set=time.samples=20001",
    "set=frequency.samples=1e9",
    "set=time.duration=1e12 s",
    "preset=yours",
    "preset=dropped",
    "preset=vezzoli_2014/fig6%00",
    "preset=VEZZOLI_2014/FIG6",
    "preset=<img src=x onerror=alert(1)>",
    "preset=~",
    "preset=$HOME",
    "preset=file:///etc/passwd",
    "preset=http://127.0.0.1/",
]
TOO_LONG = [
    'set=drive={ model = "Square", high = 100, low = -100, frequency = 1e6 }&set=time.duration=1e4 s',
    'set=drive={ model = "Square", high = 1, low = -1, frequency = 1e8 }&set=time.duration=1e5 s',
    'set=drive={ model = "PulseTrain", high = 9, width = 1e-7, frequency = 1e6 }&set=time.duration=9e4 s',
    'set=drive={ model = "Square", high = 100, low = -100, frequency = 1e6 }&set=time.duration=9 s',
]


async def _opened(port: int) -> Visitor:
    visitor = Visitor(port)
    assert await visitor.load() == 200
    await visitor.connect()
    return visitor


def _encoded(link: str) -> str:
    from urllib.parse import quote

    return "?" + quote(link, safe="=&%")


def _listing(*folders: Path) -> dict[str, tuple[int, int]]:
    return {
        str(path): (path.lstat().st_size, path.lstat().st_mtime_ns)
        for folder in folders
        for path in folder.rglob("*")
        if path.is_file() or path.is_symlink()
    }


@pytest.fixture
def watched(tmp_path_factory):
    """A server whose home, working folder and temporary folder are empty ones."""
    base = tmp_path_factory.mktemp("watched")
    home, place = base / "home", base / "place"
    home.mkdir()
    place.mkdir()
    server = started(
        tmp_path_factory, "temporary", place=place, HOME=str(home), PYTHONPATH=os.pathsep.join(sys.path)
    )
    server.watched = (home, place, server.folder)
    yield server
    server.process.kill()
    server.process.wait()
    server.process.stdout.close()


def test_more_than_a_hundred_malformed_links_and_files_give_a_sentence_each(watched):
    async def run():
        sentences = []
        for link in LINKS:
            visitor = Visitor(watched.port)
            assert await visitor.load(_encoded(link)) == 200
            sentences.append((link, visitor.alert))
            await visitor.connect()
            await visitor.close()
            await asyncio.sleep(0.05)
        for link in TOO_LONG:
            visitor = Visitor(watched.port)
            await visitor.load(_encoded(link))
            assert visitor.alert == ""
            await visitor.connect()
            await visitor.until(lambda visitor=visitor: visitor.alert)
            sentences.append((link, visitor.alert))
            await visitor.close()
        visitor = await _opened(watched.port)
        for name, content in FILES:
            if not visitor.socket.connected:  # a busy machine answered too late
                await visitor.close()
                visitor = await _opened(watched.port)
            try:
                sentences.append((name, await visitor.sentence_on(name, content)))
            except TimeoutError:
                assert not visitor.socket.connected, (name, content[:40])
                visitor = await _opened(watched.port)
                sentences.append((name, await visitor.sentence_on(name, content)))
        assert await visitor.upload(b"a.csv", bytes(21_000_000)) == 413
        await visitor.close()
        after = Visitor(watched.port)
        assert await after.load(_encoded("set=drive.high=300 V")) == 200
        assert after.alert == ""
        await after.close()
        return sentences

    before = _listing(*watched.watched)
    sentences = asyncio.run(run())
    assert len(sentences) >= 130
    for what, sentence in sentences:
        assert 15 < len(sentence) < 6000, (what, sentence)
        assert "Traceback" not in sentence
        assert "mistake of electrovib" not in sentence, (what, sentence)
        assert str(watched.folder) not in sentence
    assert _listing(*watched.watched) == before
    assert watched.stop() == ""  # nothing in its log


def _readers(server: int) -> list[int]:
    """Processes of the server that read a file."""
    found = []
    for each in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            is_reader = b"guarded_child" in each.read_bytes()
            parent = int((each.parent / "stat").read_text().rsplit(")", 1)[1].split()[1])
        except (OSError, IndexError):  # it has ended meanwhile
            continue
        if is_reader and parent == server:
            found.append(int(each.parent.name))
    return found


def test_a_visitor_who_leaves_in_the_middle_of_an_upload_leaves_nothing(watched):
    async def run():
        for _ in range(3):
            visitor = Visitor(watched.port)
            await visitor.load()
            await visitor.connect()
            sending = asyncio.create_task(visitor.upload(b"a.csv", b"1,2\n" * 4_000_000))
            await asyncio.sleep(0.1)
            sending.cancel()
            await visitor.close()
        visitor = Visitor(watched.port)
        await visitor.load()
        await visitor.connect()
        await visitor.upload(b"a.csv", b"1,2\n" * 400_000)  # left while it is read
        await visitor.close()
        address = f"{visitor.address}/_nicegui/client/{visitor.client}/upload/1"
        _, writer = await asyncio.open_connection("127.0.0.1", watched.port)
        head = f"POST {address} HTTP/1.1\r\nHost: 127.0.0.1:{watched.port}\r\nContent-Length: 1000000\r\n"
        writer.write(f"{head}Content-Type: multipart/form-data; boundary=a\r\n\r\n--a\r\n".encode())
        await writer.drain()
        await asyncio.sleep(0.2)
        writer.close()
        for _ in range(600):  # a busy machine takes its time
            if _listing(*watched.watched) == before:
                break
            await asyncio.sleep(0.1)

    before = _listing(*watched.watched)
    asyncio.run(run())
    assert _listing(*watched.watched) == before
    assert "Traceback" not in watched.stop()


def test_a_page_outlasts_an_interruption_of_its_connection(watched):
    async def run():
        visitor = Visitor(watched.port)
        await visitor.load()
        await visitor.connect()
        await visitor.socket.disconnect()
        await asyncio.sleep(6)
        await visitor.connect()  # refused for a page that is no longer there
        await visitor.close()

    asyncio.run(asyncio.wait_for(run(), 40))


def test_reading_ends_when_the_visitor_leaves(watched):
    async def run():
        visitor = Visitor(watched.port)
        await visitor.load()
        await visitor.connect()
        await visitor.upload(b"a.csv", b"1,2\n" * 1_000_000)
        await visitor.until(lambda: _readers(watched.process.pid))
        os.kill(_readers(watched.process.pid)[0], signal.SIGSTOP)  # it would not end by itself
        await visitor.close()
        while _readers(watched.process.pid):
            await asyncio.sleep(0.1)
        while list(watched.folder.glob("electrovib-*")):
            await asyncio.sleep(0.1)

    asyncio.run(asyncio.wait_for(run(), 40))
    assert "Traceback" not in watched.stop()


@pytest.mark.parametrize("stop", [signal.SIGINT, signal.SIGTERM])
def test_stopping_the_server_ends_what_runs_and_leaves_nothing(watched, stop):
    async def run():
        visitor = Visitor(watched.port)
        await visitor.load(_encoded(f"preset={FIRST}_gap"))
        await visitor.connect()
        await visitor.upload(b"a.csv", b"1,2\n" * 4_500_000)  # about ten seconds
        await visitor.until(lambda: list(watched.folder.glob("electrovib-*")))
        watched.process.send_signal(stop)
        try:
            watched.process.wait(8)
        finally:
            await visitor.close()

    asyncio.run(run())
    assert list(watched.folder.iterdir()) == []


_COUNTING = """
import gc, sys, threading, time
from electrovib.apps.explorer.server import explore
from electrovib.apps.explorer.session import Session
def count():
    while True:
        time.sleep(1)
        gc.collect()
        print(sum(isinstance(each, Session) for each in gc.get_objects()), flush=True)
threading.Thread(target=count, daemon=True).start()
explore(browser=False, say=lambda words: print(words, flush=True))
"""


def test_a_page_that_was_closed_frees_its_memory(tmp_path):
    process = subprocess.Popen(
        [sys.executable, "-u", "-c", _COUNTING],
        stdout=subprocess.PIPE,
        text=True,
        env={name: value for name, value in os.environ.items() if not name.startswith("PYTEST")}
        | {"TMPDIR": str(tmp_path), "PYTHONPATH": os.pathsep.join(sys.path)},
    )
    try:
        lines = iter(process.stdout.readline, "")
        line = next(each for each in lines if "http://" in each)
        port = int(line.partition("127.0.0.1:")[2].partition("/")[0])
        next(lines)
        next(lines)

        async def run():
            visitors = [Visitor(port) for _ in range(5)]
            for each in visitors:
                while True:
                    try:
                        assert await each.load() == 200
                        break
                    except OSError:
                        await asyncio.sleep(0.2)
                await each.connect()
            await asyncio.sleep(3)
            await visitors[0].upload(b"a.csv", b"1,2\n1,2\n2,3\n")
            await asyncio.sleep(3)
            for each in visitors:
                await each.close()

        asyncio.run(run())
        counts = []
        while len(counts) < 40 and (not counts or counts[-1]):
            counts.append(int(next(lines)))
        assert max(counts) >= 5
        assert counts[-1] == 0, counts
    finally:
        process.terminate()
        process.wait(20)
        process.stdout.close()
