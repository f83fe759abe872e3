"""Episodes for tests of the file; as a program, it remembers one after the other, and says so once each is kept."""

from __future__ import annotations

import sys
from itertools import count
from pathlib import Path

from app.memory.memory import Limits, Memory
from app.memory.store import MemoryStore
from app.messages import Desire, Source

LIMITS = Limits(50, 500, 1e9)
WORDS = Desire("d-1", "ListenForWords", 5, 1, False, {"words": "who, what", "language": "en"}, Source("rest", ""), 0.0)


def experience(memory: Memory, number: int) -> None:
    """Episode ``number``: every second is a repetition of the one before."""
    for step in range(4):
        memory.perceive({"place": {f"room {number % 40 // 2}": 1.0}, "object": {f"thing {step}": 1.0}})
    memory.use({"ListenForWords": WORDS})
    memory.accomplish()
    memory.close(float(number))


def main(folder: Path, first: int) -> None:
    """Remember in ``folder`` for ever, from episode ``first`` on."""
    store = MemoryStore(folder)
    memory = Memory(store.read(), LIMITS)
    for number in count(first):
        experience(memory, number)
        store.keep(memory.take_update())
        print(number, flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]))
