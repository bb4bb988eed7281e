"""Form factors as a linear operator."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_array
from scipy.sparse.linalg import LinearOperator

from radiosity import _native
from radiosity.checks import memory_or_most, threads_or_all, whole

if TYPE_CHECKING:
    from radiosity.patches import Patches
    from radiosity.surface_factors import SurfaceFactors

Floats = npt.NDArray[np.float64]
Progress = Callable[[int, int], object]

Method = Literal["auto", "analytic", "contour", "nusselt", "hemicube", "monte_carlo", "hierarchical"]

METHODS: tuple[Method, ...] = get_args(Method)
"""The names of all methods."""

SINGLE_METHODS: tuple[Method, ...] = tuple(name for name in METHODS if name != "hierarchical")
"""Those that measure single form factors."""

DEFAULT_TOLERANCE = 1e-6
"""Wanted error of a form factor where the caller does not say."""

DEFAULT_BLOCK_TOLERANCE = 1e-2
"""Wanted error of products of the method ``hierarchical`` where the caller does not say."""

LEAST_BLOCK_TOLERANCE = 5e-4
"""Blocks of rank one are no better than this."""

MANY_PATCHES = 10_000
"""With so many sides and a tolerance that blocks reach, ``auto`` takes blocks."""

DEFAULT_RAYS = 4096
"""Rays per patch of the method ``monte_carlo``."""

MAX_RAYS = 1 << 22
"""The most rays per patch."""

MAX_POINTS = 64
"""The most points per direction of the method ``nusselt``."""

DEFAULT_RESOLUTION = 512
"""Pixels along an edge of a hemicube."""


@dataclass(frozen=True)
class FactorReport:
    """How form factors were found and how wrong they may be; prints as a table.

    ``estimated_error`` is an estimate of the greatest error of a form factor of the smaller patch of a pair;
    ``disagreement`` the greatest difference of what both ends of a pair measured, likewise, before they were combined
    (zero where a pair is measured once for both). ``samples`` are points, hemicubes or rays of every patch.
    ``unresolved`` counts partly hidden pairs whose estimated error exceeds what the tolerance allows them. ``links``
    are blocks of rank one; of those ``estimated_error`` is the error of row sums, root mean square over area, by
    independent rays. ``why`` says why this method was chosen where it was left to choose.
    """

    method: str
    tolerance: float | None
    estimated_error: float
    disagreement: float
    samples: int
    pairs_in_full_view: int
    pairs_partly_hidden: int
    pairs_hidden: int
    by_areas: int
    by_contour: int
    by_rays: int
    links_in_full_view: int
    links_partly_hidden: int
    rays: int
    unresolved: int
    memory_bytes: int
    seconds: float
    why: str = ""

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers and strings, ready for JSON."""
        return asdict(self)

    def __str__(self) -> str:
        wanted = "" if self.tolerance is None else f" (asked for {self.tolerance:.1e})"
        rows = [
            ("method", self.method + (f" ({self.why})" if self.why else "")),
            ("estimated error", f"{self.estimated_error:.1e}{wanted}"),
        ]
        if self.disagreement:
            rows.append(("ends disagree by", f"{self.disagreement:.1e}"))
        if self.samples:
            rows.append(("samples", f"{self.samples:,} of every patch"))
        if self.by_areas + self.by_contour:
            rows.append(("pairs", f"{self.pairs_in_full_view:,} in full view, {self.pairs_partly_hidden:,} looked at "
                         f"for what is between, {self.pairs_hidden:,} hidden"))  # fmt: skip
            rows.append(("unoccluded by", f"{self.by_areas:,} area and {self.by_contour:,} contour integrals"))
        if self.links_in_full_view + self.links_partly_hidden:
            rows.append(
                ("blocks", f"{self.links_in_full_view:,} in full view, {self.links_partly_hidden:,} partly hidden")
            )
        if self.rays:
            rows.append(("rays", f"{self.rays:,}"))
        if self.unresolved:
            rows.append(("unresolved", f"{self.unresolved:,} pairs: their error exceeds what was asked"))
        memory, unit = (self.memory_bytes / 1e6, "MB") if self.memory_bytes >= 1e5 else (self.memory_bytes / 1e3, "kB")
        rows += [("memory", f"{memory:.1f} {unit}"), ("time", f"{self.seconds:.2f} s")]
        return "\n".join(f"{label:<18}{value}" for label, value in rows)


