/** Whether an element is on the screen: not folded, not scrolled away, not of a page behind others. */

/** Calls `report` with each change, and first with what is so now. Returns the undoing. */
export function whileSeen(element: Element, report: (seen: boolean) => void): () => void {
  let inside = false;
  const judge = () => report(inside && document.visibilityState === "visible");
  const observer = new IntersectionObserver((entries) => {
    inside = entries.at(-1)!.isIntersecting;
    judge();
  });
  observer.observe(element);
  document.addEventListener("visibilitychange", judge);
  return () => {
    observer.disconnect();
    document.removeEventListener("visibilitychange", judge);
  };
}
