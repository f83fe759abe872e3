/** One field of a form made from a schema, with its words, its range and what is wrong with it. */

import type { ComponentChildren } from "preact";
import { useId } from "preact/hooks";
import { fromRobot, langOf, t } from "../i18n";
import { type Field, rangeText } from "./schema";

interface Wiring {
  id: string;
  name: string;
  "aria-invalid": boolean;
  "aria-describedby": string;
}

interface LabelledProps {
  name: string;
  title: string;
  hint: string;
  error: string | undefined;
  children(props: Wiring): ComponentChildren;
}

export function Labelled({ name, title, hint, error, children }: LabelledProps) {
  const id = useId();
  return (
    <div class={`field ${error ? "wrong" : ""}`}>
      <label for={id}>{title}</label>
      {children({ id, name, "aria-invalid": !!error, "aria-describedby": `${id}-hint` })}
      <p
        id={`${id}-hint`}
        class={error ? "field-error" : "field-hint"}
        data-testid={error ? `error-${name}` : undefined}
      >
        {error ?? hint}
      </p>
    </div>
  );
}

interface FieldProps {
  field: Field;
  value: string;
  error: string | undefined;
  onInput(text: string): void;
}

export function FieldInput({ field, value, error, onInput }: FieldProps) {
  const testid = `field-params.${field.name}`;
  if (field.kind === "boolean") {
    return (
      <label class="check">
        <input
          type="checkbox"
          data-testid={testid}
          checked={value === "true"}
          onChange={(event) => onInput(event.currentTarget.checked ? "true" : "false")}
        />
        <span>
          {field.title}
          {field.description && (
            <span class="field-hint" lang={langOf(field.description)}>
              {fromRobot(field.description)}
            </span>
          )}
        </span>
      </label>
    );
  }
  const hint = [fromRobot(field.description), rangeText(field), field.required ? "" : t("optional")]
    .filter(Boolean)
    .join(" · ");
  return (
    <Labelled name={`params.${field.name}`} title={field.title} hint={hint} error={error}>
      {(props) =>
        field.kind === "choice" ? (
          <select
            {...props}
            data-testid={testid}
            value={value}
            onChange={(event) => onInput(event.currentTarget.value)}
          >
            {!field.required && <option value="">–</option>}
            {field.choices.map(({ label }) => (
              <option key={label} value={label}>
                {label}
              </option>
            ))}
          </select>
        ) : (
          <input
            {...props}
            data-testid={testid}
            autocomplete="off"
            spellcheck={false}
            inputMode={field.kind === "integer" ? "numeric" : field.kind === "number" ? "decimal" : "text"}
            value={value}
            onInput={(event) => onInput(event.currentTarget.value)}
          />
        )
      }
    </Labelled>
  );
}
