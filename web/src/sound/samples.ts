/** Samples from one form into another; pure, but for what a resampler keeps of the samples before. */

export function toFloat(samples: Int16Array): Float32Array<ArrayBuffer> {
  const floats = new Float32Array(samples.length);
  for (let i = 0; i < samples.length; i++) floats[i] = samples[i]! / 32768;
  return floats;
}

export function toInt16(samples: Float32Array): Int16Array<ArrayBuffer> {
  const ints = new Int16Array(samples.length);
  for (let i = 0; i < samples.length; i++) ints[i] = Math.max(-32768, Math.min(32767, Math.round(samples[i]! * 32768)));
  return ints;
}

/** Level (dB of full scale) by the mean of the squares; at least −100. */
export function levelDb(samples: Int16Array): number {
  let sum = 0;
  for (const sample of samples) sum += sample * sample;
  const mean = samples.length > 0 ? sum / samples.length / 32768 ** 2 : 0;
  return Math.max(-100, 10 * Math.log10(mean + 1e-12));
}

/** Another rate, piece by piece without seams: cubic interpolation (Catmull-Rom), two samples late. */
export class Resampler {
  private tail = new Float32Array(3);
  private at = 1;

  /** `step` samples of what comes in make one of what comes out; it may change from piece to piece. */
  push(samples: Float32Array, step: number): Float32Array<ArrayBuffer> {
    const whole = new Float32Array(samples.length + 3);
    whole.set(this.tail);
    whole.set(samples, 3);
    const out = new Float32Array(Math.ceil(samples.length / step) + 2);
    let count = 0;
    for (; Math.floor(this.at) <= samples.length; this.at += step) {
      const i = Math.floor(this.at);
      const t = this.at - i;
      const [a, b, c, d] = [whole[i - 1]!, whole[i]!, whole[i + 1]!, whole[i + 2]!];
      out[count++] = b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
    }
    this.at -= samples.length;
    this.tail = whole.slice(-3);
    return out.slice(0, count);
  }
}

/** Cuts a stream of samples into frames of equal length. */
export class Framer {
  private held = new Float32Array(0);

  constructor(private readonly length: number) {}

  push(samples: Float32Array): Float32Array[] {
    const whole = new Float32Array(this.held.length + samples.length);
    whole.set(this.held);
    whole.set(samples, this.held.length);
    const frames = [];
    let from = 0;
    for (; from + this.length <= whole.length; from += this.length) frames.push(whole.slice(from, from + this.length));
    this.held = whole.slice(from);
    return frames;
  }
}
