"""The hemicube: form factors from one point to everything it sees, by counting pixels (Cohen and Greenberg 1985)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from scipy.ndimage import distance_transform_edt

from radiosity import _native
from radiosity.checks import whole
from radiosity.teaching.figures import INK, PALETTE, new_figure, style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from radiosity.patches import Patches

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

NOTHING, BACK = -1, -2
"""Owners of pixels that see nothing at all; and the black back of a one-sided patch, or an obstruction."""

OTHERS = "#C8C8C8"
"""Colour of surfaces that are not named."""

LEAST = 5e-5
"""The least form factor with a digit in the legend."""


@dataclass(frozen=True)
class ItemBuffer:
    """What each pixel of a hemicube sees.

    Faces in order: the top, then the sides along the first axis, against it, along the second, against it. The top has
    ``resolution`` rows along the second axis of as many pixels along the first; sides have half as many rows, from the
    horizon up.

    Attributes:
        patches: what is seen.
        side: the side that the hemicube stands on, a row of the form factors.
        resolution: pixels along an edge.
        position: (3,) where it stands, m.
        axes: (3, 3) two tangents, turned about the normal by the seed, and the normal.
        owners: (rows, resolution) per face: the side seen, a column of the form factors, or NOTHING or BACK.
        depths: likewise, how far along the axis of its face it lies, m; infinite for nothing.
        directions: (rows, resolution, 3) per face through the centres of the pixels, not of unit length.
        unfolded: (2 resolution, 2 resolution) owners, the top in the middle; NOTHING in the corners, which are no part
            of it. Rows along the second axis, columns along the first.
    """

    patches: Patches
    side: int
    resolution: int
    position: Floats
    axes: Floats
    owners: list[Integers]
    depths: list[npt.NDArray[np.float32]]
    directions: list[Floats]
    unfolded: Integers

    @property
    def patch(self) -> Integers:
        """(n_sides,) the patch of each side: the fronts of all patches, then the backs of the two-sided ones."""
        return _patch_of_sides(self.patches)

    def row(self) -> Floats:
        """(n_sides,) the row of form factors: the delta form factors of the pixels of each side, summed."""
        return self._worth()[2:]

    def to_nothing(self) -> float:
        """The share of what leaves the point that meets nothing."""
        return float(self._worth()[2 + NOTHING])

    def to_backs(self) -> float:
        """The share that meets backs and obstructions."""
        return float(self._worth()[2 + BACK])

    def _worth(self) -> Floats:
        """(2 + n_sides,) delta form factors summed by owner, of whom BACK is the first and NOTHING the second."""
        top, side = delta_form_factors(self.resolution)
        owner = np.concatenate([face.ravel() for face in self.owners])
        delta = np.concatenate([top.ravel(), *4 * [side.ravel()]])
        return np.bincount(owner + 2, delta, 2 + len(self.patch)).astype(np.float64)


def item_buffer(
    patches: Patches, patch: int, *, resolution: int = 256, seed: int = 0, back: bool = False
) -> ItemBuffer:
    """What a hemicube on the centroid of a patch sees.

    Args:
        patches: what may be seen.
        patch: where it stands.
        resolution: pixels along an edge, even, 8 to 4096.
        seed: turns it about the normal.
        back: it stands on the back of a two-sided patch.

    Raises:
        ValueError: no such patch or back, a patch without area, a resolution out of its range.
    """
    patch = whole(patch, "patch", 0, len(patches) - 1)
    if not patches.area[patch] > 0:
        raise ValueError(f"patch {patch} has no area, so that it sees nothing")
    side = patch
    if back:
        if not patches.two_sided[patch]:
            raise ValueError(f"patch {patch} is one-sided, so that nothing is seen from its back")
        side = len(patches) + int(np.count_nonzero(patches.two_sided[:patch]))
    native = _native.item_buffer(patches._enclosure, side, _even(resolution), whole(seed, "seed", 0, 2**64 - 1))
    return ItemBuffer(
        patches, side, native.resolution, native.position, native.axes, [_signed(face) for face in native.owners()],
        native.depths(), native.directions(), _signed(native.unfolded()),
    )  # fmt: skip


def delta_form_factors(resolution: int) -> tuple[Floats, Floats]:
    """What each pixel is worth: (resolution, resolution) of the top and (resolution / 2, resolution) of a side.

    Integrated exactly over each pixel, so that the top and four sides sum to 1.

    Raises:
        ValueError: a resolution that is odd or not in 8 to 4096.
    """
    return _native.delta_form_factors(_even(resolution))


def draw_item_buffer(
    patches: Patches, patch: int, *, resolution: int = 256, seed: int = 0, back: bool = False, names: int = 10
) -> Figure:
    """The unfolded hemicube of a patch with a colour for each surface; beside it what its pixels are worth.

    Nothing is black, backs are hatched grey. The legend tells the form factor to each surface; edges of patches show.

    Args:
        patches, patch, resolution, seed, back: as of :func:`item_buffer`.
        names: how many surfaces get a colour of their own, those of the greatest form factors; at most 14.

    Raises:
        ValueError: as of :func:`item_buffer`.
        ImportError: matplotlib is not installed.
    """
    names = whole(names, "names", 1, len(PALETTE))
    buffer = item_buffer(patches, patch, resolution=resolution, seed=seed, back=back)
    with style():
        figure = new_figure(15, 6.4)
        _draw_owners(figure.add_axes((0.01, 0.05, 0.36, 0.82)), buffer, names)
        _draw_deltas(figure.add_axes((0.56, 0.05, 0.36, 0.82)), figure.add_axes((0.935, 0.2, 0.012, 0.52)), resolution)
        name = patches.scene.surfaces[patches.surface[patch]].name or f"surface {patches.surface[patch]}"
        figure.suptitle(f"The item buffer of a hemicube on patch {patch} ({name}), {resolution} pixels an edge", y=0.97)
    return figure


def _draw_owners(axes: Any, buffer: ItemBuffer, names: int) -> None:
    from matplotlib.colors import to_rgb  # noqa: PLC0415
    from matplotlib.patches import Patch  # noqa: PLC0415

    surfaces = buffer.patches.surface[buffer.patch].astype(np.int64)  # of each side
    share = np.bincount(surfaces, buffer.row(), len(buffer.patches.scene.surfaces))
    order = np.argsort(-share, kind="stable")
    named = order[:names][share[order[:names]] > 0]
    seen = np.where(buffer.unfolded >= 0, surfaces[np.maximum(buffer.unfolded, 0)], buffer.unfolded)

    picture = np.empty((*seen.shape, 3))
    picture[:] = to_rgb(OTHERS)
    picture[seen == NOTHING] = 0.0
    for surface, colour in zip(named, PALETTE, strict=False):
        picture[seen == surface] = to_rgb(colour)
    picture[_edges(buffer.unfolded)] *= 0.82
    rows, columns = np.indices(seen.shape)
    stripe = ((rows + columns) * 64 // buffer.resolution) % 2 == 0
    picture[seen == BACK] = np.where(stripe, 0.62, 0.42)[seen == BACK, None]
    picture[_corners(buffer.resolution)] = 1.0
    axes.imshow(picture, origin="lower", interpolation="nearest", extent=(-2, 2, -2, 2))
    _draw_folds(axes)
    axes.set_title("What each pixel sees")

    handles = []
    for number, surface in enumerate(named, 1):
        _number(axes, seen == surface, buffer.resolution, number)
        name = buffer.patches.scene.surfaces[surface].name or f"surface {surface}"
        handles.append(Patch(facecolor=PALETTE[number - 1], edgecolor=INK, linewidth=0.5,
                             label=f"{number}  {_short(name)}  {share[surface]:.4f}"))  # fmt: skip
    rest = share.sum() - share[named].sum()
    if rest >= LEAST:
        handles.append(Patch(facecolor=OTHERS, edgecolor=INK, linewidth=0.5,
                             label=f"{np.count_nonzero(share) - len(named)} others  {rest:.4f}"))  # fmt: skip
    handles += _codes(buffer)
    axes.legend(handles=handles, loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False, fontsize=10.5,
                title=f"form factors, sum {share.sum():.4f}", alignment="left")  # fmt: skip


def _codes(buffer: ItemBuffer) -> list[Any]:
    """Entries of the legend for what is no surface, where it has a digit to show."""
    from matplotlib.patches import Patch  # noqa: PLC0415

    backs, nothing = buffer.to_backs(), buffer.to_nothing()
    handles = []
    if backs >= LEAST:
        handles.append(Patch(facecolor="#9E9E9E", edgecolor="#6B6B6B", hatch="////", label=f"backs  {backs:.4f}"))
    if nothing >= LEAST:
        handles.append(Patch(facecolor="black", label=f"nothing  {nothing:.4f}"))
    return handles


def _draw_deltas(axes: Any, bar_axes: Any, resolution: int) -> None:
    from matplotlib.colors import LogNorm  # noqa: PLC0415

    top, side = delta_form_factors(resolution)
    values = np.ma.masked_invalid(_unfold([top, side, side, side, side], np.nan))
    # The lowest rows of the sides vanish with the height of a pixel: two decades show the rest.
    norm = LogNorm(values.max() / 100, values.max())
    image = axes.imshow(
        values, origin="lower", interpolation="nearest", extent=(-2, 2, -2, 2), norm=norm, cmap="cividis"
    )
    _draw_folds(axes)
    axes.set_title("What each pixel is worth")
    axes.figure.colorbar(image, cax=bar_axes, extend="min").set_label("delta form factor")


def _draw_folds(axes: Any) -> None:
    """The edges of the faces, and nothing else around."""
    for x, y in (
        ([-1, 1, 1, -1, -1], [-1, -1, 1, 1, -1]),
        ([-1, -1, 1, 1], [-1, -2, -2, -1]), ([-1, -1, 1, 1], [1, 2, 2, 1]),
        ([-1, -2, -2, -1], [-1, -1, 1, 1]), ([1, 2, 2, 1], [-1, -1, 1, 1]),
    ):  # fmt: skip
        axes.plot(x, y, color=INK, linewidth=1.0, solid_joinstyle="miter")
    axes.set(xlim=(-2.03, 2.03), ylim=(-2.03, 2.03))
    axes.set_axis_off()
    axes.text(0, -2.08, "horizon", ha="center", va="top", fontsize=10)


def _number(axes: Any, mask: npt.NDArray[np.bool_], resolution: int, number: int) -> None:
    """The number of a surface, where it is widest."""
    inside = distance_transform_edt(np.pad(mask, 1))[1:-1, 1:-1]
    row, column = np.unravel_index(np.argmax(inside), inside.shape)
    if inside[row, column] < resolution / 40:
        return
    x, y = (2 * (k + 0.5) / resolution - 2 for k in (column, row))
    box = {"boxstyle": "circle,pad=0.25", "facecolor": "white", "edgecolor": INK, "linewidth": 0.6}
    axes.text(x, y, str(number), ha="center", va="center", fontsize=8.5, bbox=box)


def _edges(owner: Integers) -> npt.NDArray[np.bool_]:
    """Pixels whose neighbour to the right or above is another's."""
    edge = np.zeros(owner.shape, bool)
    edge[:, :-1] |= owner[:, :-1] != owner[:, 1:]
    edge[:-1] |= owner[:-1] != owner[1:]
    return edge


