/** People whose faces are seen, where their distance is known. */

import { drawPerson } from "./drawMarks";
import { layer } from "./layer";

export const peopleLayer = layer({
  type: "perceived",
  draw: (context, { faces }, onScreen) => {
    for (const { x, y } of faces) {
      const place = x === null || y === null ? null : onScreen({ x, y });
      if (place) drawPerson(context, place);
    }
  },
});
