"""Main loop of the microphones' process: read the setup, then render the scenes as they arrive."""

from __future__ import annotations

import gc
import pickle
import select
import socket

from app.robots.simulated.acoustics.ipc import AcousticsSetup, LoudspeakerFrame, SoundScene
from app.robots.simulated.acoustics.microphone_simulator import MicrophoneSimulator
from app.robots.simulated.link_protocol import Socket


def serve(link_descriptor: int, setup_descriptor: int) -> None:
    """Render until the other end closes. The setup is a pickle in the memory of ``setup_descriptor``."""
    with open(setup_descriptor, "rb") as memory:
        memory.seek(0)
        setup = pickle.load(memory)
    assert isinstance(setup, AcousticsSetup)
    sock = Socket(socket.socket(fileno=link_descriptor))
    ear = MicrophoneSimulator(setup)
    gc.collect()
    gc.freeze()
    while not sock.closed:
        select.select([sock.fileno()], [sock.fileno()] if sock.has_unsent else [], [])
        scenes = []
        for order in sock.receive():
            if isinstance(order, SoundScene):
                scenes.append(order)
            elif isinstance(order, LoudspeakerFrame):
                ear.play(order)
        for heard in ear.listen(scenes):
            sock.send(heard)
        sock.flush()
