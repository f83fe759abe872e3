/** The black of a QR code as the path of an SVG, a module a unit. Pure. */

/** Modules of white around it, without which it is not read. */
export const QUIET = 4;

/** `code`: its rows from the top, `1` for each black module. A rectangle for each run in a row. */
export function codePath(code: readonly string[]): string {
  return code
    .flatMap((row, y) =>
      [...row.matchAll(/1+/g)].map(
        ({ 0: run, index }) => `M${index + QUIET} ${y + QUIET}h${run.length}v1h-${run.length}z`,
      ),
    )
    .join("");
}
