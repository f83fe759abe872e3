/** The worker of {@link CanvasPainter}. */

import { VP9_DELTA, VP9_KEY } from "../protocol/picture";
import type { FromPainter, ToPainter } from "./canvasPainter";
import { Video } from "./video";

/** Asked for once: Firefox refuses a worker the context of a page's canvas when it is asked for again. */
let context: OffscreenCanvasRenderingContext2D | null = null;
/** The newest picture drawn. */
let shown = 0;
const answer = (message: FromPainter) => (self as unknown as Worker).postMessage(message);
const video = new Video((id, frame) => {
  answer({ id, drawn: draw(id, frame, frame.displayWidth, frame.displayHeight) });
  frame.close();
}, answer);

self.onmessage = async ({ data }: MessageEvent<ToPainter>) => {
  if (data.canvas) context = data.canvas.getContext("2d", { alpha: false });
  if (!data.picture || !context) return;
  const { id, data: whole, offset, coding } = data.picture;
  const bytes = new Uint8Array(whole, offset);
  if (coding === VP9_KEY || coding === VP9_DELTA) {
    video.decode(id, bytes, coding === VP9_KEY);
    return;
  }
  let bitmap: ImageBitmap;
  try {
    bitmap = await createImageBitmap(new Blob([bytes], { type: "image/jpeg" }));
  } catch {
    answer({ id, drawn: false });
    return;
  }
  answer({ id, drawn: draw(id, bitmap, bitmap.width, bitmap.height) });
  bitmap.close();
};

/** Whether it was drawn: after a newer one it is not, as where JPEG follows video that is still being decoded. */
function draw(id: number, picture: CanvasImageSource, width: number, height: number): boolean {
  if (!context || id < shown) return false;
  shown = id;
  const { canvas } = context;
  if (canvas.width !== width || canvas.height !== height) {
    canvas.width = width;
    canvas.height = height;
  }
  context.drawImage(picture, 0, 0, width, height);
  return true;
}
