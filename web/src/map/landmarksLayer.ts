/** QR codes found. */

import { drawPoster } from "./drawMarks";
import { layer } from "./layer";

export const landmarksLayer = layer({
  type: "landmarks",
  draw: (context, { landmarks }, onScreen) => {
    for (const landmark of landmarks) {
      const place = onScreen(landmark);
      if (place) drawPoster(context, place);
    }
  },
});
