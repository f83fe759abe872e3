"""Where places of the map are on the page's screen."""

from __future__ import annotations

from dataclasses import dataclass

from playwright.sync_api import Page

#: The map's view, once it has been the same for so many frames: it is drawn a turn after what was pressed.
_VIEW = """
(canvas) => new Promise((done) => {
  const seen = () => {
    const { left, top, width, height } = canvas.getBoundingClientRect();
    const { x, y, scale, up } = canvas.dataset;
    return JSON.stringify({ x, y, scale, up, left, top, width, height });
  };
  let [before, same] = ["", 0];
  const look = () => {
    const now = seen();
    same = now === before ? same + 1 : 0;
    before = now;
    if (same < 40) requestAnimationFrame(look);
    else done(JSON.parse(now));
  };
  look();
})
"""


@dataclass(frozen=True)
class MapView:
    """Middle of the canvas on the page (px) and on the map (m), with px for each metre."""

    left: float
    top: float
    x: float
    y: float
    scale: float

    def at(self, x: float, y: float) -> tuple[float, float]:
        """Where the place (m) is on the page (px)."""
        return self.left + self.scale * (x - self.x), self.top - self.scale * (y - self.y)


def map_view(page: Page) -> MapView:
    """The view of the page's map, at rest."""
    seen = page.get_by_test_id("map-canvas").evaluate(_VIEW)
    return MapView(
        left=seen["left"] + seen["width"] / 2,
        top=seen["top"] + seen["height"] / 2,
        x=float(seen["x"]),
        y=float(seen["y"]),
        scale=float(seen["scale"]),
    )
