/** A bar with its limit marked. */

interface Props {
  label: string;
  value: number;
  limit: number;
  text: string;
  /** The value at full width; the limit unless it is exceeded. */
  full?: number;
}

export function Meter({ label, value, limit, text, full }: Props) {
  const whole = Math.max(full ?? limit, 1e-9);
  const over = value > limit * 1.001;
  return (
    <div
      class={`meter ${over ? "over" : ""}`}
      role="meter"
      aria-label={label}
      aria-valuenow={Math.round(value * 10) / 10}
      aria-valuemin={0}
      aria-valuemax={Math.round(whole)}
      aria-valuetext={text}
    >
      <span class="meter-label">{label}</span>
      <span class="meter-text">{text}</span>
      <span class="meter-track">
        <span class="meter-fill" style={{ width: `${Math.min(100, (100 * value) / whole)}%` }} />
        {limit < whole && <span class="meter-limit" style={{ left: `${(100 * limit) / whole}%` }} />}
      </span>
    </div>
  );
}
