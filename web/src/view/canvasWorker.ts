/** The worker of {@link CanvasPainter}. */

import type { FromPainter, ToPainter } from "./canvasPainter";

/** Asked for once: Firefox refuses a worker the context of a page's canvas when it is asked for again. */
let context: OffscreenCanvasRenderingContext2D | null = null;
const answer = (message: FromPainter) => (self as unknown as Worker).postMessage(message);

self.onmessage = async ({ data }: MessageEvent<ToPainter>) => {
  if (data.canvas) context = data.canvas.getContext("2d", { alpha: false });
  if (!data.picture || !context) return;
  const { id, data: bytes, offset } = data.picture;
  let bitmap: ImageBitmap;
  try {
    bitmap = await createImageBitmap(new Blob([new Uint8Array(bytes, offset)], { type: "image/jpeg" }));
  } catch {
    answer({ id, drawn: false });
    return;
  }
  const { canvas } = context;
  if (canvas.width !== bitmap.width || canvas.height !== bitmap.height) {
    canvas.width = bitmap.width;
    canvas.height = bitmap.height;
  }
  context.drawImage(bitmap, 0, 0);
  bitmap.close();
  answer({ id, drawn: true });
};
