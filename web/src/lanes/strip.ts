/**
 * A strip of pixels wider than the view: time runs along it, one column is one device pixel. What is drawn once stays; the
 * view moves over the strip. Pure.
 */

export interface Slice {
  /** Columns, whole: from `from` up to but without `to`. */
  from: number;
  to: number;
  /** The strip begins with another time: what is on it is void. */
  whole: boolean;
}

export interface Edges {
  /** Stamps. */
  from: number;
  to: number;
}

/** So many views wide is a strip: the wider, the less often it is drawn as a whole. */
const WIDE = 1.5;
/** A live view goes on for so long (s) between two ticks, and has to find the strip there. */
const AHEAD_S = 0.3;

export class Strip {
  /** Stamp of the left edge of column 0. */
  origin = 0;
  /** Columns per second. */
  perSecond = 0;
  columns = 0;
  /** Device pixels of the view. */
  private view = 0;
  private align = 1;
  /** Columns before this are drawn; fractions of one are not. */
  private drawn = 0;

  /** Another size of the view (device pixels): nothing drawn is of use. Patterns repeat after `align` columns. */
  resize(view: number, align = 1): void {
    this.align = align;
    this.view = Math.max(1, Math.round(view));
    this.columns = Math.round(this.view * WIDE);
    this.clear();
  }

  clear(): void {
    this.perSecond = 0;
    this.drawn = 0;
  }

  /** What was drawn from `stamp` on has changed. */
  invalidate(stamp: number): void {
    this.drawn = Math.max(0, Math.min(this.drawn, Math.floor(this.column(stamp))));
  }

  column(stamp: number): number {
    return (stamp - this.origin) * this.perSecond;
  }

  stamp(column: number): number {
    return this.origin + column / this.perSecond;
  }

  /**
   * Makes the strip cover `edges`, and says which columns are to be drawn now that all is known up to the stamp `known`;
   * null: none. The same columns are never asked for twice.
   */
  cover(edges: Edges, known: number): Slice | null {
    const perSecond = this.view / (edges.to - edges.from);
    const whole = Math.abs(perSecond - this.perSecond) > 1e-9 * perSecond || !this.holds(edges);
    if (whole) {
      // By whole columns and patterns of before, so that nothing is seen to jump.
      const same = this.perSecond > 0 && Math.abs(perSecond - this.perSecond) <= 1e-9 * perSecond;
      this.origin = same ? this.stamp(Math.floor(this.column(edges.from) / this.align) * this.align) : edges.from;
      this.perSecond = perSecond;
      this.drawn = 0;
    }
    const from = this.drawn;
    const to = Math.min(this.columns, Math.floor(this.column(known)));
    if (to <= from) return whole ? { from: 0, to: 0, whole } : null;
    this.drawn = to;
    return { from, to, whole };
  }

  /** Columns that the view may still move on from `edges` before it leaves the strip. */
  room(edges: Edges): number {
    return this.columns - this.view - Math.floor(this.column(edges.from));
  }

  private holds(edges: Edges): boolean {
    return this.perSecond > 0 && this.column(edges.from) >= 0 && this.room(edges) >= AHEAD_S * this.perSecond;
  }
}
