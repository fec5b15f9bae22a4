"""A simulated bench as a process of its own: its instruments answer on the loopback interface, in real time.

`test_killed` runs this file.
"""

from __future__ import annotations

import argparse
import socket
import sys
import threading
from typing import TYPE_CHECKING, BinaryIO, Final

from electrovib.bench.clock import SystemClock
from electrovib.bench.settings import read_settings
from electrovib.bench.twin.commands import TwinInstrument
from electrovib.bench.twin.simulated import SimulatedBench
from electrovib.scenario import read_scenario

if TYPE_CHECKING:
    from collections.abc import Sequence

HOST: Final = "127.0.0.1"
_LONGEST: Final = 1 << 20


class TwinState(TwinInstrument):
    """Answers questions about the plate, which no real instrument would, and switches the high voltage as an operator."""

    def __init__(self, bench: SimulatedBench) -> None:
        super().__init__("ELECTROVIB,STATE,0,0")
        self._queries |= {
            "PLATE": lambda _: f"{bench.plate_voltage():.6E}",
            "ENABLED": lambda _: str(int(bench.plant.is_on)),
        }
        self._commands |= {"OPERATE": bench.operate}


def serve(instrument: TwinInstrument, lock: threading.Lock) -> int:
    """Answer on a port of the loopback interface, in threads that end with the process, and return its number.

    The lock is held during each message: the instruments share one plate.
    """
    server = socket.create_server((HOST, 0))
    threading.Thread(target=_accept, args=(server, instrument, lock), daemon=True).start()
    port: int = server.getsockname()[1]
    return port


def _accept(server: socket.socket, instrument: TwinInstrument, lock: threading.Lock) -> None:
    while True:
        connection, _ = server.accept()
        with connection, connection.makefile("rb") as file:
            while message := _message(file):
                with lock:
                    instrument.send(message)
                    try:
                        reply = instrument.receive()
                    except TimeoutError:
                        continue
                try:
                    connection.sendall(reply + b"\n")
                except OSError:
                    break


def _message(file: BinaryIO) -> bytes:
    """Read one message: a line, or a command with a block; empty at the end of the connection."""
    head = b""
    while len(head) < _LONGEST:
        try:
            sign = file.read(1)
        except OSError:
            return b""
        if not sign:
            return b""
        if sign == b"\n":
            return head or b" "
        head += sign
        if sign == b"#":
            digits = file.read(1) or b"0"
            size = file.read(int(digits)) or b"0"
            return head + digits + size + (file.read(int(size) + 1) or b"")[: int(size)]
    return b""


def main(arguments: Sequence[str] | None = None) -> None:
    """Serve a bench until standard input ends, or for at most a given time; print the port of each instrument."""
    parser = argparse.ArgumentParser(description="A simulated bench on the loopback interface.")
    parser.add_argument("bench")
    parser.add_argument("scenario")
    parser.add_argument("--seconds", type=float, default=60.0)
    given = parser.parse_args(arguments)
    bench = SimulatedBench(
        read_settings(given.bench), read_scenario(given.scenario), seed=0, clock=SystemClock()
    )
    lock = threading.Lock()
    roles: dict[str, TwinInstrument] = {**bench.connections, "state": TwinState(bench)}
    for role, instrument in roles.items():
        print(f"{role}: TCPIP::{HOST}::{serve(instrument, lock)}::SOCKET", flush=True)
    print("ready", flush=True)
    waiting = threading.Thread(target=sys.stdin.read, daemon=True)
    waiting.start()
    waiting.join(given.seconds)


if __name__ == "__main__":
    main()
