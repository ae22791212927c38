"""Kernels that change a few triangles of a large mesh: cut out, put in, flip, find again what is unchanged.

Arrays mean the same as in `taut.geometry._kernels`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taut.arrays import head, longer
from taut.compiling import kernel
from taut.geometry._kernels import beyond, cell_of, inside, orient, row_span, segments_near

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Shewchuk 1997, Adaptive precision floating-point arithmetic: error bound of the plain in-circle determinant
_CIRCLE_ERROR = (10.0 + 96.0 * 2.0**-53) * 2.0**-53


@kernel
def triangles_near(
    xy: Floats, tri: Ints, frame: Floats, shape: Ints, start: Ints, items: Ints, edges: Ints, margin: float
) -> Ints:
    """Triangles that come within ``margin`` of an edge; edges are (k, 2) rows of ``xy``. Ascending."""
    if tri.shape[0] == 0:
        return np.empty(0, dtype=np.int64)
    marked = np.zeros(tri.shape[0], dtype=np.bool_)
    out = np.empty(64, dtype=np.int64)
    n = 0
    nx, ny = shape[0], shape[1]
    for e in range(edges.shape[0]):
        ax, ay, bx, by = xy[edges[e, 0], 0], xy[edges[e, 0], 1], xy[edges[e, 1], 0], xy[edges[e, 1], 1]
        col0, col1 = (
            cell_of(min(ax, bx) - margin, frame[0], frame[2], nx),
            cell_of(max(ax, bx) + margin, frame[0], frame[2], nx),
        )
        row0, row1 = (
            cell_of(min(ay, by) - margin, frame[1], frame[2], ny),
            cell_of(max(ay, by) + margin, frame[1], frame[2], ny),
        )
        for row in range(row0, row1 + 1):
            for col in range(col0, col1 + 1):
                for i in range(start[row * nx + col], start[row * nx + col + 1]):
                    t = items[i]
                    if marked[t]:
                        continue
                    near = inside(xy, tri, t, ax, ay)
                    for k in range(3):
                        c, d = tri[t, k], tri[t, (k + 1) % 3]
                        near = near or segments_near(ax, ay, bx, by, xy[c, 0], xy[c, 1], xy[d, 0], xy[d, 1], margin)
                    if not near:
                        continue
                    marked[t] = True
                    if n == out.shape[0]:
                        out = longer(out)
                    out[n] = t
                    n += 1
    return np.sort(head(out, n))


@kernel
def rim(tri: Ints, nbr: Ints, cavity: Ints) -> tuple[Ints, Ints]:
    """Edges about some triangles: (k, 2) vertices, the cavity on the left, and the triangle beyond each or −1."""
    within = np.zeros(tri.shape[0], dtype=np.bool_)
    for t in cavity:
        within[t] = True
    edges = np.empty((3 * cavity.shape[0], 2), dtype=np.int64)
    beyond = np.empty(3 * cavity.shape[0], dtype=np.int64)
    n = 0
    for t in cavity:
        for k in range(3):
            s = nbr[t, k]
            if s >= 0 and within[s]:
                continue
            edges[n, 0], edges[n, 1], beyond[n] = tri[t, k], tri[t, (k + 1) % 3], s
            n += 1
    return edges[:n].copy(), head(beyond, n)


@kernel
def splice(
    n: int, tri: Ints, nbr: Ints, cavity: Ints, new_tri: Ints, new_nbr: Ints, outside: Ints
) -> tuple[Ints, Ints, Ints, Ints]:
    """Put new triangles in the place of a cavity; what stays keeps its order, what is new comes last.

    ``n`` is the number of vertices, ``outside`` (k, 3) the old triangle across each edge of the new ones, −1 if none.

    Returns
    -------
    vertex_number, triangle_number : new numbers of the old ones, −1 for those no longer used.
    tri, nbr : the new mesh.
    """
    m = tri.shape[0]
    number = np.zeros(m, dtype=np.int64)
    for t in cavity:
        number[t] = -1
    kept = 0
    used = np.full(n, -1, dtype=np.int64)
    for t in range(m):
        if number[t] < 0:
            continue
        number[t] = kept
        kept += 1
        for k in range(3):
            used[tri[t, k]] = 0
    for t in range(new_tri.shape[0]):
        for k in range(3):
            used[new_tri[t, k]] = 0
    count = 0
    for v in range(n):
        if used[v] == 0:
            used[v] = count
            count += 1
    out_tri = np.empty((kept + new_tri.shape[0], 3), dtype=np.int64)
    out_nbr = np.empty((kept + new_tri.shape[0], 3), dtype=np.int64)
    for t in range(m):
        s = number[t]
        if s < 0:
            continue
        for k in range(3):
            out_tri[s, k] = used[tri[t, k]]
            out_nbr[s, k] = number[nbr[t, k]] if nbr[t, k] >= 0 else -1
    for t in range(new_tri.shape[0]):
        for k in range(3):
            out_tri[kept + t, k] = used[new_tri[t, k]]
            out_nbr[kept + t, k] = kept + new_nbr[t, k] if new_nbr[t, k] >= 0 else -1
    for t in range(new_tri.shape[0]):
        for k in range(3):
            if outside[t, k] < 0:
                continue
            s = number[outside[t, k]]
            a, b = out_tri[kept + t, k], out_tri[kept + t, (k + 1) % 3]
            j = 0
            while out_tri[s, j] != b or out_tri[s, (j + 1) % 3] != a:
                j += 1
            out_nbr[kept + t, k], out_nbr[s, j] = s, kept + t
    return used, number, out_tri, out_nbr


@kernel
def _in_circle(xy: Floats, a: int, b: int, c: int, d: int) -> bool:
    """Whether d lies inside the circle through a, b, c (counter-clockwise) beyond doubt."""
    dx, dy = xy[d, 0], xy[d, 1]
    ax, ay, bx, by, cx, cy = xy[a, 0] - dx, xy[a, 1] - dy, xy[b, 0] - dx, xy[b, 1] - dy, xy[c, 0] - dx, xy[c, 1] - dy
    al, bl, cl = ax * ax + ay * ay, bx * bx + by * by, cx * cx + cy * cy
    det = al * (bx * cy - cx * by) + bl * (cx * ay - ax * cy) + cl * (ax * by - bx * ay)
    size = al * (abs(bx * cy) + abs(cx * by)) + bl * (abs(cx * ay) + abs(ax * cy)) + cl * (abs(ax * by) + abs(bx * ay))
    return bool(det > _CIRCLE_ERROR * size)


@kernel
def flip_to_delaunay(xy: Floats, tri: Ints, nbr: Ints, first: int) -> Ints:
    """Flip edges in place, beginning at triangles from ``first`` on, until the mesh is Delaunay again.

    Source: Lawson 1977. Returns the triangles that are new or changed, ascending.
    """
    m = tri.shape[0]
    changed = np.zeros(m, dtype=np.bool_)
    stack = np.empty(max(3 * (m - first), 16), dtype=np.int64)
    top = 0
    for t in range(first, m):
        changed[t] = True
        for k in range(3):
            stack[top] = 3 * t + k
            top += 1
    while top > 0:
        top -= 1
        t, k = stack[top] // 3, stack[top] % 3
        s = nbr[t, k]
        if s < 0:
            continue
        a, b, c = tri[t, k], tri[t, (k + 1) % 3], tri[t, (k + 2) % 3]
        j = 0
        while nbr[s, j] != t or tri[s, (j + 1) % 3] != a:
            j += 1
        d = tri[s, (j + 2) % 3]
        if not _in_circle(xy, a, b, c, d):
            continue
        if orient(xy[a, 0], xy[a, 1], xy[d, 0], xy[d, 1], xy[c, 0], xy[c, 1]) <= 0.0:
            continue
        if orient(xy[d, 0], xy[d, 1], xy[b, 0], xy[b, 1], xy[c, 0], xy[c, 1]) <= 0.0:
            continue
        ad, db, bc, ca = nbr[s, (j + 1) % 3], nbr[s, (j + 2) % 3], nbr[t, (k + 1) % 3], nbr[t, (k + 2) % 3]
        tri[t, 0], tri[t, 1], tri[t, 2] = a, d, c
        nbr[t, 0], nbr[t, 1], nbr[t, 2] = ad, s, ca
        tri[s, 0], tri[s, 1], tri[s, 2] = d, b, c
        nbr[s, 0], nbr[s, 1], nbr[s, 2] = db, bc, t
        for i in range(3):
            if ad >= 0 and nbr[ad, i] == s and tri[ad, i] == d:
                nbr[ad, i] = t
            if bc >= 0 and nbr[bc, i] == t and tri[bc, i] == c:
                nbr[bc, i] = s
        changed[t] = changed[s] = True
        if top + 4 > stack.shape[0]:
            stack = longer(stack)
        stack[top], stack[top + 1], stack[top + 2], stack[top + 3] = 3 * t, 3 * t + 2, 3 * s, 3 * s + 1
        top += 4
    out = np.empty(m, dtype=np.int64)
    n = 0
    for t in range(m):
        if changed[t]:
            out[n] = t
            n += 1
    return head(out, n)


@kernel
def any_hairline(xy: Floats, tri: Ints, nbr: Ints, triangles: Ints, width: float) -> bool:
    """Whether `close_hairlines` would change anything, judged by these triangles."""
    for t in triangles:
        for k in range(3):
            a, b, c = tri[t, k], tri[t, (k + 1) % 3], tri[t, (k + 2) % 3]
            if nbr[t, k] >= 0:
                ex, ey = xy[b, 0] - xy[a, 0], xy[b, 1] - xy[a, 1]
                if ex * ex + ey * ey < width * width:
                    return True
            elif not beyond(xy, a, b, xy[c, 0], xy[c, 1], width):
                return True
    return False


# ---------------------------------------------------------------------------------------------------------------------
# Tables of the changed mesh


@kernel
def wedges_of_vertices(fan: Ints, n: int) -> tuple[Ints, Ints]:
    """CSR of the wedges of each of n vertices, ascending."""
    start = np.zeros(n + 1, dtype=np.int64)
    for w in range(fan.shape[0]):
        start[fan[w, 0] + 1] += 1
    for v in range(n):
        start[v + 1] += start[v]
    put = start.copy()
    out = np.empty(fan.shape[0], dtype=np.int64)
    for w in range(fan.shape[0]):
        out[put[fan[w, 0]]] = w
        put[fan[w, 0]] += 1
    return start, out


@kernel
def patched_wedges(
    tri: Ints, nbr: Ints, fan: Ints, wedge_of: Ints, vertex_number: Ints, triangle_number: Ints, changed: Ints
) -> tuple[Ints, Ints]:
    """Wedges of a mesh after a change, from those before, ``fan`` and ``wedge_of``; what is new comes last.

    ``vertex_number`` and ``triangle_number`` are the new numbers of the old ones, −1 if gone; ``changed`` the new
    triangles that are new or of new shape. Returns the same as `wedges`.
    """
    moved = np.zeros(tri.shape[0], dtype=np.bool_)
    for t in changed:
        moved[t] = True
    number = np.zeros(fan.shape[0], dtype=np.int64)
    for t in range(triangle_number.shape[0]):
        if triangle_number[t] >= 0 and not moved[triangle_number[t]]:
            continue
        for k in range(3):
            number[wedge_of[t, k]] = -1
    walls = 0
    for t in range(tri.shape[0]):
        walls += (nbr[t, 0] < 0) + (nbr[t, 1] < 0) + (nbr[t, 2] < 0)
    out = np.empty((walls, 5), dtype=np.int64)
    count = 0
    for w in range(fan.shape[0]):
        if number[w] < 0:
            continue
        number[w] = count
        out[count, 0], out[count, 1] = vertex_number[fan[w, 0]], vertex_number[fan[w, 1]]
        out[count, 2], out[count, 3], out[count, 4] = vertex_number[fan[w, 2]], triangle_number[fan[w, 3]], fan[w, 4]
        count += 1
    out_of = np.full((tri.shape[0], 3), -1, dtype=np.int64)
    for t in range(triangle_number.shape[0]):
        s = triangle_number[t]
        if s >= 0 and not moved[s]:
            for k in range(3):
                out_of[s, k] = number[wedge_of[t, k]]
    for t in changed:
        for k in range(3):
            if out_of[t, k] >= 0:
                continue
            s, j = t, k
            v = tri[t, k]
            while nbr[s, j] >= 0:
                s = nbr[s, j]
                j = 0
                while tri[s, j] != v:
                    j += 1
            out[count, 0], out[count, 1], out[count, 3], out[count, 4] = v, tri[s, (j + 1) % 3], s, j
            while True:
                out_of[s, j] = count
                out[count, 2] = tri[s, (j + 2) % 3]
                s = nbr[s, (j + 2) % 3]
                if s < 0:
                    break
                j = 0
                while tri[s, j] != v:
                    j += 1
            count += 1
    return out, out_of


@kernel
def same_wedges(fan: Ints, other: Ints, number: Ints, vertex_start: Ints, vertex_wedges: Ints) -> Ints:
    """For each wedge of ``other`` the wedge of ``fan`` with the same vertex and boundary neighbours, or −1.

    ``number`` holds the numbers that the vertices of ``fan`` have in ``other``, whose wedges by vertex are the CSR.
    """
    out = np.full(other.shape[0], -1, dtype=np.int64)
    for w in range(fan.shape[0]):
        v, b, a = number[fan[w, 0]], number[fan[w, 1]], number[fan[w, 2]]
        if v < 0:
            continue
        for i in range(vertex_start[v], vertex_start[v + 1]):
            if other[vertex_wedges[i], 1] == b and other[vertex_wedges[i], 2] == a:
                out[vertex_wedges[i]] = w
    return out


@kernel
def patched_grid(
    xy: Floats, tri: Ints, frame: Floats, shape: Ints, start: Ints, items: Ints, number: Ints, changed: Ints
) -> tuple[Ints, Ints]:
    """Start and items of a location grid of which some triangles are new, some gone and the others renumbered.

    ``number`` holds the new numbers of the old triangles, −1 if gone; ``changed`` the new triangles that are to be
    entered, whether new or of new shape. None of them may reach beyond the frame.
    """
    nx, ny = shape[0], shape[1]
    step = frame[2]
    slack = step * 1e-6
    moved = np.zeros(tri.shape[0], dtype=np.bool_)
    for t in changed:
        moved[t] = True
    cell = np.empty(64, dtype=np.int64)
    what = np.empty(64, dtype=np.int64)
    n = 0
    for t in changed:
        ymin = min(xy[tri[t, 0], 1], xy[tri[t, 1], 1], xy[tri[t, 2], 1])
        ymax = max(xy[tri[t, 0], 1], xy[tri[t, 1], 1], xy[tri[t, 2], 1])
        for row in range(cell_of(ymin - slack, frame[1], step, ny), cell_of(ymax + slack, frame[1], step, ny) + 1):
            lo = frame[1] + row * step
            xa, xb = row_span(xy, tri, t, lo - slack, lo + step + slack)
            if xb < xa:
                continue
            for col in range(cell_of(xa - slack, frame[0], step, nx), cell_of(xb + slack, frame[0], step, nx) + 1):
                if n == cell.shape[0]:
                    cell, what = longer(cell), longer(what)
                cell[n], what[n] = row * nx + col, t
                n += 1
    more = np.zeros(nx * ny, dtype=np.int64)
    for i in range(n):
        more[cell[i]] += 1
    out_start = np.empty(nx * ny + 1, dtype=np.int64)
    out = np.empty(items.shape[0] + n, dtype=np.int64)
    filled = 0
    for c in range(nx * ny):
        out_start[c] = filled
        for i in range(start[c], start[c + 1]):
            t = number[items[i]]
            if t >= 0 and not moved[t]:
                out[filled] = t
                filled += 1
        # the places kept free here are filled below
        filled += more[c]
        more[c] = filled - more[c]
    out_start[nx * ny] = filled
    for i in range(n):
        out[more[cell[i]]] = what[i]
        more[cell[i]] += 1
    return out_start, head(out, filled)
