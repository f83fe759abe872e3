/** The page's layout: chosen from presets, changed by hand, kept in this browser for each preset, shared as a link. */

import { computed, type ReadonlySignal, signal } from "@preact/signals";
import type { Store } from "../state/store";
import { type Chosen, DEFAULTS, decode, encode, FIRST, type Layout, limited, type Preset, TABS } from "./layout";

const KEY = "hbba.layout";
const PARAMETER = "layout";

export class LayoutControl {
  private readonly chosen = signal<Chosen>(FIRST);
  readonly preset: ReadonlySignal<Preset> = computed(() => this.chosen.value.preset);
  readonly layout: ReadonlySignal<Layout> = computed(() => this.chosen.value.layout);
  /** Whether the layout differs from the preset as it comes. */
  readonly changed = computed(() => encode(this.chosen.value) !== encode(standard(this.chosen.value.preset)));

  constructor(
    private readonly store: Store,
    /** Where layouts are kept; null: nowhere. */
    private readonly storage: Pick<Storage, "getItem" | "setItem"> | null,
  ) {}

  /** Takes the layout of the link `search`, else the one last used here. */
  start(search: string): void {
    const linked = decode(new URLSearchParams(search).get(PARAMETER));
    const last = linked ?? decode(this.storage?.getItem(KEY) ?? null);
    if (last === null) return;
    this.chosen.value = last;
    this.show(last.preset);
  }

  choose(preset: Preset): void {
    this.put(decode(this.storage?.getItem(`${KEY}.${preset}`) ?? null) ?? standard(preset));
    this.show(preset);
  }

  change(by: Partial<Layout>): void {
    const { preset, layout } = this.chosen.peek();
    this.put({ preset, layout: limited({ ...layout, ...by }) });
  }

  /** Back to the preset as it comes. */
  reset(): void {
    this.put(standard(this.chosen.peek().preset));
  }

  /** The address that opens the page `href` in this layout. */
  link(href: string): string {
    const address = new URL(href);
    address.searchParams.set(PARAMETER, encode(this.chosen.peek()));
    return address.href;
  }

  /** What a preset is about is what is shown first. */
  private show(preset: Preset): void {
    this.store.tab.value = TABS[preset];
    if (preset === "tour") this.store.showTour("view");
    else if (this.store.mapPlace.peek() === "view") {
      this.store.showMap("tab");
      this.store.tab.value = TABS[preset];
    }
  }

  private put(chosen: Chosen): void {
    this.chosen.value = chosen;
    this.storage?.setItem(KEY, encode(chosen));
    this.storage?.setItem(`${KEY}.${chosen.preset}`, encode(chosen));
  }
}

function standard(preset: Preset): Chosen {
  return { preset, layout: DEFAULTS[preset] };
}
