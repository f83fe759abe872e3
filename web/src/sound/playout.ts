/**
 * When to play what comes over the network: a small reserve of sound against its unevenness, kept at its length.
 *
 * Sound comes at the robot's pace and is played at this computer's, which differ a little: where the reserve grows or
 * shrinks, the sound is played up to 1 % faster or slower, too little to be heard. After a hitch it begins afresh with a
 * larger reserve; what came too late in a burst is left out, so that the delay does not stay.
 */

import type { Sound } from "../protocol/sound";
import { levelDb, Resampler, toFloat } from "./samples";

/** The reserve that is aimed at: at the beginning, at least and at most, s. */
const FIRST_S = 0.1;
const LEAST_S = 0.06;
const MOST_S = 0.3;
/** What is more than so much over the aim is left out. */
const EXCESS_S = 0.12;
/** Too close to now to be played in time. */
const MARGIN_S = 0.005;
const SMOOTHING = 0.02;
const MOST_FASTER = 0.01;
/** Part of the aim's excess over the least that each good frame takes away: gone after a minute or so. */
const CALMING = 0.0005;
const REMEMBERED_S = 1;
/** A seam is smoothed over so many samples. */
const SEAM = 96;

/** Samples to begin at `at`, s of the audio clock. */
export interface Piece {
  at: number;
  samples: Float32Array<ArrayBuffer>;
}

interface Played {
  at: number;
  until: number;
  stamp: number;
  duration: number;
  level: number;
}

export class Playout {
  /** The reserve aimed at, s. */
  aim = FIRST_S;
  private resampler = new Resampler();
  private next: number | null = null;
  private reserve = FIRST_S;
  private seq = 0;
  private last = 0;
  private played: Played[] = [];

  /** `rate`: samples a second that are played. */
  constructor(private readonly rate: number) {}

  /** What to play of a frame that comes at `now` (s of the audio clock), and when; null: nothing. */
  push(sound: Sound, now: number): Piece | null {
    if (sound.samples.length === 0) return null;
    let whole = this.next !== null && sound.seq === this.seq + 1;
    const ahead = this.next === null ? null : this.next / this.rate - now;
    if (ahead === null || ahead < MARGIN_S) {
      if (ahead !== null) this.aim = Math.min(MOST_S, 1.5 * this.aim);
      this.next = Math.ceil((now + this.aim) * this.rate);
      this.reserve = this.aim;
      this.last = 0;
      whole = false;
    } else if (ahead > this.aim + EXCESS_S) return null;
    else {
      this.reserve += SMOOTHING * (ahead - this.reserve);
      this.aim -= CALMING * (this.aim - LEAST_S);
    }
    this.seq = sound.seq;
    const faster = Math.max(-MOST_FASTER, Math.min(MOST_FASTER, 0.1 * (this.reserve - this.aim)));
    const samples = this.resampler.push(toFloat(sound.samples), (sound.rate / this.rate) * (1 + faster));
    if (!whole) this.smooth(samples);
    const at = this.next! / this.rate;
    this.next! += samples.length;
    this.last = samples.at(-1) ?? 0;
    this.played.push({
      at,
      until: this.next! / this.rate,
      stamp: sound.stamp,
      duration: sound.samples.length / sound.rate,
      level: levelDb(sound.samples),
    });
    while (this.played[0]!.until < now - REMEMBERED_S) this.played.shift();
    return { at, samples };
  }

  /** What is played at `at` (s of the audio clock): the robot's time of it, and its level (dB); null: nothing. */
  heard(at: number): { stamp: number; level: number } | null {
    const piece = this.played.find((one) => one.at <= at && at < one.until);
    if (!piece) return null;
    return { stamp: piece.stamp + ((at - piece.at) / (piece.until - piece.at)) * piece.duration, level: piece.level };
  }

  private smooth(samples: Float32Array): void {
    const off = this.last - (samples[0] ?? 0);
    const over = Math.min(SEAM, samples.length);
    for (let i = 0; i < over; i++) samples[i]! += off * (1 - i / over);
  }
}
