/** The fields of one thing that a step does. */

import { fieldsOf, initialValues, paramsOf } from "../desires/schema";
import { named, t } from "../i18n";
import type { Media, Step, Wait } from "../protocol/types";
import { useApp } from "../state/context";
import { spaced } from "../ui/format";
import { TargetIcon } from "../ui/icons";
import { MediaFields } from "./MediaFields";
import { Choice, More, NumberField, Problems, TextFields, TypedField, WordFields } from "./parts";
import type { Part } from "./tourEdits";
import type { PointTarget } from "./tourPath";
import { problemsAt } from "./tourProblems";

const EXPRESSIONS = ["happy", "attractive", "sad", "angry", "calm"] as const;
/** At about the height of what visitors look at. */
export const HEIGHT_M = 1.2;

interface Props {
  part: Part;
  step: Step;
  /** Of the step, as `stops.2.do.0`. */
  path: string;
  languages: readonly string[];
  onChange: (change: Partial<Step>) => void;
}

/** The fields of what the step does, and all that is wrong with it. */
export function PartFields({ part, step, path, languages, onChange }: Props) {
  const here = `${path}.${part}`;
  switch (part) {
    case "say":
      return (
        <TextFields
          label={t("Say")}
          long
          texts={step.say}
          languages={languages}
          path={here}
          testid="step-say"
          onDone={(say) => onChange({ say: Object.keys(say).length > 0 ? say : null })}
        />
      );
    case "look":
      return <LookFields look={step.look!} path={path} onChange={onChange} />;
    case "point":
      return (
        <PointFields
          label={t("Point at")}
          point={step.point!}
          target={{ path, part: "point" }}
          onDone={(point) => onChange({ point })}
        />
      );
    case "show":
      return <ShowFields show={step.show!} path={here} languages={languages} onDone={(show) => onChange({ show })} />;
    case "gesture":
      return <GestureFields gesture={step.gesture!} path={here} onDone={(gesture) => onChange({ gesture })} />;
    case "expression":
      return (
        <Choice
          label={t("Face")}
          value={step.expression!}
          path={here}
          options={[...new Set([...EXPRESSIONS, step.expression!])].map((one) => [one, named(one)] as const)}
          onChange={(expression) => onChange({ expression })}
        />
      );
    case "wait":
      return <WaitFields wait={step.wait!} path={here} languages={languages} onDone={(wait) => onChange({ wait })} />;
  }
}

type Point = [number, number, number];

function LookFields({
  look,
  path,
  onChange,
}: {
  look: NonNullable<Step["look"]>;
  path: string;
  onChange: Props["onChange"];
}) {
  const { map } = useApp();
  const point = Array.isArray(look) ? look : null;
  return (
    <>
      <Choice
        label={t("Look at")}
        value={point ? "point" : (look as "visitors" | "poster")}
        {...(point ? {} : { path: `${path}.look` })}
        options={[
          ["visitors", t("the visitors")],
          ["poster", t("the poster")],
          ["point", t("a point")],
        ]}
        onChange={(to) => {
          const robot = map.robot.peek();
          onChange({ look: to === "point" ? [robot?.x ?? 0, robot?.y ?? 0, HEIGHT_M] : to });
        }}
      />
      {point && (
        <PointFields
          label={t("Point")}
          point={point}
          target={{ path, part: "look" }}
          onDone={(to) => onChange({ look: to })}
        />
      )}
    </>
  );
}

function PointFields(props: { label: string; point: Point; target: PointTarget; onDone: (point: Point) => void }) {
  const { tourPointing, tours } = useApp();
  const { point, target } = props;
  const whole = `${target.path}.${target.part}`;
  const chosen = tourPointing.isFor(target);
  const set = (at: number) => (value: number | null) => {
    if (value !== null) props.onDone(point.with(at, value) as Point);
  };
  return (
    <div class="tour-point">
      {(["x", "y", "z"] as const).map((axis, at) => (
        <NumberField
          key={axis}
          label={at === 0 ? `${props.label}: x` : axis === "z" ? t("height") : axis}
          value={point[at]!}
          path={`${target.path}.${target.part}.${at}`}
          testid={`step-${target.part}-${axis}`}
          onDone={set(at)}
        />
      ))}
      <button
        type="button"
        class={`button small ${chosen ? "on" : ""}`}
        data-testid={`step-${target.part}-pick`}
        aria-pressed={chosen}
        title={t("Click where it is: on the map, in the 3D view, or in the camera's picture")}
        onClick={() => tourPointing.choose(chosen ? null : target)}
      >
        <TargetIcon /> {chosen ? t("Click on the point…") : t("By a click")}
      </button>
      <Problems
        problems={problemsAt(
          tours.problems.value,
          whole,
          [0, 1, 2].map((at) => `${whole}.${at}`),
        )}
      />
    </div>
  );
}

