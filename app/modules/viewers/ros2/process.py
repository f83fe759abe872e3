"""The program's process in the graph of ROS 2: ``python -m app.modules.viewers.ros2.process SOCKET`` (an inherited file
descriptor).

It publishes CDR as it comes, says how many listen to each topic, and passes on calls of services. It ends by a Stop
message, or when the program does.
"""

from __future__ import annotations

import os
import select
import signal
import socket
import sys

from app.base.child_processes import end_with_parent


def main(arguments: list[str]) -> int:
    """Serve the program at the other end of the socket; 1 with a sentence for people on standard error."""
    parent = os.getppid()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches every process of a terminal; the program sends Stop
    end_with_parent()
    if parent != os.getppid():
        return 0
    from app.logs.ros.live.graph import MISSING

    try:
        import rclpy  # noqa: F401
    except ImportError:
        print(MISSING, file=sys.stderr)
        return 1
    from app.modules.viewers.ros2.node import GraphNode
    from app.modules.viewers.ros2.protocol import Answer, Frames, Open, Publish, ToProcess, encode

    link = socket.socket(fileno=int(arguments[0]))
    frames = Frames(ToProcess)  # type: ignore[arg-type]  # a union of types
    node: GraphNode | None = None
    while True:
        ready, _, _ = select.select([link], [], [], None if node is None else node.look())
        if not ready:
            continue
        data = link.recv(1 << 20)
        if not data:
            return 0
        for message in frames.feed(data):
            if isinstance(message, Open):
                node = GraphNode(message, link.sendall)
                link.sendall(encode(node.ready))
            elif node is None or not isinstance(message, Publish | Answer):
                return 0
            elif isinstance(message, Publish):
                node.publish(message.topic, message.data)
            else:
                node.answer(message.call, message.data)


if __name__ == "__main__":
    status = main(sys.argv[1:])
    sys.stderr.flush()
    os._exit(status)  # rclpy's and the middleware's exit handlers have nothing to add
