/** Pictures of one kind from the stream; each is acknowledged when drawn, which asks for the next. */

import { effect, type ReadonlySignal, signal } from "@preact/signals";
import { CAMERA, type PANORAMA, type Picture, parsePicture } from "../protocol/picture";
import type { Session } from "../state/session";

const KEPT_MS = 1500;

export class PictureFeed {
  /** Stamp of the picture shown; null: none yet on this connection. */
  readonly stamp = signal<number | null>(null);
  canvas: HTMLCanvasElement | null = null;

  constructor(
    private readonly session: Session,
    private readonly kind: typeof CAMERA | typeof PANORAMA,
    /** Whether the page shows these pictures. */
    private readonly shown: ReadonlySignal<boolean>,
  ) {}

  private jumped = 0;

  start(): void {
    this.session.onBinary.set(this.kind, (frame) => void this.take(frame));
    this.session.onHello.add(() => {
      this.stamp.value = null;
      this.request();
    });
    // A picture of before a jump stays until that of the new place comes, but not for long if none does.
    this.session.onJump.add(() => {
      const before = this.stamp.peek();
      clearTimeout(this.jumped);
      this.jumped = window.setTimeout(() => this.stamp.peek() === before && (this.stamp.value = null), KEPT_MS);
    });
    effect(() => {
      void this.shown.value;
      this.request();
    });
    document.addEventListener("visibilitychange", () => this.request());
  }

  private wanted(): boolean {
    return this.shown.peek() && !document.hidden;
  }

  private request(): void {
    const wanted = this.wanted();
    this.session.send({ type: "view", ...(this.kind === CAMERA ? { camera: wanted } : { panorama: wanted }) });
  }

  private async take(frame: ArrayBuffer): Promise<void> {
    const picture = parsePicture(frame);
    if (!picture) return;
    if (this.wanted() && this.canvas) await this.draw(picture, this.canvas);
    this.session.send({ type: "ack", kind: this.kind, seq: picture.seq });
  }

  private async draw(picture: Picture, canvas: HTMLCanvasElement): Promise<void> {
    let bitmap: ImageBitmap;
    try {
      bitmap = await createImageBitmap(new Blob([picture.data], { type: "image/jpeg" }));
    } catch {
      return; // a damaged picture: the next one comes after the acknowledgement all the same
    }
    if (canvas.width !== bitmap.width || canvas.height !== bitmap.height) {
      canvas.width = bitmap.width;
      canvas.height = bitmap.height;
    }
    canvas.getContext("2d")!.drawImage(bitmap, 0, 0);
    bitmap.close();
    this.stamp.value = picture.stamp;
  }
}
