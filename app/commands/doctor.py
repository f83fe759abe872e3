"""``hbba doctor``: checks whether this computer is ready for ``hbba run``; names what is missing, and the remedy."""

from __future__ import annotations

import argparse
import importlib.util
import os
import shutil
import socket
import subprocess
import sys
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from app.base import child_processes, paths
from app.commands import doctor_devices
from app.commands.output import add_json, print_json

CHROMIUM_NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
PYTHON_MINIMUM = (3, 11)
MEMORY_MINIMUM_MB = 1500
#: Four images of each camera in flight (640x480 colour and depth, 1024x768 colour), and room to spare.
SHARED_MEMORY_MINIMUM_MB = 24
#: Against the loss of a file that is the program's own.
REINSTALL = "install the project again: this file is its own"


@dataclass(frozen=True, slots=True)
class Finding:
    """One check: its finding and, if it is not ``ok``, the remedy.

    ``required``: ``hbba run`` does not work without.
    """

    name: str
    ok: bool
    required: bool
    found: str
    remedy: str = ""


def add_parser(subparsers: Any) -> None:
    parser = subparsers.add_parser(
        "doctor",
        help="check this computer and say what is missing",
        description="Check this computer and say what is missing. Exit code 1 if `hbba run` would not work here.",
    )
    parser.add_argument("--port", type=int, default=8080, metavar="N", help="the console's port (default 8080)")
    add_json(parser)


def run(args: argparse.Namespace) -> int:
    findings = [look() for look in checks(args.port)]
    if args.json:
        print_json([asdict(finding) for finding in findings])
    else:
        print(table(findings))
    return int(any(finding.required and not finding.ok for finding in findings))


def checks(port: int) -> Iterable[Callable[[], Finding]]:
    """Everything to look at, in the order it is shown."""
    return (
        python,
        configuration,
        packages,
        graphics,
        lambda: port_free("127.0.0.1", port),
        cores,
        memory,
        shared_memory,
        page,
        kernels,
        face_model,
        voice_network,
        cameras,
        audio,
        serial_ports,
        gamepads,
        speech,
        chromium,
    )


def table(findings: Iterable[Finding]) -> str:
    """The findings for people, with remedies."""
    findings = list(findings)
    lines = []
    for finding in findings:
        mark = "✓" if finding.ok else "✗" if finding.required else "–"
        lines.append(f"  {mark} {finding.name:<14} {finding.found}")
        if not finding.ok and finding.remedy:
            lines.append(f"    {'':<14} → {finding.remedy}")
    missing = [finding.name for finding in findings if finding.required and not finding.ok]
    lines.append("")
    lines.append(f"`hbba run` will not work yet: {', '.join(missing)}." if missing else "Ready: start with `hbba run`.")
    return "\n".join(lines)


# --- What is looked at -------------------------------------------------------------------------------------------


def python() -> Finding:
    """The interpreter's version."""
    minimum = ".".join(map(str, PYTHON_MINIMUM))
    return Finding(
        "Python", sys.version_info >= PYTHON_MINIMUM, True, sys.version.split()[0], f"install Python {minimum} or newer"
    )


def configuration() -> Finding:
    """The configuration that ``hbba run`` uses when nothing else is said."""
    from app.base.errors import ConfigError
    from app.commands.check import check_file

    path = paths.config_dir() / "lab.yaml"
    try:
        kind, _ = check_file(path)
    except ConfigError as failure:
        return Finding("configuration", False, True, str(failure), "correct it; `hbba check FILE` looks again")
    return Finding("configuration", True, True, f"{path} ({kind})")


def packages() -> Finding:
    """The entry points of packages of others, and whether all of them can be imported."""
    from app.base.errors import ConfigError
    from app.base.extensions import DISTRIBUTION, GROUPS, announced_configurations, extensions

    found: list[str] = []
    try:
        announced_configurations()
        for group, kind in GROUPS.items():
            names: list[str] = []
            for name, extension in extensions(group).items():
                if group != "hbba.configurations":
                    extension.load()
                if extension.distribution != DISTRIBUTION:
                    names.append(f"{name} ({extension.distribution})")
            if names:
                found.append(f"{kind}: {', '.join(sorted(names))}")
    except ConfigError as failure:
        return Finding("packages", False, False, str(failure), "correct or uninstall the package")
    return Finding("packages", True, False, "; ".join(found) or "none beside the program's own")


def graphics() -> Finding:
    """Rendering without a screen, for the simulated camera; tried in another process, as a broken driver may crash."""
    from app.robots.simulated.gl import check_gl, gl_environment

    if problem := check_gl():
        found, _, remedy = problem.partition(": ")
        return Finding("EGL", False, True, found, remedy)
    remedy = "install or update Mesa's drivers: as root, apt-get install libegl1 libgl1-mesa-dri"
    command = child_processes.python("-c", "import mujoco; mujoco.GLContext(64, 64).make_current()")
    environment = {**os.environ, **gl_environment()}
    try:
        done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=60, check=False)
    except subprocess.TimeoutExpired:
        return Finding("EGL", False, True, "opening a context took over 60 s", remedy)
    if done.returncode:
        last = (done.stderr.strip().splitlines() or [f"exit code {done.returncode}"])[-1]
        return Finding("EGL", False, True, f"no context: {last}", remedy)
    return Finding("EGL", True, True, "draws without a screen")


def port_free(host: str, port: int) -> Finding:
    """Whether the console could listen."""
    remedy = f"end the program that listens there, or choose another: hbba run --port {port + 1}"
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
        except OSError as failure:
            return Finding("port", False, True, f"{host}:{port}: {failure.strerror}", remedy)
    return Finding("port", True, True, f"{host}:{port} is free")


