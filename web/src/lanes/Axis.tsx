/** Time along the foot of the lanes, and its lines behind them: it stands while the strip moves. */

import type { Tick } from "./viewport";

export function Axis({ ticks, suffix }: { ticks: Tick[]; suffix: string }) {
  return (
    <div class="lane-axis" aria-hidden="true" data-testid={`lane-axis${suffix}`}>
      {ticks.map(({ share, label }) => (
        <span key={label} style={{ left: `${share * 100}%` }}>
          {label}
        </span>
      ))}
    </div>
  );
}

export function TimeLines({ ticks }: { ticks: Tick[] }) {
  return (
    <>
      {ticks.map(({ share, label }) => (
        <i key={label} class="lane-time" style={{ left: `${share * 100}%` }} />
      ))}
    </>
  );
}
