"""Views and legend on one sheet."""

from __future__ import annotations

import io
import textwrap
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from radiosity.marking.kinds import TURNED, Mark
from radiosity.marking.stage import Stage, View
from radiosity.marking.views import ASPECT, Panel, visible_anchors
from radiosity.teaching.figures import INK, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Floats = npt.NDArray[np.float64]
Pixels = npt.NDArray[np.uint8]

DPI = 100

WIDTH = 1400
"""Pixels of the sheet."""

MARGIN, HEAD, ROW, LINE = 12, 44, 24, 17
"""Pixels around views, above them, and of a row of the legend and a further line in it."""

SAMPLES = 2
"""Rays along each edge of a pixel."""

PAPER = np.array([1.0, 1.0, 1.0])
CLAY = np.array([0.95, 0.94, 0.92])
TINTED = 0.72
"""How much of a tinted face is the colour of its mark."""

MOST_EDGES = 500
MOST_TOLD, MOST_LISTED = 12, 30
"""Findings whose messages are in the legend, and findings that are in it at all."""

_SEVERITY = {"error": "#B00020", "warning": "#A86200", "note": "#2A6F97"}


@dataclass(frozen=True)
class Box:
    """Where a view is on the sheet, in pixels from its upper left corner."""

    left: int
    top: int
    width: int
    height: int


