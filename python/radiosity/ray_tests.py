"""What rays tell of a scene: faces that look the wrong way, faces that are never lit, and where light escapes.

:func:`radiosity.diagnosis.examine` calls them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Literal

import numpy as np
import numpy.typing as npt

from radiosity._native import SceneError
from radiosity.scene import Finding, Scene
from radiosity.sight import BACK, FRONT, Sight, look_around, not_buried

if TYPE_CHECKING:
    from radiosity.patches import Patches

Floats = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

MOST_FACES = 200_000
"""Scenes of more faces are not looked around in."""

NOTHING = 0.05
"""A share up to this of what a side sees is as good as nothing."""

OUTSIDE = 0.9
"""A side from which more than this escapes is no inside of a space."""

OPEN = 0.3
"""Where more than this escapes nobody meant to close the space."""

LEAST_LOSS = 2e-3
"""What escapes is worth a word above this, or where the space should be closed."""

MOST_NAMED = 4

LARGEST_ROOM = 100.0
"""Metres: closed spaces that are larger have perhaps the wrong unit."""

_RAYS_TRACED_OUT = 4000
_EDGES_COMPARED = 3000


def complete(
    scene: Scene,
    known: list[Finding],
    enclosure: bool | None,
    *,
    seed: int = 0,
    threads: int | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> list[Finding]:
    """What is known from shapes with what rays tell, each said once; nothing more where shapes are unsound."""
    try:
        faces = sum(len(np.asarray(surface.faces)) for surface in scene.surfaces)
        if faces > MOST_FACES:
            message = (
                f"it has {faces:,} faces: too many to look around from each; radiosity factors measures what they see"
            )
            return [*known, Finding("note", "no-rays", "", message)]
        patches = scene.patches(as_is=True)
    except SceneError:
        return known
    if not len(patches):
        return known
    sight = look_around(patches, seed=seed, threads=threads, progress=progress)
    _recheck(sight, seed, threads)
    wanted = bool(scene.hints.get("enclosure")) if enclosure is None else enclosure
    turned = _is_turned(sight)
    found = [*_turned(sight, turned), *_backs_in_sight(sight), *_buried(sight), *_blocked_lamps(sight)]
    share = _share_that_escapes(sight, turned)
    if enclosure is not False and share < OPEN:
        found += _escapes(scene, known, sight, turned, share, wanted)
    found = _said_once(known + found)
    return _with_idle_rims_as_one(found) if share < OPEN else found


def _said_once(found: list[Finding]) -> list[Finding]:
    """Without what is told of the same faces by a better finding."""
    said = {f.code: set[tuple[int | None, int]]() for f in found}
    for finding in found:
        said[finding.code] |= _faces(finding)

    def is_told(finding: Finding) -> bool:
        better = {"mixed-winding": "turned-faces", "back-in-sight": "mixed-winding"}.get(finding.code, "")
        return bool(_faces(finding)) and _faces(finding) <= said.get(better, set())

    return [finding for finding in found if not is_told(finding)]


def _faces(finding: Finding) -> set[tuple[int | None, int]]:
    return {(finding.surface, int(face)) for face in finding.faces}


def _with_idle_rims_as_one(found: list[Finding]) -> list[Finding]:
    """With one finding for all rims of a space that no light passes: those of sheets and bodies in it."""
    passed = {edge.tobytes() for f in found if f.code == "light-escapes" for edge in f.edges}
    rims = [f for f in found if f.code == "open-edges" and passed.isdisjoint(edge.tobytes() for edge in f.edges)]
    if not rims:
        return found
    edges = np.concatenate([f.edges for f in rims])
    named = list(dict.fromkeys(f.element.partition(", face")[0].removeprefix("surface ") for f in rims if f.element))
    more = f" and {len(named) - MOST_NAMED} more" if len(named) > MOST_NAMED else ""
    element = f"{'surfaces' if len(named) > 1 else 'surface'} {', '.join(named[:MOST_NAMED])}{more}"
    message = (
        f"{len(edges):,} edges belong to one face only, but no ray left the space there: they are rims of sheets and "
        "open bodies, or of holes too small for a few rays; close them where something should be solid"
    )
    one = Finding("note", "open-rims", element, message, edges=edges)
    return [*(f for f in found if not any(f is rim for rim in rims)), one]


def _recheck(sight: Sight, seed: int, threads: int | None) -> None:
    """Leave out what faces see of the floor below their own body, where one of their sides is doubtful."""
    black, lit = sight.black + sight.buried, sight.lit
    in_body = (black > 0.3).any(axis=1) & (sight.escaped == 0).any(axis=1)
    seen_behind = _one_sided(sight.patches) & (lit[:, BACK] > 0.5)
    suspects = np.flatnonzero((sight.patches.area > 0) & (seen_behind | (in_body & (lit > 0).any(axis=1))))
    if len(suspects):
        share = not_buried(sight.patches, suspects, seed=seed, threads=threads)
        sight.black[suspects] += (1 - share) * lit[suspects]
        sight.lit[suspects] *= share
        sight.far[suspects] *= share


def _is_turned(sight: Sight) -> Flags:
    """(n,) one-sided faces whose front sees nothing that is lit where their back does."""
    saw_anything = sight.lit + sight.black + sight.escaped > 0
    blind = (sight.lit[:, FRONT] <= NOTHING) & saw_anything[:, FRONT]
    return _one_sided(sight.patches) & blind & (sight.lit[:, BACK] >= 1 - 4 * NOTHING)


def _one_sided(patches: Patches) -> Flags:
    return ~patches.two_sided & (patches.area > 0)


def _turned(sight: Sight, turned: Flags) -> Iterator[Finding]:
    for surface, element, faces in _by_surface(sight.patches, turned):
        message = (
            "its front sees nothing that is lit and its back looks into the space: it looks the wrong way; reverse the "
            "order of its corners, or make it two-sided"
        )
        yield Finding("warning", "turned-faces", element, message, surface, faces)


def _backs_in_sight(sight: Sight) -> Iterator[Finding]:
    """One-sided faces that are seen from behind too, and are black there."""
    seen = _one_sided(sight.patches) & (sight.lit[:, FRONT] > NOTHING) & (sight.far[:, BACK] > 0.6)
    # Lamps have dark backs.
    seen &= ~(sight.patches.emission > 0).any(axis=1)
    for surface, element, faces in _by_surface(sight.patches, seen):
        message = (
            "its back is in sight of what is lit, and is black: make it two-sided, close the body that it belongs to, "
            "or reverse the order of its corners if that body is inside out"
        )
        yield Finding("note", "back-in-sight", element, message, surface, faces)


def _buried(sight: Sight) -> Iterator[Finding]:
    """Faces within solids: whatever they look at is the inside of something."""
    nothing = (sight.lit + sight.escaped == 0).all(axis=1)
    blocked = (sight.black + sight.buried > 0).all(axis=1)
    for surface, element, faces in _by_surface(sight.patches, nothing & blocked & (sight.patches.area > 0)):
        message = (
            "it lies within a solid, where no light comes: remove it, or turn the solid around if it is inside out"
        )
        yield Finding("note", "buried-faces", element, message, surface, faces)


def _blocked_lamps(sight: Sight) -> Iterator[Finding]:
    """Lamps that shine on something right before them."""
    lamps = (sight.patches.emission > 0).any(axis=1) & ~sight.patches.two_sided & (sight.patches.area > 0)
    for surface, element, faces in _by_surface(sight.patches, lamps & (sight.close[:, FRONT] > 0.9)):
        message = "it emits, and nine tenths of that ends right before it: turn it around, or move it out"
        yield Finding("warning", "blocked-lamp", element, message, surface, faces)


def _by_surface(patches: Patches, chosen: Flags) -> Iterator[tuple[int, str, npt.NDArray[np.uint32]]]:
    """Index, element and chosen faces of each surface that has any."""
    for k in np.unique(patches.surface[chosen]):
        own = patches.surface == k
        faces = patches.face[own & chosen]
        name = f"surface '{patches.scene.surfaces[int(k)].name}'"
        more = f" (and {len(faces) - 1} more)" if len(faces) > 1 else ""
        element = name if len(faces) == own.sum() else f"{name}, face {faces[0]}{more}"
        yield int(k), element, faces


def _inside(sight: Sight, turned: Flags) -> Flags:
    """(n,) faces whose fronts are in a space."""
    sees = (sight.lit[:, FRONT] > NOTHING) & (sight.escaped[:, FRONT] < OUTSIDE)
    return np.asarray((sight.patches.area > 0) & ~turned & sees)


def _share_that_escapes(sight: Sight, turned: Flags) -> float:
    """Of what faces in a space send, how much leaves it; all where there is no space to speak of."""
    inside, area = _inside(sight, turned), sight.patches.area
    if area[inside].sum() < 0.5 * area.sum() or not inside.any():
        return 1.0
    return float(np.average(sight.escaped[inside, FRONT], weights=area[inside]))


def _escapes(
    scene: Scene, known: list[Finding], sight: Sight, turned: Flags, share: float, wanted: bool
) -> list[Finding]:
    """Whether light leaves a space that is nearly closed, from which surfaces, and through which hole."""
    inside = _inside(sight, turned)
    found = _too_large(sight.patches) if share < NOTHING else []
    if share <= (0 if wanted else LEAST_LOSS):
        return found
    openings = [f for f in known if f.code in {"open-edges", "narrow-gap"} and len(f.edges)]
    if not wanted:
        openings += [f for f in scene.findings(enclosure=True) if f.code == "open-edges" and len(f.edges)]
    severity: Literal["note", "warning"] = "warning" if wanted else "note"
    losers, surface, faces = _losers(sight, inside)
    where, edges, points = _ways_out(sight, inside, openings)
    message = (
        f"{_percent(share)} of what it sends leaves the space: {losers}{where}; close it if no light should escape"
    )
    finding = Finding(severity, "light-escapes", f"surface '{scene.surfaces[surface].name}'", message, surface, faces)
    return [*found, replace(finding, edges=edges, points=points)]


def _too_large(patches: Patches) -> list[Finding]:
    size = float(np.linalg.norm(np.ptp(patches.polygons.reshape(-1, 3), axis=0)))
    if not LARGEST_ROOM < size <= 1000:
        return []
    message = f"it is a closed space of {size:.4g} m; if that is a mistake, give the unit of the file, as in --unit cm"
    return [Finding("note", "implausible-size", "", message)]


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %" if share >= 0.1 else f"{100 * share:.2g} %"


def _losers(sight: Sight, inside: Flags) -> tuple[str, int, npt.NDArray[np.uint32]]:
    """The surfaces that lose most, in words; the first of them and its faces that lose anything."""
    patches = sight.patches
    lost, sent = (
        np.bincount(patches.surface[inside], values, len(patches.scene.surfaces))
        for values in (patches.area[inside] * sight.escaped[inside, FRONT], patches.area[inside])
    )
    order = [int(k) for k in np.argsort(-lost, kind="stable") if lost[k] > 0]
    told = [f"'{patches.scene.surfaces[k].name}' loses {_percent(lost[k] / sent[k])}" for k in order[:MOST_NAMED]]
    more = f", and {len(order) - MOST_NAMED} surfaces more" if len(order) > MOST_NAMED else ""
    own = inside & (patches.surface == order[0]) & (sight.escaped[:, FRONT] > 0)
    return ", ".join(told) + more, order[0], patches.face[own]


def _ways_out(sight: Sight, inside: Flags, openings: list[Finding]) -> tuple[str, Floats, Floats]:
    """Through which opening most rays leave, in words; the edges and the middle of those that any leaves through."""
    rays = sight.exits[inside[sight.exit_from]]
    if not openings:
        return "", np.zeros((0, 2, 3)), np.zeros((0, 3))
    rays = rays[:: max(1, len(rays) // _RAYS_TRACED_OUT)]
    edges = np.concatenate([f.edges for f in openings])
    owner = np.repeat(np.arange(len(openings)), [len(f.edges) for f in openings])
    keep = slice(None, None, max(1, len(edges) // _EDGES_COMPARED))
    edges, owner = edges[keep], owner[keep]
    # Which gap a ray slipped through is told by the edge that it passes most closely.
    nearest = np.concatenate(
        [_passing(part, edges).argmin(axis=1) for part in np.array_split(rays, len(rays) // 256 + 1)]
    )
    count = np.bincount(owner[nearest], minlength=len(openings))
    best = int(np.argmax(count))
    used = [f for f, n in zip(openings, count, strict=True) if n > 0.1 * count[best]]
    x, y, z = openings[best].edges.reshape(-1, 3).mean(axis=0) + 0.0
    kind = "gap" if openings[best].code == "narrow-gap" else "hole"
    where = (
        f"; {_percent(count[best] / len(rays))} of that passes the {kind} around ({x:.4g}, {y:.4g}, {z:.4g}) at "
        f"{openings[best].element}"
    )
    middles = np.array([f.edges.reshape(-1, 3).mean(axis=0) for f in used])
    return where, np.concatenate([f.edges for f in used]), middles


def _passing(rays: Floats, edges: Floats) -> Floats:
    """(rays, edges) least distances, seen from where each ray starts: between lines and nine points of each edge."""
    steps = np.linspace(0, 1, 9)[:, None, None]
    points = (1 - steps) * edges[:, 0] + steps * edges[:, 1]
    least = np.full((len(rays), len(edges)), np.inf)
    origin, direction = rays[:, 0, None], rays[:, 1, None]
    for point in points:
        to = point[None] - origin
        length = np.linalg.norm(to, axis=2)
        along = np.einsum("rek,rek->re", to, np.broadcast_to(direction, to.shape))
        away = np.sqrt(np.maximum(length**2 - along**2, 0)) / np.maximum(length, 1e-300)
        np.minimum(least, np.where(along > 0, away, 2.0), out=least)
    return least
