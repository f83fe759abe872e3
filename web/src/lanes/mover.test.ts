import { beforeEach, expect, test, vi } from "vitest";
import { Mover } from "./mover";
import { Strip } from "./strip";

const animate = vi.fn(() => ({ cancel: () => undefined, currentTime: 0 }) as unknown as Animation);

function element(): HTMLElement {
  return { style: { transform: "" }, animate } as unknown as HTMLElement;
}

beforeEach(() => {
  animate.mockClear();
  vi.stubGlobal("window", { matchMedia: () => ({ matches: false }) });
});

/** A strip of 10 columns a second, from stamp 0. */
function strip(): Strip {
  const made = new Strip();
  made.resize(600);
  made.cover({ from: 0, to: 60 }, 0);
  return made;
}

test("where a card draws, the compositor moves the strips on between two ticks", () => {
  const moved = element();
  new Mover([moved], true).show(strip(), { from: 1, to: 61 }, 1, 1);
  expect(animate).toHaveBeenCalledTimes(1);
});

test("where the processor draws, each tick moves them, and nothing moves between two", () => {
  const moved = element();
  const mover = new Mover([moved], false);
  for (const [from, x] of [
    [1, 10],
    [1.25, 13],
    [1.5, 15],
  ] as const) {
    mover.show(strip(), { from, to: from + 60 }, 1, 1);
    expect(moved.style.transform).toBe(`translateX(${-x}px)`);
  }
  expect(animate).not.toHaveBeenCalled();
});
