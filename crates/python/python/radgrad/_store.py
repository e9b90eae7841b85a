"""Files that keep results: uncompressed `.npz` of bytes and one table, with a digest over all."""

from __future__ import annotations

import hashlib
import io
import json
import os
import zipfile
from typing import Any, Union

import numpy as np

from . import _radgrad

PathLike = Union[str, "os.PathLike[str]"]

#: Of the layout.
VERSION = 1

#: Bytes that reading a file may take unless others are asked for.
BUDGET = 4 << 30


def _digest(about: bytes, parts: "dict[str, bytes]") -> str:
    sha = hashlib.sha256(about)
    for name in sorted(parts):
        sha.update(name.encode() + b"\0" + len(parts[name]).to_bytes(8, "little"))
        sha.update(parts[name])
    return sha.hexdigest()


def save(file: PathLike, kind: str, about: "dict[str, Any]", parts: "dict[str, bytes]") -> None:
    """Write a file, whole or not at all."""
    path = os.fspath(file)
    if not path.lower().endswith(".npz"):
        raise ValueError(f"{path!r}: expected a name ending in .npz")
    text = json.dumps({"radgrad": VERSION, "kind": kind, **about}, sort_keys=True).encode()
    whole = {"about": text, "digest": _digest(text, parts).encode(), **parts}
    content = io.BytesIO()
    np.savez(content, **{name: np.frombuffer(part, dtype=np.uint8) for name, part in whole.items()})  # type: ignore[arg-type]
    _radgrad.write_whole(path, content.getvalue())


def load(file: PathLike, kind: str, wanted: "tuple[str, ...]", budget: int = BUDGET) -> "tuple[dict[str, Any], dict[str, bytes]]":
    """Read what `save` wrote; a ValueError if it is anything else."""
    path = os.fspath(file)
    content = _radgrad.read_regular(path, budget)

    def refused(what: str) -> ValueError:
        return ValueError(f"{path!r}: {what}: expected a file that a radgrad.{kind} saved; save it again")

    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            # What is compressed may be of any size.
            if any(info.compress_type != zipfile.ZIP_STORED or info.file_size > len(content) for info in archive.infolist()):
                raise refused("it has compressed parts")
        with np.load(io.BytesIO(content), allow_pickle=False) as arrays:
            names = set(arrays.files)
            if not {"about", "digest", *wanted} <= names:
                raise refused(f"it has {sorted(names)} and lacks {sorted({'about', 'digest', *wanted} - names)}")
            parts = {name: bytes(arrays[name].tobytes()) for name in ("about", "digest", *wanted)}
        text, digest = parts.pop("about"), parts.pop("digest")
        if _digest(text, parts).encode() != digest:
            raise refused("its content is not what was written: it is damaged")
        about = json.loads(text)
    # zipfile, numpy, ast and tokenize raise almost anything where a byte is wrong.
    except Exception as error:
        raise error if str(error).startswith(repr(path)) else refused(str(error) or type(error).__name__) from None
    if about.get("kind") != kind:
        raise refused(f"it holds a radgrad.{about.get('kind')}")
    if about.get("radgrad") != VERSION:
        raise refused(f"its layout is {about.get('radgrad')}, and this version reads {VERSION}")
    return about, parts