class FormFactors(LinearOperator):  # type: ignore[misc]
    """F with ``F[i, j]`` the fraction of what leaves patch i that arrives at patch j, (n, n).

    Stored as the symmetric exchange ``G = A F``, so that ``A_i F_ij = A_j F_ji`` holds exactly. Row sums are what was
    measured, never normalised. Where patches are two-sided, rows and columns are sides: the fronts of all patches,
    then the backs of the two-sided ones; ``patch`` says whose.

    Attributes:
        patches: what they are between.
        patch: (n,) the patch of each row and column; ``arange(n)`` where all are one-sided.
        area: (n,) m2.
        report: how they were found and how wrong they may be.
    """

    def __init__(
        self, patches: Patches, native: _native.Factors, method: str, tolerance: float | None, why: str = ""
    ) -> None:
        self.patches = patches
        self.patch = native.patch
        self.area = patches.area[self.patch]
        self.report = FactorReport(method=method, tolerance=tolerance, why=why, **native.report())
        self._native = native
        with np.errstate(divide="ignore"):
            self._inverse_area = np.where(self.area > 0, 1 / self.area, 0.0)
        super().__init__(dtype=np.float64, shape=(len(native), len(native)))

    def __repr__(self) -> str:
        return f"FormFactors({self.shape[0]} x {self.shape[1]} by {self.report.method})"

    def _matmat(self, x: npt.ArrayLike) -> Floats:
        block = np.ascontiguousarray(x, dtype=np.float64)
        return self._native.exchange(block) * self._inverse_area[:, None]

    def _matvec(self, x: npt.ArrayLike) -> Floats:
        return self._matmat(np.reshape(x, (-1, 1)))[:, 0]

    def _rmatvec(self, x: npt.ArrayLike) -> Floats:
        # F^T = (A^-1 G)^T = G A^-1.
        scaled = np.ascontiguousarray((np.ravel(x) * self._inverse_area)[:, None])
        return self._native.exchange(scaled)[:, 0]

    def row(self, i: int) -> Floats:
        """(n,) form factors from patch i.

        Raises:
            IndexError: there is no such patch.
        """
        n = self.shape[0]
        if not -n <= i < n:
            raise IndexError(f"row {i} of {n} patches")
        row = np.zeros(n)
        columns, values = self._native.row(i % n)
        row[columns] = values * self._inverse_area[i]
        return row

    def toarray(self) -> Floats:
        """(n, n) dense form factors."""
        return self._native.dense()

    def to_scipy_sparse(self) -> csr_array:
        """(n, n) compressed rows of the factors that are not zero."""
        return self._compressed(self._native.csr())

    def _compressed(self, rows: _native.CsrTuple) -> csr_array:
        offsets, columns, values = rows
        return csr_array((values, columns.astype(np.int32), offsets), shape=self.shape)

    def count(self) -> int:
        """The number of factors that are not zero, without copies of them."""
        return self._native.count()

    def standard_error(self) -> csr_array:
        """(n, n) compressed rows: the standard error of each factor above zero, of the method ``monte_carlo``.

        It is that of as many independent rays; quasi-random rays do better. A factor without an entry was hit by no
        ray: with 95 % probability it is below 3 / rays.

        Raises:
            ValueError: another method found them; see ``report.estimated_error``.
        """
        rows = self._native.standard_error()
        if rows is None:
            raise ValueError(f"{self.report.method} has no standard errors; see report.estimated_error")
        return self._compressed(rows)

    def closure(self) -> Floats:
        """(n,) raw row sums: 1 in a closed enclosure up to the error of the method, never normalised."""
        return self._matvec(np.ones(self.shape[0]))

    def reciprocity_error(self) -> float:
        """The greatest ``|A_i F_ij - A_j F_ji|`` relative to the smaller area: rounding, since one G serves both.

        ``report.disagreement`` tells how far apart both ends were before they were combined.
        """
        matrix = self.to_scipy_sparse()
        exchange = csr_array(
            (matrix.data * np.repeat(self.area, np.diff(matrix.indptr)), matrix.indices, matrix.indptr)
        )
        difference = abs(exchange - exchange.T).tocoo()
        if difference.nnz == 0:
            return 0.0
        rows, columns = difference.coords
        return float(np.max(difference.data / np.minimum(self.area[rows], self.area[columns])))

    def enforce(self, what: Literal["closure"] = "closure", sums: npt.ArrayLike = 1.0) -> FormFactors:
        """Form factors nearest to these, reciprocal, not negative, whose rows sum to what is known.

        Least squares, weighted by standard errors where rays found the factors and by their size elsewhere: Larsen
        and Howell (1986), *Least-squares smoothing of direct-exchange areas in zonal analysis*, J. Heat Transfer 108,
        239. These factors stay as they are.

        Args:
            what: "closure".
            sums: wanted row sums, one for all or (n,): 1 in a closed enclosure.

        Raises:
            ValueError: sums that are not in [0, 1], or that no reciprocal factors have, such as 1 for two plates of
                different area that see only each other.
        """
        if self.report.method == "hierarchical":
            raise ValueError("the exchange is hierarchical and keeps no single form factors: measure with method auto")
        if what != "closure":
            raise ValueError(f"there is nothing to enforce by the name '{what}'; closure can be")
        wanted = np.broadcast_to(np.asarray(sums, dtype=np.float64), self.shape[:1])
        if not np.all((wanted >= 0) & (wanted <= 1)):
            raise ValueError("row sums of form factors must be within 0 and 1")
        blind = np.flatnonzero((self.closure() == 0) & (wanted > 0) & (self.area > 0))
        if len(blind):
            raise ValueError(f"patch {self.patch[blind[0]]} sees nothing, so that its row cannot sum to 1")
        native, left = self._native.smoothed(wanted.tolist())
        if left > ENFORCED:
            raise ValueError(f"no reciprocal form factors have these row sums: some stay {left:.1e} off")
        return FormFactors(self.patches, native, self.report.method, self.report.tolerance)

    def by_surface(self) -> SurfaceFactors:
        """The form factors between whole surfaces; those that the scene combines count as one."""
        from radiosity.surface_factors import summed  # noqa: PLC0415

        return summed(self)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write ``.npz`` (reads back with :meth:`load` and with ``scipy.sparse.load_npz``), ``.csv`` or ``.exchange``.

        An ``.exchange`` is not compressed and needs no memory to be read. The file appears whole or not at all.

        Raises:
            ValueError: another suffix.
            OSError: the disk is full, the folder is missing ...
        """
        from radiosity.factor_files import save_factors  # noqa: PLC0415

        save_factors(self, path)

    @classmethod
    def load(
        cls,
        path: str | os.PathLike[str],
        patches: Patches | None = None,
        *,
        verify: bool = False,
        memory_limit: int | None = None,
    ) -> FormFactors:
        """Read what :meth:`save` wrote as ``.npz`` or ``.exchange``.

        An ``.exchange`` is mapped: it opens at once, whatever its size, and its numbers are read from the disk as they
        are used. Do not write to a file that is open so: to replace it, delete it or rename another one to its name,
        as this package does.

        Args:
            path: the file.
            patches: what the factors are between, to solve on them. By default patches are made anew from the file,
                with the reflectance and emission of their surfaces.
            verify: read all of an ``.exchange`` and hold it against its checksums. Its structure is always checked.
            memory_limit: bytes; what is read of an ``.exchange`` that is larger does not stay in memory (default: four
                fifths of what is available).

        Raises:
            ValueError: no such file, or damaged, or it was measured on other patches.
            OSError: the file cannot be read.
        """
        from radiosity.factor_files import load_factors  # noqa: PLC0415

        return load_factors(path, patches, verify=verify, memory_limit=memory_limit)


ENFORCED = 1e-6
"""Relative deviation of a row sum above which it counts as not met."""


def form_factors(
    patches: Patches,
    *,
    method: Method = "auto",
    tolerance: float | None = None,
    rays: int | None = None,
    resolution: int | None = None,
    hemicubes: int | None = None,
    points: int | None = None,
    seed: int = 0,
    memory_limit: int | None = None,
    checkpoint: str | os.PathLike[str] | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
) -> FormFactors:
    """Measure the form factors between all patches, whatever stands between them.

    With ``checkpoint="F.exchange"`` they are measured onto that file, block by block, and used from there: they need
    not fit the memory. While it is built it is ``F.exchange.partial``; if the process ends early, the same call goes
    on from there, and the file has the same bytes in the end. If the file is there already it is opened. The methods
    "hemicube", "monte_carlo" and, without ``points``, "nusselt" write in the end only.

    Args:
        patches: the patches; where some are two-sided, their backs take part and follow all fronts.
        method: how.
            "auto": per pair the cheapest way that meets the tolerance: Gauss points on both areas, contour integrals
            where patches are near or touch; where something may stand between, exactly what is visible, integrated
            adaptively, or a few rays where they suffice.
            "analytic": closed forms where all edges are parallel or perpendicular, contour integrals to 1e-12
            elsewhere.
            "contour": contour integrals for every pair.
            "nusselt": Nusselt's analog, the projected area on the base of the hemisphere, averaged over points.
            "hemicube": item buffers of hemicubes on every patch (Cohen and Greenberg 1985).
            "monte_carlo": quasi-random cosine-distributed rays from every patch.
            "hierarchical": for a great many patches: what is far apart in blocks of rank one, what is near pair by
            pair; memory and time grow nearly as the number of patches does. Products are to the tolerance, single
            factors are not. "auto" takes it from 10,000 patches on where the tolerance is 5e-4 or more.
            A count below that is given with "auto" chooses the method it belongs to.
        tolerance: wanted error of a form factor, and of a row sum (default 1e-6). Nusselt's analog and hemicubes take
            points and hemicubes until both ends of pairs and successive answers agree as well, within limits;
            ``report.estimated_error`` says what was reached. For rays the standard error of one form factor at worst.
            Of "hierarchical" the error of ``F @ x`` for x from 0 to 1, root mean square over area (default 1e-2, 5e-4
            at least).
        rays: rays per patch of "monte_carlo" (default 4,096), instead of a tolerance.
        resolution: pixels along an edge of a hemicube (default 512), even.
        hemicubes: hemicubes per patch (default 1, at the centroid), instead of a tolerance.
        points: points per direction of "nusselt" (default 4, that is 16 points a patch), instead of a tolerance.
        seed: the same seed gives the same bytes.
        memory_limit: bytes that may be taken (default: four fifths of what is available). With a checkpoint, what is
            at hand while measuring; if the file is larger, what is read of it does not stay in memory.
        checkpoint: an ``.exchange`` file to measure onto.
        threads: default: all cores. The answer does not depend on it.
        progress: called with (done, total) some twenty times a second.

    Raises:
        ValueError: no such method, a count that does not go with the method, a tolerance out of reach; mirrors or clear
            glass, which form factors leave out; a checkpoint of other patches or settings (delete it to start over), or
            a damaged one.
        ResourceError: the form factors may not fit the memory limit.
        OSError: the checkpoint cannot be written. If the disk is full, what is done stays: make room and call again.
        BlockingIOError: another process is measuring onto the same file.
    """
    if method not in METHODS:
        raise ValueError(f"there is no method '{method}'; choose {', '.join(METHODS[:-1])} or {METHODS[-1]}")
    if tolerance is not None and not 0 < tolerance < np.inf:
        raise ValueError(f"tolerance must be a positive number such as 1e-4, not {tolerance}")
    counts = {"rays": rays, "resolution": resolution, "hemicubes": hemicubes, "points": points}
    method = _method_of(method, {name: count for name, count in counts.items() if count is not None})
    method, why = _scaled(method, patches, tolerance)
    samples, wanted = _samples(method, tolerance, rays, hemicubes, points)
    with _explained(checkpoint):
        native = _native.form_factors(
            patches._diffuse_enclosure("form factors"),
            method,
            DEFAULT_TOLERANCE if wanted is None else wanted,
            samples,
            _pixels(resolution),
            whole(seed, "seed", 0, 2**64 - 1),
            memory_or_most(memory_limit),
            None if checkpoint is None else _onto(checkpoint, patches, method, wanted),
            threads_or_all(threads),
            progress,
        )
    return FormFactors(patches, native, method, wanted, why)


def _scaled(method: Method, patches: Patches, tolerance: float | None) -> tuple[Method, str]:
    """The method, blocks if it was left to choose and they suit so many patches; and why."""
    sides = len(patches) + int(np.count_nonzero(patches.two_sided))
    if method != "auto" or sides < MANY_PATCHES or tolerance is None or tolerance < LEAST_BLOCK_TOLERANCE:
        return method, ""
    return "hierarchical", f"{sides:,} sides and a tolerance of {tolerance:.1e}"


def _onto(
    checkpoint: str | os.PathLike[str], patches: Patches, method: str, tolerance: float | None
) -> tuple[str, str]:
    """The path of a checkpoint and what the file is to say."""
    from radiosity.exchange_files import describe, is_exchange  # noqa: PLC0415

    if not is_exchange(checkpoint):
        raise ValueError(f"{checkpoint}: name a checkpoint that ends in .exchange")
    return os.fspath(checkpoint), describe(patches, method, tolerance)


@contextmanager
def _explained(checkpoint: str | os.PathLike[str] | None) -> Iterator[None]:
    """Have an interruption say how to go on."""
    try:
        yield
    except KeyboardInterrupt as interruption:
        if checkpoint is not None:
            from radiosity.exchange_files import partial_name  # noqa: PLC0415

            partial = partial_name(checkpoint)
            if partial.exists():
                interruption.add_note(f"what was measured is in {partial}: do the same again to go on from there")
        raise


_COUNTS: dict[Method, set[str]] = {
    "nusselt": {"points"},
    "hemicube": {"resolution", "hemicubes"},
    "monte_carlo": {"rays"},
}


def _method_of(method: Method, counts: dict[str, int]) -> Method:
    """The method; that which goes with the counts given, if it was left to choose."""
    for name in counts:
        if method == "auto":
            method = next(m for m, own in _COUNTS.items() if name in own)
        elif name not in _COUNTS.get(method, set()):
            raise ValueError(f"the method {method} takes no {name}")
    return method


def _samples(
    method: str, tolerance: float | None, rays: int | None, hemicubes: int | None, points: int | None
) -> tuple[int | None, float | None]:
    """How many samples a method is to take, None for as many as the tolerance needs, and the tolerance."""
    if method == "monte_carlo":
        if rays is None:
            rays = DEFAULT_RAYS if tolerance is None else _rays_for(tolerance)
        return whole(rays, "rays", 1, MAX_RAYS), tolerance
    if method == "nusselt":
        few = 4 if tolerance is None else None
        return few if points is None else whole(points, "points", 1, MAX_POINTS), tolerance
    if method == "hemicube":
        few = 1 if tolerance is None else None
        return few if hemicubes is None else whole(hemicubes, "hemicubes", 1, 4096), tolerance
    if method == "hierarchical":
        if tolerance is not None and tolerance < LEAST_BLOCK_TOLERANCE:
            raise ValueError(
                f"a tolerance of {tolerance} is out of reach of blocks: ask for {LEAST_BLOCK_TOLERANCE} or more, "
                "or measure pair by pair with method auto"
            )
        return None, DEFAULT_BLOCK_TOLERANCE if tolerance is None else tolerance
    return None, DEFAULT_TOLERANCE if tolerance is None else tolerance


def _pixels(resolution: int | None) -> int:
    """Pixels along an edge of a hemicube, whose sides are half as high."""
    pixels = DEFAULT_RESOLUTION if resolution is None else whole(resolution, "resolution", 8, 4096)
    if pixels % 2:
        raise ValueError(f"resolution must be even, not {pixels}")
    return pixels


def _rays_for(tolerance: float) -> int:
    """Rays that bring the standard error of the worst factor, 1/2, down to ``tolerance``."""
    least = 0.5 / MAX_RAYS**0.5
    if tolerance < least:
        raise ValueError(f"a tolerance of {tolerance} is out of reach of rays: ask for {least:.1e} or more")
    return int(np.ceil(0.25 / tolerance**2))
