"""A running server, attacked through its own protocol: malformed links and files, leaving, stopping."""

import asyncio
import io
import os
import signal
import zipfile
from pathlib import Path
from urllib.parse import quote

import numpy as np
import pytest

pytest.importorskip("nicegui")  # its client library is that of the visitor

from tests.browser.conftest import started
from tests.browser.visitor import Visitor
from tests.unit.apps.explorer.test_state import MALFORMED

pytestmark = pytest.mark.slow


def _zip(size):
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("[Content_Types].xml", "<a/>")
        archive.writestr("xl/worksheets/sheet1.xml", bytes(size))
    return packed.getvalue()


def _objects():
    np.save(file := io.BytesIO(), np.array([{1: 2}], dtype=object))
    return file.getvalue()


RANDOM = np.random.default_rng(1).integers(0, 256, 3000, dtype=np.uint8).tobytes()
HUGE = b"{'descr': '<f8', 'fortran_order': False, 'shape': (100000000000,), }"
TABLES = [b"", b"\0", b"x", b"1,2", b"1," * 9_000_000, b"\n" * 19_000_000, bytes(19_900_000), b'"' * 100_000]
TABLES += [b"t," + b"<b>" * 1000 + b"\n1,2\n2,3\n", b"\xff\xfe" + b"\xd8" * 99, RANDOM]
FILES = [
    *((b"a.csv", content) for content in TABLES),
    *((b"a.xlsx", content) for content in (_zip(1000), b"PK\x03\x04" + RANDOM)),
    *((b"a.npy", b"\x93NUMPY" + content) for content in (b"\x01\0v\0" + HUGE.ljust(117) + b"\n", RANDOM)),
    (b"a.npy", _objects()),
    *((b"a.nc", b"\x89HDF\r\n\x1a\n" + content) for content in (bytes(100), RANDOM)),
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
    *((name, b"x") for name in (b"../../../a.csv", b"..\\..\\a.csv", b"a\0b.csv", b"x" * 1500 + b".csv")),
    *((name, b"x") for name in (b"<img src=x onerror=alert(1)>.csv", b"\xff\xfe.csv")),
    *((name, RANDOM) for name in (b"/etc/passwd", b"a.exe")),
    (b"a", b"#!/bin/sh\necho 1"),
    (b"a.py", b"import os"),
    (b"a.pkl", b"\x80\x04\x95cos\nsystem\n(S'id'\ntR."),
]
NINES = b"a = " + b"9" * 100_000
SCENARIOS = [b"", b"\xff", b"#" * 600_000, b"a = " + b"[" * 100_000, b"a." * 200_000 + b"a = 1", NINES]
SCENARIOS += [b"a = 1\na = 2", b"schema = 1979-05-27", b"schema = 99999", b'"__class__" = 1']
DRIVES = """
{ model = "Sampled", file = "/etc/passwd" }
{ model = "Sampled", file = "~/.bashrc" }
{ model = "Sampled", file = "$HOME/a.csv" }
{ model = "__import__", command = "id" }
{ model = "Sine", amplitude = nan, frequency = inf }
{ model = "Sine", amplitude = 1e999, frequency = 1 }
{ model = "Sine", amplitude = "__import__('os').system('id')", frequency = 1 }
"/etc/passwd"
"""
SCENARIOS += [f"schema = 1\ndrive = {text}".encode() for text in DRIVES.strip().splitlines()]
FILES += [(b"a.toml", content) for content in SCENARIOS[:-1]] + [(b"a.TOML", SCENARIOS[-1])]
LINKS = r"""
set=drive.high=1e999
set=drive.high=NaN V
set=drive.high=三 V
set=drive.high=<script>alert(1)</script>
set=drive.high={{7*7}}
set=drive.high.__class__.__init__=1
set=__init__.__globals__=1
set=stack.insulator.material=$HOME/a.toml
set=stack.insulator.material=%00
set=stack.insulator.material={ model = "Tabulated", 'file' = "a.csv" }
set=friction={ model = 5 }
set=time=1
set=time.samples=20001
set=time.duration=1e12 s
preset=yours
preset=vezzoli_2014/fig6%00
preset=<img src=x onerror=alert(1)>
preset=$HOME
preset=file:///etc/passwd
preset=http://127.0.0.1/
""".strip().splitlines()
TOO_LONG = """
set=drive={ model = "Square", high = 100, low = -100, frequency = 1e6 }&set=time.duration=1e4 s
set=drive={ model = "Square", high = 1, low = -1, frequency = 1e8 }&set=time.duration=1e5 s
set=drive={ model = "PulseTrain", high = 9, width = 1e-7, frequency = 1e6 }&set=time.duration=9e4 s
set=drive={ model = "Square", high = 100, low = -100, frequency = 1e6 }&set=time.duration=9 s
""".strip().splitlines()


