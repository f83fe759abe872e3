/** The side column: the registered panels in their tabs. */

import { useApp } from "../state/context";
import { Tabs } from "../ui/Tabs";
import { externalTabs } from "./external";
import { type Panel, tabsOf } from "./panel";
import { PANELS } from "./registry";

export function Side({ phone }: { phone: boolean }) {
  const app = useApp();
  const items = tabsOf(PANELS, app, phone).map(({ panels, ...tab }) => ({
    ...tab,
    content: () => panels.map((panel) => <Shown key={`${panel.type} ${panels.indexOf(panel)}`} panel={panel} />),
  }));
  return <Tabs items={[...items, ...externalTabs(app)]} />;
}

function Shown({ panel }: { panel: Panel }) {
  const { store } = useApp();
  return <panel.Card message={store.of(panel.type).value} />;
}
