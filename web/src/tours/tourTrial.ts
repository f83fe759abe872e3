/** Has the robot do a step of a tour now. */

import { inWords } from "../protocol/problem";
import { idempotencyKey } from "../protocol/requests";
import type { Rest } from "../protocol/rest";
import type { Step } from "../protocol/types";
import type { Store } from "../state/store";
import { desiresOf } from "./tryStep";

export class TourTrial {
  constructor(
    private readonly store: Store,
    private readonly rest: Rest,
  ) {}

  /** Whether it would do anything. */
  can(step: Step, poster: string | null): boolean {
    return this.store.live.value && !this.store.replay.value && this.desires(step, [], poster).length > 0;
  }

  async step(step: Step, languages: readonly string[], poster: string | null): Promise<void> {
    try {
      for (const desire of this.desires(step, languages, poster)) await this.rest.addDesire(desire, idempotencyKey());
    } catch (error) {
      this.store.notify("error", inWords(error));
    }
  }

  private desires(step: Step, [first = "en"]: readonly string[], poster: string | null) {
    const classes = this.store.hello.value?.classes ?? [];
    const serves = (kind: string) => classes.some(({ name, served }) => name === kind && served);
    return desiresOf(step, { language: first, fallback: first, poster, serves });
  }
}
