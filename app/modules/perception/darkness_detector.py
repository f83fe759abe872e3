"""DarknessDetector: whether it is dark before the camera.

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ DarknessDetector    in   images    Image, 15 Hz / φ                                      │
    │                     out  darkness  Darkness, with each image taken                       │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

The mean luma of the colour image, Y' = 0.2126 R' + 0.7152 G' + 0.0722 B' (ITU-R BT.709), of every ``step``-th pixel of
every ``step``-th row. It is dark below ``dark_below``, light above ``light_above``, and between the two as before.
"""

from __future__ import annotations

from pydantic import Field, model_validator

from app.attention.desires import DesireClass
from app.messages import Darkness, Image
from app.modules.perception.luma import mean_luma
from app.modules.perception.opencv import use_calling_thread
from app.runtime.module import Module, ModuleContext, Settings


class DarknessDetectorSettings(Settings):
    dark_below: float = Field(0.06, gt=0, lt=1, description="mean luma below which it is dark, 0 to 1")
    light_above: float = Field(0.10, gt=0, lt=1, description="mean luma above which it is light again")
    step: int = Field(8, ge=1, le=64, description="one pixel in so many is looked at, across and down")

    @model_validator(mode="after")
    def _in_order(self) -> DarknessDetectorSettings:
        if self.dark_below > self.light_above:
            raise ValueError(f"light_above should be at least dark_below, {self.dark_below:g}")
        return self


DETECT_DARKNESS = DesireClass(
    name="DetectDarkness",
    title="Detect darkness",
    description="Say whether it is dark before the camera.",
)


class DarknessDetector(Module):
    title = "Darkness detector"
    desire_classes = (DETECT_DARKNESS,)
    runs_elsewhere = True
    Settings = DarknessDetectorSettings
    settings: DarknessDetectorSettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self._dark = False
        self.images = self.input("images", Image)
        self.darkness = self.output("darkness", Darkness)
        self.on(self.images, self._look)

    async def start(self) -> None:
        """Keep OpenCV's work where it is measured."""
        use_calling_thread()

    async def _look(self, image: Image) -> None:
        luma = mean_luma(image.color, self.settings.step)
        self._dark = luma < (self.settings.light_above if self._dark else self.settings.dark_below)
        self.darkness.publish(Darkness(image.stamp, image.frame, luma, self._dark))
