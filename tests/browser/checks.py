"""What must hold of the page in every state: each control can be pressed, and axe finds no violation."""

from __future__ import annotations

import pytest
from playwright.sync_api import Page, expect

from app.base.paths import checkout_dir

#: What each control's middle is covered by, if not by itself. Controls out of sight in a list are scrolled to first.
_COVERED = """
() => {
  const found = [];
  const controls = "button, a[href], input, select, textarea, [role=button], [role=tab], [role=separator]";
  for (const control of document.querySelectorAll(controls)) {
    const style = getComputedStyle(control);
    if (control.disabled || style.visibility === "hidden" || style.pointerEvents === "none") continue;
    if (control.closest(".skips, details:not([open]) > :not(summary)")) continue; // seen with the focus, or opened
    control.scrollIntoView({ block: "nearest", inline: "nearest" });
    const box = control.getBoundingClientRect();
    if (box.width < 2 || box.height < 2) continue;
    const [x, y] = [box.left + box.width / 2, box.top + box.height / 2];
    const name = control.dataset.testid || control.getAttribute("aria-label") || control.textContent.trim();
    const top = document.elementFromPoint(x, y);
    const own = top && (control.contains(top) || [...(control.labels ?? [])].some((label) => label.contains(top)));
    const over = top?.closest(".notice")?.textContent || top?.dataset.testid || top?.className || top?.tagName;
    if (!own) found.push(`${name}: ${over ?? "outside the window"}`);
  }
  if (document.documentElement.scrollWidth > innerWidth) found.push("the page is wider than the window");
  return found;
}
"""
#: Keeps the page's sockets, to bring it a message as the program does.
_KEEP_SOCKETS = """
const Own = WebSocket;
window.keptSockets = [];
window.WebSocket = class extends Own {
  constructor(...given) {
    super(...given);
    keptSockets.push(this);
  }
};
"""
#: Two notices; resolved when they are shown where they belong.
_NOTICES = """
async () => {
  const live = keptSockets.find((each) => each.url.includes("/live") && each.readyState === WebSocket.OPEN);
  const texts = ["The 3D view is slow on this computer. Hide it for smoother driving.", "You have control."];
  for (const text of texts) {
    const data = JSON.stringify({ type: "notice", level: "warning", text });
    live?.dispatchEvent(new MessageEvent("message", { data }));
  }
  const shown = () => [...document.querySelectorAll(".notice[style]")].map((each) => each.textContent);
  while (live && !texts.every((text) => shown().includes(text)))
    await new Promise((done) => requestAnimationFrame(done));
  return texts.length * Boolean(live);
}
"""
#: Closes all notices, as a person would: by themselves they go after nine seconds.
_DISMISS = "() => document.querySelectorAll('.notice button').forEach((each) => each.click())"
_AXE = """
async () => (await axe.run({
  runOnly: ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"],
  rules: { region: { enabled: false } }, // separators lie between the page's landmarks
})).violations.map(({ id, nodes }) => `${id}: ${nodes.map((node) => node.target.join(" ")).join(", ")}`)
"""


def covered_controls(page: Page) -> list[str]:
    """The controls whose middle lies under something else, with what lies there.

    What a busy computer stops for a moment is said in the page's middle, over everything: that is waited for. So is the
    end of notices, which go by themselves.
    """
    while True:
        for passing in ("banner", "notice"):
            expect(page.get_by_test_id(passing)).to_have_count(0)
        found: list[str] = page.evaluate(_COVERED)
        if _under_banner(found):
            continue
        if not found or page.get_by_test_id("banner").or_(page.get_by_test_id("notice")).count() == 0:
            return found


def keep_sockets(page: Page) -> None:
    """Load the page again so that :func:`covered_by_notices` can bring it notices."""
    page.add_init_script(_KEEP_SOCKETS)
    page.reload()
    page.locator("[data-testid=connection][data-phase=live]").wait_for()


def covered_by_notices(page: Page) -> list[str]:
    """As :func:`covered_controls`, of a page after :func:`keep_sockets`, while two notices are shown."""
    while True:
        expect(page.get_by_test_id("banner")).to_have_count(0)
        if page.evaluate(_NOTICES) == 0:
            continue
        found: list[str] = page.evaluate(_COVERED)
        # With a notice gone by itself meanwhile, or the banner over all, it says nothing.
        if page.get_by_test_id("notice").count() >= 2 and not _under_banner(found):
            page.evaluate(_DISMISS)
            return found


def _under_banner(found: list[str]) -> bool:
    """Whether the page's own words on a busy computer lay over a control: they go by themselves."""
    return any(each.endswith(": banner") for each in found)


def axe_script() -> str:
    """The script of axe-core; skips the test where it is not installed."""
    root = checkout_dir()
    assert root is not None
    file = root / "web" / "node_modules" / "axe-core" / "axe.min.js"
    if not file.is_file():
        pytest.skip("axe-core is not installed: npm ci in web/")
    return file.read_text(encoding="utf-8")


def violations(page: Page, axe: str) -> list[str]:
    """What axe (``axe``: its script) finds wrong with the page as it is."""
    page.evaluate(axe)
    found: list[str] = page.evaluate(_AXE)
    return found
