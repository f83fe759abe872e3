import { afterEach, expect, test } from "vitest";
import { fr, robot } from "./fr";
import { chooseLanguage, languageOf, startLanguage } from "./language";
import { fromRobot, langOf, named } from "./robot";
import { decimals, plural, rich, shown, t } from "./text";

const ENGLISH = shown.peek();
afterEach(() => {
  shown.value = ENGLISH;
});

function french(): void {
  shown.value = { language: "fr", tag: "fr-CA", catalogue: fr, robot };
}

/** A browser whose reader reads `reads`, with an empty storage. */
function reader(...reads: string[]) {
  const kept = new Map<string, string>();
  const storage = {
    getItem: (key: string) => kept.get(key) ?? null,
    setItem: (k: string, v: string) => void kept.set(k, v),
  };
  return { root: { lang: "" } as HTMLElement, storage, reads };
}

test.each([
  [null, ["fr-CA", "en"], "fr"],
  [null, ["en-GB", "fr"], "en"],
  [null, ["de", "fr-FR"], "fr"],
  [null, ["de"], "en"],
  [null, [], "en"],
  ["en", ["fr"], "en"],
  ["fr", ["en"], "fr"],
  ["xx", ["fr"], "fr"],
] as const)("of the kept choice %j and a reader of %j the page speaks %s", (kept, reads, language) => {
  expect(languageOf(kept, reads)).toBe(language);
});

test("the browser's language is shown, and the choice of another kept", async () => {
  const here = reader("fr-CA", "en");
  await startLanguage(here);
  expect([here.root.lang, t("Emergency stop"), shown.value.tag]).toEqual(["fr", "Arrêt d’urgence", "fr-CA"]);
  expect(here.storage.getItem("hbba.language")).toBeNull();
  await chooseLanguage("en", here);
  expect([here.root.lang, t("Emergency stop")]).toEqual(["en", "Emergency stop"]);
  await startLanguage(here);
  expect(here.root.lang).toBe("en");
});

test("values stand in their places, figures with the language's sign", () => {
  expect(t("{metres} m away, {where}", { metres: 2.5, where: "behind" })).toBe("2.5 m away, behind");
  french();
  expect(t("{metres} m away, {where}", { metres: 2.5, where: "derrière" })).toBe("à 2,5 m, derrière");
  expect(decimals("0.10")).toBe("0,10");
});

test("plurals follow the language: none is singular in French", () => {
  const stops = (count: number) => plural(count, "{count} stop", "{count} stops");
  expect([0, 1, 2].map(stops)).toEqual(["0 stops", "1 stop", "2 stops"]);
  french();
  expect([0, 1, 2].map(stops)).toEqual(["0 halte", "1 halte", "2 haltes"]);
});

test("what a word is in this place is not shown", () => {
  expect(t("Drive|preset")).toBe("Drive");
  french();
  expect(t("Drive|preset")).toBe("Conduite");
});

test("elements stand in a sentence", () => {
  expect(rich("in {folder}", { folder: "here" })).toEqual(["in ", "here", ""]);
});

test("names and sentences of the program are translated, with what is in them", () => {
  const text = "fulfilled at 4 of 8 by locate-near-faces-1; would get 8 with 28.8 % more cpu";
  expect([named("Locate faces"), fromRobot(text), langOf(text)]).toEqual(["Locate faces", text, undefined]);
  french();
  expect(named("Locate faces")).toBe("Localiser les visages");
  expect(fromRobot(text)).toBe(
    "satisfait à 4 sur 8 par locate-near-faces-1\u202f; aurait 8 avec 28,8 % de plus de CPU",
  );
  expect(langOf(text)).toBeUndefined();
  expect(fromRobot(text.replace("with 28.8", "with at most 62"))).toBe(
    "satisfait à 4 sur 8 par locate-near-faces-1\u202f; aurait 8 avec au plus 62 % de plus de CPU",
  );
  expect(fromRobot("motivation ScenarioCoordinator desires LocateFaces (intensity 8, utility 1)")).toBe(
    "la motivation Coordinateur du scénario désire Localiser les visages (intensité 8, utilité 1)",
  );
});

test("what no pattern knows stays English, and says so", () => {
  french();
  expect(fromRobot("the flux capacitor is cold")).toBe("the flux capacitor is cold");
  expect(langOf("the flux capacitor is cold")).toBe("en");
  expect(langOf("")).toBeUndefined();
});

test("a sentence of the program keeps its places", () => {
  const places = (text: string) => [...text.matchAll(/\{(\w+)\}/g)].map(([, name]) => name).sort();
  const differ = Object.entries(robot.sentences).filter(([en, into]) => `${places(en)}` !== `${places(into)}`);
  expect(differ).toEqual([]);
});

test("a refusal is translated as a sentence by itself, and what it says within it", () => {
  french();
  expect(fromRobot("There is a map called lab already; delete it first, or choose another name.")).toBe(
    "Il y a déjà une carte appelée lab\u202f; supprimez-la d’abord, ou choisissez un autre nom.",
  );
  expect(fromRobot("Nothing can be saved: the ring holds nothing yet.")).toBe(
    "Rien ne peut être gardé\u202f: la boucle ne contient encore rien.",
  );
  expect(fromRobot("The body has reported nothing for 1.1 s.")).toBe("Le corps n’a rien signalé depuis 1,1 s.");
  expect(fromRobot("Commands arrive up to 0.5 s late: driving waits.")).toBe(
    "Les commandes arrivent avec jusqu’à 0,5 s de retard\u202f: la conduite attend.",
  );
  expect(fromRobot("slowed: something 0.6 m to the left")).toBe("ralenti\u202f: quelque chose à 0,6 m à gauche");
  expect(langOf("There is nothing like it.")).toBe("en");
});
