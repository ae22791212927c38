"""Kernels compile also where their results cannot be kept."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba
import pytest

from taut import compiling


def double(x: int) -> int:
    return 2 * x


@pytest.mark.parametrize(("refusals", "caches"), [(0, [True]), (1, [True, True]), (2, [True, True, None])])
def test_a_kernel_compiles_wherever_its_result_can_be_kept(
    refusals: int, caches: list[bool | None], monkeypatch: pytest.MonkeyPatch
) -> None:
    """First beside the package or in the user's cache, then among temporary files, then nowhere."""
    tried: list[bool | None] = []

    def njit(**options: Any) -> Callable[[Any], Any]:
        tried.append(options.get("cache"))
        if len(tried) <= refusals:
            raise RuntimeError("no locator available")
        return numba.njit(nogil=True)

    monkeypatch.setattr(compiling, "njit", njit)
    config: Any = numba.config
    monkeypatch.setattr(config, "CACHE_DIR", "")
    assert compiling.kernel(double)(21) == 42
    assert tried == caches
    assert bool(config.CACHE_DIR) == (refusals > 0)
