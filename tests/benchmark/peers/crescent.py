"""The crescent of the benchmark as the other programs can take it."""

import math


def outline(p, segments=48):
    """Corners of the x-z outline, m, clockwise from the left tip: dished top, tips, circular arc."""
    half, tip, depth, dish = p["chord"] / 2, p["tip"], p["depth"], p["dish"]
    sagitta = depth - tip
    radius = (half**2 + sagitta**2) / (2 * sagitta)
    stations = [-half + p["chord"] * i / segments for i in range(segments + 1)]
    top = [(x, -dish * (1 - (x / half) ** 2)) for x in stations]
    bottom = [(x, -depth + radius - math.sqrt(radius**2 - x**2)) for x in reversed(stations)]
    return top + bottom


def clearance(point, polygon):
    """Distance of a point from the nearest side of a polygon, m."""
    best = math.inf
    for a, b in zip(polygon, polygon[1:] + polygon[:1]):
        side = (b[0] - a[0], b[1] - a[1])
        length = side[0] ** 2 + side[1] ** 2
        if length == 0:
            continue
        t = ((point[0] - a[0]) * side[0] + (point[1] - a[1]) * side[1]) / length
        t = min(1.0, max(0.0, t))
        best = min(best, math.hypot(point[0] - a[0] - t * side[0], point[1] - a[1] - t * side[1]))
    return best


def clump(p, stations=10):
    """Two rows of spheres inside the crescent: [(x, y, z, r)], m. Each is as large as fits."""
    polygon = outline(p)
    reach = 0.8 * p["chord"] / 2  # nearer to the tips the spheres would become much smaller
    spheres = []
    for i in range(stations):
        x = -reach + 2 * reach * i / (stations - 1)
        u = 2 * x / p["chord"]
        top = -p["dish"] * (1 - u * u)
        bottom = min(z for (px, z) in polygon if abs(px - x) <= p["chord"] / 48)
        z = (top + bottom) / 2
        half_width = p["width"] / 2 - math.tan(p["draft"]) * (-bottom)
        r = min(clearance((x, z), polygon), 0.75 * half_width)
        y = half_width - r
        spheres += [(x, -y, z, r), (x, y, z, r)]
    return spheres
