/** Numbers, ages and divisors in words for people. */

import { decimals, fromRobot, named, shown, spaceBetween, t, within } from "../i18n";

export function ago(seconds: number): string {
  const s = Math.max(0, seconds);
  if (s < 1.5) return t("just now");
  if (s < 90) return t("{count} s ago", { count: Math.round(s) });
  if (s < 5400) return t("{count} min ago", { count: Math.round(s / 60) });
  if (s < 129_600) return t("{count} h ago", { count: Math.round(s / 3600) });
  return t("{count} d ago", { count: Math.round(s / 86_400) });
}

export function left(seconds: number): string {
  const s = Math.max(0, seconds);
  if (s < 90) return t("{count} s left", { count: Math.ceil(s) });
  if (s < 5400) return t("{count} min left", { count: Math.round(s / 60) });
  return t("{count} h left", { count: Math.round(s / 3600) });
}

/** "all", "1 of 2", "closed". */
export function divisor(phi: number | null | undefined): string {
  if (phi === null || phi === undefined) return t("closed");
  return phi === 1 ? t("all") : t("1 of {phi}", { phi });
}

/** What each of several filters lets through, a line each; empty for a single one, which is shown elsewhere. */
export function divisorLines(divisors: Readonly<Record<string, number | null>>): string[] {
  const filters = Object.entries(divisors);
  return filters.length < 2 ? [] : filters.map(([name, phi]) => `${name} ${divisor(phi)}`);
}

export function millis(ms: number | null | undefined): string {
  if (ms === null || ms === undefined || !Number.isFinite(ms)) return "–";
  if (ms < 9.95) return decimals(ms.toFixed(1));
  if (ms < 10_000) return Math.round(ms).toString();
  return `${Math.round(ms / 1000)} s`;
}

export function number(value: number | null | undefined, digits = 1): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  return decimals(Number(value.toFixed(digits)).toString()).replace("-", "−");
}

/** One decimal where needed; what is too little for that is not nothing. */
export function small(value: number): string {
  return value > 0 && value < 0.05 ? `< ${decimals("0.1")}` : number(value);
}

export function percent(share: number | null | undefined): string {
  return share === null || share === undefined ? "–" : t("{share} %", { share: Math.round(share * 100) });
}

/** FindQRCodes → Find QR codes, in the reader's language where that has a name for it. */
export function spaced(name: string): string {
  return named(spaceBetween(name));
}

/** What people call a module, by its name in the program. */
export function moduleTitle(name: string, modules: readonly { name: string; title: string }[]): string {
  const title = modules.find((module) => module.name === name)?.title;
  return title ? named(title) : spaced(name);
}

/** Telepresence: see through the robot's eyes. The name as everywhere on the page, then what the class says it is. */
export function nameAndTitle(kind: { name: string; title: string }): string {
  const name = spaced(kind.name);
  const own = named(kind.title);
  if (own === "" || own.toLowerCase() === name.toLowerCase()) return name;
  const title = /^\p{Lu}[\p{Ll} ]/u.test(own) ? within(own) : own;
  return t("{what}: {which}", { what: name, which: title });
}

/** A state in words. `degraded` still has all the utility that was wanted, which is no fault to shout about. */
export function stateWord(state: string): string {
  return state === "degraded" ? t("fulfilled, below its best") : named(state);
}

/** A reason without the state it begins with, for where the state stands beside it. */
export function reasonText(state: string, text: string): string {
  const own = text.startsWith(`${state}: `) ? text.slice(state.length + 2) : text;
  const rest = fromRobot(own);
  return (rest.charAt(0).toUpperCase() + rest.slice(1)).replace(/\bcpu\b/g, "CPU");
}

/** Bytes as people count them: 34 MB. */
export function size(bytes: number | null | undefined): string {
  if (bytes === null || bytes === undefined || !Number.isFinite(bytes)) return "–";
  let [value, unit] = [bytes, 0];
  while (value >= 999.5 && unit < 4) [value, unit] = [value / 1000, unit + 1];
  return `${number(value, unit === 0 || value >= 99.5 ? 0 : value >= 9.95 ? (unit > 2 ? 1 : 0) : 1)} ${named(["B", "kB", "MB", "GB", "TB"][unit]!)}`;
}

/** 1:02, or 1:02:03; with `digits` of a second. */
export function clockSpan(seconds: number, digits = 0): string {
  const whole = Math.max(0, Math.floor(seconds * 10 ** digits + 1e-6) / 10 ** digits);
  const [h, m] = [Math.floor(whole / 3600), Math.floor((whole % 3600) / 60)];
  const s = decimals((whole % 60).toFixed(digits)).padStart(digits > 0 ? 3 + digits : 2, "0");
  return h > 0 ? `${h}:${String(m).padStart(2, "0")}:${s}` : `${m}:${s}`;
}

/** Day and time of day where the reader is. */
export function dayTime(stamp: number): string {
  return new Date(stamp * 1000).toLocaleString(shown.value.tag, {
    dateStyle: "medium",
    timeStyle: "short",
    hourCycle: "h23",
  });
}

/** As a sentence of its own: with a capital and a full stop. */
export function sentence(text: string): string {
  const trimmed = fromRobot(text.trim()).replace(/[.\s]+$/, "");
  return trimmed && `${trimmed.charAt(0).toUpperCase()}${trimmed.slice(1)}.`;
}

export function clockTime(stamp: number): string {
  return new Date(stamp * 1000).toLocaleTimeString(shown.value.language, { timeStyle: "medium", hourCycle: "h23" });
}
