/** Resources that attention shares out, in words. Pure. */

import { type Text, t } from "../i18n";
import { spaced } from "../ui/format";

/** The lab's resources in words: the meter's label, and the unit of a strategy's cost. Others go by their names. */
const RESOURCES: Record<string, { label: Text; unit: Text }> = {
  cpu: { label: "CPU promised", unit: "% CPU" },
  recording: { label: "CPU for recording", unit: "% CPU to record" },
  power: { label: "Power promised", unit: "W" },
};

export function resourceLabel(name: string): string {
  const [what, node] = name.split("@");
  if (node && what === "cpu") return t("CPU of {node}", { node });
  if (node && what === "bandwidth") return t("Link to {node}", { node });
  return RESOURCES[name] ? t(RESOURCES[name].label) : capital(spaced(name));
}

/** Of what a strategy costs. */
export function resourceUnit(name: string): string {
  return RESOURCES[name] ? t(RESOURCES[name].unit) : name;
}

function capital(words: string): string {
  return words.charAt(0).toUpperCase() + words.slice(1);
}
