/**
 * When the page brings what it shows up to date: at each frame where a graphics card draws it, a few times a second
 * where the processor does. There a frame costs twice what the scripts in it cost, and the robot may be on that processor:
 * so all that changes by itself there changes at the same times, in one frame.
 */

/** Between two turns (ms) of a page that the processor draws. */
export const CALM_MS = 250;

/** Drivers that draw on the processor, as they name themselves. */
const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i;

let card: boolean | null = null;

/** Whether a graphics card draws this page, by the name of WebGL's renderer. */
export function accelerated(): boolean {
  card ??= typeof document !== "undefined" && hasCard(rendererName());
  return card;
}

/** Whether the renderer of this name (null: there is no WebGL) is a graphics card. */
export function hasCard(renderer: string | null): boolean {
  return renderer !== null && !SOFTWARE.test(renderer);
}

function rendererName(): string | null {
  const context = document.createElement("canvas").getContext("webgl");
  if (!context) return null;
  const names = context.getExtension("WEBGL_debug_renderer_info"); // Firefox has the name without it
  const name: unknown = context.getParameter(names ? names.UNMASKED_RENDERER_WEBGL : context.RENDERER);
  context.getExtension("WEBGL_lose_context")?.loseContext(); // a browser keeps few of them
  return String(name);
}

/** From `at` (ms, the page's clock) to the next turn of a page that the processor draws: the same for all of the page. */
export function untilTurn(at: number): number {
  return CALM_MS - (at % CALM_MS);
}

/** Calls `run` once, at the next turn. */
export function nextTurn(run: () => void): void {
  if (accelerated()) requestAnimationFrame(run);
  else setTimeout(run, untilTurn(performance.now()));
}

/** Calls `run` four times a second, where the processor draws at the turns; returns what ends that. */
export function fourTimesASecond(run: () => void): () => void {
  let timer: ReturnType<typeof setTimeout>;
  const wait = () => {
    timer = setTimeout(() => {
      wait();
      run();
    }, untilTurn(performance.now()));
  };
  wait();
  return () => clearTimeout(timer);
}

/** A function that calls `show` with the newest value at the next turn. */
export function atTurns<T>(show: (value: T) => void): (value: T) => void {
  let waiting: { value: T } | null = null;
  return (value) => {
    if (waiting === null)
      nextTurn(() => {
        const newest = waiting!.value;
        waiting = null;
        show(newest);
      });
    waiting = { value };
  };
}

/** A function that calls `show` with the newest value, at once where none was shown for a turn, else at its end. */
export function paced<T>(show: (value: T) => void): (value: T) => void {
  let waiting: { value: T } | null = null;
  let resting = false;
  const rest = () => {
    resting = true;
    nextTurn(() => {
      resting = false;
      if (waiting === null) return;
      const { value } = waiting;
      waiting = null;
      show(value);
      rest();
    });
  };
  return (value) => {
    if (resting) {
      waiting = { value };
      return;
    }
    show(value);
    rest();
  };
}
