import { parseSync } from "vite";
import { expect, test } from "vitest";
import { fr, robot } from "./fr";
import type { Catalogue } from "./text";

const CATALOGUE: Catalogue = fr;
const SOURCES: Record<string, string> = import.meta.glob("../**/*.{ts,tsx}", {
  query: "?raw",
  import: "default",
  eager: true,
});
/** Pages of their own: the face, the visitors' page with its four languages, the one on REST; and generated types. */
const OTHERS = /\.test\.ts$|\.fixture\.ts$|\.d\.ts$|^\.\.\/(face|visitor|rest)\/|^\.\/fr\/|generated\.ts$/;
/** What people read of an element beside its children. */
const SHOWN = /^(title|alt|placeholder|label|hint|about|words|yes|no|zero|aria-(label|description|valuetext))$/;
/** Neither words nor names of a language: what is typed into a field, brands. */
const NO_WORDS = new Set(["HBBA", "ground-floor", "HBBA:SAY/EN/MIND THE STEP.", "HBBA:STOP/ "]);
/** So many letters in a row make a word; units are shorter. */
const WORD = /[A-Za-z]{3}/;

interface Node {
  type: string;
  [key: string]: unknown;
}
interface Found {
  where: string;
  text: string;
}

function* within(node: Node, parents: readonly Node[] = []): Generator<[Node, readonly Node[]]> {
  yield [node, parents];
  for (const value of Object.values(node))
    for (const child of Array.isArray(value) ? value : [value])
      if (child && typeof child === "object" && "type" in child) yield* within(child as Node, [...parents, node]);
}

const trees = Object.entries(SOURCES)
  .filter(([file]) => !OTHERS.test(file))
  .map(([file, source]) => [file, source, parseSync(file, source).program as unknown as Node] as const);

/** The texts that `expression` may be: itself, or either of a choice. */
function literals(expression: Node | undefined): string[] {
  if (expression?.type === "Literal") return [String(expression["value"])];
  if (expression?.type !== "ConditionalExpression") return [];
  return [expression["consequent"], expression["alternate"]].flatMap((each) => literals(each as Node));
}

/** What is handed to `t`, `rich` and `plural` as it stands. */
function called(): Found[] {
  return trees.flatMap(([where, , tree]) =>
    [...within(tree)].flatMap(([node]) => {
      const name = (node["callee"] as Node | undefined)?.["name"];
      if (node.type !== "CallExpression" || (name !== "t" && name !== "rich" && name !== "plural")) return [];
      const given = (node["arguments"] as Node[])[name === "plural" ? 2 : 0];
      return literals(given).map((text) => ({ where, text }));
    }),
  );
}

/** Every string of the sources: tables hand theirs on by their names. */
function strings(): Set<string> {
  const all = trees.flatMap(([, , tree]) => [...within(tree)].map(([node]) => node));
  return new Set(all.filter(({ type }) => type === "Literal").map(({ value }) => String(value)));
}

function forms(text: string): string[] {
  const entry = CATALOGUE[text];
  return typeof entry === "string" ? [entry] : Object.values(entry ?? {});
}

const places = (text: string) => new Set([...text.matchAll(/\{(\w+)\}/g)].map(([, name]) => name));

test("every text that the page says has its French", () => {
  const texts = called();
  expect(texts.length).toBeGreaterThan(900);
  expect(texts.filter(({ text }) => !(text in CATALOGUE))).toEqual([]);
});

test("no French is left over", () => {
  const used = strings();
  expect(Object.keys(CATALOGUE).filter((text) => !used.has(text))).toEqual([]);
});

test("a text has the same places for values in both languages", () => {
  const differ = Object.keys(CATALOGUE).filter((text) =>
    forms(text).some((form) => {
      const [here, there] = [places(text), places(form)];
      // "une fois" needs no figure.
      const fewer = CATALOGUE[text] !== form && form !== forms(text).at(-1);
      return (
        [...here].some((name) => !there.has(name) && !(fewer && name === "count")) ||
        [...there].some((name) => !here.has(name))
      );
    }),
  );
  expect(differ).toEqual([]);
});

test("French has its spaces and its apostrophes", () => {
  const wrong = Object.keys(CATALOGUE)
    .flatMap(forms)
    .concat(Object.values(robot.names), Object.values(robot.sentences), Object.values(robot.rules))
    .filter((text) => / [:;!?%»]|« |\w'\w|\w[;!?»]/.test(text));
  expect(wrong).toEqual([]);
});

test("what is said of an element, and in it, comes from the catalogue", () => {
  const bare = trees.flatMap(([where, source, tree]) =>
    [...within(tree)].flatMap(([node, parents]) => {
      if (node.type === "JSXText") {
        const text = String(node["value"]).trim();
        return WORD.test(text) && !NO_WORDS.has(text) ? [{ where, text }] : [];
      }
      const said =
        node.type === "Literal" ? String(node["value"]) : node.type === "TemplateLiteral" ? written(node) : "";
      if (!WORD.test(said) || NO_WORDS.has(said) || !isShown(node, parents)) return [];
      return [{ where, text: source.slice(Number(node["start"]), Number(node["end"])) }];
    }),
  );
  expect(bare).toEqual([]);
});

/** The words of a template beside its values. */
function written(template: Node): string {
  return (template["quasis"] as Node[]).map((part) => (part["value"] as { cooked: string }).cooked).join(" ");
}

/** Whether a string is what an attribute or a child of an element says: as it stands, chosen by a condition, or joined. */
function isShown(node: Node, parents: readonly Node[]): boolean {
  let inner = node;
  for (const outer of parents.toReversed()) {
    if (outer.type === "JSXAttribute") {
      const name = (outer["name"] as Node)["name"];
      return typeof name === "string" && SHOWN.test(name);
    }
    if (outer.type === "CallExpression" || outer.type === "BinaryExpression") return false;
    if (outer.type === "JSXExpressionContainer") {
      inner = outer;
      continue;
    }
    if (outer.type === "JSXElement" || outer.type === "JSXFragment") return true;
    const passes =
      (outer.type === "ConditionalExpression" && outer["test"] !== inner) ||
      (outer.type === "LogicalExpression" && outer["right"] === inner) ||
      (outer.type === "TemplateLiteral" && inner.type !== "Literal");
    if (!passes) return false;
    inner = outer;
  }
  return false;
}
