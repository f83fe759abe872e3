/** Map and local costmap from the stream: what each is, its picture in the page's colours, acknowledged when drawn. */

import { effect, type ReadonlySignal, signal } from "@preact/signals";
import { COSTMAP, MAP, parsePicture } from "../protocol/picture";
import type { GridInfo } from "../protocol/types";
import type { Session } from "../state/session";
import { drawnBox, palette, recolor } from "./colors";
import type { Bounds } from "./mapProjection";

export interface GridPicture {
  info: GridInfo;
  canvas: HTMLCanvasElement;
  /** What is known of it, in its frame; null: nothing. */
  known: Bounds | null;
}

const KINDS = { map: MAP, costmap: COSTMAP } as const;

export class GridFeed {
  /** Null: none yet on this connection. */
  readonly picture = signal<GridPicture | null>(null);
  private info: GridInfo | null = null;
  private readonly colors: Uint8ClampedArray;

  constructor(
    private readonly session: Session,
    private readonly kind: keyof typeof KINDS,
    private readonly shown: ReadonlySignal<boolean>,
  ) {
    this.colors = palette(this.announcement);
  }

  start(): void {
    this.session.onBinary.set(KINDS[this.kind], (frame) => void this.take(frame));
    // Of the picture that comes next.
    this.session.on(this.announcement, (info) => (this.info = info));
    this.session.onHello.add(() => {
      this.picture.value = null;
      this.request();
    });
    this.session.onJump.add(() => (this.picture.value = null));
    effect(() => {
      if (!this.shown.value && this.kind === "costmap") this.picture.value = null;
      this.request();
    });
    document.addEventListener("visibilitychange", () => this.request());
  }

  private get announcement(): GridInfo["type"] {
    return this.kind === "map" ? "map_info" : "costmap_info";
  }

  private request(): void {
    const wanted = this.shown.peek() && !document.hidden;
    this.session.send({ type: "view", ...(this.kind === "map" ? { map: wanted } : { costmap: wanted }) });
  }

  private async take(frame: ArrayBuffer): Promise<void> {
    const picture = parsePicture(frame);
    if (!picture) return;
    const info = this.info?.seq === picture.seq ? this.info : null;
    const drawn = info && (await this.drawn(picture.data, info));
    if (drawn) this.picture.value = drawn;
    this.session.send({ type: "ack", kind: picture.kind, seq: picture.seq });
  }

  private async drawn(png: Uint8Array<ArrayBuffer>, info: GridInfo): Promise<GridPicture | null> {
    let bitmap: ImageBitmap;
    try {
      // The grey values are figures: no colour management may touch them.
      bitmap = await createImageBitmap(new Blob([png], { type: "image/png" }), { colorSpaceConversion: "none" });
    } catch {
      return null; // a damaged picture: the next one comes after the acknowledgement all the same
    }
    const canvas = document.createElement("canvas");
    canvas.width = bitmap.width;
    canvas.height = bitmap.height;
    const context = canvas.getContext("2d", { willReadFrequently: true })!;
    context.drawImage(bitmap, 0, 0);
    bitmap.close();
    const image = context.getImageData(0, 0, canvas.width, canvas.height);
    recolor(image.data, this.colors);
    context.putImageData(image, 0, 0);
    return { info, canvas, known: boundsOf(drawnBox(image.data, canvas.width), canvas.height, info) };
  }
}

/** The picture's top row has the greatest y. */
function boundsOf(box: ReturnType<typeof drawnBox>, height: number, info: GridInfo): Bounds | null {
  if (!box) return null;
  const [x, y] = info.origin;
  const cell = info.resolution_m;
  return {
    left: x + box.left * cell,
    right: x + box.right * cell,
    bottom: y + (height - box.bottom) * cell,
    top: y + (height - box.top) * cell,
  };
}