def _encoded(link):
    return "?" + quote(link, safe="=&%")


def _listing(*folders):
    found = [path for folder in folders for path in folder.rglob("*") if path.is_file() or path.is_symlink()]
    return {str(path): (path.lstat().st_size, path.lstat().st_mtime_ns) for path in found}


@pytest.fixture
def watched(tmp_path_factory):
    """A server whose home, working folder and temporary folder are empty ones, and stay empty."""
    base = tmp_path_factory.mktemp("watched")
    home, place = base / "home", base / "place"
    home.mkdir()
    place.mkdir()
    server = started(tmp_path_factory, "temporary", place=place, HOME=str(home))
    server.watched = (home, place, server.folder)
    yield server
    server.process.kill()
    server.process.wait()
    server.process.stdout.close()


async def _opened(port, link=""):
    visitor = Visitor(port)
    assert await visitor.load(_encoded(link)) == 200
    return visitor


async def _connected(port, link=""):
    visitor = await _opened(port, link)
    await visitor.connect()
    return visitor


async def _sentences(port):
    """Send every link and every file, and yield what is answered."""
    for link in [*MALFORMED, *LINKS]:
        visitor = await _opened(port, link)
        yield link, visitor.alert
        await visitor.connect()
        await visitor.close()
        await asyncio.sleep(0.05)
    for link in TOO_LONG:
        visitor = await _opened(port, link)
        assert visitor.alert == ""
        await visitor.connect()
        await visitor.until(lambda visitor=visitor: visitor.alert)
        yield link, visitor.alert
        await visitor.close()
    visitor = await _connected(port)
    for name, content in [*FILES, (b"a.xlsx", _zip(300_000_000))]:
        for _ in range(2):  # a busy machine may have answered too late
            if not visitor.socket.connected:
                await visitor.close()
                visitor = await _connected(port)
            try:
                sentence = await visitor.sentence_on(name, content)
                break
            except TimeoutError:
                assert not visitor.socket.connected, (name, content[:40])
        yield name, sentence
    assert await visitor.upload(b"a.csv", bytes(21_000_000)) == 413
    await visitor.close()


def test_more_than_a_hundred_malformed_links_and_files_give_a_sentence_each(watched):
    async def run():
        found = [each async for each in _sentences(watched.port)]
        after = await _opened(watched.port, "set=drive.high=300 V")
        assert after.alert == ""
        await after.close()
        return found

    before = _listing(*watched.watched)
    sentences = asyncio.run(run())
    assert len(sentences) >= 100
    for what, sentence in sentences:
        assert 15 < len(sentence) < 6000, (what, sentence)
        for words in ("Traceback", "mistake of electrovib", str(watched.folder)):
            assert words not in sentence, (what, sentence)
    assert _listing(*watched.watched) == before
    assert watched.stop() == ""  # nothing in its log


