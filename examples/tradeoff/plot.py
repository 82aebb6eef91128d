"""Curves over logarithmic axes, as SVG."""

import math

COLORS = ["#c0392b", "#e67e22", "#2c3e50", "#7f8c8d", "#2980b9", "#27ae60"]
WIDTH, HEIGHT, LEFT, BOTTOM, TOP, RIGHT = 640, 420, 70, 50, 36, 20


def plot(path, title, curves, across, up):
    """Writes points (x, y), joined in the order of x, one curve to a name."""
    points = [p for curve in curves.values() for p in curve if min(p) > 0]
    low, high = ([10 ** (side(math.log10(p[i]) for p in points) + pad) for i in (0, 1)] for side, pad in ((min, -0.1), (max, 0.1)))

    def place(value, axis):
        share = math.log(value / low[axis]) / math.log(high[axis] / low[axis])
        return LEFT + share * (WIDTH - LEFT - RIGHT) if axis == 0 else HEIGHT - BOTTOM - share * (HEIGHT - BOTTOM - TOP)

    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" font-size="12">',
           f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>', f'<text x="{LEFT}" y="20" font-size="14">{title}</text>']
    for axis in (0, 1):
        for decade in range(math.floor(math.log10(low[axis])), math.ceil(math.log10(high[axis])) + 1):
            for step in (1, 2, 5):
                value = step * 10.0**decade
                if low[axis] <= value <= high[axis]:
                    at = place(value, axis)
                    ends = (at, TOP, at, HEIGHT - BOTTOM) if axis == 0 else (LEFT, at, WIDTH - RIGHT, at)
                    out.append('<line x1="%.1f" y1="%.1f" x2="%.1f" y2="%.1f" stroke="#ddd"/>' % ends)
                    x, y, anchor = (at, HEIGHT - BOTTOM + 16, "middle") if axis == 0 else (LEFT - 6, at + 4, "end")
                    out.append(f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{value:g}</text>')
    out.append(f'<text x="{(LEFT + WIDTH) / 2}" y="{HEIGHT - 12}" text-anchor="middle">{across}</text>')
    out.append(f'<text transform="translate(16 {HEIGHT / 2}) rotate(-90)" text-anchor="middle">{up}</text>')
    for number, (name, curve) in enumerate(curves.items()):
        color = COLORS[number % len(COLORS)]
        places = [(place(x, 0), place(y, 1)) for x, y in sorted(curve) if min(x, y) > 0]
        # What is cached and what is not are no one curve.
        if "cached" not in name:
            out.append(f'<polyline fill="none" stroke="{color}" stroke-width="1.5" points="{" ".join("%.1f,%.1f" % p for p in places)}"/>')
        out += ['<circle cx="%.1f" cy="%.1f" r="3" fill="%s"/>' % (*p, color) for p in places]
        out.append(f'<text x="{WIDTH - RIGHT - 6}" y="{TOP + 16 + 16 * number}" text-anchor="end" fill="{color}">{name}</text>')
    open(path, "w").write("\n".join(out + ["</svg>\n"]))
