"""Form factors between whole surfaces."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import IO, TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_array

from radiosity.files import write_whole

if TYPE_CHECKING:
    from radiosity.factors import FormFactors

Floats = npt.NDArray[np.float64]

SUFFIXES = (".npz", ".csv")
"""What :meth:`SurfaceFactors.save` writes."""


@dataclass(frozen=True, eq=False)
class SurfaceFactors:
    """Form factors between surfaces, made by :meth:`radiosity.FormFactors.by_surface`; prints as a table.

    Attributes:
        names: of the surfaces in the order of the scene, then of the backs of two-sided ones, as "NAME (back)".
            Surfaces that are combined with another count with it; those that nothing is left of are left out.
        area: (m,) m2.
        F: (m, m) the fraction of what leaves surface i evenly that arrives at surface j.
    """

    names: tuple[str, ...]
    area: Floats
    F: Floats

    def __str__(self) -> str:
        heads = (*self.names, "sum")
        left, widths = max(map(len, ("from | to", *self.names))), [max(len(head), 6) for head in heads]
        lines = [[f"{'from | to':<{left}}", *(f"{head:>{w}}" for head, w in zip(heads, widths, strict=True))]]
        for name, row in zip(self.names, np.column_stack([self.F, self.closure()]), strict=True):
            lines.append([f"{name:<{left}}", *(f"{factor:>{w}.4f}" for factor, w in zip(row, widths, strict=True))])
        return "\n".join(map(" ".join, lines))

    def closure(self) -> Floats:
        """(m,) row sums: 1 in a closed enclosure up to the error of the method, never normalised."""
        return np.asarray(self.F.sum(axis=1))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write ``.npz`` (arrays names, area and F) or ``.csv`` (F, with names above and on the left).

        The file appears whole or not at all.

        Raises:
            ValueError: another suffix.
            OSError: the disk is full, the folder is missing ...
        """
        suffix = Path(path).suffix.lower()
        if suffix == ".npz":
            arrays = {"names": np.array(self.names), "area": self.area, "F": self.F}
            write_whole(Path(path), lambda file: np.savez_compressed(file, **arrays))  # type: ignore[arg-type]
        elif suffix == ".csv":
            write_whole(Path(path), self._write_table)
        else:
            raise ValueError(f"{path}: cannot write '{suffix}' files of form factors; use one of {', '.join(SUFFIXES)}")

    def _write_table(self, file: IO[bytes]) -> None:
        import csv  # noqa: PLC0415
        import io  # noqa: PLC0415

        text = io.TextIOWrapper(file, encoding="utf-8", newline="")
        writer = csv.writer(text)
        writer.writerow(["", *self.names])
        for name, row in zip(self.names, self.F.tolist(), strict=True):
            writer.writerow([name, *map(repr, row)])
        text.flush()
        text.detach()


def summed(factors: FormFactors) -> SurfaceFactors:
    """F between surfaces: ``F_AB`` = sum over i in A and j in B of ``A_i F_ij``, by the area of A."""
    keys, group = np.unique(_sides(factors), return_inverse=True)
    n, m = len(group), len(keys)
    member = csr_array((np.ones(n), (np.arange(n), group)), shape=(n, m))
    exchange = factors.to_scipy_sparse()
    exchange.data *= np.repeat(factors.area, np.diff(exchange.indptr))
    area = np.asarray(member.T @ factors.area)
    between = (member.T @ exchange @ member).toarray() / area[:, None]
    names = [surface.name for surface in factors.patches.scene.surfaces]
    count = len(names)
    return SurfaceFactors(tuple(names[k] if k < count else f"{names[k - count]} (back)" for k in keys), area, between)


def _sides(factors: FormFactors) -> npt.NDArray[np.int64]:
    """(n,) what each row counts with: the index of a surface, or, for backs, that plus the number of surfaces."""
    patches = factors.patches
    count = len(patches.scene.surfaces)
    whole = np.arange(count)
    for part, counts_with in patches.scene.combined.items():
        whole[part] = counts_with
    is_back = np.arange(factors.shape[0]) >= len(patches)
    return whole[patches.surface[factors.patch]] + count * is_back
