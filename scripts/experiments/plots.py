"""Grouped bars as SVG, without any package."""
import html
import math

COLOURS = ["#1f6fb4", "#d1605e", "#5a9e4b", "#8c6bb1", "#c98a2b"]


def bar_plot(title, groups, series, unit, log_scale=False):
    """SVG text; nothing when there is no value. `series`: {name: [value or None per group]}."""
    # A bar is no narrower than its value, and slanted names of groups end above the legend.
    width = max(860, 80 + 50 * len(series) * len(groups))
    name_height = 3 * max(map(len, groups))
    height, left, top, bottom = 300 + name_height, 60, 40, 40 + name_height
    values = [v for row in series.values() for v in row if v is not None and v > 0]
    if not values:
        return None
    high = max(values)
    low = min(values) / 2 if log_scale else 0

    def scale(value):
        share = math.log(value / low) / math.log(high / low) if log_scale else value / high
        return share * (height - top - bottom)

    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" font-family="sans-serif" font-size="12">',
           f'<rect width="{width}" height="{height}" fill="white"/>',
           f'<text x="{left}" y="22" font-size="14">{html.escape(title)} [{html.escape(unit)}]</text>']
    step = (width - left - 20) / len(groups)
    bar = step * 0.8 / len(series)
    for g, group in enumerate(groups):
        x0 = left + g * step + 0.1 * step
        for s, row in enumerate(series.values()):
            value = row[g]
            if value is None:
                continue
            size = scale(value) if value > 0 else 0
            y = height - bottom - size
            x = x0 + s * bar
            out.append(f'<rect x="{x:.1f}" y="{y:.1f}" width="{bar * 0.95:.1f}" height="{size:.1f}" fill="{COLOURS[s % len(COLOURS)]}"/>')
            out.append(f'<text x="{x + 0.5 * bar:.1f}" y="{y - 3:.1f}" text-anchor="middle" font-size="8">{value:.3g}</text>')
        x = x0 + 0.4 * step
        y = height - bottom + 14
        out.append(f'<text x="{x:.1f}" y="{y}" text-anchor="end" transform="rotate(-30 {x:.1f} {y})" font-size="10">{html.escape(group)}</text>')
    for s, name in enumerate(series):
        x = left + 200 * s
        out.append(f'<rect x="{x}" y="{height - 16}" width="10" height="10" fill="{COLOURS[s % len(COLOURS)]}"/>')
        out.append(f'<text x="{x + 14}" y="{height - 7}">{html.escape(name)}</text>')
    out.append(f'<line x1="{left}" y1="{height - bottom}" x2="{width - 20}" y2="{height - bottom}" stroke="#444"/>')
    return "\n".join(out + ["</svg>", ""])
