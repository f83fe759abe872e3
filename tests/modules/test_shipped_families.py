"""The families of the shipped strategy files: each strategy as it once stood in the file by itself."""

from __future__ import annotations

from pathlib import Path

import pytest

from app.attention.strategy_file import load_strategies
from app.program.config import load_configuration
from app.program.desire_classes import desire_classes

STRATEGIES = Path(__file__).parents[2] / "config" / "strategies"

Row = tuple[float, float, tuple[float, ...]]
#: By file and name: utility, cpu, and φ of its filters in the order of the file.
TABLES: dict[str, dict[str, Row]] = {
    "lab": {
        "find-qr-codes-1": (8, 10, (1, 1, 2)),
        "find-qr-codes-2": (4, 5, (2, 2, 2)),
        "find-qr-codes-4": (2, 2.5, (4, 4, 2)),
        "find-qr-codes-8": (1, 1.25, (8, 8, 2)),
        "locate-faces-1": (8, 60, (1, 1)),
        "locate-faces-2": (4, 30, (2, 2)),
        "locate-faces-4": (2, 15, (4, 4)),
        "locate-faces-8": (1, 7.5, (8, 8)),
        "locate-near-faces-1": (4, 22, (1, 1)),
        "locate-near-faces-2": (2, 11, (2, 2)),
        "locate-near-faces-4": (1, 5.5, (4, 4)),
        "telepresence-1": (8, 5.4, (1, 1, 2)),
        "telepresence-2": (4, 2.7, (2, 2, 4)),
        "telepresence-4": (2, 1.35, (4, 4, 8)),
        "telepresence-8": (1, 0.675, (8, 8, 16)),
    },
    "webcam": {
        "find-qr-codes-1": (8, 6, (1,)),
        "find-qr-codes-2": (4, 3, (2,)),
        "find-qr-codes-4": (2, 1.5, (4,)),
        "find-qr-codes-8": (1, 0.75, (8,)),
        "locate-faces-1": (8, 28, (1,)),
        "locate-faces-2": (4, 14, (2,)),
        "locate-faces-4": (2, 7, (4,)),
        "locate-faces-8": (1, 3.5, (8,)),
        "locate-near-faces-1": (4, 9, (1,)),
        "locate-near-faces-2": (2, 4.5, (2,)),
        "locate-near-faces-4": (1, 2.25, (4,)),
        "telepresence-1": (8, 2, (1,)),
        "telepresence-2": (4, 1, (2,)),
        "telepresence-4": (2, 0.5, (4,)),
    },
}
CLASSES = {"FindQRCodes", "LocateFaces", "Telepresence"}


@pytest.mark.parametrize("file", TABLES)
def test_each_strategy_is_what_it_was_by_itself(file: str) -> None:
    table = load_strategies(
        [STRATEGIES / f"{file}.yaml"], classes=desire_classes(load_configuration(STRATEGIES.parent / "lab.yaml"))
    )
    found = {
        s.name: (s.utility, s.costs["cpu"], tuple(s.filters.values())) for s in table.strategies if s.cls in CLASSES
    }
    assert found == TABLES[file]
    for strategy in table.strategies:
        fine = {"locate-faces": True, "locate-near-faces": False}.get(strategy.name.rpartition("-")[0])
        if fine is not None:
            assert strategy.parameters["FaceDetector"] == {"fine": fine}
