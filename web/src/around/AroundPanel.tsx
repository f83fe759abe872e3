/** On a phone, the strip of all directions in its small form, among what was found. */

import { panel } from "../panels/panel";
import { useApp } from "../state/context";
import { Around } from "./Around";

export const aroundPanel = panel({
  type: "perceived",
  tab: "Found",
  Card: AroundPanel,
  offered: (_, phone) => phone,
});

function AroundPanel() {
  const { store } = useApp();
  return store.around.value === "large" ? null : <Around place="tab" />;
}
