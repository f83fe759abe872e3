/** From a parameter model's JSON Schema to form fields, and from what was typed back to parameters. Pure. */

import { named, t } from "../i18n";
import type { DesireClass, JsonSchema } from "../protocol/types";

export type FieldKind = "number" | "integer" | "boolean" | "string" | "choice" | "json";

export interface Field {
  name: string;
  title: string;
  description: string;
  kind: FieldKind;
  required: boolean;
  /** Text as typed; booleans are "true" or "false". */
  initial: string;
  minimum?: number;
  maximum?: number;
  exclusiveMinimum?: number;
  exclusiveMaximum?: number;
  minLength?: number;
  maxLength?: number;
  pattern?: string;
  choices: { label: string; value: unknown }[];
}

export type Values = Readonly<Record<string, string>>;
export type Errors = Record<string, string>;

export function fieldsOf(schema: JsonSchema): Field[] {
  const required = new Set(schema.required ?? []);
  return Object.entries(schema.properties ?? {}).map(([name, property]) =>
    fieldOf(name, property, schema, required.has(name)),
  );
}

export function initialValues(fields: readonly Field[]): Values {
  return Object.fromEntries(fields.map((field) => [field.name, field.initial]));
}

/** The parameters typed, leaving out optional fields left empty; or what is wrong, by field. */
export function paramsOf(
  fields: readonly Field[],
  values: Values,
): { params: Record<string, unknown>; errors: Errors } {
  const params: Record<string, unknown> = {};
  const errors: Errors = {};
  for (const field of fields) {
    const text = values[field.name] ?? "";
    if (text.trim() === "" && field.kind !== "boolean") {
      if (field.required) errors[field.name] = t("Needed.");
      continue;
    }
    const read = readValue(field, text);
    if ("error" in read) errors[field.name] = read.error;
    else params[field.name] = read.value;
  }
  return { params, errors };
}

function fieldOf(name: string, property: JsonSchema, root: JsonSchema, required: boolean): Field {
  const schema = resolve(property, root);
  const choices = choicesOf(schema);
  const kind = choices.length > 0 ? "choice" : kindOf(schema);
  const field: Field = {
    name,
    title: named(property.title ?? schema.title ?? titled(name)),
    description: property.description ?? schema.description ?? "",
    kind,
    required,
    initial: initialText(property.default ?? schema.default, kind, choices, required),
    choices,
  };
  const bounds = ["minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum", "minLength", "maxLength"] as const;
  for (const bound of bounds) if (typeof schema[bound] === "number") field[bound] = schema[bound];
  if (schema.pattern) field.pattern = schema.pattern;
  return field;
}

/** Follows `$ref` and `allOf`, and takes the first branch that is not null of `anyOf` (how optional values are written). */
function resolve(schema: JsonSchema, root: JsonSchema, depth = 0): JsonSchema {
  if (depth > 8) return schema;
  if (schema.$ref) {
    const found = root.$defs?.[schema.$ref.split("/").at(-1) ?? ""];
    return found ? { ...resolve(found, root, depth + 1), ...without(schema, "$ref") } : schema;
  }
  if (schema.allOf?.length === 1) return { ...resolve(schema.allOf[0]!, root, depth + 1), ...without(schema, "allOf") };
  const branches = schema.anyOf?.filter((branch) => branch.type !== "null");
  if (branches?.length === 1) return { ...resolve(branches[0]!, root, depth + 1), ...without(schema, "anyOf") };
  return schema;
}

function without(schema: JsonSchema, key: keyof JsonSchema): JsonSchema {
  const { [key]: _, ...rest } = schema;
  return rest;
}

function choicesOf(schema: JsonSchema): Field["choices"] {
  const values = schema.enum ?? (schema.const !== undefined ? [schema.const] : []);
  return values.filter((value) => value !== null).map((value) => ({ label: String(value), value }));
}

function kindOf(schema: JsonSchema): FieldKind {
  const type = Array.isArray(schema.type) ? schema.type.find((candidate) => candidate !== "null") : schema.type;
  if (type === "number" || type === "integer" || type === "boolean" || type === "string") return type;
  return "json";
}