def _readers(server):
    """Processes of the server that read a file."""
    found = []
    for each in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            is_reader = b"electrovib.data.guarded" in each.read_bytes()
            parent = int((each.parent / "stat").read_text().rsplit(")", 1)[1].split()[1])
        except (OSError, IndexError):  # it has ended meanwhile
            continue
        if is_reader and parent == server:
            found.append(int(each.parent.name))
    return found


def test_a_visitor_who_leaves_in_the_middle_of_an_upload_leaves_nothing(watched):
    """Nor what reads the file, although it would not end by itself."""
    before, own = _listing(*watched.watched), watched.process.pid

    async def run():
        for _ in range(3):
            visitor = await _connected(watched.port)
            sending = asyncio.create_task(visitor.upload(b"a.csv", b"1,2\n" * 4_000_000))
            await asyncio.sleep(0.1)
            sending.cancel()
            await visitor.close()
        visitor = await _connected(watched.port)
        await visitor.upload(b"a.csv", b"1,2\n" * 1_000_000)
        await visitor.until(lambda: _readers(own))
        os.kill(_readers(own)[0], signal.SIGSTOP)
        await visitor.close()
        address = f"{visitor.address}/_nicegui/client/{visitor.client}/upload/1"
        _, writer = await asyncio.open_connection("127.0.0.1", watched.port)
        head = f"POST {address} HTTP/1.1\r\nHost: 127.0.0.1:{watched.port}\r\nContent-Length: 1000000\r\n"
        writer.write(f"{head}Content-Type: multipart/form-data; boundary=a\r\n\r\n--a\r\n".encode())
        await writer.drain()
        await asyncio.sleep(0.2)
        writer.close()
        while _readers(own) or _listing(*watched.watched) != before:  # a busy machine takes its time
            await asyncio.sleep(0.1)

    asyncio.run(asyncio.wait_for(run(), 90))
    assert "Traceback" not in watched.stop()


def test_a_page_outlasts_an_interruption_of_its_connection(watched):
    async def run():
        visitor = await _connected(watched.port)
        await visitor.socket.disconnect()
        await asyncio.sleep(6)
        await visitor.connect()  # refused for a page that is no longer there
        await visitor.close()

    asyncio.run(asyncio.wait_for(run(), 40))


@pytest.mark.parametrize("stop", [signal.SIGINT, signal.SIGTERM])
def test_stopping_the_server_ends_what_runs_and_leaves_nothing(watched, stop):
    async def run():
        visitor = await _connected(watched.port, "preset=vezzoli_2014/fig6_gap")
        await visitor.upload(b"a.csv", b"1,2\n" * 4_500_000)  # about ten seconds
        await visitor.until(lambda: list(watched.folder.glob("electrovib-*")))
        watched.process.send_signal(stop)
        try:
            watched.process.wait(8)
        finally:
            await visitor.close()

    asyncio.run(run())
    assert list(watched.folder.iterdir()) == []


COUNTING = """
import gc, threading, time
from electrovib.apps.explorer.session import Session
def count():
    while True:
        time.sleep(1)
        gc.collect()
        print(sum(isinstance(each, Session) for each in gc.get_objects()), flush=True)
threading.Thread(target=count, daemon=True).start()
"""


def test_a_page_that_was_closed_frees_its_memory(tmp_path_factory):
    server = started(tmp_path_factory, "counting", code=COUNTING)

    async def run():
        visitors = [await _connected(server.port) for _ in range(5)]
        await asyncio.sleep(3)
        await visitors[0].upload(b"a.csv", b"1,2\n1,2\n2,3\n")
        await asyncio.sleep(3)
        for each in visitors:
            await each.close()

    try:
        asyncio.run(run())
        counts, unopened = [], 1  # `started` has loaded a page whose websocket it never opened
        while len(counts) < 40 and (max(counts, default=0) < 5 + unopened or counts[-1] > unopened):
            counts.append(int(server.process.stdout.readline()))
        assert max(counts) == 5 + unopened
        assert counts[-1] <= unopened, counts
    finally:
        server.stop()
