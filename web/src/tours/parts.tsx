/** Small parts of the editor: fields that hand on what was typed once it is finished, texts by language, problems. */

import { useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect, useId, useRef } from "preact/hooks";
import { shown, t } from "../i18n";
import type { TourProblemReport } from "../protocol/types";
import { useApp } from "../state/context";
import { sentence } from "../ui/format";
import { WarnIcon } from "../ui/icons";
import { type Texts, withText, withWords } from "./tourEdits";
import { problemsAt } from "./tourProblems";
import { numberOf, numberShown, wrongOf } from "./tourRules";

interface FieldProps {
  label: string;
  value: string;
  /** Of the value that it is, as `pace.speed`: what is wrong with it is shown here. */
  path?: string | undefined;
  testid?: string | undefined;
  hint?: string;
  placeholder?: string;
  /** What was typed cannot be a value. */
  wrong?: string;
  /** Several lines. */
  long?: boolean;
  maxLength?: number;
  disabled?: boolean;
  /** Called when it is left or Enter is pressed, if it was changed. */
  onDone: (value: string) => void;
}

/** An edit is what was typed until the field was left: one request to the robot, one step to undo. */
export function TypedField(props: FieldProps) {
  const id = useId();
  const typed = useSignal<string | null>(null);
  const now = useRef(props);
  now.current = props;
  const problems = useProblems(props.path);
  const done = () => {
    const value = typed.peek();
    typed.value = null;
    if (value !== null && value !== now.current.value) now.current.onDone(value);
  };
  // What was typed is not lost with the form.
  useEffect(() => done, []);
  const shared = {
    id,
    "data-testid": props.testid,
    "aria-invalid": isWrong(problems) || !!props.wrong,
    "aria-describedby": `${id}-about`,
    value: typed.value ?? props.value,
    placeholder: props.placeholder,
    maxLength: props.maxLength,
    disabled: props.disabled,
    autocomplete: "off",
    onInput: (event: { currentTarget: { value: string } }) => (typed.value = event.currentTarget.value),
    onBlur: done,
  };
  return (
    <div class={`field ${shared["aria-invalid"] ? "wrong" : ""}`}>
      <label for={id}>{props.label}</label>
      {props.long ? (
        <textarea {...shared} rows={Math.min(8, 2 + Math.floor(shared.value.length / 60))} />
      ) : (
        <input {...shared} onKeyDown={(event) => event.key === "Enter" && done()} />
      )}
      <div id={`${id}-about`} class="field-about">
        {props.hint && <span class="field-hint">{props.hint}</span>}
        {props.wrong && (
          <span class="field-error" role="alert">
            {props.wrong}
          </span>
        )}
        <Problems problems={problems} />
      </div>
    </div>
  );
}

export function NumberField(
  props: Omit<FieldProps, "value" | "onDone" | "wrong"> & {
    value: number | null;
    /** What is shown is so many times the value: 100 for percent. */
    scale?: number;
    /** What may be typed, in the unit that is shown, where the robot would refuse it in another. */
    range?: readonly [least: number, most: number];
    onDone: (value: number | null) => void;
  },
) {
  const { value, scale = 1, range, onDone, ...rest } = props;
  const wrong = useSignal("");
  return (
    <TypedField
      {...rest}
      value={numberShown(value, scale)}
      wrong={wrong.value}
      onDone={(typed) => {
        wrong.value = wrongOf(typed, range);
        if (!wrong.peek()) onDone(numberOf(typed, scale));
      }}
    />
  );
}

/** A number that cannot be left out: without one it stays as it was. */
export function FigureField(
  props: Omit<Parameters<typeof NumberField>[0], "onDone" | "value"> & {
    value: number;
    onDone: (value: number) => void;
  },
) {
  return <NumberField {...props} onDone={(value) => value !== null && props.onDone(value)} />;
}

export function Choice<T extends string>(props: {
  label: string;
  value: T;
  options: readonly (readonly [value: T, words: string])[];
  path?: string;
  testid?: string;
  hint?: string;
  onChange: (value: T) => void;
}) {
  const id = useId();
  const problems = useProblems(props.path);
  return (
    <div class={`field ${isWrong(problems) ? "wrong" : ""}`}>
      <label for={id}>{props.label}</label>
      <select
        id={id}
        data-testid={props.testid}
        aria-invalid={isWrong(problems)}
        aria-describedby={`${id}-about`}
        value={props.value}
        onChange={(event) => props.onChange(event.currentTarget.value as T)}
      >
        {props.options.map(([value, words]) => (
          <option key={value} value={value}>
            {words}
          </option>
        ))}
      </select>
      <div id={`${id}-about`} class="field-about">
        {props.hint && <span class="field-hint">{props.hint}</span>}
        <Problems problems={problems} />
      </div>
    </div>
  );
}

