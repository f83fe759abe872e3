/** The worker of {@link CanvasPainter}. */

import type { FromPainter, ToPainter } from "./canvasPainter";

let canvas: OffscreenCanvas | null = null;
const answer = (message: FromPainter) => (self as unknown as Worker).postMessage(message);

self.onmessage = async ({ data }: MessageEvent<ToPainter>) => {
  if (data.canvas) canvas = data.canvas;
  if (!data.picture || !canvas) return;
  const { id, data: bytes, offset } = data.picture;
  let bitmap: ImageBitmap;
  try {
    bitmap = await createImageBitmap(new Blob([new Uint8Array(bytes, offset)], { type: "image/jpeg" }));
  } catch {
    answer({ id, drawn: false });
    return;
  }
  if (canvas.width !== bitmap.width || canvas.height !== bitmap.height) {
    canvas.width = bitmap.width;
    canvas.height = bitmap.height;
  }
  canvas.getContext("2d", { alpha: false })!.drawImage(bitmap, 0, 0);
  bitmap.close();
  answer({ id, drawn: true });
};
