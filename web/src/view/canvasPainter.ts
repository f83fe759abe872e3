/** Draws pictures on a canvas of the page in a worker, so that decoding and drawing hold up neither keys nor commands. */

export interface ToPainter {
  canvas?: OffscreenCanvas;
  picture?: { id: number; data: ArrayBuffer; offset: number; coding: number };
}
/** What became of a picture. */
export interface Painted {
  /** False for one that is damaged, or older than what is shown. */
  drawn: boolean;
  /** Why video cannot be decoded here, for people. */
  failed?: string;
  /** It needs pictures before it that did not come here: video is to begin afresh. */
  incomplete?: boolean;
}
export interface FromPainter extends Painted {
  id: number;
}

export class CanvasPainter {
  private readonly worker = new Worker(new URL("./canvasWorker.ts", import.meta.url), { type: "module" });
  private readonly waiting = new Map<number, (painted: Painted) => void>();
  private last = 0;

  /** `canvas` is drawn to by the worker alone from now on; its size is the newest picture's. */
  constructor(canvas: HTMLCanvasElement) {
    const offscreen = canvas.transferControlToOffscreen();
    this.post({ canvas: offscreen }, [offscreen]);
    this.worker.onmessage = ({ data: { id, ...painted } }: MessageEvent<FromPainter>) => {
      this.waiting.get(id)?.(painted);
      this.waiting.delete(id);
    };
  }

  /** Draws the picture in `data` from `offset` on, which is of this `coding`; `data` is given away. */
  draw(data: ArrayBuffer, offset: number, coding: number): Promise<Painted> {
    const id = ++this.last;
    return new Promise((resolve) => {
      this.waiting.set(id, resolve);
      this.post({ picture: { id, data, offset, coding } }, [data]);
    });
  }

  /** Nothing is drawn any more. */
  end(): void {
    this.worker.terminate();
    for (const resolve of this.waiting.values()) resolve({ drawn: false });
    this.waiting.clear();
  }

  private post(message: ToPainter, given: Transferable[]): void {
    this.worker.postMessage(message, given);
  }
}
