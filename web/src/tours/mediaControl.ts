/** Pictures and videos on the robot, and the one that is on its way there. */

import { type ReadonlySignal, signal } from "@preact/signals";
import { t } from "../i18n";
import { inWords } from "../protocol/problem";
import type { TourRest } from "../protocol/tourRest";
import type { TourMedia, TourMediaList } from "../protocol/types";

/** What a browser offers to choose; what is in a file, the robot looks at. */
export const TAKEN = ["image/jpeg", "image/png", "image/webp", "image/gif", "video/mp4", "video/webm"];

/** A file on its way: how much of it is there, 0 to 1. */
export interface Upload {
  name: string;
  share: number;
}

export class MediaControl {
  private readonly known = signal<TourMediaList | null>(null);
  private readonly sent = signal<Upload | null>(null);
  private readonly said = signal("");
  /** Null: not read yet. */
  readonly list: ReadonlySignal<TourMediaList | null> = this.known;
  /** Null: none is on its way. */
  readonly upload: ReadonlySignal<Upload | null> = this.sent;
  /** Why the last was not taken, or not deleted; empty: it was. */
  readonly refusal: ReadonlySignal<string> = this.said;
  private stop = new AbortController();

  constructor(private readonly rest: TourRest) {}

  async refresh(): Promise<void> {
    try {
      this.known.value = await this.rest.tourMedia();
    } catch (error) {
      this.said.value = inWords(error);
    }
  }

  /** Resolves to how tours name it; null: it was not taken. */
  async add(file: File): Promise<string | null> {
    if (this.sent.peek()) return null;
    this.said.value = this.objection(file);
    if (this.said.peek()) return null;
    this.stop = new AbortController();
    this.sent.value = { name: file.name, share: 0 };
    const onShare = (share: number) => (this.sent.value = { name: file.name, share });
    try {
      const { file: named } = await this.rest.addTourMedia(file, onShare, this.stop.signal);
      await this.refresh();
      return named;
    } catch (error) {
      if (!this.stop.signal.aborted) this.said.value = inWords(error);
      return null;
    } finally {
      this.sent.value = null;
    }
  }

  cancel(): void {
    this.stop.abort();
  }

  /** For good. */
  async remove({ file }: TourMedia): Promise<void> {
    try {
      await this.rest.deleteTourMedia(file);
      this.said.value = "";
    } catch (error) {
      this.said.value = inWords(error);
    }
    await this.refresh();
  }

  /** The refusal is read. */
  clear(): void {
    this.said.value = "";
  }

  /** What is seen before it is sent; the robot looks for itself. */
  private objection({ name, type, size }: File): string {
    const limits = this.known.peek();
    if (type !== "" && !TAKEN.includes(type))
      return t("{name} is no picture (JPEG, PNG, WebP, GIF) and no video (MP4, WebM).", { name });
    const most = type.startsWith("video/") ? limits?.largest_video : limits?.largest_picture;
    if (type !== "" && most !== undefined && size > most)
      return t("{name} is larger than {count} MB.", { name, count: Math.floor(most / 1024 ** 2) });
    return "";
  }
}
