"""Keys, mouse and fingers move the view; links bring it back; what cannot be shown is said."""

from pathlib import Path

import numpy as np
from browsing import Open, pixels
from playwright.sync_api import Page
from scenes import cornell, lit

from radiosity.viewer.page import page as empty_page

POSITION, DIRECTION = "radiosity.position", "radiosity.direction"


def settled(page: Page, expression: str) -> list[float]:
    """A value once it stays for some pictures."""
    page.evaluate(
        """async expression => {
          let last = null, same = 0;
          while (same < 5) {
            await new Promise(requestAnimationFrame);
            const now = JSON.stringify(eval(expression));
            same = now === last ? same + 1 : 0;
            last = now;
          }
        }""",
        expression,
    )
    return [float(x) for x in page.evaluate(expression)]


def middle(page: Page) -> tuple[float, float]:
    box = page.locator("main > canvas").first.bounding_box()
    assert box
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def test_orbiting_keeps_the_distance_and_the_wheel_comes_nearer(open_lit: Open) -> None:
    page = open_lit(lit(cornell()), width=1100, height=600)
    page.wait_for_function("radiosity.app.rays.tree")
    camera = cornell().patches.scene.cameras[0]
    assert np.allclose(page.evaluate(POSITION), camera.position, atol=1e-6)
    x, y = middle(page)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 60, y, steps=3)
    page.mouse.up()
    turned = settled(page, POSITION)
    # Around what was in the middle of the picture: it is still there, as far away.
    assert np.isclose(turned[1], camera.position[1], atol=1e-3)
    assert abs(turned[0] - camera.position[0]) > 0.05
    page.mouse.wheel(0, -200)
    assert settled(page, POSITION)[2] > turned[2] + 0.02


def test_a_key_starts_walking_and_a_drag_looks_around(open_lit: Open) -> None:
    page = open_lit(lit(cornell()), width=1100, height=600)
    page.wait_for_function("radiosity.app.rays.tree")
    page.keyboard.press("w")
    assert page.evaluate("radiosity.mode") == "walk"
    x, y, z = settled(page, POSITION)
    # The camera is before the box, where no ground is: one stands inside, a quarter of a person high.
    scale = 0.5488 / 2.2  # the height of the box, and what a person stands in
    assert np.isclose(y, 1.65 * scale, atol=2e-3) and z > 0 and 0 < x < 0.556
    before = np.array(page.evaluate(DIRECTION))
    at = middle(page)
    page.mouse.move(*at)
    page.mouse.down()
    page.mouse.move(at[0] + 100, at[1], steps=3)
    page.mouse.up()
    # What was seized stays under the pointer: 100 pixels of 600, which are the vertical angle.
    angle = np.arccos(before @ np.array(page.evaluate(DIRECTION)))
    assert np.isclose(angle, 100 / 600 * page.evaluate("radiosity.app.stage.verticalAngle"), rtol=1e-3)


def test_fingers_look_around_and_walk(open_lit: Open) -> None:
    page = open_lit(lit(cornell()), width=390, height=844)
    page.evaluate("radiosity.mode = 'walk'")
    touch = page.context.new_cdp_session(page)

    def drag(points: list[tuple[float, float]], to: list[tuple[float, float]]) -> None:
        def at(places: list[tuple[float, float]]) -> list[dict[str, float]]:
            return [{"x": x, "y": y, "id": k} for k, (x, y) in enumerate(places)]

        touch.send("Input.dispatchTouchEvent", {"type": "touchStart", "touchPoints": at(points)})
        touch.send("Input.dispatchTouchEvent", {"type": "touchMove", "touchPoints": at(to)})
        touch.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})

    before, place = np.array(page.evaluate(DIRECTION)), np.array(settled(page, POSITION))
    drag([(200, 150)], [(140, 150)])
    after = np.array(page.evaluate(DIRECTION))
    assert 0.01 < np.arccos(before @ after) < 0.5
    assert np.allclose(settled(page, POSITION), place, atol=1e-9)
    drag([(150, 200), (250, 200)], [(190, 200), (210, 200)])
    # Pinching walks backwards.
    assert (np.array(settled(page, POSITION)) - place) @ after < -0.01


def test_a_link_brings_view_and_settings_back(open_lit: Open) -> None:
    page = open_lit(lit(cornell()), width=800, height=600)
    page.evaluate("radiosity.mode = 'fly'; radiosity.look([0.2, 0.3, 0.1], [0.3, 0.2, 0.5])")
    page.evaluate("radiosity.setSettings({ falseColours: true, map: 'turbo', range: [0, 2] })")
    page.keyboard.press("l")
    page.wait_for_function("location.hash.startsWith('#view=')")
    address = page.url
    page.goto("about:blank")
    page.goto(address)
    page.evaluate("radiosity.ready")
    assert np.allclose(page.evaluate(POSITION), [0.2, 0.3, 0.1], atol=1e-4)
    toward = np.array([0.1, -0.1, 0.4])
    assert np.allclose(page.evaluate(DIRECTION), toward / np.linalg.norm(toward), atol=1e-4)
    said = page.evaluate("radiosity.settings")
    assert (said["falseColours"], said["map"], said["range"]) == (True, "turbo", [0, 2])
    assert page.evaluate("radiosity.mode") == "fly"


def test_pages_without_a_scene_and_with_a_damaged_one_say_so(open_page: Open, tmp_path: Path) -> None:
    path = tmp_path / "page.html"
    path.write_text(empty_page(), encoding="utf-8")
    page = open_page(path.as_uri(), ready=False)
    page.get_by_text("There is no scene here").wait_for()
    element = '<body><script type="application/gzip" id="radiosity-scene">H4sIAAAA</script>'
    path.write_text(empty_page().replace("<body>", element, 1), encoding="utf-8")
    page = open_page(path.as_uri(), ready=False)
    page.get_by_text("This scene cannot be shown").wait_for()


def test_a_graphics_card_that_comes_back_shows_the_picture_again(open_lit: Open) -> None:
    page = open_lit(lit(cornell()))
    page.evaluate("window.card = radiosity.app.stage.renderer.getContext().getExtension('WEBGL_lose_context')")
    page.evaluate("card.loseContext()")
    page.get_by_text("The graphics card was taken away").wait_for()
    page.evaluate("card.restoreContext()")
    page.get_by_text("The graphics card was taken away").wait_for(state="hidden")
    drawn = page.evaluate("radiosity.statistics.drawn")
    page.wait_for_function("drawn => radiosity.statistics.drawn >= drawn", arg=drawn)
    assert np.mean(pixels(page) > 60) > 0.3  # middle grey is 118 of 255
