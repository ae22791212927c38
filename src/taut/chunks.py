"""Kernels over chunks of their work, on all cores: they hold no interpreter lock, so plain threads suffice."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")


def over_chunks(work: Callable[[int, int], T], count: int, size: int) -> list[T]:
    """Call ``work(first, last)`` for the chunks of 0 … count − 1 of at most ``size``; results in their order.

    The calling thread works, too, so that little work starts no thread. The first error is raised when all have ended.

    >>> over_chunks(lambda first, last: last - first, 5, 2)
    [2, 2, 1]
    """
    if count <= size:
        return [work(0, count)] if count else []
    firsts = range(0, count, size)
    results: dict[int, T] = {}
    errors: list[BaseException] = []
    left = iter(firsts)
    lock = threading.Lock()

    def run() -> None:
        while not errors:
            with lock:
                first = next(left, None)
            if first is None:
                return
            try:
                results[first] = work(first, min(first + size, count))
            except BaseException as error:
                errors.append(error)

    threads = [threading.Thread(target=run) for _ in range(min(os.cpu_count() or 1, len(firsts)) - 1)]
    for thread in threads:
        thread.start()
    run()
    for thread in threads:
        thread.join()
    if errors:
        raise errors[0]
    return [results[first] for first in firsts]
