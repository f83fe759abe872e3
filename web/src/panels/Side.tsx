/** The side column: the registered panels in their tabs. */

import { useMemo } from "preact/hooks";
import { useApp } from "../state/context";
import { Tabs } from "../ui/Tabs";
import { externalTabs } from "./external";
import { offeredTabs, type Panel } from "./panel";
import { PANELS } from "./registry";

export function Side({ phone }: { phone: boolean }) {
  const app = useApp();
  const offered = useMemo(() => offeredTabs(PANELS, app, phone), [phone]);
  const items = offered.value.map(({ panels, ...tab }) => ({
    ...tab,
    content: () => panels.map((panel) => <Shown key={`${panel.type} ${panels.indexOf(panel)}`} panel={panel} />),
  }));
  return <Tabs items={[...items, ...externalTabs(app)]} />;
}

function Shown({ panel }: { panel: Panel }) {
  const { store } = useApp();
  return <panel.Card message={store.of(panel.type).value} />;
}
