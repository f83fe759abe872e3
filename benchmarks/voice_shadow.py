"""The rooms of ``voice_rooms`` heard by microphones on a robot's torso, by the simulated body's own acoustics."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose3
from app.robots.simulated.acoustics.diffraction import BaffledMicrophones
from app.robots.simulated.acoustics.offline_rendering import OfflineSource, render_scene
from app.robots.simulated.acoustics.room import Shoebox
from benchmarks.voice_rooms import BLOCK_S, RATE, Recipe, Scene, Talker, draw, talk


def shadowed(recipe: Recipe, positions: NDArray[np.float64], speech: Path, torso: bool) -> Scene:
    """Play ``recipe``, of people who stand and look at the robot, to microphones on the torso (a rigid sphere through
    them), or to the same without it."""
    plan = draw(recipe)
    length = int(recipe.duration_s * RATE)
    sources = [
        OfflineSource(talk(speech, file, length).astype(np.float32), path[0], looks="listener")
        for file, path in zip(plan.files, plan.paths, strict=True)
    ]
    room = Shoebox((0.0, 0.0, 0.0), tuple(plan.size), (recipe.rt60_s, recipe.rt60_s))
    heard, truths = render_scene(
        sources,
        Pose3.from_translation_rpy(tuple(plan.middle)),
        room,
        recipe.duration_s,
        BaffledMicrophones(positions, RATE, shadow=torso),
        seed=recipe.seed,
    )
    samples = heard.T.astype(np.float64)
    noise = np.sqrt((samples**2).mean()) * 10 ** (-recipe.snr_db / 20)
    samples += plan.rng.normal(0, noise, samples.shape)
    samples *= 0.3 / np.abs(samples).max()
    talkers = tuple(
        Talker(file, _times(path), truth.directions[:1].astype(np.float64), float(truth.ranges_m[0]), truth.active)
        for file, path, truth in zip(plan.files, plan.paths, truths, strict=True)
    )
    single = samples.astype(np.float32)
    return Scene(f"torso {torso}, seed {recipe.seed}", RATE, positions, single, single[:, :0].T, talkers)


def _times(path: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.arange(len(path), dtype=np.float64) * BLOCK_S
