"""Kernels of elimination on graphs: star to mesh, vertex by vertex, in floats and modulo a prime."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taut.compiling import kernel

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_ULPS = 2.0**-50  # what a potential may have lost to rounding, in units of the flow that passed


@kernel
def eliminate(indptr: Ints, indices: Ints, weights: Floats) -> tuple[Ints, Ints, Floats, Floats]:
    """Rows of the elimination from the edges to later vertices: start, columns, shares, pivots."""
    n = indptr.shape[0] - 1
    start = np.zeros(n + 1, dtype=np.int64)
    columns = np.empty(2 * indices.shape[0] + n, dtype=np.int64)
    conductances = np.empty(columns.shape[0])
    shares = np.empty(columns.shape[0])
    pivots = np.zeros(n)
    row = np.zeros(n)
    seen_in = np.full(n, -1, dtype=np.int64)
    found = np.empty(n, dtype=np.int64)
    # rows that still have to be spread over vertex k stand in a list: first[k], following[first[k]], …
    first = np.full(n, -1, dtype=np.int64)
    following = np.full(n, -1, dtype=np.int64)
    at = np.zeros(n, dtype=np.int64)
    for k in range(n):
        count = 0
        for e in range(indptr[k], indptr[k + 1]):
            j = indices[e]
            seen_in[j], row[j], found[count] = k, weights[e], j
            count += 1
        i = first[k]
        while i >= 0:
            after = following[i]
            a, end = at[i], start[i + 1]
            for b in range(a + 1, end):
                j = columns[b]
                if seen_in[j] != k:
                    seen_in[j], row[j], found[count] = k, 0.0, j
                    count += 1
                # conductance · conductance / pivot, in the one order that cannot underflow before its time
                row[j] += min(conductances[a], conductances[b]) * max(shares[a], shares[b])
            if a + 1 < end:
                at[i] = a + 1
                following[i] = first[columns[a + 1]]
                first[columns[a + 1]] = i
            i = after
        begin = start[k]
        end = begin + count
        start[k + 1] = end
        if end > columns.shape[0]:
            more = max(end, 2 * columns.shape[0]) - columns.shape[0]
            columns = np.append(columns, np.empty(more, dtype=np.int64))
            conductances = np.append(conductances, np.empty(more))
            shares = np.append(shares, np.empty(more))
        columns[begin:end] = np.sort(found[:count])
        for a in range(begin, end):
            conductances[a] = row[columns[a]]
            pivots[k] += conductances[a]
        for a in range(begin, end):
            shares[a] = conductances[a] / pivots[k] if pivots[k] > 0.0 else 0.0
        if count > 0:
            at[k] = begin
            following[k] = first[columns[begin]]
            first[columns[begin]] = k
    return start, columns[: start[n]].copy(), shares[: start[n]].copy(), pivots


@kernel
def pair_resistances(
    start: Ints, columns: Ints, shares: Floats, pivots: Floats, left: Ints, right: Ints
) -> tuple[Floats, Floats]:
    """Resistance of each pair within a component, and how far rounding may have moved it."""
    n = pivots.shape[0]
    out = np.zeros(left.shape[0])
    doubt = np.zeros(left.shape[0])
    flow = np.zeros(n)
    passed = np.zeros(n)
    for p in range(left.shape[0]):
        if left[p] == right[p]:
            continue
        flow[left[p]], flow[right[p]] = 1.0, -1.0
        passed[left[p]] = passed[right[p]] = 1.0
        # the flow from a vertex passes only its first later neighbour, that one's first later neighbour, and so on
        a, b = left[p], right[p]
        while min(a, b) < n:
            k = min(a, b)
            parent = columns[start[k]] if start[k] < start[k + 1] else n
            a, b = parent if a == k else a, parent if b == k else b
            if pivots[k] > 0.0:
                lost = _ULPS * passed[k]
                out[p] += flow[k] * (flow[k] / pivots[k])
                doubt[p] += (2.0 * abs(flow[k]) + lost) * (lost / pivots[k])
                for e in range(start[k], start[k + 1]):
                    flow[columns[e]] += shares[e] * flow[k]
                    passed[columns[e]] += shares[e] * passed[k]
            flow[k] = passed[k] = 0.0
    return out, doubt


@kernel
def sum_of_resistances(start: Ints, columns: Ints, shares: Floats, pivots: Floats) -> float:
    """Sum over all pairs of a connected graph.

    The flow through vertex k to later ones, when one unit enters at i, is reach[i]; the pair (i, j) loses
    (reach[i] − reach[j])² / pivot there, and Σ over pairs is n times the squared deviations from the mean.
    """
    n = pivots.shape[0]
    lowest = np.arange(n)  # no vertex before it flows through k
    reach = np.zeros(n)
    total = 0.0
    for k in range(n):
        if start[k] < start[k + 1]:
            parent = columns[start[k]]
            lowest[parent] = min(lowest[parent], lowest[k])
    for k in range(n):
        if pivots[k] == 0.0:
            continue
        reach[k] = 1.0
        mean = 1.0 / n
        for i in range(k - 1, lowest[k] - 1, -1):
            reach[i] = 0.0
            for a in range(start[i], start[i + 1]):
                if columns[a] > k:
                    break
                reach[i] += shares[a] * reach[columns[a]]
            mean += reach[i] / n
        squares = (n - 1 - k + lowest[k]) * mean**2
        for i in range(lowest[k], k + 1):
            squares += (reach[i] - mean) ** 2
        total += squares * (n / pivots[k])
    return total


@kernel
def all_resistances(start: Ints, columns: Ints, shares: Floats, pivots: Floats) -> Floats:
    """Resistances of all pairs, rows and columns in the order of elimination."""
    n = pivots.shape[0]
    out = np.full((n, n), np.inf)
    for k in range(n - 1, -1, -1):
        out[k, k] = 0.0
        if pivots[k] == 0.0:
            continue
        spread = 0.0
        for a in range(start[k], start[k + 1]):
            inner = 0.0
            for b in range(start[k], a):
                inner += shares[b] * out[columns[a], columns[b]]
            spread += shares[a] * inner
        row = out[k, k + 1 :]
        row[:] = 0.0
        for a in range(start[k], start[k + 1]):
            row += shares[a] * out[columns[a], k + 1 :]
        for j in range(k + 1, n):
            # all current leaves k through its pivot, so no resistance from k is less than 1 / pivot
            out[k, j] = out[j, k] = 1.0 / pivots[k] + max(out[k, j] - spread, 0.0)
    return out


@kernel
def pivot_product(start: Ints, columns: Ints, weights: Ints, prime: int) -> int:
    """Product of all pivots but the last one, modulo a prime; −1 if the prime divides one of them.

    The same elimination, where division by a pivot is multiplication by its inverse.
    """
    n = start.shape[0] - 1
    values = weights.copy()
    row = np.zeros(n, dtype=np.int64)
    first = np.full(n, -1, dtype=np.int64)
    following = np.full(n, -1, dtype=np.int64)
    at = np.zeros(n, dtype=np.int64)
    inverses = np.zeros(n, dtype=np.int64)
    inverse = 1.0 / prime
    product = 1
    for k in range(n - 1):
        for e in range(start[k], start[k + 1]):
            row[columns[e]] = values[e]
        i = first[k]
        while i >= 0:
            after = following[i]
            a = at[i]
            factor = values[a] * inverses[i] % prime
            for b in range(a + 1, start[i + 1]):
                # several times as fast as %: congruent, and at most a little outside 0 … prime
                total = row[columns[b]] + factor * values[b]
                row[columns[b]] = total - int(total * inverse) * prime
            if a + 1 < start[i + 1]:
                at[i] = a + 1
                following[i] = first[columns[a + 1]]
                first[columns[a + 1]] = i
            i = after
        pivot = 0
        for e in range(start[k], start[k + 1]):
            values[e] = row[columns[e]]
            pivot = (pivot + values[e]) % prime
        if pivot == 0:
            return -1
        product = product * pivot % prime
        inverses[k] = _inverse(pivot, prime)
        at[k] = start[k]
        following[k] = first[columns[start[k]]]
        first[columns[start[k]]] = k
    return product


@kernel
def _inverse(value: int, prime: int) -> int:
    """value^(prime − 2), by Fermat's theorem the inverse of the value."""
    power, result, exponent = value, 1, prime - 2
    while exponent > 0:
        if exponent & 1:
            result = result * power % prime
        power = power * power % prime
        exponent >>= 1
    return result
