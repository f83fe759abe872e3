"""A viewer's client in the place of viser's."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import Any

import numpy as np


class Node:
    """A node of the scene, with what it was given."""

    points: Any
    vertices: Any
    opacity: Any
    position: Any
    visible: Any

    def __init__(self, **given: Any) -> None:
        self.__dict__.update(given)


class Camera:
    """A browser's camera that is left where it was first."""

    def __init__(self) -> None:
        self.position: Any = np.array([-3.0, 0.0, 2.0])
        self.look_at: Any = np.zeros(3)
        self.fov = 0.9
        self.aspect = 1.5

    def on_update(self, _: Any) -> None:
        """It does not move by itself."""


class Client:
    """Takes what a scene sends to its viewer; ``nodes`` by name."""

    def __init__(self) -> None:
        self.nodes: dict[str, Node] = {}
        self.scene = self
        self.camera = Camera()

    @contextlib.contextmanager
    def atomic(self) -> Iterator[None]:
        yield

    def __getattr__(self, kind: str) -> Any:
        if not kind.startswith("add_"):
            raise AttributeError(kind)

        def add(name: str, *_: Any, **given: Any) -> Node:
            self.nodes[name] = Node(**given)
            return self.nodes[name]

        return add
