"""Monte Carlo shooting: scenes of millions of patches without form factors."""

from __future__ import annotations

import math
import os
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from radiosity import _native
from radiosity.checks import memory_or_most, threads_or_all, whole
from radiosity.files import write_whole
from radiosity.patches import Patches
from radiosity.solution import Floats, Progress, Solution, _lamps, _per_light, _per_patch

_FORMAT = "radiosity shooting state"


class ShootingSolution(Solution):
    """A solution by shooting, which can be gone on from.

    There is no operator behind it, only sums over rays: a few hundred bytes a patch. ``report.iterations`` counts
    bounces, ``report.residual`` is the power that was not shot any more, relative to what was there first. Power
    balances exactly.
    """

    def refine(
        self,
        *,
        accuracy: float,
        max_rays: int | None = None,
        memory_limit: int | None = None,
        time_limit: float | None = None,
        threads: int | None = None,
        progress: Progress | None = None,
    ) -> ShootingSolution:
        """The same light to a better accuracy, from the rays so far and more.

        The answer has the bytes that it would have had if asked for at once. This solution stays as it is.

        Args:
            accuracy: wanted error of irradiance, as in :func:`radiosity.solve`.
            max_rays: most rays that a patch gathers by, those so far included; as before if not given.
            memory_limit, time_limit, threads, progress: as in :func:`radiosity.solve`.

        Raises:
            ResourceError: a second state does not fit the memory limit.
        """
        return _shoot(
            self.patches, self.reflectance, self.emission, accuracy=accuracy,
            max_rays=self._options["max_rays"] if max_rays is None else max_rays, memory_limit=memory_limit,
            time_limit=time_limit, state=self._native.state, seed=self._options["seed"], threads=threads,
            progress=progress, lights=self._options.get("lights"),
        )  # fmt: skip

    def relight(
        self,
        *,
        emission: npt.ArrayLike | None = None,
        reflectance: npt.ArrayLike | None = None,
        lights: npt.ArrayLike | None = None,
        progress: Progress | None = None,
    ) -> ShootingSolution:
        """The equilibrium with other lamps or paint on the same geometry, shot afresh.

        Shooting keeps no operator, so this takes as long as the first solve; a solution by another solver is relit
        without a new ray.

        Args:
            emission: W/m2, broadcast to (n_patches, n_bands), or (n_surfaces, n_bands) to set whole surfaces.
            reflectance: likewise, in [0, 1).
            lights: strength of the lights without area, broadcast to (n_lights, n_bands).
            progress: called with (done, total) some twenty times a second; what it raises ends the work.
        """
        new_emission = self.emission if emission is None else _per_patch(self.patches, emission, "emission")
        new_reflectance = (
            self.reflectance if reflectance is None else _per_patch(self.patches, reflectance, "reflectance")
        )
        options = self._options if lights is None else self._options | {"lights": _per_light(self.lights, lights)}
        return _shoot(self.patches, new_reflectance, new_emission, **options, progress=progress)

    def save_state(self, path: str | os.PathLike[str]) -> None:
        """Write what :func:`load_state` goes on from: an ``.npz`` file that appears whole or not at all.

        Raises:
            ValueError: another suffix. OSError: the disk is full, the folder is missing ...
        """
        if Path(path).suffix.lower() != ".npz":
            raise ValueError(f"{path}: a state of shooting is an .npz file")
        counts, shares, sums, landed = self._native.state.parts()
        arrays: dict[str, Any] = {
            "format": np.array(_FORMAT),
            "counts": counts,
            "shares": shares,
            "sums": sums,
            "landed": landed,
            "reflectance": self.reflectance,
            "emission": self.emission,
        }
        write_whole(Path(path), lambda file: np.savez(file, **arrays))


def load_state(
    patches: Patches,
    path: str | os.PathLike[str],
    *,
    accuracy: float = math.inf,
    max_rays: int = 1 << 18,
    memory_limit: int | None = None,
    time_limit: float | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
) -> ShootingSolution:
    """Go on from a saved state, on the patches that it was shot on.

    Args:
        patches: the same patches: geometry, lights and order must be those of the state.
        path: what :meth:`ShootingSolution.save_state` wrote.
        accuracy: wanted error of irradiance; without one, the solution as it was saved.
        max_rays, memory_limit, time_limit, threads, progress: as in :func:`radiosity.solve`.

    Raises:
        ValueError: the file is no state of shooting, of another version, or of another scene.
        OSError: it cannot be read.
    """
    try:
        with np.load(path, allow_pickle=False) as arrays:
            if "format" not in arrays or str(arrays["format"]) != _FORMAT:
                raise ValueError("it has another format")
            names = ("counts", "shares", "sums", "landed", "reflectance", "emission")
            counts, shares, sums, landed, reflectance, emission = (arrays[name] for name in names)
        state = _native.ShootingState(counts, shares, sums, landed)
    except (ValueError, KeyError, TypeError, zipfile.BadZipFile) as error:
        raise ValueError(f"{path}: cannot go on from this file: {error}") from error
    if reflectance.shape != patches.reflectance.shape:
        raise ValueError(f"{path}: the state is of {len(reflectance)} patches, and here are {len(patches)}")
    return _shoot(
        patches, reflectance, emission, accuracy=min(accuracy, 1e300), max_rays=max_rays, memory_limit=memory_limit,
        time_limit=time_limit, state=state, seed=int(counts[1]), threads=threads, progress=progress,
    )  # fmt: skip


def shoot(
    patches: Patches,
    *,
    accuracy: float,
    max_rays: int,
    memory_limit: int | None,
    time_limit: float | None,
    start: Solution | None,
    seed: int,
    threads: int | None,
    progress: Progress | None,
    why: str = "",
) -> ShootingSolution:
    """As ``radiosity.solve(patches, solver="shooting")``, which see."""
    options: dict[str, Any] = {
        "accuracy": accuracy, "max_rays": max_rays, "memory_limit": memory_limit, "time_limit": time_limit,
        "threads": threads, "progress": progress,
    }  # fmt: skip
    if start is None:
        return _shoot(patches, patches.reflectance, patches.emission, seed=seed, why=why, **options)
    if not isinstance(start, ShootingSolution):
        raise ValueError("start must be a solution by shooting")
    if start.patches is not patches:
        raise ValueError("start was shot on other patches; pass those patches to solve")
    return start.refine(**options)


def _shoot(
    patches: Patches,
    reflectance: Floats,
    emission: Floats,
    *,
    accuracy: float,
    max_rays: int,
    seed: int,
    memory_limit: int | None = None,
    time_limit: float | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
    state: _native.ShootingState | None = None,
    why: str = "",
    lights: Floats | None = None,
) -> ShootingSolution:
    threads, seed = threads_or_all(threads), whole(seed, "seed", 0, 2**64 - 1)
    seconds = math.inf if time_limit is None else float(time_limit)
    if not seconds > 0:
        raise ValueError(f"time_limit must be a positive number of seconds, not {time_limit}")
    native = _native.shoot(
        patches._diffuse_enclosure("shooting"), reflectance, emission, _lamps(patches.scene, lights), accuracy, seed,
        whole(max_rays, "max_rays", 1, 2**32 - 1), memory_or_most(memory_limit), seconds, state, threads, progress,
    )  # fmt: skip
    options: dict[str, Any] = {"accuracy": float(accuracy), "max_rays": max_rays, "threads": threads, "seed": seed}
    options |= {} if lights is None else {"lights": lights}
    return ShootingSolution(patches, native, reflectance, emission, options, why=why)


__all__ = ["ShootingSolution", "load_state"]