function ShowFields({
  show,
  path,
  languages,
  onDone,
}: {
  show: Media;
  path: string;
  languages: readonly string[];
  onDone: (show: Media) => void;
}) {
  return (
    <>
      <MediaFields file={show.file} onDone={(file) => onDone({ ...show, file })} />
      <TypedField
        label={t("Picture or video")}
        value={show.file}
        path={`${path}.file`}
        hint={t("A file in the folder of tours, as media/arm.jpg.")}
        onDone={(file) => onDone({ ...show, file: file.trim() })}
      />
      <TextFields
        label={t("What it shows, in words")}
        path={`${path}.alt`}
        texts={show.alt}
        languages={languages}
        onDone={(alt) => onDone({ ...show, alt })}
      />
    </>
  );
}

/** A class of desires of this program that ends by itself, with its parameters. */
function GestureFields({
  gesture,
  path,
  onDone,
}: {
  path: string;
  gesture: NonNullable<Step["gesture"]>;
  onDone: (gesture: NonNullable<Step["gesture"]>) => void;
}) {
  const { store, tours } = useApp();
  const classes = (store.hello.value?.classes ?? []).filter(({ name, served }) => served && !OTHERS.has(name));
  const names = [...new Set([gesture.class, ...classes.map(({ name }) => name)])];
  const kind = classes.find(({ name }) => name === gesture.class);
  const fields = kind ? fieldsOf(kind.schema) : [];
  const values = initialValues(fields);
  return (
    <>
      <Choice
        label={t("Gesture")}
        value={gesture.class}
        options={names.map((name) => [name, spaced(name)] as const)}
        onChange={(name) => onDone({ class: name, params: {} })}
      />
      {fields.length > 0 && (
        <More title={t("How exactly")} paths={[`${path}.params`]}>
          {fields.map((field) => (
            <TypedField
              key={`${gesture.class}.${field.name}`}
              label={field.title}
              path={`${path}.params.${field.name}`}
              value={String(gesture.params[field.name] ?? "")}
              placeholder={values[field.name] ?? ""}
              onDone={(typed) => {
                const { [field.name]: _, ...rest } = gesture.params;
                if (typed.trim() === "") return onDone({ ...gesture, params: rest });
                // What is no such value is handed on as it was typed: the robot says what is wrong with it.
                const read = paramsOf([field], { [field.name]: typed }).params[field.name] as string | number | boolean;
                onDone({ ...gesture, params: { ...rest, [field.name]: read ?? typed } });
              }}
            />
          ))}
        </More>
      )}
      <Problems
        problems={problemsAt(
          tours.problems.value,
          path,
          fields.map(({ name }) => `${path}.params.${name}`),
        )}
      />
    </>
  );
}

/** What has a form of its own here, or is the guide's. */
const OTHERS: ReadonlySet<string> = new Set(["Say", "Ask", "LookAt", "PointAt", "Express", "GoTo", "SLAM", "Record"]);

function WaitFields({
  wait,
  path,
  languages,
  onDone,
}: {
  wait: Wait;
  path: string;
  languages: readonly string[];
  onDone: (wait: Wait) => void;
}) {
  const { tours } = useApp();
  return (
    <>
      <NumberField
        label={t("Wait at most (s)")}
        value={wait.at_most_s}
        path={`${path}.at_most_s`}
        testid="step-wait"
        onDone={(at_most_s) => at_most_s !== null && onDone({ ...wait, at_most_s })}
      />
      <WordFields
        label={t("Until one of these words")}
        words={wait.words}
        path={`${path}.words`}
        languages={languages}
        onDone={(words) => onDone({ ...wait, words })}
      />
      <TextFields
        label={t("Until a press on the button")}
        texts={wait.press}
        path={`${path}.press`}
        languages={languages}
        onDone={(press) => onDone({ ...wait, press: Object.keys(press).length > 0 ? press : null })}
      />
      <NumberField
        label={t("Until so many claps")}
        value={wait.claps}
        path={`${path}.claps`}
        onDone={(claps) => onDone({ ...wait, claps })}
      />
      <label class="check">
        <input
          type="checkbox"
          checked={wait.call}
          onChange={(event) => onDone({ ...wait, call: event.currentTarget.checked })}
        />
        <span>{t("Until somebody calls out")}</span>
      </label>
      <label class="check">
        <input
          type="checkbox"
          checked={wait.all_left}
          onChange={(event) => onDone({ ...wait, all_left: event.currentTarget.checked })}
        />
        <span>{t("Until all visitors have left")}</span>
      </label>
      <Problems
        problems={problemsAt(
          tours.problems.value,
          path,
          ["at_most_s", "words", "press", "claps"].map((name) => `${path}.${name}`),
        )}
      />
    </>
  );
}
