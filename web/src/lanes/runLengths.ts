/** The spells a lane spends in one state, for what is drawn along its foot. Pure. */

import type { LaneState } from "../protocol/types";
import type { Span } from "./columns";
import type { Lane, LaneHistory } from "./history";

/** Calls `visit` for each stretch of one state that touches `span`, in order; silences belong to none. */
export function spells(
  history: LaneHistory,
  lane: Lane,
  span: Pick<Span, "from" | "to">,
  visit: (state: LaneState, from: number, to: number) => void,
): void {
  const stop = history.at(span.to);
  let state: LaneState | undefined;
  let began = 0;
  let until = 0;
  const close = () => {
    if (state !== undefined && until > span.from) visit(state, began, Math.min(until, span.to));
  };
  for (let number = Math.max(history.first, history.at(span.from)); number <= stop; number++) {
    const slot = number % history.capacity;
    const stamp = history.stamps[slot]!;
    const here = lane.state[slot];
    if (here !== state || stamp > until) {
      until = Math.min(until, stamp);
      close();
      state = here;
      began = stamp;
    }
    const next = number + 1 < history.count ? history.stamps[(number + 1) % history.capacity]! : Infinity;
    until = Math.min(next, stamp + history.holds[slot]!);
  }
  close();
}
