"""How kernels are compiled: without Python objects, without the interpreter's lock, and once for all later runs.

Numba notices an edit in the file of a kernel, but not in the files of the kernels that it calls. So what is kept is
valid for all files with kernels as they were: an edit in one of them compiles all anew.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numba
from numba import njit

Function = TypeVar("Function", bound=Callable[..., Any])


def kernel(function: Function) -> Function:
    """Compile a function of numbers and arrays at its first call and keep the result on disk.

    Division by zero gives inf or nan as in NumPy. Where neither the package's folder nor the user's cache can be
    written, as in many containers, the results are kept among the temporary files.
    """
    options: dict[str, Any] = {"nogil": True, "error_model": "numpy"}
    compiled: Function
    try:
        compiled = njit(cache=True, **options)(function)
    except RuntimeError:  # no place for the cache
        config: Any = numba.config
        config.CACHE_DIR = str(Path(tempfile.gettempdir()) / "taut-kernels")
        try:
            compiled = njit(cache=True, **options)(function)
        except RuntimeError:
            compiled = njit(**options)(function)
    index: Any = getattr(getattr(compiled, "_cache", None), "_cache_file", None)
    if hasattr(index, "_version"):
        # what was kept by another version is not even read, so it may name types that are gone
        index._version = (index._version, _STAMP)
    return compiled


def _stamp() -> tuple[float, int]:
    """Newest time and total size of the files with kernels."""
    home = Path(__file__).resolve().parent
    shared = [home / "arrays.py", home / "heap.py"]
    known = [path.stat() for path in (*shared, *home.glob("*/_*kernels.py")) if path.exists()]
    return max((file.st_mtime for file in known), default=0.0), sum(file.st_size for file in known)


_STAMP = _stamp()
