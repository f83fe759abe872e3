import { describe, expect, test } from "vitest";
import type { DesireClass, JsonSchema } from "../protocol/types";
import { fieldsOf, initialValues, offered, paramsOf, placeErrors, rangeText } from "./schema";

test("only what a strategy serves is offered", () => {
  const kind = (name: string, served: boolean) => ({ name, served }) as DesireClass;
  const all = [kind("SLAM", true), kind("Record", false)];
  expect(offered(all).map(({ name }) => name)).toEqual(["SLAM"]);
});

// As pydantic writes it.
const GOTO: JsonSchema = {
  type: "object",
  title: "GoTo",
  required: ["x", "y", "mode"],
  $defs: { Mode: { type: "string", enum: ["direct", "planned"], title: "Mode" } },
  properties: {
    x: { type: "number", title: "X", description: "Metres in the map.", minimum: -50, maximum: 50 },
    y: { type: "number" },
    theta: {
      anyOf: [{ type: "number", exclusiveMinimum: -3.2, maximum: 3.2 }, { type: "null" }],
      default: null,
      title: "Heading",
    },
    tries: { type: "integer", minimum: 1, default: 3 },
    mode: { $ref: "#/$defs/Mode" },
    quiet: { type: "boolean", default: true },
    label: { type: "string", maxLength: 4, default: "" },
    via: { type: "array", default: [[1, 2]] },
  },
};

const fields = fieldsOf(GOTO);
const field = (name: string) => fields.find((candidate) => candidate.name === name)!;

describe("fields", () => {
  test("each property becomes the field of its kind", () => {
    expect(fields.map((f) => [f.name, f.kind])).toEqual([
      ["x", "number"],
      ["y", "number"],
      ["theta", "number"],
      ["tries", "integer"],
      ["mode", "choice"],
      ["quiet", "boolean"],
      ["label", "string"],
      ["via", "json"],
    ]);
  });

  test("titles, bounds, optional values and defaults are found behind anyOf and $ref", () => {
    expect(field("theta")).toMatchObject({
      title: "Heading",
      required: false,
      maximum: 3.2,
      exclusiveMinimum: -3.2,
      initial: "",
    });
    expect(field("mode")).toMatchObject({ required: true, initial: "direct" });
    expect(field("y").title).toBe("Y");
    expect(initialValues(fields)).toMatchObject({ tries: "3", quiet: "true", via: "[[1,2]]", x: "" });
    expect(rangeText(field("x"))).toBe("from -50 to 50");
    expect(rangeText(field("theta"))).toBe("more than -3.2, to 3.2");
  });

  test("a model without parameters has no fields", () => {
    expect(fieldsOf({ type: "object", properties: {} })).toEqual([]);
    expect(fieldsOf({})).toEqual([]);
  });
});

describe("values", () => {
  const typed = { ...initialValues(fields), x: "1,5", y: "-2" };

  test("what was typed becomes parameters, empty optional ones are left out", () => {
    const { params, errors } = paramsOf(fields, typed);
    expect(errors).toEqual({});
    expect(params).toEqual({ x: 1.5, y: -2, tries: 3, mode: "direct", quiet: true, via: [[1, 2]] });
  });

  test.each([
    ["x", "", "Needed."],
    ["x", "far", "A number is needed."],
    ["x", "51", "At most 50."],
    ["tries", "1.5", "A whole number is needed."],
    ["tries", "0", "At least 1."],
    ["theta", "-3.2", "More than -3.2."],
    ["mode", "sideways", "One of direct, planned."],
    ["label", "too long", "At most 4 characters."],
    ["via", "[1,", 'Not valid JSON, e.g. [1, 2] or {"x": 1}.'],
  ])("%s = %j is refused: %s", (name, text, message) => {
    const { params, errors } = paramsOf(fields, { ...typed, [name]: text });
    expect(errors).toEqual({ [name]: message });
    expect(params).not.toHaveProperty(name);
  });
});

test("a problem's errors are placed at their fields, the rest is kept", () => {
  const { byField, rest } = placeErrors(
    [
      { field: "params.x", message: "too far" },
      { field: "body.intensity", message: "at most 8" },
      { field: "tries", message: "too many" },
      { field: "robot", message: "unknown" },
      { field: "", message: "no" },
    ],
    fields,
  );
  expect(byField).toEqual({ "params.x": "too far", intensity: "at most 8", "params.tries": "too many" });
  expect(rest).toEqual(["robot: unknown", "no"]);
});
