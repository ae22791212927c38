"""Kernels compile also where their results cannot be kept."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
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


def test_what_another_version_has_kept_is_not_even_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It may name types that are gone; reading it would fail."""
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(compiling, "_STAMP", "one version")
    assert compiling.kernel(double)(3) == 6
    (index,) = tmp_path.glob("**/*.nbi")
    with index.open("rb") as file:
        version = pickle.load(file)
        read = file.tell()
    kept = index.read_bytes()
    index.write_bytes(kept[:read] + b"cno_such_module\nType\n.")
    monkeypatch.setattr(compiling, "_STAMP", "another version")
    assert compiling.kernel(double)(4) == 8
    assert "one version" in version


def test_an_edit_in_the_file_of_a_called_kernel_is_noticed(tmp_path: Path) -> None:
    """The package is copied, a kernel is called that calls another file's, and that one is changed."""
    source = Path(compiling.__file__).parent
    package = tmp_path / "taut"
    for path in ("__init__.py", "compiling.py", "heap.py"):
        package.mkdir(exist_ok=True)
        (package / path).write_bytes((source / path).read_bytes())
    (package / "user").mkdir()
    (package / "user" / "__init__.py").write_text("")
    (package / "user" / "_kernels.py").write_text(
        "from taut.compiling import kernel\n"
        "from taut.heap import drop_first\n\n\n"
        "@kernel\ndef first_left(keys, items):\n    drop_first(keys, items, 2)\n    return keys[0]\n"
    )
    script = (
        "import numpy as np; from taut.user._kernels import first_left; "
        "print(first_left(np.array([1.0, 2.0]), np.array([0, 1])))"
    )

    def said() -> str:
        environment = {**os.environ, "PYTHONPATH": str(tmp_path), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
        run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, env=environment)
        assert run.returncode == 0, run.stderr
        return run.stdout.strip()

    assert said() == "2.0"
    heap = package / "heap.py"
    heap.write_text(heap.read_text().replace("keys[i], items[i] = key, item", "keys[i], items[i] = 7.0, item"))
    assert said() == "7.0"