def boxes(count: int) -> list[Box]:
    """One view over the whole width, or several in rows of two."""
    if count == 1:
        width = 1120
        return [Box((WIDTH - width) // 2, HEAD, width, round(width / ASPECT))]
    width = (WIDTH - 3 * MARGIN) // 2
    height = round(width / ASPECT)
    return [
        Box(MARGIN + (k % 2) * (width + MARGIN), HEAD + (k // 2) * (height + MARGIN), width, height)
        for k in range(count)
    ]


def png(stage: Stage, panels: list[Panel], title: str) -> bytes:
    """The sheet as a PNG file."""
    places = boxes(len(panels))
    bottom = max(box.top + box.height for box in places) + MARGIN
    legend = _legend(stage)
    height = bottom + MARGIN + sum(ROW + LINE * len(lines) for _, _, lines in legend) + MARGIN
    figure = new_figure(WIDTH / DPI, height / DPI)
    count = len(stage.marks)
    told = "nothing to remark" if not count else "1 finding" if count == 1 else f"{count} findings"
    _write(figure, MARGIN, HEAD / 2, f"{title}: {told}", height, size=14, weight="bold")
    shown: set[int] = set()
    for (view, seen, name), box in zip(panels, places, strict=True):
        axes = figure.add_axes(
            (box.left / WIDTH, 1 - (box.top + box.height) / height, box.width / WIDTH, box.height / height)
        )
        # What is hidden in every view is at least told where it would be.
        hidden = [] if shown or name else [m for m in stage.marks if len(m.anchors) and not _anywhere(m, panels)]
        _draw(axes, view, seen, hidden, name, box)
        shown |= {mark.number for mark in seen}
    _draw_legend(figure, legend, bottom + MARGIN, height)
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=DPI)
    return file.getvalue()


def _anywhere(mark: Mark, panels: list[Panel]) -> bool:
    return any(mark in seen for _, seen, _ in panels)


def shade(view: View, width: int, height: int) -> Pixels:
    """(height, width, 3) the scene in clay, faces of findings tinted, outlines in ink."""
    stage = view.stage
    face, distance = view.first_hits(SAMPLES * width, SAMPLES * height)
    there = face >= 0
    normal = stage.normal[face]
    # From above and from the left, so that walls that meet differ; what is behind counts as before.
    lamp = 1.0 * stage.up - 0.5 * view.axes[2] - 0.7 * view.axes[0]
    light = np.where(there, 0.62 + 0.38 * abs(normal @ (lamp / np.linalg.norm(lamp))), 1.0)
    colour = np.where(there[..., None], CLAY, PAPER)
    tint = np.where(there, stage.tint[face], -1)
    table = np.array([_rgb(mark.colour) for mark in stage.marks] + [PAPER])
    row, column = np.indices(face.shape)
    stripes = (row + column) // (6 * SAMPLES) % 2 == 0
    from_behind = (normal @ view.axes[2] > 0) & np.array([m.finding.code in TURNED for m in stage.marks] + [False])[
        tint
    ]
    strength = np.where(from_behind & stripes, 0.5 * TINTED, TINTED)
    colour = np.where((tint >= 0)[..., None], colour + strength[..., None] * (table[tint] - colour), colour)
    colour = colour * light[..., None]
    colour *= 1 - 0.10 * _borders(face)[..., None]
    colour *= 1 - 0.45 * _borders(np.where(there, stage.surface[face], -2))[..., None]
    colour *= 1 - 0.25 * _creases(normal, there, distance)[..., None]
    mean = colour.reshape(height, SAMPLES, width, SAMPLES, 3).mean(axis=(1, 3))
    return np.asarray(np.clip(255 * mean + 0.5, 0, 255), np.uint8)


def _borders(values: npt.NDArray[np.intp]) -> npt.NDArray[np.bool_]:
    """Pixels whose neighbour to the right or below is of another face."""
    border = np.zeros(values.shape, bool)
    border[:, :-1] |= values[:, 1:] != values[:, :-1]
    border[:-1] |= values[1:] != values[:-1]
    return border


def _creases(normal: Floats, there: npt.NDArray[np.bool_], distance: Floats) -> npt.NDArray[np.bool_]:
    """Pixels at which the direction of the surface changes, or one stands before another."""
    near = np.where(there, distance, 0.0)
    crease = np.zeros(there.shape, bool)
    for a, b in ((np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1], np.s_[1:])):
        bend = np.einsum("hwk,hwk->hw", normal[a], normal[b]) < 0.9
        step = abs(near[a] - near[b]) > 0.05 * np.maximum(near[a], near[b])
        crease[a] |= there[a] & there[b] & (bend | step)
    return crease


def _rgb(colour: str) -> Floats:
    return np.array([int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)])


def _draw(axes: Axes, view: View, seen: list[Mark], hidden: list[Mark], name: str, box: Box) -> None:
    axes.imshow(shade(view, box.width, box.height), extent=(0, box.width, box.height, 0), interpolation="nearest")
    axes.set(xlim=(0, box.width), ylim=(box.height, 0), xticks=[], yticks=[])
    for mark in reversed(view.stage.marks):
        _draw_edges(axes, view, mark, mark.outlines if mark in hidden and not len(mark.edges) else mark.edges, box)
    _draw_numbers(axes, view, seen, hidden, box)
    if name:
        frame = {"boxstyle": "round,pad=0.3", "fc": "white", "ec": INK, "lw": 0.6}
        axes.text(12, 22, name, fontsize=10, bbox=frame, va="center", zorder=9)


def _draw_edges(axes: Axes, view: View, mark: Mark, edges: Floats, box: Box) -> None:
    """Thick lines along edges, dimmed and broken where they are hidden."""
    from matplotlib.collections import LineCollection  # noqa: PLC0415

    if not len(edges):
        return
    edges = edges[:: max(1, len(edges) // MOST_EDGES)]
    steps = np.linspace(0, 1, 33 if len(edges) < 60 else 9)[None, :, None]
    points = edges[:, None, 0] + steps * (edges[:, None, 1] - edges[:, None, 0])
    n = points.shape[1]
    pixels = view.project(points.reshape(-1, 3), box.width, box.height).reshape(-1, n, 3)
    visible = view.sees(points.reshape(-1, 3)).reshape(-1, n)
    pieces = np.stack([pixels[:, :-1, :2], pixels[:, 1:, :2]], axis=2)
    usable = np.isfinite(pieces).all(axis=(2, 3)) & (abs(pieces).max(axis=(2, 3)) < 20 * WIDTH)
    clear = visible[:, :-1] & visible[:, 1:]
    thick = 3.2 if len(edges) < 40 else 2.2
    for which, style, width, alpha in ((~clear, (0, (2.2, 1.6)), 0.6 * thick, 0.6), (clear, "-", thick, 1.0)):
        lines = pieces[which & usable]
        if len(lines):
            runs = _runs(pieces, which & usable)
            if style == "-":
                axes.add_collection(
                    LineCollection(runs, colors="white", linewidths=width + 1.6, capstyle="round", zorder=3)
                )
            axes.add_collection(
                LineCollection(runs, colors=mark.colour, linewidths=width, linestyles=[style], alpha=alpha, zorder=4)
            )


def _runs(pieces: Floats, chosen: npt.NDArray[np.bool_]) -> list[Floats]:
    """Consecutive chosen pieces of each edge as one line, so that dashes run on."""
    lines = []
    for edge, wanted in zip(pieces, chosen, strict=True):
        bounds = np.flatnonzero(np.diff(np.concatenate([[0], wanted.astype(np.int8), [0]])))
        for start, end in bounds.reshape(-1, 2):
            lines.append(np.concatenate([edge[start:end, 0], edge[end - 1 : end, 1]]))
    return lines


def _draw_numbers(axes: Axes, view: View, seen: list[Mark], hidden: list[Mark], box: Box) -> None:
    """Numbers in circles beside the marks, off one another."""
    marks = seen + hidden
    places = [visible_anchors(view, mark) for mark in seen] + [mark.anchors for mark in hidden]
    pixels = [view.project(place[:1], box.width, box.height)[0, :2] for place in places]
    usable = [k for k, pixel in enumerate(pixels) if np.isfinite(pixel).all()]
    if not usable:
        return
    at = np.array([pixels[k] for k in usable])
    spots = _apart(at, box)
    for k, (x, y), (u, v) in zip(usable, at, spots, strict=True):
        mark, is_hidden = marks[k], k >= len(seen)
        axes.plot([x, u], [y, v], "-", color="white", lw=2.6, zorder=5, alpha=0.9)
        axes.plot([x, u], [y, v], ":" if is_hidden else "-", color=INK, lw=1.1, zorder=6)
        if not is_hidden:
            axes.plot([x], [y], "o", color=mark.colour, ms=5, mec="white", mew=1, zorder=7)
        _circle(axes, u, v, mark, is_hidden)


def _circle(axes: Axes, x: float, y: float, mark: Mark, is_hidden: bool = False) -> None:
    face = "white" if is_hidden else mark.colour
    axes.plot([x], [y], "o", ms=17, mfc=face, mec=mark.colour if is_hidden else "white", mew=1.3, zorder=8)
    ink = INK if is_hidden or _rgb(mark.colour) @ [0.3, 0.6, 0.1] > 0.6 else "white"
    axes.text(x, y, str(mark.number), fontsize=9, weight="bold", color=ink, ha="center", va="center_baseline", zorder=9)


def _apart(at: Floats, box: Box) -> Floats:
    """(n, 2) places for numbers: away from the middle of the picture, 30 pixels from one another and from the marks."""
    middle = np.array([box.width / 2, box.height / 2])
    away = at - middle
    length = np.linalg.norm(away, axis=1, keepdims=True)
    away = np.where(length > 1, away / np.maximum(length, 1), [0.0, -1.0])
    spots = at + 38 * away
    for _ in range(60):
        for i in range(len(spots)):
            push = np.zeros(2)
            for others, reach in ((np.delete(spots, i, axis=0), 30.0), (at, 26.0)):
                gap = spots[i] - others
                far = np.linalg.norm(gap, axis=1, keepdims=True)
                gap = np.where(far > 1e-6, gap / np.maximum(far, 1e-6), [[np.cos(2.4 * i), np.sin(2.4 * i)]])
                push += (np.maximum(reach - far, 0) * gap).sum(axis=0)
            spots[i] = np.clip(spots[i] + 0.5 * push, 16, [box.width - 16, box.height - 16])
    return np.asarray(spots)


Row = tuple[Mark | None, str, list[str]]
"""A finding in the legend: its mark, its line, and what it says."""


def _legend(stage: Stage) -> list[Row]:
    rows: list[Row] = []
    told = len(stage.marks) <= MOST_TOLD
    for mark in stage.marks[:MOST_LISTED]:
        finding = mark.finding
        parts = [_count(len(mark.faces), "face"), _count(len(mark.edges), "edge")]
        nowhere = "" if len(mark.anchors) else "not drawn"
        counts = ", ".join(part for part in [*parts, nowhere] if part) or "a place"
        element = textwrap.shorten(finding.element, 90, placeholder="...") or "the scene"
        message = textwrap.wrap(finding.message, 185, max_lines=2, placeholder=" ...") if told else []
        rows.append((mark, f"{element}   ({counts})", message))
    if len(stage.marks) > MOST_LISTED:
        rows.append((None, f"and {len(stage.marks) - MOST_LISTED} more: radiosity check lists all", []))
    if any(mark.finding.code in TURNED for mark in stage.marks):
        rows.append(
            (None, "Striped faces are seen from behind. Broken lines are hidden by what stands before them.", [])
        )
    elif any(len(mark.edges) for mark in stage.marks):
        rows.append((None, "Broken lines are hidden by what stands before them.", []))
    if not rows:
        rows.append((None, "No findings: neither shapes and paint nor rays tell of anything doubtful.", []))
    return rows


def _count(n: int, what: str) -> str:
    return f"{n:,} {what}{'s' if n != 1 else ''}" if n else ""


def _draw_legend(figure: Figure, rows: list[Row], top: float, height: int) -> None:
    axes = figure.add_axes((0, 0, 1, 1), zorder=-1)
    axes.set(xlim=(0, WIDTH), ylim=(height, 0))
    axes.axis("off")
    y = top + ROW / 2
    for mark, line, message in rows:
        if mark is None:
            _write(figure, MARGIN + 116, y, line, height, size=9, color="#555555")
        else:
            _circle(axes, MARGIN + 14, y, mark)
            severity = mark.finding.severity
            _write(figure, MARGIN + 36, y, severity, height, color=_SEVERITY[severity], weight="bold")
            _write(figure, MARGIN + 116, y, mark.finding.code, height, weight="bold")
            _write(figure, MARGIN + 310, y, line, height)
        for text in message:
            y += LINE
            _write(figure, MARGIN + 116, y, text, height, size=9, color="#555555")
        y += ROW


def _write(figure: Figure, x: float, y: float, text: str, height: int, size: float = 10.5, **options: Any) -> None:
    # A dollar sign in the name of a surface is no formula.
    figure.text(x / WIDTH, 1 - y / height, text, fontsize=size, va="center", parse_math=False, **options)
