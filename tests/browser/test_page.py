"""The page itself: its weight, and what it says where it cannot draw."""

from pathlib import Path

from browsing import Open
from playwright.sync_api import Browser
from scenes import lit, two_lamps

from radiosity.viewer import page as module
from radiosity.viewer.page import with_scene


def test_it_weighs_less_than_a_megabyte() -> None:
    assert len(module.page().encode()) < 1_000_000


def test_it_asks_nobody_for_anything(open_lit: Open) -> None:
    page = open_lit(lit(two_lamps()))
    asked = page.evaluate("performance.getEntriesByType('resource').map(({ name }) => name)")
    assert [name for name in asked if not name.startswith(("blob:", "data:"))] == []
    assert page.title() == "A test"


def test_without_webgl_there_is_a_message(browser: Browser, tmp_path: Path) -> None:
    path = tmp_path / "page.html"
    path.write_text(with_scene(lit(two_lamps())), encoding="utf-8")
    page = browser.new_context().new_page()
    page.add_init_script(
        "const get = HTMLCanvasElement.prototype.getContext;"
        "HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {"
        "  return kind.startsWith('webgl') ? null : get.call(this, kind, ...rest); };"
    )
    page.goto(path.as_uri())
    page.get_by_text("WebGL").first.wait_for(timeout=20_000)
    page.context.close()


def test_a_damaged_scene_is_said_to_be(browser: Browser, tmp_path: Path) -> None:
    text = with_scene(lit(two_lamps()))
    begin = text.index('id="radiosity-scene">') + len('id="radiosity-scene">')
    path = tmp_path / "page.html"
    path.write_text(text[: begin + 4000] + text[begin + 4400 :], encoding="utf-8")
    page = browser.new_context().new_page()
    page.goto(path.as_uri())
    page.get_by_text("damaged").first.wait_for(timeout=20_000)
    page.context.close()
