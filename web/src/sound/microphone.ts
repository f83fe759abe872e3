/** This computer's microphone: opened when it is first needed, let go a while after it was last. */

import { t } from "../i18n";
import url from "./microphone.worklet.js?url&no-inline";
import { Framer, Resampler } from "./samples";

export const RATE = 48_000;
const FRAME_S = 0.02;

export interface Microphone {
  /** Called with each 20 ms of samples at 48 kHz. */
  onFrame: (samples: Float32Array) => void;
  /** Called when it was taken away. */
  onEnd: () => void;
  close(): void;
}

/** Opens it. Rejects with what the browser says; see `microphoneProblem`. */
export async function openMicrophone(): Promise<Microphone> {
  const stream = await navigator.mediaDevices.getUserMedia({
    audio: { echoCancellation: true, noiseSuppression: true, autoGainControl: true, channelCount: 1 },
  });
  // At the computer's own rate: some browsers take a microphone at no other.
  const context = new AudioContext({ latencyHint: "interactive" });
  const close = () => {
    stream.getTracks().forEach((track) => track.stop());
    void context.close();
  };
  try {
    await context.audioWorklet.addModule(url);
    await context.resume();
  } catch (error) {
    close();
    throw error;
  }
  const node = new AudioWorkletNode(context, "microphone", {
    numberOfInputs: 1,
    channelCount: 1,
    channelCountMode: "explicit",
  });
  // Only what leads to the loudspeaker is sure to be asked for its samples.
  const silent = new GainNode(context, { gain: 0 });
  new MediaStreamAudioSourceNode(context, { mediaStream: stream })
    .connect(node)
    .connect(silent)
    .connect(context.destination);
  const microphone: Microphone = { onFrame: () => undefined, onEnd: () => undefined, close };
  const resampler = new Resampler();
  const framer = new Framer(RATE * FRAME_S);
  node.port.onmessage = (event: MessageEvent<Float32Array>) => {
    const samples = context.sampleRate === RATE ? event.data : resampler.push(event.data, context.sampleRate / RATE);
    for (const frame of framer.push(samples)) microphone.onFrame(frame);
  };
  stream.getTracks().forEach((track) => (track.onended = () => microphone.onEnd()));
  return microphone;
}

/** Why there is no microphone, and what to do about it. */
export function microphoneProblem(error: unknown): string {
  const name = error instanceof DOMException ? error.name : "";
  if (name === "NotAllowedError")
    return t(
      "The browser may not use your microphone. Allow it beside the page's address, then hold the button again.",
    );
  if (name === "NotFoundError") return t("This computer has no microphone. Plug one in, then hold the button again.");
  if (name === "NotReadableError")
    return t("Your microphone is in use by another program. Close that, then hold the button again.");
  return t("Your microphone could not be opened.");
}
