/** Camera pictures from the stream onto a canvas; each is acknowledged when drawn, which asks for the next. */

import { effect, signal } from "@preact/signals";
import { CAMERA, parsePicture, type Picture } from "../protocol/picture";
import type { Session } from "../state/session";
import type { Store } from "../state/store";

const KEPT_MS = 1500;

export class CameraFeed {
  /** Stamp of the picture shown; null: none yet on this connection. */
  readonly stamp = signal<number | null>(null);
  canvas: HTMLCanvasElement | null = null;

  constructor(
    private readonly store: Store,
    private readonly session: Session,
  ) {}

  private jumped = 0;

  start(): void {
    this.session.onPicture = (frame) => void this.take(frame);
    this.session.onHello = () => {
      this.stamp.value = null;
      this.tell();
    };
    // A picture of before a jump stays until that of the new place comes, but not for long if none does.
    this.session.onJump = () => {
      const before = this.stamp.peek();
      clearTimeout(this.jumped);
      this.jumped = window.setTimeout(() => this.stamp.peek() === before && (this.stamp.value = null), KEPT_MS);
    };
    effect(() => {
      void this.store.camera.value;
      this.tell();
    });
    document.addEventListener("visibilitychange", () => this.tell());
  }

  private wanted(): boolean {
    return this.store.camera.peek() !== "hidden" && !document.hidden;
  }

  private tell(): void {
    this.session.send({ type: "view", camera: this.wanted() });
  }

  private async take(frame: ArrayBuffer): Promise<void> {
    const picture = parsePicture(frame);
    if (picture?.kind !== CAMERA) return;
    if (this.wanted() && this.canvas) await this.draw(picture, this.canvas);
    this.session.send({ type: "ack", kind: CAMERA, seq: picture.seq });
  }

  private async draw(picture: Picture, canvas: HTMLCanvasElement): Promise<void> {
    let bitmap: ImageBitmap;
    try {
      bitmap = await createImageBitmap(new Blob([picture.jpeg], { type: "image/jpeg" }));
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
