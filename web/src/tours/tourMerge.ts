/** What two editors made of one tour, in one: each change that the other did not touch is kept; pure. */

export interface Merge<T> {
  merged: T;
  /** What both changed, each in its own way, as `stops.arm.title.en`; `merged` has it as mine. */
  conflicts: string[];
}

type Value = unknown;
type Members = Record<string, Value>;

/** `base`: what both began with. */
export function merge<T>(base: T, mine: T, theirs: T): Merge<T> {
  const conflicts: string[] = [];
  const merged = merged_(base, mine, theirs, "", conflicts) as T;
  return { merged, conflicts };
}

export function equal(a: Value, b: Value): boolean {
  if (Object.is(a, b)) return true;
  if (Array.isArray(a)) return Array.isArray(b) && a.length === b.length && a.every((one, at) => equal(one, b[at]));
  if (!isMembers(a) || !isMembers(b)) return false;
  const keys = Object.keys(a);
  return keys.length === Object.keys(b).length && keys.every((key) => key in b && equal(a[key], b[key]));
}

function merged_(base: Value, mine: Value, theirs: Value, path: string, conflicts: string[]): Value {
  if (equal(mine, theirs) || equal(base, theirs)) return mine;
  if (equal(base, mine)) return theirs;
  if (isMembers(base) && isMembers(mine) && isMembers(theirs)) return members(base, mine, theirs, path, conflicts);
  const lists = [base, mine, theirs];
  if (lists.every(hasIds)) return byId(lists[0]!, lists[1]!, lists[2]!, path, conflicts);
  if (Array.isArray(base) && Array.isArray(mine) && Array.isArray(theirs))
    if (base.length === mine.length && base.length === theirs.length)
      return base.map((one, at) => merged_(one, mine[at], theirs[at], within(path, at), conflicts));
  conflicts.push(path);
  return mine;
}

function members(base: Members, mine: Members, theirs: Members, path: string, conflicts: string[]): Members {
  const found: Members = {};
  for (const key of new Set([...Object.keys(theirs), ...Object.keys(mine)])) {
    const value = merged_(base[key], mine[key], theirs[key], within(path, key), conflicts);
    if (value !== undefined) found[key] = value;
  }
  return found;
}

/** Lists whose entries have ids: stops, questions. The order is mine where I changed it, else theirs. */
function byId(base: Entry[], mine: Entry[], theirs: Entry[], path: string, conflicts: string[]): Entry[] {
  const reordered = !equal(shared(base, mine), shared(mine, base));
  const [first, second] = reordered ? [mine, theirs] : [theirs, mine];
  const order = first.map(({ id }) => id);
  second.forEach(({ id }, at) => {
    if (order.includes(id)) return;
    // After the one that it follows in its own list.
    const before = second.slice(0, at).findLast((one) => order.includes(one.id));
    order.splice(before ? order.indexOf(before.id) + 1 : 0, 0, id);
  });
  return order.flatMap((id) => {
    const [was, my, their] = [base, mine, theirs].map((list) => list.find((one) => one.id === id));
    // Deleted by one: gone, unless the other changed it.
    if (was && !my) return equal(was, their) ? [] : kept(their!, `${within(path, id)}`, conflicts);
    if (was && !their) return equal(was, my) ? [] : kept(my!, `${within(path, id)}`, conflicts);
    return [merged_(was, my ?? their, their ?? my, within(path, id), conflicts) as Entry];
  });
}

function kept(one: Entry, path: string, conflicts: string[]): Entry[] {
  conflicts.push(path);
  return [one];
}

/** The ids of `of` that are in `other`, in order. */
function shared(of: Entry[], other: Entry[]): string[] {
  return of.map(({ id }) => id).filter((id) => other.some((one) => one.id === id));
}

type Entry = Members & { id: string };

function hasIds(value: Value): value is Entry[] {
  return Array.isArray(value) && value.every((one) => isMembers(one) && typeof one["id"] === "string");
}

function isMembers(value: Value): value is Members {
  return typeof value === "object" && value !== null && !Array.isArray(value);
}

function within(path: string, key: string | number): string {
  return path === "" ? String(key) : `${path}.${key}`;
}