def _unfold(faces: list[npt.NDArray[Any]], fill: float) -> npt.NDArray[Any]:
    """The cross of five faces; ``fill`` in the corners."""
    resolution = faces[0].shape[1]
    size, half = 2 * resolution, resolution // 2
    inner = slice(half, half + resolution)
    picture = np.full((size, size), fill)
    picture[inner, inner] = faces[0]
    picture[inner, size - half :] = faces[1][::-1].T
    picture[inner, :half] = faces[2].T
    picture[size - half :, inner] = faces[3][::-1]
    picture[:half, inner] = faces[4]
    return picture


def _corners(resolution: int) -> npt.NDArray[np.bool_]:
    """Where the unfolded square has no face."""
    k = np.arange(2 * resolution)
    outer = (k < resolution // 2) | (k >= 2 * resolution - resolution // 2)
    return outer[:, None] & outer[None, :]


def _patch_of_sides(patches: Patches) -> Integers:
    return np.concatenate([np.arange(len(patches)), np.flatnonzero(patches.two_sided)])


def _signed(owners: npt.NDArray[np.uint32]) -> Integers:
    """Owners with the codes of this module: the two greatest numbers are -1 and -2."""
    return owners.view(np.int32).astype(np.int64)


def _short(name: str, most: int = 22) -> str:
    return name if len(name) <= most else name[: most - 1] + "…"


def _even(resolution: int) -> int:
    number = whole(resolution, "resolution", 8, 4096)
    if number % 2:
        raise ValueError(f"the resolution of a hemicube is even, not {number}")
    return number
