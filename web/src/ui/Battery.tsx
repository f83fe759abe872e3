/** The battery in the top bar; nothing for a body without one. */

import { t } from "../i18n";
import { useApp } from "../state/context";
import { batteryWords } from "./batteryText";
import { BatteryIcon } from "./icons";

export function Battery() {
  const { store } = useApp();
  const battery = store.of("battery").value;
  if (battery === null) return null;
  const words = batteryWords(battery);
  return (
    <div class={`metric battery ${words.tone}`} title={words.hint}>
      <dt>{t("Battery")}</dt>
      <dd data-testid="battery" data-tone={words.tone} data-charging={battery.charging}>
        <BatteryIcon charge={battery.charge} charging={battery.charging} />
        {words.charge}
        {words.left && <span class="unit"> {words.left}</span>}
      </dd>
    </div>
  );
}
