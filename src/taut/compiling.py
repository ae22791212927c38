"""How kernels are compiled: without Python objects, without the interpreter's lock, and once for all later runs."""

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
    return compiled
