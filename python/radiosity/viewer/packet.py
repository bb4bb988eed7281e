"""A head and arrays in one block of bytes, which a browser reads without copying.

8 bytes   "RADPKT01"
4 bytes   length of the JSON that follows, little endian
JSON      {"head": {...}, "arrays": {name: {"type": "f4", "shape": [n, 3], "offset": 0}}}, padded with spaces
data      from the next multiple of 8 on; offsets count from its beginning and are multiples of 8; little endian
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
import numpy.typing as npt

MAGIC = b"RADPKT01"

_TYPES = {"f4": np.dtype("<f4"), "u4": np.dtype("<u4")}
_ALIGNMENT = 8


def pack(head: Any, arrays: Mapping[str, npt.NDArray[Any]]) -> bytes:
    """The bytes of a head, which is a dataclass, and arrays of floats (as f4) or whole numbers (as u4)."""
    described, blocks, offset = {}, [], 0
    for name, array in arrays.items():
        kind = "f4" if np.issubdtype(array.dtype, np.floating) else "u4"
        data = np.ascontiguousarray(array, dtype=_TYPES[kind]).tobytes()
        described[name] = {"type": kind, "shape": list(array.shape), "offset": offset}
        data += b"\0" * (-len(data) % _ALIGNMENT)
        blocks.append(data)
        offset += len(data)
    text = json.dumps({"head": _plain(asdict(head)), "arrays": described}, allow_nan=False).encode()
    text += b" " * (-(len(MAGIC) + 4 + len(text)) % _ALIGNMENT)
    return b"".join([MAGIC, struct.pack("<I", len(text)), text, *blocks])


def unpack(data: bytes) -> tuple[dict[str, Any], dict[str, npt.NDArray[Any]]]:
    """The head as a dictionary, and the arrays.

    Raises:
        ValueError: it is no packet.
    """
    if data[: len(MAGIC)] != MAGIC:
        raise ValueError("this is no packet: it does not begin with RADPKT01")
    try:
        return _unpacked(data, len(MAGIC) + 4)
    except (struct.error, ValueError, KeyError, TypeError) as error:
        raise ValueError("this packet is damaged") from error


def _unpacked(data: bytes, begin: int) -> tuple[dict[str, Any], dict[str, npt.NDArray[Any]]]:
    (length,) = struct.unpack_from("<I", data, len(MAGIC))
    said = json.loads(data[begin : begin + length])
    arrays = {
        name: np.frombuffer(data, _TYPES[a["type"]], math.prod(a["shape"]), begin + length + a["offset"]).reshape(
            a["shape"]
        )
        if math.prod(a["shape"])
        else np.zeros(a["shape"], _TYPES[a["type"]])
        for name, a in said["arrays"].items()
    }
    return said["head"], arrays


def _plain(value: Any) -> Any:
    """Numbers that JSON has: infinities and NaNs become None, numpy's become Python's."""
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value
