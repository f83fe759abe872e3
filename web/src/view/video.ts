/** Video by WebCodecs, a picture at a time; any failure ends it, with its reason. For a worker. */

import type { FromPainter } from "./canvasPainter";
import { VP9 } from "./vp9";

/** A decoder that has given nothing for so long (ms) keeps pictures back, as one made for films may. */
export const STALLED_MS = 2000;

export class Video {
  private decoder: VideoDecoder | null = null;
  /** Ids of the pictures that the decoder has, and what ends the patience with each. */
  private readonly waiting = new Map<number, number>();

  /** `shown` is given each picture decoded, and closes it; `answer` what became of the others. */
  constructor(
    private readonly shown: (id: number, frame: VideoFrame) => void,
    private readonly answer: (message: FromPainter) => void,
  ) {}

  /** Decodes picture `id`, which is a `key` picture or needs those before it. */
  decode(id: number, data: Uint8Array<ArrayBuffer>, key: boolean): void {
    if (!this.decoder && !key) {
      this.answer({ id, drawn: false, incomplete: true });
      return;
    }
    this.waiting.set(
      id,
      setTimeout(() => this.fail(`the decoder gave no picture for ${STALLED_MS / 1000} s`), STALLED_MS) as never,
    );
    try {
      this.decoder ??= this.opened();
      this.decoder.decode(new EncodedVideoChunk({ type: key ? "key" : "delta", timestamp: id, data }));
    } catch (error) {
      this.fail(`the decoder failed: ${error instanceof Error ? error.message : error}`);
    }
  }

  private opened(): VideoDecoder {
    const decoder = new VideoDecoder({
      output: (frame) => {
        clearTimeout(this.waiting.get(frame.timestamp));
        if (this.waiting.delete(frame.timestamp)) this.shown(frame.timestamp, frame);
        else frame.close();
      },
      error: (error) => {
        if (decoder === this.decoder) this.fail(`the decoder failed: ${error.message}`);
      },
    });
    decoder.configure(VP9);
    return decoder;
  }

  private fail(failed: string): void {
    const decoder = this.decoder;
    this.decoder = null;
    if (decoder && decoder.state !== "closed") decoder.close();
    for (const [id, patience] of this.waiting) {
      clearTimeout(patience);
      this.answer({ id, drawn: false, failed });
    }
    this.waiting.clear();
  }
}
