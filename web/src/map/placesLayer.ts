/** Named places, each with the heading that the robot has there. */

import { drawPlace, drawPlaceNames } from "./drawMarks";
import { layer } from "./layer";

export const placesLayer = layer({
  type: "places",
  draw: (context, { places }, onScreen) => {
    const named = [];
    for (const { x, y, heading, name, problem } of places) {
      const at = onScreen({ x, y, frame: "map" });
      const ahead = onScreen({ x: x + Math.cos(heading), y: y + Math.sin(heading), frame: "map" });
      if (!at || !ahead) continue;
      drawPlace(context, at, Math.atan2(ahead.y - at.y, ahead.x - at.x), problem !== "");
      named.push({ at, name });
    }
    drawPlaceNames(context, named);
  },
});
