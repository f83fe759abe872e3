"""The page in French, at a desk and on a phone: no English of its own is left to see, and all of it fits."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from app.base.paths import checkout_dir
from tests.browser.checks import axe_script, covered_controls, violations

DESK, PHONE = (1440, 900), (390, 844)
TABS = ("map", "tour", "found", "load", "events", "recordings", "attention")
#: What people see, or hear of a screen reader, of what is in French: texts of elements and of their attributes.
_SAID = """
() => {
  const said = new Set();
  const shown = (element) => element.checkVisibility({ visibilityProperty: true });
  // What a desire's parameter may be are words of the program, which speaks English.
  const described = "[data-testid=desire-form]";
  const french = (element) => element.closest("[lang]").lang === "fr" && !element.closest(described);
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node = walker.nextNode(); node; node = walker.nextNode()) {
    const text = node.nodeValue.trim();
    if (text && shown(node.parentElement) && french(node.parentElement)) said.add(text);
  }
  for (const element of document.querySelectorAll("[title], [aria-label], [placeholder], [alt]"))
    for (const name of ["title", "aria-label", "placeholder", "alt"]) {
      const text = element.getAttribute(name)?.trim();
      if (text && shown(element) && french(element)) said.add(text);
    }
  return [...said];
}
"""


@pytest.fixture(scope="module")
def english() -> re.Pattern[str]:
    """Matches each English text that reads otherwise in French, as a whole or with values in its places."""
    root = checkout_dir()
    assert root is not None
    folder = root / "web" / "src" / "i18n" / "fr"
    texts = {**json.loads((folder / "robot.json").read_text())["names"]}
    for file in folder.glob("*.ts"):
        texts |= _entries(file)
    differ = {_plain(text) for text, other in texts.items() if _plain(text) != other}
    # What is one language's text may be another's for something else: "Note", "Place".
    differ -= set(texts.values())
    differ -= {"The robotics lab"}  # what a place of the example tour is called, too
    assert len(differ) > 1000
    places = [re.sub(r"\\\{\w+\\\}", ".+", re.escape(text)) for text in differ]
    # Values without words around them ("{x} m") would match anything.
    return re.compile("|".join(each for each in places if re.search(r"[A-Za-z]{3}", each.replace(".+", ""))))


def _entries(file: Path) -> dict[str, str]:
    entry = r'^  (?:("(?:[^"\\]|\\.)*")|(\w+)):\s+(?:\{ one: "(?:[^"\\]|\\.)*", other: )?("(?:[^"\\]|\\.)*")'
    found = re.findall(entry, file.read_text(encoding="utf-8"), re.MULTILINE)
    return {json.loads(quoted) if quoted else word: json.loads(other) for quoted, word, other in found}


def _plain(text: str) -> str:
    """Without what it is, which is not shown: ``Drive|preset``."""
    return text.partition("|")[0].strip()


class Walk:
    """Looks at the page in one state after another, and keeps what is wrong in each."""

    def __init__(self, page: Page, english: re.Pattern[str]) -> None:
        self.page = page
        self.wrong: dict[str, list[str]] = {}
        self._english = english
        self._axe = axe_script()

    def look(self, state: str, *, over: bool = False) -> None:
        """``over``: something is open over the page, and covers what it is for."""
        said: list[str] = self.page.evaluate(_SAID)
        assert len(said) > 20
        wrong = [f"English: {text}" for text in said if self._english.fullmatch(text)]
        if not over:
            wrong += [f"covered: {control}" for control in covered_controls(self.page)]
        wrong += [f"axe: {violation}" for violation in violations(self.page, self._axe)]
        if wrong:
            self.wrong[state] = wrong


def test_a_desk_in_french(open_page: Callable[..., Page], english: re.Pattern[str]) -> None:
    page = open_page(locale="fr-CA")
    page.set_viewport_size({"width": DESK[0], "height": DESK[1]})
    expect(page.locator("html")).to_have_attribute("lang", "fr")
    walk = Walk(page, english)
    for preset in ("drive", "tour", "debug", "attention"):
        page.get_by_test_id("layout").click()
        page.get_by_test_id(f"layout-{preset}").click()
        walk.look(preset)
    for tab in TABS:
        page.get_by_test_id(f"tab-{tab}").click()
        walk.look(tab)
    page.get_by_test_id("intention-names").click()
    walk.look("names")
    for opened in ("desire-add", "drive-settings", "say", "layout", "lanes-table-toggle", "help"):
        page.get_by_test_id(opened).click()
        walk.look(opened, over=True)
    page.get_by_test_id("help").click()
    page.get_by_test_id("tab-tour").click()
    page.get_by_test_id("tour-open").first.click()
    page.get_by_test_id("tour-editor").wait_for()
    walk.look("tour editor")
    assert walk.wrong == {}


def test_a_phone_in_french(open_page: Callable[..., Page], english: re.Pattern[str]) -> None:
    page = open_page(locale="fr-FR")
    page.set_viewport_size({"width": PHONE[0], "height": PHONE[1]})
    page.locator("[data-testid=page].narrow").wait_for()
    walk = Walk(page, english)
    walk.look("page")
    for tab in (*TABS, "lanes"):
        page.get_by_test_id(f"tab-{tab}").click()
        walk.look(tab)
    page.get_by_test_id("help").click()
    walk.look("help", over=True)
    assert walk.wrong == {}


def test_the_language_changes_where_one_is_and_stays_over_a_reload(open_page: Callable[..., Page]) -> None:
    page = open_page(locale="en-GB")
    page.set_viewport_size({"width": DESK[0], "height": DESK[1]})
    stop, html = page.get_by_test_id("estop"), page.locator("html")
    expect(stop).to_have_text("E-STOP")
    page.get_by_test_id("tab-map").click()
    page.get_by_test_id("layout").click()
    page.get_by_test_id("language").select_option("fr")
    expect(stop).to_have_text("ARRÊT D’URGENCE")
    expect(html).to_have_attribute("lang", "fr")
    expect(page.get_by_test_id("layout-box")).to_be_visible()
    expect(page.get_by_test_id("tab-map")).to_have_attribute("aria-selected", "true")
    page.reload()
    expect(stop).to_have_text("ARRÊT D’URGENCE")
    page.get_by_test_id("layout").click()
    page.get_by_test_id("language").select_option("en")
    expect(stop).to_have_text("E-STOP")
    expect(html).to_have_attribute("lang", "en")
