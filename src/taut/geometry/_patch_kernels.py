"""Kernels that change a few triangles of a large mesh: cut out, put in, flip, find again what is unchanged, look anew.

Arrays mean the same as in `taut.geometry._kernels`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taut.compiling import kernel
from taut.geometry._kernels import _cell, _row_span, beyond, head, inside, longer, orient
from taut.geometry._seeing_kernels import _blind, _higher, _parts_line, entry, expand

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

# Shewchuk 1997, Adaptive precision floating-point arithmetic: error bound of the plain in-circle determinant
_CIRCLE_ERROR = (10.0 + 96.0 * 2.0**-53) * 2.0**-53


# ---------------------------------------------------------------------------------------------------------------------
# The boundary of the mesh


@kernel
def walls_in_box(xy: Floats, fan: Ints, x0: float, y0: float, x1: float, y1: float) -> Ints:
    """Wedges whose boundary edge, from vertex to first neighbour, has a bounding box that meets the box given."""
    out = np.empty(64, dtype=np.int64)
    n = 0
    for w in range(fan.shape[0]):
        ax, ay, bx, by = xy[fan[w, 0], 0], xy[fan[w, 0], 1], xy[fan[w, 1], 0], xy[fan[w, 1], 1]
        if max(ax, bx) < x0 or min(ax, bx) > x1 or max(ay, by) < y0 or min(ay, by) > y1:
            continue
        if n == out.shape[0]:
            out = longer(out)
        out[n] = w
        n += 1
    return head(out, n)


@kernel
def loops_through(fan: Ints, wedge_of: Ints, seeds: Ints) -> Ints:
    """Wedges whose boundary edges are on the closed walks along the boundary that pass through some of them."""
    seen = np.zeros(fan.shape[0], dtype=np.bool_)
    out = np.empty(64, dtype=np.int64)
    n = 0
    for seed in seeds:
        w = seed
        while not seen[w]:
            seen[w] = True
            if n == out.shape[0]:
                out = longer(out)
            out[n] = w
            n += 1
            w = wedge_of[fan[w, 3], (fan[w, 4] + 1) % 3]
    return head(out, n)


@kernel
def boundary_rings(xy: Floats, fan: Ints, wedge_of: Ints, part: Ints, parts: int) -> tuple[Ints, Ints, Ints]:
    """Cut the boundary into rings that pass through no other vertex than the first twice.

    Returns
    -------
    vertex : (k,) vertices, ring after ring, the first of each again at its end.
    ring_start : (r + 1,) where each ring begins, part after part, the shell of each before its holes.
    part_start : (p + 1,) where the rings of each part begin.
    """
    n = fan.shape[0]
    vertex = np.empty(2 * n, dtype=np.int64)
    start = np.zeros(n + 1, dtype=np.int64)
    owner = np.empty(n, dtype=np.int64)
    hole = np.zeros(n, dtype=np.bool_)
    seen = np.zeros(n, dtype=np.bool_)
    place = np.full(xy.shape[0], -1, dtype=np.int64)
    path = np.empty(n + 1, dtype=np.int64)
    filled, rings = 0, 0
    for seed in range(n):
        if seen[seed]:
            continue
        top = 0
        w = seed
        while True:
            v = fan[w, 0]
            back = 0 if seen[w] else place[v]
            if back >= 0:
                area = 0.0
                for i in range(back, top):
                    a, b = path[i], path[i + 1] if i + 1 < top else path[back]
                    area += (xy[a, 0] - xy[v, 0]) * (xy[b, 1] - xy[v, 1])
                    area -= (xy[a, 1] - xy[v, 1]) * (xy[b, 0] - xy[v, 0])
                    place[a] = -1
                # an edge that is walked forth and back is no ring
                if top - back > 2:
                    for i in range(back, top):
                        vertex[filled] = path[i]
                        filled += 1
                    vertex[filled] = path[back]
                    filled += 1
                    owner[rings], hole[rings] = part[fan[seed, 3]], area < 0.0
                    rings += 1
                    start[rings] = filled
                top = back
            if seen[w]:
                break
            seen[w] = True
            place[v], path[top] = top, v
            top += 1
            w = wedge_of[fan[w, 3], (fan[w, 4] + 1) % 3]
    part_start = np.zeros(parts + 1, dtype=np.int64)
    for r in range(rings):
        part_start[owner[r] + 1] += 1
    for p in range(parts):
        part_start[p + 1] += part_start[p]
    order = np.empty(rings, dtype=np.int64)
    put = part_start.copy()
    for holes in range(2):
        for r in range(rings):
            if hole[r] == (holes == 1):
                order[put[owner[r]]] = r
                put[owner[r]] += 1
    out = np.empty(filled, dtype=np.int64)
    ring_start = np.zeros(rings + 1, dtype=np.int64)
    filled = 0
    for k in range(rings):
        for i in range(start[order[k]], start[order[k] + 1]):
            out[filled] = vertex[i]
            filled += 1
        ring_start[k + 1] = filled
    return out, ring_start, part_start


# ---------------------------------------------------------------------------------------------------------------------
# The cavity


@kernel
def _gap(ax: float, ay: float, bx: float, by: float, px: float, py: float) -> float:
    """Square of the distance of p from the segment a b, which may be a point."""
    ex, ey, dx, dy = bx - ax, by - ay, px - ax, py - ay
    square = ex * ex + ey * ey
    f = min(max((dx * ex + dy * ey) / square, 0.0), 1.0) if square > 0.0 else 0.0
    dx, dy = dx - f * ex, dy - f * ey
    return dx * dx + dy * dy


@kernel
def _crosses(ax: float, ay: float, bx: float, by: float, cx: float, cy: float, dx: float, dy: float) -> bool:
    """Whether the segments a b and c d have exactly one point in common and it is no end of either."""
    one, two = orient(ax, ay, bx, by, cx, cy), orient(ax, ay, bx, by, dx, dy)
    if not ((one > 0.0 and two < 0.0) or (one < 0.0 and two > 0.0)):
        return False
    one, two = orient(cx, cy, dx, dy, ax, ay), orient(cx, cy, dx, dy, bx, by)
    return (one > 0.0 and two < 0.0) or (one < 0.0 and two > 0.0)


@kernel
def _near(
    ax: float, ay: float, bx: float, by: float, cx: float, cy: float, dx: float, dy: float, margin: float
) -> bool:
    """Whether the segments a b and c d come within ``margin`` of each other."""
    if max(ax, bx) < min(cx, dx) - margin or min(ax, bx) > max(cx, dx) + margin:
        return False
    if max(ay, by) < min(cy, dy) - margin or min(ay, by) > max(cy, dy) + margin:
        return False
    least = min(_gap(ax, ay, bx, by, cx, cy), _gap(ax, ay, bx, by, dx, dy))
    least = min(least, _gap(cx, cy, dx, dy, ax, ay), _gap(cx, cy, dx, dy, bx, by))
    return least <= margin * margin or _crosses(ax, ay, bx, by, cx, cy, dx, dy)


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
            _cell(min(ax, bx) - margin, frame[0], frame[2], nx),
            _cell(max(ax, bx) + margin, frame[0], frame[2], nx),
        )
        row0, row1 = (
            _cell(min(ay, by) - margin, frame[1], frame[2], ny),
            _cell(max(ay, by) + margin, frame[1], frame[2], ny),
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
                        near = near or _near(ax, ay, bx, by, xy[c, 0], xy[c, 1], xy[d, 0], xy[d, 1], margin)
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
        for row in range(_cell(ymin - slack, frame[1], step, ny), _cell(ymax + slack, frame[1], step, ny) + 1):
            lo = frame[1] + row * step
            xa, xb = _row_span(xy, tri, t, lo - slack, lo + step + slack)
            if xb < xa:
                continue
            for col in range(_cell(xa - slack, frame[0], step, nx), _cell(xb + slack, frame[0], step, nx) + 1):
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


# ---------------------------------------------------------------------------------------------------------------------
# Seeing anew


@kernel
def meeting(positions: Floats, indptr: Ints, indices: Ints, sides: Floats, margin: float) -> tuple[Ints, Ints, Bools]:
    """Edges (i, j), i < j, that come within ``margin`` of the sides (k, 4) of a polygon, and whether they cross one."""
    x0, y0, x1, y1 = np.inf, np.inf, -np.inf, -np.inf
    for k in range(sides.shape[0]):
        x0, x1 = min(x0, sides[k, 0], sides[k, 2]), max(x1, sides[k, 0], sides[k, 2])
        y0, y1 = min(y0, sides[k, 1], sides[k, 3]), max(y1, sides[k, 1], sides[k, 3])
    x0, y0, x1, y1 = x0 - margin, y0 - margin, x1 + margin, y1 + margin
    a = np.empty(64, dtype=np.int64)
    b = np.empty(64, dtype=np.int64)
    through = np.empty(64, dtype=np.int64)
    n = 0
    for i in range(positions.shape[0]):
        ax, ay = positions[i, 0], positions[i, 1]
        for e in range(indptr[i + 1] - 1, indptr[i] - 1, -1):
            j = indices[e]
            if j < i:
                break
            bx, by = positions[j, 0], positions[j, 1]
            if max(ax, bx) < x0 or min(ax, bx) > x1 or max(ay, by) < y0 or min(ay, by) > y1:
                continue
            near, crossing = False, False
            for k in range(sides.shape[0]):
                cx, cy, dx, dy = sides[k, 0], sides[k, 1], sides[k, 2], sides[k, 3]
                if not _near(ax, ay, bx, by, cx, cy, dx, dy, margin):
                    continue
                near = True
                if _crosses(ax, ay, bx, by, cx, cy, dx, dy):
                    crossing = True
                    break
            if not near:
                continue
            if n == a.shape[0]:
                a, b, through = longer(a), longer(b), longer(through)
            a[n], b[n], through[n] = i, j, 1 if crossing else 0
            n += 1
    return head(a, n), head(b, n), head(through, n) > 0


@kernel
def _within(px: float, py: float, ax: float, ay: float, bx: float, by: float, qx: float, qy: float) -> bool:
    """Whether q lies, seen from p, in the closed cone from a counter-clockwise to b, which is narrower than π."""
    return orient(px, py, ax, ay, qx, qy) >= 0.0 and orient(px, py, qx, qy, bx, by) >= 0.0


@kernel
def _push_cone(
    xy: Floats, tri: Ints, nbr: Ints, t: int, k: int, right: int, left: int, v: int, b: int, a: int, stack: Ints
) -> int:
    """Put the cone from corner v between two points through edge k of triangle t on the empty stack.

    Returns how many rows there are: none if the edge is closed or the cone wholly blind.
    """
    s = nbr[t, k]
    right_blind = 1 if _blind(xy, v, b, a, right) else 0
    left_blind = 1 if _blind(xy, v, b, a, left) else 0
    rows = 0
    if s >= 0 and not (right_blind == 1 and left_blind == 1):
        stack[0, 0], stack[0, 1], stack[0, 2], stack[0, 3] = s, entry(tri, nbr, t, k, s), right, left
        stack[0, 4], stack[0, 5] = right_blind, left_blind
        rows = 1
    return rows


@kernel
def see_past(
    xy: Floats, tri: Ints, nbr: Ints, fan: Ints, wedge_of: Ints, wanted: Bools, roots: Ints, hull: Ints
) -> tuple[Ints, Ints]:
    """Pairs (v, w) of wanted wedges, v one of ``roots``, joined by a taut segment without a vertex strictly between.

    ``hull``, if not empty, are rows of ``xy`` that are a convex polygon, counter-clockwise: every pair whose segment
    or its extension beyond w meets its inside is found, others may be left out.
    """
    va = np.empty(256, dtype=np.int64)
    vb = np.empty(256, dtype=np.int64)
    count = 0
    stack = np.empty((64, 6), dtype=np.int64)
    seen = np.empty(256, dtype=np.int64)
    h = hull.shape[0]
    for v in roots:
        vertex = fan[v, 0]
        px, py = xy[vertex, 0], xy[vertex, 1]
        first, last = fan[v, 1], fan[v, 2]
        around = True
        right, left = -1, -1
        for i in range(h):
            a, b = hull[i], hull[i + 1 if i + 1 < h else 0]
            c = hull[i - 1 if i > 0 else h - 1]
            after = orient(px, py, xy[a, 0], xy[a, 1], xy[b, 0], xy[b, 1])
            before = orient(px, py, xy[c, 0], xy[c, 1], xy[a, 0], xy[a, 1])
            if after < 0.0:
                around = False
            # the tangent points of a convex polygon are where its boundary turns round, seen from p
            if before <= 0.0 and after > 0.0:
                right = a
            if before > 0.0 and after <= 0.0:
                left = a
        around = around or right < 0 or left < 0
        if not around and _blind(xy, vertex, first, last, right) and _blind(xy, vertex, first, last, left):
            continue
        n = 0
        s, j = fan[v, 3], fan[v, 4]
        while s >= 0:
            a, b = tri[s, (j + 1) % 3], tri[s, (j + 2) % 3]
            if n + 2 > seen.shape[0]:
                seen = longer(seen)
            from_right, to_left = a, b
            if not around:
                rx, ry, lx, ly = xy[right, 0], xy[right, 1], xy[left, 0], xy[left, 1]
                ax, ay, bx, by = xy[a, 0], xy[a, 1], xy[b, 0], xy[b, 1]
                a_in, b_in = _within(px, py, rx, ry, lx, ly, ax, ay), _within(px, py, rx, ry, lx, ly, bx, by)
                if not a_in:
                    from_right = right if _within(px, py, ax, ay, bx, by, rx, ry) else -1
                if not b_in:
                    to_left = left if _within(px, py, ax, ay, bx, by, lx, ly) else -1
            else:
                a_in, b_in = True, True
            if a_in:
                seen[n] = wedge_of[s, (j + 1) % 3]
                n += 1
            if b_in and nbr[s, (j + 2) % 3] < 0:
                seen[n] = wedge_of[s, (j + 2) % 3]
                n += 1
            if from_right >= 0 and to_left >= 0:
                top = _push_cone(xy, tri, nbr, s, (j + 1) % 3, from_right, to_left, vertex, first, last, stack)
                top, n = expand(xy, tri, nbr, wedge_of, px, py, vertex, first, last, stack, top, seen, n, np.inf)
                while top > 0:
                    stack, seen = _higher(stack), longer(seen)
                    top, n = expand(xy, tri, nbr, wedge_of, px, py, vertex, first, last, stack, top, seen, n, np.inf)
            s = nbr[s, (j + 2) % 3]
            if s >= 0:
                j = 0
                while tri[s, j] != vertex:
                    j += 1
        for i in range(n):
            w = seen[i]
            if not wanted[w]:
                continue
            u = fan[w, 0]
            if _parts_line(xy, px, py, u, fan[w, 1], fan[w, 2]) or _parts_line(
                xy, xy[u, 0], xy[u, 1], vertex, fan[v, 1], fan[v, 2]
            ):
                continue
            if count == va.shape[0]:
                va, vb = longer(va), longer(vb)
            va[count], vb[count] = v, w
            count += 1
    return head(va, count), head(vb, count)


@kernel
def _place(indptr: Ints, indices: Ints, i: int, j: int) -> int:
    """Place of column j in row i."""
    lo, hi = indptr[i], indptr[i + 1]
    while lo < hi:
        middle = (lo + hi) // 2
        if indices[middle] < j:
            lo = middle + 1
        else:
            hi = middle
    return int(lo)


@kernel
def patched_rows(
    indptr: Ints, indices: Ints, weights: Floats, number: Ints, n: int, lost: Ints, pairs: Ints, lengths: Floats
) -> tuple[Ints, Ints, Floats]:
    """CSR of a graph on n vertices of which some edges are lost and some are new.

    ``number`` holds the new numbers of the old vertices, ascending, −1 for those that are gone; the others come last.
    ``lost`` (k, 2) are edges in old numbers, ``pairs`` (p, 2) in new ones, both directions of each and sorted by rows;
    pairs that are edges already are no harm.
    """
    gone = np.zeros(indices.shape[0], dtype=np.bool_)
    for k in range(lost.shape[0]):
        gone[_place(indptr, indices, lost[k, 0], lost[k, 1])] = True
        gone[_place(indptr, indices, lost[k, 1], lost[k, 0])] = True
    out_start = np.empty(n + 1, dtype=np.int64)
    out = np.empty(indices.shape[0] + pairs.shape[0], dtype=np.int64)
    out_weights = np.empty(indices.shape[0] + pairs.shape[0])
    k, filled = 0, 0
    row = 0
    for old in range(number.shape[0] + 1):
        # after the old vertices that stay come the new ones
        last = n if old == number.shape[0] else number[old] + 1
        for i in range(row, last):
            out_start[i] = filled
            e = indptr[old] if old < number.shape[0] else 0
            end = indptr[old + 1] if old < number.shape[0] else 0
            while k < pairs.shape[0] and pairs[k, 0] == i:
                while e < end and (gone[e] or number[indices[e]] < pairs[k, 1]):
                    if not gone[e] and number[indices[e]] >= 0:
                        out[filled], out_weights[filled] = number[indices[e]], weights[e]
                        filled += 1
                    e += 1
                if e < end and number[indices[e]] == pairs[k, 1]:
                    e += 1
                out[filled], out_weights[filled] = pairs[k, 1], lengths[k]
                filled += 1
                k += 1
            for f in range(e, end):
                j = number[indices[f]]
                if j >= 0 and not gone[f]:
                    out[filled], out_weights[filled] = j, weights[f]
                    filled += 1
        row = max(row, last)
    out_start[n] = filled
    return out_start, out[:filled], out_weights[:filled]
