"""What tests in a browser share."""

from __future__ import annotations

import base64
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from playwright.sync_api import Page

Open = Callable[..., Page]
"""Opens a page; see conftest.py."""


def pixels(page: Page) -> npt.NDArray[np.uint8]:
    """(height, width, 3) of the picture alone, as it is on the screen."""
    said = page.evaluate(
        """() => {
          const { stage } = radiosity.app, gl = stage.renderer.getContext();
          stage.draw();
          const [w, h] = [gl.drawingBufferWidth, gl.drawingBufferHeight], data = new Uint8Array(4 * w * h);
          gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, data);
          let text = "";
          for (let i = 0; i < data.length; i += 8192) text += String.fromCharCode(...data.subarray(i, i + 8192));
          return { w, h, data: btoa(text) };
        }"""
    )
    flat = np.frombuffer(base64.b64decode(said["data"]), np.uint8)
    return flat.reshape(said["h"], said["w"], 4)[::-1, :, :3]