function initialText(value: unknown, kind: FieldKind, choices: Field["choices"], required: boolean): string {
  if (kind === "boolean") return value === true ? "true" : "false";
  if (value === undefined || value === null) return kind === "choice" && required ? (choices[0]?.label ?? "") : "";
  if (kind === "json") return JSON.stringify(value);
  return String(value);
}

function readValue(field: Field, text: string): { value: unknown } | { error: string } {
  switch (field.kind) {
    case "boolean":
      return { value: text === "true" };
    case "choice": {
      const choice = field.choices.find(({ label }) => label === text);
      return choice
        ? { value: choice.value }
        : { error: t("One of {choices}.", { choices: field.choices.map((c) => c.label).join(", ") }) };
    }
    case "json":
      try {
        return { value: JSON.parse(text) as unknown };
      } catch {
        return { error: t("Not valid JSON, e.g. {one} or {other}.", { one: "[1, 2]", other: '{"x": 1}' }) };
      }
    case "string":
      return checkText(field, text);
    default:
      return checkNumber(field, text);
  }
}

function checkText(field: Field, text: string): { value: unknown } | { error: string } {
  if (field.minLength !== undefined && text.length < field.minLength)
    return { error: t("At least {minLength} characters.", { minLength: field.minLength }) };
  if (field.maxLength !== undefined && text.length > field.maxLength)
    return { error: t("At most {maxLength} characters.", { maxLength: field.maxLength }) };
  return { value: text };
}

function checkNumber(field: Field, text: string): { value: unknown } | { error: string } {
  const value = Number(text.replace(",", ".").replace("−", "-"));
  if (!Number.isFinite(value)) return { error: t("A number is needed.") };
  if (field.kind === "integer" && !Number.isInteger(value)) return { error: t("A whole number is needed.") };
  const { minimum, maximum, exclusiveMinimum, exclusiveMaximum } = field;
  if (minimum !== undefined && value < minimum) return { error: t("At least {minimum}.", { minimum }) };
  if (maximum !== undefined && value > maximum) return { error: t("At most {maximum}.", { maximum }) };
  if (exclusiveMinimum !== undefined && value <= exclusiveMinimum)
    return { error: t("More than {exclusiveMinimum}.", { exclusiveMinimum }) };
  if (exclusiveMaximum !== undefined && value >= exclusiveMaximum)
    return { error: t("Less than {exclusiveMaximum}.", { exclusiveMaximum }) };
  return { value };
}

function titled(name: string): string {
  const words = name.replace(/_/g, " ");
  return words.charAt(0).toUpperCase() + words.slice(1);
}

/** "−1 to 5", "more than 0"; empty if anything goes. */
export function rangeText(field: Field): string {
  const low =
    field.minimum !== undefined
      ? t("from {minimum}", { minimum: field.minimum })
      : field.exclusiveMinimum !== undefined
        ? t("more than {exclusiveMinimum}", { exclusiveMinimum: field.exclusiveMinimum })
        : "";
  const high =
    field.maximum !== undefined
      ? t("to {maximum}", { maximum: field.maximum })
      : field.exclusiveMaximum !== undefined
        ? t("less than {exclusiveMaximum}", { exclusiveMaximum: field.exclusiveMaximum })
        : "";
  const both = field.minimum !== undefined && field.maximum !== undefined;
  return [low, high].filter(Boolean).join(both ? " " : ", ");
}

/** The classes that a desire can come true of. */
export function offered(classes: readonly DesireClass[]): DesireClass[] {
  return classes.filter(({ served }) => served);
}

/** Sorts a problem's field errors onto the form: `body.params.x` and `params.x` are field `x` of the parameters. */
export function placeErrors(
  errors: readonly { field: string; message: string }[],
  fields: readonly Field[],
): { byField: Errors; rest: string[] } {
  const known = new Set([
    "class",
    "intensity",
    "utility",
    "security",
    "ttl",
    ...fields.map((field) => `params.${field.name}`),
  ]);
  const byField: Errors = {};
  const rest: string[] = [];
  for (const { field, message } of errors) {
    const path = String(field ?? "")
      .replace(/^body[./]/, "")
      .replace(/\//g, ".")
      .replace(/^\./, "");
    const place = [path, `params.${path}`].find((candidate) => known.has(candidate));
    if (place) byField[place] = message;
    else rest.push(path ? `${path}: ${message}` : message);
  }
  return { byField, rest };
}