def cores() -> Finding:
    """Processor cores that this process may use."""
    usable = available_cores(len(os.sched_getaffinity(0)), Path("/sys/fs/cgroup/cpu.max"))
    return Finding(
        "cores", usable >= 2, False, f"{usable:g}", "give it 2 cores; with fewer, the simulated world slows down evenly"
    )


def available_cores(affinity: int, quota_file: Path) -> float:
    """The cores of ``affinity`` (how many), or fewer where a container's quota (cgroup v2 ``cpu.max``) says so."""
    try:
        quota, period = quota_file.read_text(encoding="ascii").split()
        return min(float(affinity), round(int(quota) / int(period), 1))
    except (OSError, ValueError):
        return float(affinity)


def memory() -> Finding:
    """Memory that is free for us."""
    import psutil

    free_mb = psutil.virtual_memory().available / 2**20
    return Finding(
        "memory",
        free_mb >= MEMORY_MINIMUM_MB,
        False,
        f"{free_mb / 1024:.1f} GiB free",
        "close other programs: 1.5 GiB are needed",
    )


def shared_memory() -> Finding:
    """Room for images between the body's process and this one."""
    folder = Path("/dev/shm")
    if not folder.is_dir():
        return Finding("shared memory", False, True, "there is no /dev/shm", "mount a tmpfs there")
    free_mb = shutil.disk_usage(folder).free / 2**20
    return Finding(
        "shared memory",
        free_mb >= SHARED_MEMORY_MINIMUM_MB,
        True,
        f"{free_mb:.0f} MiB free",
        f"give /dev/shm {SHARED_MEMORY_MINIMUM_MB} MiB (docker run --shm-size=256m)",
    )


def page() -> Finding:
    """The built operator page."""
    built = (paths.static_dir() / "index.html").is_file()
    remedy = "`make run` builds it; until then the console serves a plain page"
    return Finding("operator page", built, False, "built" if built else "not built", remedy)


def kernels() -> Finding:
    """Check the numerical kernels compiled for this computer."""
    from app.base import compiled

    ready = compiled.is_ready()
    remedy = "`hbba run` compiles them before the robot starts, once: a minute or two"
    return Finding("kernels", ready, False, "compiled" if ready else "not compiled yet", remedy)


def face_model() -> Finding:
    """YuNet's network, and that this computer's OpenCV reads it."""
    import cv2

    from app.modules.perception.faces.yunet import MODEL, YuNetDetector

    try:
        YuNetDetector()
    except cv2.error as failure:
        return Finding("face model", False, False, f"{MODEL} cannot be read: {failure.err}", REINSTALL)
    return Finding("face model", True, False, f"YuNet ({MODEL.name})")


def voice_network() -> Finding:
    """Check the network that distinguishes voices from other sounds, run by ONNX Runtime."""
    from app.modules.perception.voices.voice_activity import MODEL

    remedy = "pip install 'onnxruntime>=1.20,<1.33'; without it the robot runs, and locates no voices"
    try:
        import onnxruntime
    except ImportError as failure:
        return Finding("voice network", False, False, f"no ONNX Runtime: {failure}", remedy)
    if not MODEL.is_file():
        return Finding("voice network", False, False, f"no {MODEL}", REINSTALL)
    return Finding("voice network", True, False, f"Silero VAD, ONNX Runtime {onnxruntime.__version__}")


def cameras() -> Finding:
    """Cameras, for a body of devices."""
    found = doctor_devices.cameras()
    remedy = "only for --robot webcam; there, --camera FILE takes a video or pictures instead"
    return Finding("cameras", bool(found), False, ", ".join(found) or "none", remedy)


def audio() -> Finding:
    """Sound cards, for a body of devices, and whether they can be reached."""
    from app.robots.devices.image_inputs import InputUnavailable
    from app.robots.devices.sound import sounddevice

    only = "only for --robot webcam; there, --microphones FILE takes a sound file instead"
    try:
        devices = [device for device in sounddevice().query_devices() if device["max_input_channels"]]
    except InputUnavailable as failure:
        return Finding("microphones", False, False, str(failure).partition(";")[0], only)
    inputs = [f"{device['name']} ({device['max_input_channels']} ch)" for device in devices]
    return Finding("microphones", bool(inputs), False, ", ".join(inputs) or "none", only)


def serial_ports() -> Finding:
    """Serial ports, for a robot of parts (docs/your-robot.md)."""
    found = doctor_devices.serial_ports()
    remedy = "only for a base or a laser on a serial line (docs/your-robot.md)"
    return Finding("serial ports", bool(found), False, ", ".join(found) or "none", remedy)


def gamepads() -> Finding:
    """Gamepads that are plugged in here, for a robot of parts."""
    found = doctor_devices.gamepads()
    remedy = "only to drive a robot of parts by hand beside it; the page takes a gamepad of the browser's"
    return Finding("gamepads", bool(found), False, ", ".join(found) or "none", remedy)


def speech() -> Finding:
    """Check the speech synthesis for the robot's voice, and for people of the simulated world."""
    found = importlib.util.find_spec("espeakng_loader") is not None
    remedy = "pip install 'hbba[speech]'; without it the robot speaks by subtitles alone"
    return Finding("spoken text", found, False, "espeak-ng" if found else "no espeak-ng", remedy)


def chromium() -> Finding:
    """The browser that the tests drive."""
    found = find_chromium()
    return Finding(
        "Chromium",
        found is not None,
        False,
        found or "none",
        "only needed for tests; as root: apt-get install chromium",
    )


def find_chromium() -> str | None:
    """The browser for tests: ``HBBA_CHROMIUM`` if set, else the first of CHROMIUM_NAMES on the path."""
    return os.environ.get("HBBA_CHROMIUM") or next(filter(None, map(shutil.which, CHROMIUM_NAMES)), None)
