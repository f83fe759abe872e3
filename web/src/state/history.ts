/** What is kept of messages beyond the newest: lanes, events and load over time, notices. */

import { fromRobot, langOf } from "../i18n";
import { GAP_S } from "../lanes/history";
import type { Session } from "./session";
import type { Store } from "./store";

/** However fast a recording runs, its lanes hold until the next ones. */
const REPLAY_HOLD_S = 10;

/** What the lanes draw of the past; among all kinds, a source that stutters would leave no room for them. */
const LANES_EVENTS = 500;
const LANES_KINDS = "desire,intention,exploitation,accomplishment";

export function keepHistory(session: Session, store: Store): void {
  const holdS = () => (store.replay.peek() ? REPLAY_HOLD_S : GAP_S);
  session.on("lanes", (message) => store.lanes.push(message, holdS()));
  session.on("lanes_history", (message) => store.lanes.fill(message, holdS()));
  session.on("events", (message) => store.addEvents(message.events));
  session.on("load", (message) => store.addLoad(message));
  session.on("notice", (message) => store.notify(message.level, fromRobot(message.text), langOf(message.text)));
  session.onHello.add(() => {
    session.rest.timeline(LANES_EVENTS, LANES_KINDS).then(
      (events) => store.addEvents(events),
      () => undefined, // those that come are shown
    );
  });
  session.onJump.add(() => store.forget());
}
