"""The kinds of the lab's motivations."""

from __future__ import annotations

from app.base import paths
from app.modules.motivations.motivation import Motivation
from app.program.config import load_configuration
from app.runtime.graph import load_class


def test_every_motivation_of_the_lab_declares_its_kind() -> None:
    modules = load_configuration(paths.config_dir() / "lab.yaml").program.modules
    kinds = {}
    for name, spec in modules.items():
        if spec.class_path.startswith("app.modules.motivations."):
            motivation = load_class(spec.class_path)
            assert motivation is not None
            assert issubclass(motivation, Motivation), f"{name} says of no desire why it is there"
            kinds[name] = motivation.motive
    assert kinds == {
        "Recharge": "instinctive",
        "RestAfterGesture": "instinctive",
        "Curiosity": "instinctive",
        "ScenarioCoordinator": "rational",
        "TourGuide": "rational",
        "EpisodicMemory": "rational",
        "ProgressSupervisor": "emotional",
        "Emotions": "emotional",
    }
