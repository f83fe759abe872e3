/** Keeps the map's canvas as large as it is shown, and painted. */

import { effect } from "@preact/signals";
import type { App } from "../state/context";
import { showsNow } from "../state/freshness";
import type { MapPlace } from "../state/store";
import { drawTour } from "../tours/tourMarks";
import { narrow } from "../ui/media";
import { draw } from "./drawMap";
import { composed, type Point } from "./mapProjection";
import { goalOf } from "./mapText";
import { sketch } from "./mapTools";
import { LAYERS } from "./registry";

/** As in view-tools.css. */
const COLUMN_PX = 860;

/** Paints at the next frame after any change; returns what ends it. */
export function paintOn(canvas: HTMLCanvasElement, place: MapPlace, app: App): () => void {
  const { store, map, grid, ahead } = app;
  let frame = 0;
  const size = { width: 0, height: 0 };
  const paint = () => {
    frame = 0;
    if (size.width < 1) return;
    const localization = store.of("localization").peek();
    const X_MO = localization?.X_MO ?? null;
    const navigation = store.of("navigation").peek();
    const going = navigation && navigation.state !== "idle" && navigation.state !== "arrived" ? navigation : null;
    const goal = goalOf(store.of("desires").peek()?.desires) ?? going?.goal ?? null;
    const around = map.costmap.peek() ? grid.costmap.picture.peek() : null;
    const tools = map.tools.peek();
    const onMap = ({ x, y }: Point) => (X_MO ? composed(X_MO, { x, y, theta: 0 }) : null);
    draw(canvas.getContext("2d")!, size, map.view.peek(), {
      map: grid.map.picture.peek(),
      costmap: around && showsNow(around.info.stamp, store.now.peek(), store.clock.rate) ? around : null,
      X_MO,
      robot: map.robot.peek(),
      ahead: X_MO && ahead.pose.peek() ? composed(X_MO, ahead.pose.peek()!) : null,
      body: {
        footprint: store.hello.peek()?.robot.footprint ?? [],
        sigma: localization?.sigma ?? [0, 0, 0],
        astray: localization?.state === "lost" || localization?.state === "searching",
      },
      softLimit: store.softLimit.peek(),
      path: going?.path ?? [],
      goal,
      givenUp: goal ? null : (navigation?.given_up?.goal ?? null),
      target: going?.target ?? null,
      zones: grid.map.picture.peek()?.known ? map.zones.peek() : [],
      selected: map.selected.peek(),
      tool: tools.tool,
      act: tools.act,
      sketch: sketch(tools, map.sight),
      cursor: tools.cursor,
      bar: place === "view" ? aboveTools(size.width) : null,
      percepts: (context, onScreen) => {
        for (const layer of LAYERS) {
          const message = store.of(layer.type).peek();
          const place = (point: Point & { frame?: string }) => {
            const there = point.frame === "map" ? point : onMap(point);
            return there && onScreen(there);
          };
          if (message) layer.draw(context, message, place);
        }
        // Its numbers are on the dots of its places.
        const tour = app.tourMarks.peek();
        if (tour) drawTour(context, tour, onScreen);
      },
    });
  };
  const later = () => {
    if (!frame) frame = requestAnimationFrame(paint);
  };
  const sized = new ResizeObserver(() => {
    size.width = canvas.clientWidth;
    size.height = canvas.clientHeight;
    const density = Math.min(2, window.devicePixelRatio || 1);
    canvas.width = Math.round(size.width * density);
    canvas.height = Math.round(size.height * density);
    map.resize({ ...size }, place);
    map.met(grid.map.picture.peek());
    cancelAnimationFrame(frame);
    paint();
  });
  sized.observe(canvas);
  const end = effect(() => {
    void [store.of("localization").value, store.of("navigation").value, store.of("desires").value?.desires];
    for (const layer of LAYERS) void store.of(layer.type).value;
    void [map.view.value, map.tools.value, map.robot.value, map.zones.value, map.selected.value, map.costmap.value];
    // Seconds, as what stands around is only shown while it does.
    void [grid.costmap.picture.value, store.seconds.value, store.hello.value, app.tourMarks.value];
    void [ahead.pose.value, store.softLimit.value];
    map.met(grid.map.picture.value);
    later();
  });
  return () => {
    end();
    sized.disconnect();
    cancelAnimationFrame(frame);
  };
}

/** The view's tools stand in a row, or in a column where there is little room; its left corner is under the drive pad. */
function aboveTools(width: number): { right: number; bottom: number } {
  return { right: 14, bottom: !narrow.peek() && width <= COLUMN_PX ? 166 : 60 };
}