/** Any of a few: buttons that stay pressed. */
export function Several<T extends string>(props: {
  label: string;
  values: readonly T[];
  options: readonly (readonly [value: T, words: string])[];
  /** Shows this many letters of each; the whole word is read aloud. */
  letters?: number;
  path: string;
  testid?: string;
  onChange: (value: T, on: boolean) => void;
}) {
  const id = useId();
  return (
    <div class="field">
      <span class="tour-label" id={id}>
        {props.label}
      </span>
      <div class="tour-several" role="group" aria-labelledby={id}>
        {props.options.map(([value, words]) => {
          const on = props.values.includes(value);
          return (
            <button
              key={value}
              type="button"
              class="button small"
              data-testid={props.testid && `${props.testid}-${value}`}
              aria-pressed={on}
              aria-label={words}
              onClick={() => props.onChange(value, !on)}
            >
              {words.slice(0, props.letters)}
            </button>
          );
        })}
      </div>
      <Problems problems={useProblems(props.path)} />
    </div>
  );
}

/** One field for each language of the tour. */
export function TextFields(props: {
  label: string;
  texts: Texts | null;
  languages: readonly string[];
  path?: string;
  testid?: string;
  long?: boolean;
  onDone: (texts: Texts) => void;
}) {
  const { texts, languages, path } = props;
  return (
    <>
      {languages.map((language) => (
        <TypedField
          key={language}
          label={languages.length > 1 ? `${props.label}, ${languageName(language)}` : props.label}
          value={texts?.[language] ?? ""}
          path={path && `${path}.${language}`}
          testid={props.testid && `${props.testid}-${language}`}
          {...(props.long ? { long: true, maxLength: 2000 } : { maxLength: 100 })}
          onDone={(text) => props.onDone(withText(texts, language, text))}
        />
      ))}
      <Rest path={path} languages={languages} />
    </>
  );
}

/** Words to listen for, by language. */
export function WordFields(props: {
  label: string;
  words: Record<string, string[]>;
  languages: readonly string[];
  path?: string;
  placeholder?: string;
  onDone: (words: Record<string, string[]>) => void;
}) {
  const { languages, path } = props;
  return (
    <>
      {languages.map((language) => (
        <TypedField
          key={language}
          label={languages.length > 1 ? `${props.label}, ${languageName(language)}` : props.label}
          value={(props.words[language] ?? []).join(", ")}
          path={path && `${path}.${language}`}
          placeholder={props.placeholder ?? t("next, go on")}
          onDone={(typed) => props.onDone(withWords(props.words, language, typed))}
        />
      ))}
      <Rest path={path} languages={languages} />
    </>
  );
}

/** What is about a text as a whole, or about a language that has no field. */
function Rest({ path, languages }: { path: string | undefined; languages: readonly string[] }) {
  const { tours } = useApp();
  if (path === undefined) return null;
  const shown = languages.map((language) => `${path}.${language}`);
  return <Problems problems={problemsAt(tours.problems.value, path, shown)} />;
}

/** What is wrong here; nothing where nothing is. */
export function Problems({ problems }: { problems: readonly TourProblemReport[] }) {
  if (problems.length === 0) return null;
  return (
    <ul class="tour-problems">
      {problems.map(({ field, message, severity }) => (
        <li key={`${field} ${message}`} class={severity} data-testid="tour-problem" data-field={field}>
          <WarnIcon />
          <span>
            {severity === "mistake" && <b>{t("Not kept:")} </b>}
            {sentence(message)}
          </span>
        </li>
      ))}
    </ul>
  );
}

/** What is not needed every day, folded; what is wrong at one of `paths`, in it, is shown all the same. */
export function More(props: {
  title: string;
  children: ComponentChildren;
  /** What it says while it is folded. */
  about?: string;
  paths?: readonly string[];
  testid?: string;
}) {
  const { tours } = useApp();
  const problems = (props.paths ?? []).flatMap((path) => problemsAt(tours.problems.value, path));
  const open = useSignal(false);
  return (
    <div class="tour-fold">
      <details
        class="tour-more"
        data-testid={props.testid}
        onToggle={(event) => (open.value = event.currentTarget.open)}
      >
        <summary>
          {props.title}
          {props.about && <span class="tour-about">{props.about}</span>}
        </summary>
        <div class="tour-form">{props.children}</div>
      </details>
      {!open.value && <Problems problems={problems} />}
    </div>
  );
}

/** "English"; of a tag that the browser does not know, the tag. */
export function languageName(tag: string): string {
  try {
    return new Intl.DisplayNames([shown.value.language], { type: "language" }).of(tag) ?? tag;
  } catch {
    return tag;
  }
}

function useProblems(path: string | undefined): TourProblemReport[] {
  const { tours } = useApp();
  return path === undefined ? [] : problemsAt(tours.problems.value, path);
}

/** A warning marks no field: the tour runs all the same. */
function isWrong(problems: readonly TourProblemReport[]): boolean {
  return problems.some(({ severity }) => severity !== "warning");
}
