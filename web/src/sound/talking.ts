/** Speaking through the robot: while a button or the key V is held, and not a moment longer. */

import { computed, effect, type ReadonlySignal, signal } from "@preact/signals";
import { typesText } from "../drive/driveController";
import { t } from "../i18n";
import { packVoice } from "../protocol/sound";
import type { Session } from "../state/session";
import type { Store } from "../state/store";
import type { Listening } from "./listening";
import { type Microphone, microphoneProblem, openMicrophone, RATE } from "./microphone";
import { levelDb, toInt16 } from "./samples";

const KEY = "KeyV";
/** Opening it takes a moment; kept open for good, the browser would show for hours that it listens. */
const KEEP_MS = 10_000;

/** `opening`: held, but the microphone is not there yet. */
export type Talk = "idle" | "opening" | "talking";

export class Talking {
  readonly state = signal<Talk>("idle");
  /** Of what the microphone hears while it is spoken, dB of full scale. */
  readonly level = signal<number | null>(null);
  /** Why one cannot speak now, in words; null: one can. */
  readonly refusal: ReadonlySignal<string | null>;
  private microphone: Microphone | null = null;
  private opening = false;
  private letGo = 0;
  private seq = 0;

  constructor(
    private readonly store: Store,
    private readonly session: Session,
    private readonly listening: Listening,
  ) {
    this.refusal = computed(() => whyNot(store));
  }

  start(): void {
    this.listen(window);
    window.addEventListener("blur", () => this.release());
    window.addEventListener("pagehide", () => this.release());
    document.addEventListener("visibilitychange", () => this.release());
    effect(() => {
      if (this.refusal.value !== null) this.release();
    });
  }

  press(): void {
    if (this.state.peek() !== "idle") return;
    const reason = this.refusal.peek();
    if (reason) {
      if (this.store.live.peek()) this.store.notify("warning", reason);
      return;
    }
    clearTimeout(this.letGo);
    if (this.microphone) this.begin();
    else {
      this.state.value = "opening";
      void this.open();
    }
  }

  release(): void {
    const before = this.state.peek();
    if (before === "idle") return;
    this.state.value = "idle";
    this.level.value = null;
    if (before === "talking") {
      this.send(new Float32Array(0));
      this.listening.mute(false);
    }
    this.keep();
  }

  private keep(): void {
    clearTimeout(this.letGo);
    this.letGo = window.setTimeout(() => this.drop(), KEEP_MS);
  }

  private listen(target: Window): void {
    target.addEventListener("keydown", (event) => {
      const plain = !(event.ctrlKey || event.altKey || event.metaKey);
      if (event.code === KEY && plain && !event.repeat && !typesText(event.target)) this.press();
    });
    target.addEventListener("keyup", (event) => event.code === KEY && this.release());
  }

  private async open(): Promise<void> {
    if (this.opening) return;
    this.opening = true;
    try {
      const microphone = await openMicrophone();
      this.microphone = microphone;
      microphone.onFrame = (samples) => this.send(samples);
      microphone.onEnd = () => {
        this.release();
        this.drop();
      };
      if (this.state.peek() === "opening") this.begin();
      else this.keep();
    } catch (error) {
      this.release();
      this.store.notify("error", microphoneProblem(error));
    } finally {
      this.opening = false;
    }
  }

  private begin(): void {
    this.listening.mute(true);
    this.state.value = "talking";
  }

  private send(samples: Float32Array): void {
    const ends = samples.length === 0;
    if (!ends && this.state.peek() !== "talking") return;
    const now = this.store.clock.now(performance.now() / 1000);
    const ints = toInt16(samples);
    this.seq += 1;
    this.session.sendBinary(
      packVoice({ seq: this.seq, stamp: now === null ? 0 : now - samples.length / RATE, rate: RATE, samples: ints }),
    );
    if (!ends) this.level.value = levelDb(ints);
  }

  private drop(): void {
    this.microphone?.close();
    this.microphone = null;
  }
}

function whyNot(store: Store): string | null {
  const hello = store.hello.value;
  if (store.replay.value) return t("This is a recording: nothing can be said in it.");
  const phase = store.link.value.phase;
  if (!hello || (phase !== "live" && phase !== "stale")) return t("Not connected to the robot.");
  if (!hello.audio.speak) return t("This robot has no loudspeaker.");
  const speaker = store.of("status").value?.speaker;
  if (speaker && !speaker.mine) return t("The robot's voice is in use by {operator}.", { operator: speaker.operator });
  if (!navigator.mediaDevices)
    return t("Browsers give the microphone only to pages from this computer (localhost) or over https.");
  return null;
}
