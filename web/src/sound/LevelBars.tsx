/** How loud something is, in five bars; `level` in dB of full scale, null for nothing at all. */

const BARS_DB = [-62, -50, -40, -30, -20];

export function LevelBars({ level }: { level: number | null }) {
  return (
    <span class="level-bars" aria-hidden="true">
      {BARS_DB.map((least) => (
        <i key={least} class={level !== null && level >= least ? "lit" : ""} />
      ))}
    </span>
  );
}
