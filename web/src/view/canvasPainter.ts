/** Draws JPEGs on a canvas of the page in a worker, so that decoding and drawing hold up neither keys nor commands. */

export interface ToPainter {
  canvas?: OffscreenCanvas;
  picture?: { id: number; data: ArrayBuffer; offset: number };
}
/** `drawn` is false for a picture that is no JPEG. */
export interface FromPainter {
  id: number;
  drawn: boolean;
}

export class CanvasPainter {
  private readonly worker = new Worker(new URL("./canvasWorker.ts", import.meta.url), { type: "module" });
  private readonly waiting = new Map<number, (drawn: boolean) => void>();
  private last = 0;

  /** `canvas` is drawn to by the worker alone from now on; its size is the newest picture's. */
  constructor(canvas: HTMLCanvasElement) {
    const offscreen = canvas.transferControlToOffscreen();
    this.post({ canvas: offscreen }, [offscreen]);
    this.worker.onmessage = ({ data: { id, drawn } }: MessageEvent<FromPainter>) => {
      this.waiting.get(id)?.(drawn);
      this.waiting.delete(id);
    };
  }

  /** Draws the JPEG in `data` from `offset` on; `data` is given away. Whether it is one. */
  draw(data: ArrayBuffer, offset: number): Promise<boolean> {
    const id = ++this.last;
    return new Promise((resolve) => {
      this.waiting.set(id, resolve);
      this.post({ picture: { id, data, offset } }, [data]);
    });
  }

  /** Nothing is drawn any more. */
  end(): void {
    this.worker.terminate();
    for (const resolve of this.waiting.values()) resolve(false);
    this.waiting.clear();
  }

  private post(message: ToPainter, given: Transferable[]): void {
    this.worker.postMessage(message, given);
  }
}
