"""Files of form factors: arrays that scipy opens too, and tables."""

from __future__ import annotations

import json
import os
import zipfile
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from radiosity import _native
from radiosity.exchange_files import ExchangeFile, is_exchange, save_exchange
from radiosity.factors import FormFactors
from radiosity.files import write_whole
from radiosity.scene import Scene, Surface

if TYPE_CHECKING:
    from radiosity.patches import Patches

PathLike = str | os.PathLike[str]
Arrays = dict[str, npt.NDArray[Any]]

SUFFIXES = (".npz", ".csv", ".exchange")
"""What :func:`save_factors` writes."""


def save_factors(factors: FormFactors, path: PathLike) -> None:
    """Write form factors as ``.npz``, ``.csv`` or ``.exchange``; the file appears whole or not at all."""
    suffix = Path(path).suffix.lower()
    if is_exchange(path):
        save_exchange(factors, path)
    elif suffix == ".npz":
        write_whole(Path(path), lambda file: np.savez_compressed(file, **_arrays(factors)))  # type: ignore[arg-type]
    elif suffix == ".csv":
        write_whole(Path(path), lambda file: _write_table(factors, file))
    else:
        raise ValueError(f"{path}: cannot write '{suffix}' files of form factors; use one of {', '.join(SUFFIXES)}")


def _arrays(factors: FormFactors) -> Arrays:
    """F as scipy.sparse.save_npz has it, beside what the rows are and what they were cut from."""
    matrix, p = factors.to_scipy_sparse(), factors.patches
    report = {name: value for name, value in factors.report.to_dict().items() if name != "seconds"}
    return {
        "format": np.array(b"csr"), "shape": np.array(matrix.shape),
        "data": matrix.data, "indices": matrix.indices, "indptr": matrix.indptr,
        "patch": factors.patch, "closure": factors.closure(),
        "area": p.area, "centre": p.centre, "normal": p.normal, "surface": p.surface, "face": p.face,
        "polygons": p.polygons, "two_sided": p.two_sided, "obstructions": p.obstructions,
        "surface_names": np.array([s.name for s in p.scene.surfaces]),
        "combined": np.array(list(p.scene.combined.items()), dtype=np.int64).reshape(-1, 2),
        "bands": np.array(p.scene.bands),
        "reflectance": p.reflectance, "emission": p.emission, "report": np.array(json.dumps(report)),
    }  # fmt: skip


def _write_table(factors: FormFactors, file: IO[bytes]) -> None:
    """One line per factor above zero: from, to, factor, and the names of the surfaces."""
    import csv  # noqa: PLC0415
    import io  # noqa: PLC0415

    text = io.TextIOWrapper(file, encoding="utf-8", newline="")
    writer = csv.writer(text)
    writer.writerow(["from", "to", "factor", "from_surface", "to_surface"])
    matrix = factors.to_scipy_sparse()
    names = [s.name for s in factors.patches.scene.surfaces]
    surface = [names[k] for k in factors.patches.surface[factors.patch]]
    for i in range(matrix.shape[0]):
        row = slice(matrix.indptr[i], matrix.indptr[i + 1])
        for j, f in zip(matrix.indices[row].tolist(), matrix.data[row].tolist(), strict=True):
            writer.writerow([i, j, repr(f), surface[i], surface[j]])
    text.flush()
    text.detach()


def load_factors(
    path: PathLike, patches: Patches | None = None, *, verify: bool = False, memory_limit: int | None = None
) -> FormFactors:
    """Read form factors that :func:`save_factors` wrote as ``.npz`` or ``.exchange``."""
    if is_exchange(path):
        return ExchangeFile(path, verify=verify).factors(patches, memory_limit)
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = dict(file)
        report = json.loads(str(arrays["report"]))
        found = scene_of(arrays).patches(as_is=True)
        offsets, columns = arrays["indptr"].astype(np.int64), arrays["indices"].astype(np.uint32)
        values = np.ascontiguousarray(arrays["data"], dtype=np.float64)
    except (KeyError, ValueError, EOFError, zipfile.BadZipFile) as e:
        raise ValueError(f"{path}: this is no file of form factors, or it is damaged ({e})") from e
    if patches is None:
        patches = found
    elif not np.array_equal(patches.polygons, found.polygons):
        raise ValueError(f"{path}: these form factors are between other patches")
    try:
        native = _native.given_factors(patches._diffuse_enclosure("form factors"), offsets, columns, values)
    except ValueError as e:
        raise ValueError(f"{path}: {e}") from e
    return FormFactors(patches, native, report["method"], report["tolerance"])


def scene_of(arrays: Arrays) -> Scene:
    """The surfaces as they were cut, a face a patch."""
    surfaces = [
        Surface(
            arrays["polygons"][of].reshape(-1, 3),
            _faces(arrays["polygons"][of]),
            _paint(arrays["reflectance"][of]),
            arrays["emission"][of][0] if np.any(of) else 0.0,
            str(name),
            two_sided=bool(np.any(arrays["two_sided"][of])),
        )
        for name, of in ((name, arrays["surface"] == k) for k, name in enumerate(arrays["surface_names"]))
    ]
    blockers = arrays["obstructions"]
    obstructions = [Surface(blockers.reshape(-1, 3), _faces(blockers), name="obstructions")] if len(blockers) else []
    bands = [str(band) for band in arrays["bands"]]
    combined = {int(part): int(whole) for part, whole in arrays.get("combined", [])}
    return Scene(surfaces, bands=bands, obstructions=obstructions, name="form factors", combined=combined)


def _paint(reflectance: npt.NDArray[Any]) -> npt.ArrayLike:
    """(bands,) of a surface from (k, bands) of its patches: the mean where textures make them differ."""
    if not len(reflectance):
        return 0.5
    is_one = bool(np.all(reflectance == reflectance[0]))
    return np.asarray(reflectance[0] if is_one else reflectance.mean(axis=0))


def _faces(polygons: npt.NDArray[Any]) -> npt.NDArray[np.int64]:
    """A face for each polygon of four corners; a triangle repeats its last index as it repeats its last corner."""
    faces = np.arange(4 * len(polygons)).reshape(-1, 4)
    triangle = np.all(polygons[:, 2] == polygons[:, 3], axis=1) if len(polygons) else np.zeros(0, bool)
    faces[triangle, 3] = faces[triangle, 2]
    return faces
