/** Pictures of one kind from the stream; each is acknowledged when drawn or passed over, which asks for the next. */

import { effect, type ReadonlySignal, signal } from "@preact/signals";
import { CAMERA, FILE, type PANORAMA, type Picture, parsePicture, VP9_KEY } from "../protocol/picture";
import type { Session } from "../state/session";
import { atTurns, paced } from "../state/turns";
import { CanvasPainter, type Painted } from "./canvasPainter";
import { vp9Problem } from "./vp9";

const KEPT_MS = 1500;
/** As the robot takes it. */
const WIDEST_PX = 16_384;

export class PictureFeed {
  /** Stamp of the picture shown; null: none yet on this connection. */
  readonly stamp = signal<number | null>(null);
  /** How the picture shown came; "": none yet. */
  readonly coding = signal<"" | "JPEG" | "VP9">("");
  readonly shownSize = signal("");
  /** Why they come as JPEG alone, for people; "": as VP9, too. */
  readonly noVp9 = signal("this page has not asked for video yet");
  /** A canvas that is read again: drawn to here. */
  canvas: HTMLCanvasElement | null = null;
  /** Size of the picture shown (px). */
  size = { width: 640, height: 480 };
  private painter: CanvasPainter | null = null;
  private shownOn: HTMLCanvasElement | null = null;

  constructor(
    private readonly session: Session,
    private readonly kind: typeof CAMERA | typeof PANORAMA,
    /** Whether the page shows these pictures. */
    private readonly shown: ReadonlySignal<boolean>,
    /** Whether one picture a turn is enough: nobody steers by them, and the processor draws the page. */
    private readonly calm: ReadonlySignal<boolean>,
  ) {}

  private jumped = 0;
  /** Of the pictures drawn. */
  private count = 0;
  /** The canvas is drawn to for each picture; what depends on its stamp, once a turn. */
  private readonly drawn = paced((stamp: number) => (this.stamp.value = stamp));
  private readonly calmly = atTurns((held: { picture: Picture; frame: ArrayBuffer; greeting: number }) => {
    // One that is held while others were drawn at once, or of another connection, is old.
    if (this.calm.peek() && held.greeting === this.greetings) void this.put(held.picture, held.frame);
  });
  private greetings = 0;
  /** The width last asked for, px; and that of now, CSS px. */
  private asked = 0;
  private clientWidth = 0;
  /** Video was asked to begin afresh, and has not yet. */
  private askedAfresh = false;

  start(): void {
    this.session.onBinary.set(this.kind, (frame) => void this.take(frame));
    this.session.onHello.add(() => {
      this.greetings += 1;
      this.stamp.value = null;
      this.request();
      // A decoder that failed gets another chance with each connection.
      if (this.kind === CAMERA) void this.tryVideo();
    });
    // A picture of before a jump stays until that of the new place comes, but not for long if none does.
    // At a place that it was at before, the picture is the same one again.
    this.session.onJump.add(() => {
      const before = this.count;
      clearTimeout(this.jumped);
      this.jumped = window.setTimeout(() => this.count === before && (this.stamp.value = null), KEPT_MS);
    });
    effect(() => {
      void this.shown.value;
      this.request();
    });
    document.addEventListener("visibilitychange", () => this.request());
  }

  /** Shows the pictures on `canvas`, by a worker that alone draws to it; returns what ends that. */
  show(canvas: HTMLCanvasElement): () => void {
    const painter = new CanvasPainter(canvas);
    this.painter = painter;
    this.shownOn = canvas;
    // Read with each picture, the width would lay out the page each time.
    const sized = new ResizeObserver(() => {
      this.clientWidth = canvas.clientWidth;
    });
    sized.observe(canvas);
    this.request(); // a new worker: video begins afresh
    return () => {
      sized.disconnect();
      if (this.painter === painter) this.painter = this.shownOn = null;
      painter.end();
    };
  }

  private wanted(): boolean {
    return this.shown.peek() && !document.hidden;
  }

  private request(): void {
    const wanted = this.wanted();
    const vp9 = this.noVp9.peek() === "";
    if (this.kind === CAMERA) this.session.send({ type: "view", camera: wanted, vp9, ...this.width() });
    else this.session.send({ type: "view", panorama: wanted });
  }

  /** How wide it is shown, in pixels of the screen: the robot sends no larger picture. */
  private width(): { camera_px?: number } {
    const width = Math.round((this.shownOn?.clientWidth ?? 0) * (window.devicePixelRatio || 1));
    this.asked = width;
    return width > 0 ? { camera_px: Math.min(width, WIDEST_PX) } : {};
  }

  /** The page shows it in another size than it asked for. */
  private resized(): boolean {
    const width = this.clientWidth * (window.devicePixelRatio || 1);
    return this.shownOn !== null && width > 0 && Math.abs(width - this.asked) > 0.1 * this.asked + 8;
  }

  private async take(frame: ArrayBuffer): Promise<void> {
    const picture = parsePicture(frame);
    if (!picture) return;
    let painted: Painted = { drawn: false };
    if (this.wanted()) {
      // Each picture of a video is needed for the next.
      if (this.calm.peek() && picture.coding === FILE) this.calmly({ picture, frame, greeting: this.greetings });
      else painted = await this.put(picture, frame);
    }
    this.session.send({ type: "ack", kind: this.kind, seq: picture.seq });
    this.mend(picture, painted);
    if (this.kind === CAMERA && this.resized() && this.wanted()) this.session.send({ type: "view", ...this.width() });
  }

  private async put(picture: Picture, frame: ArrayBuffer): Promise<Painted> {
    const painted = await this.paint(picture, frame);
    if (painted.drawn) {
      this.count += 1;
      this.size = { width: picture.width, height: picture.height };
      this.shownSize.value = `${picture.width} × ${picture.height}`;
      this.coding.value = picture.coding === FILE ? "JPEG" : "VP9";
      this.drawn(picture.stamp);
    }
    return painted;
  }

  private async tryVideo(): Promise<void> {
    this.noVp9.value = await vp9Problem(window.isSecureContext, window.VideoDecoder);
    if (this.noVp9.peek() === "") this.request();
  }

  /** Goes back to JPEGs where video failed, and asks for a beginning where it has none. */
  private mend(picture: Picture, painted: Painted): void {
    if (picture.coding === VP9_KEY) this.askedAfresh = false;
    if (painted.failed !== undefined) {
      this.noVp9.value = painted.failed;
      this.request();
    } else if (painted.incomplete && !this.askedAfresh && this.noVp9.peek() === "") {
      this.askedAfresh = true;
      this.request();
    }
  }

  /** After a damaged picture the next one comes all the same, as it was acknowledged. */
  private async paint(picture: Picture, frame: ArrayBuffer): Promise<Painted> {
    if (this.painter) return this.painter.draw(frame, picture.data.byteOffset, picture.coding);
    return { drawn: this.canvas !== null && (await this.draw(picture, this.canvas)) };
  }

  private async draw(picture: Picture, canvas: HTMLCanvasElement): Promise<boolean> {
    let bitmap: ImageBitmap;
    try {
      bitmap = await createImageBitmap(new Blob([picture.data], { type: "image/jpeg" }));
    } catch {
      return false;
    }
    if (canvas.width !== bitmap.width || canvas.height !== bitmap.height) {
      canvas.width = bitmap.width;
      canvas.height = bitmap.height;
    }
    canvas.getContext("2d")!.drawImage(bitmap, 0, 0);
    bitmap.close();
    return true;
  }
}
