"""Pictures against golden ones, by statistics."""

from __future__ import annotations

import numpy as np
import pytest
from goldens import SUBJECTS, Golden, draw, leave


@pytest.mark.parametrize("name", SUBJECTS)
def test_a_picture_is_of_the_light_it_was_of(name: str) -> None:
    golden, picture = Golden.load(name), draw(SUBJECTS[name], seed=1)
    wrong = golden.verdict(picture)
    assert wrong is None, f"{wrong}: see {leave(name, golden, picture)}"


@pytest.mark.parametrize("name", SUBJECTS)
def test_other_light_is_told(name: str) -> None:
    golden = Golden.load(name)
    rng = np.random.default_rng(2)
    like = golden.mean + np.sqrt(golden.variance) * rng.normal(size=golden.mean.shape[:2])[..., None]
    assert golden.verdict(like) is None
    # A little brighter, dark in a corner, shifted by a pixel, three times as noisy, without noise, of another size.
    dark = like.copy()
    dark[:10, :12] *= 0.5
    noisy = golden.mean + 3 * (like - golden.mean)
    for other in (1.06 * like, dark, np.roll(like, 1, axis=1), noisy, like[1:]):
        assert golden.verdict(other) is not None
    if np.sqrt(golden.variance.mean()) > 1e-3 * golden.mean.mean():
        assert golden.verdict(golden.mean) is not None


def test_what_failed_is_left_to_look_at(tmp_path: object, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("goldens.FOLDER", tmp_path)
    golden = Golden.load("cornell-smooth")
    path = leave("cornell-smooth", golden, 0.5 * golden.mean)
    assert path.read_bytes().startswith(b"\x89PNG")
