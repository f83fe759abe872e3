"""Ports: opened, lost, opened again, and each refusal in words."""

from __future__ import annotations

import socket
from pathlib import Path

import pytest

from app.robots.drivers.port import (
    CONNECT_S,
    MOST_UNSENT,
    RETRY_S,
    InputAddress,
    Port,
    SerialAddress,
    TcpAddress,
    address,
)
from app.robots.simulated.parts.plugs import Pipe, Server, Terminal


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("/dev/ttyACM0", SerialAddress("/dev/ttyACM0", 115200)),
        ("tcp://192.168.0.10:10940", TcpAddress("192.168.0.10", 10940)),
        ("tcp://[::1]:7", TcpAddress("::1", 7)),
    ],
)
def test_addresses(text: str, found: SerialAddress | TcpAddress) -> None:
    assert address(text, 115200) == found


@pytest.mark.parametrize(
    ("text", "baud", "said"),
    [
        ("COM3", 115200, "is no port: /dev/serial/by-id"),
        ("/dev/ttyS0", 123456, "baud 123456 is none that Linux knows; 50, 75"),
        ("tcp://laser:10940", 115200, "give the IP address; the look-up of a name would hold up the guard"),
        ("tcp://192.168.0.10", 115200, "give the IP address"),
        ("tcp://192.168.0.10:0", 115200, "a port is a number from 1 to 65535"),
    ],
)
def test_wrong_addresses_are_refused(text: str, baud: int, said: str) -> None:
    with pytest.raises(ValueError, match=said.replace("?", r"\?")):
        address(text, baud)


def test_a_serial_line_gives_its_bytes_as_they_are_and_comes_back(tmp_path: Path) -> None:
    plug, port = Terminal(tmp_path / "line"), Port(SerialAddress(str(tmp_path / "line"), 115200))
    assert not port.tend(0.0)
    assert port.problem == "there is no such device: is it plugged in?"
    plug.plug()
    assert not port.tend(RETRY_S / 2)  # not due yet
    assert port.tend(RETRY_S)
    every = bytes(range(256))
    plug.write(every)
    assert port.read() == every
    port.write(every)
    assert plug.read() == every
    assert port.read() == b""
    assert port.is_open
    plug.unplug()
    assert port.read() == b""
    assert (port.is_open, port.problem) == (False, "it was unplugged")
    plug.plug()
    assert port.tend(2 * RETRY_S)
    assert port.problem == ""
    port.close()
    plug.unplug()


def test_what_was_sent_last_still_arrives(tmp_path: Path) -> None:
    plug, port = Terminal(tmp_path / "line"), Port(SerialAddress(str(tmp_path / "line"), 9600))
    plug.plug()
    assert port.tend(0.0)
    port.write(b"stop")
    port.close()
    assert plug.read() == b"stop"
    plug.unplug()


def test_a_line_that_another_program_has_is_refused(tmp_path: Path) -> None:
    plug = Terminal(tmp_path / "line")
    plug.plug()
    first, second = (Port(SerialAddress(str(tmp_path / "line"), 115200)) for _ in range(2))
    assert first.tend(0.0)
    assert not second.tend(0.0)
    assert second.problem == "another program has it open"
    first.close()
    assert second.tend(RETRY_S)
    second.close()
    plug.unplug()


def test_a_device_that_takes_nothing_is_lost(tmp_path: Path) -> None:
    plug, port = Terminal(tmp_path / "line"), Port(SerialAddress(str(tmp_path / "line"), 115200))
    plug.plug()
    assert port.tend(0.0)
    for _ in range(2000):  # beyond what the line itself holds
        port.write(bytes(MOST_UNSENT // 4))
        if not port.is_open:
            break
    assert port.problem == "it takes nothing that is sent to it"
    plug.unplug()


def test_files_that_are_no_devices_are_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x")
    serial, events = Port(SerialAddress(str(tmp_path / "file"), 115200)), Port(InputAddress(str(tmp_path / "file")))
    assert not serial.tend(0.0)
    assert serial.problem == "it is no serial port"
    assert not events.tend(0.0)
    assert events.problem == "it is a plain file, and no device"


def test_a_tcp_connection_is_made_refused_closed_and_made_again() -> None:
    server = Server("127.0.0.1", 0)
    server.plug()
    port = Port(TcpAddress(*server.address))
    port.tend(0.0)
    assert port.tend(0.0)  # loopback connects at once
    server.read()
    server.write(b"hello")
    assert port.read() == b"hello"
    port.write(b"well")
    assert server.read() == b"well"
    server.unplug()
    port.read()
    assert port.problem == "it closed the connection"
    with socket.create_server(("127.0.0.1", 0)) as silent:
        nobody = silent.getsockname()
    refused = Port(TcpAddress(*nobody))
    refused.tend(0.0)
    refused.tend(0.0)
    assert refused.problem == "nothing listens there"
    server.close()


def test_a_connection_that_nobody_answers_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.robots.drivers.port.select.select", lambda *_: ([], [], []))
    with socket.create_server(("127.0.0.1", 0)) as silent:
        port = Port(TcpAddress(*silent.getsockname()))
        assert not port.tend(0.0)
        assert not port.tend(CONNECT_S - 0.1)
        assert port.waits_to_write
        assert not port.tend(CONNECT_S)
        assert port.problem == "it does not answer"


def test_a_file_of_events_comes_and_goes(tmp_path: Path) -> None:
    plug, port = Pipe(tmp_path / "events"), Port(InputAddress(str(tmp_path / "events")))
    plug.plug()
    assert port.tend(0.0)
    plug.write(b"event")
    assert port.read() == b"event"
    assert port.read() == b""
    assert port.is_open
    plug.unplug()
    port.read()
    assert port.problem == "it was unplugged"
    assert not (tmp_path / "events").exists()
