"""The report: one HTML file without external parts. It has plots, pictures and tables."""
import base64
import html
import io
import json

from PIL import Image

import plots
import tables

PICTURE_PX = 192  # width and height, so that the page stays small


def small_png(path):
    """The picture as a data URI, with at most PICTURE_PX per side and 128 colours."""
    with Image.open(path) as picture:
        picture = picture.convert("RGB")
        picture.thumbnail((PICTURE_PX, PICTURE_PX), Image.Resampling.BOX)
        small = picture.quantize(128, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    kept = io.BytesIO()
    small.save(kept, "PNG", optimize=True)
    return "data:image/png;base64," + base64.b64encode(kept.getvalue()).decode()


def worst_pictures(rows):
    """For each scene and mode, the pictures of the compared frame with the largest FLIP."""
    parts = []
    for (scene, mode), own in plots.grouped([r for r in rows if r["part"] == "mode"], "scene", "mode").items():
        own = [r for r in own if r["flip"] is not None and (r["pictures"] / "left_heat.png").exists()]
        if not own:
            continue
        row = max(own, key=lambda r: r["error.flip.p99"])
        shown = "".join(f'<figure><img alt="{eye} eye, {what}" src="{small_png(row["pictures"] / f"{eye}_{what}.png")}">'
                        f"<figcaption>{eye}, {what}</figcaption></figure>"
                        for eye in ("left", "right") for what in ("shown", "reference", "heat"))
        parts.append(f'<h3 style="color:{plots.COLOURS.get(mode, plots.OTHER)}">{html.escape(scene)}: '
                     f"{html.escape(row['words'])}</h3><p>{html.escape(row['trace'])}, {html.escape(row['network'])}; "
                     f"FLIP {row['error.flip.p99']:.4f} (99 %), {row['flip']:.4f} (median)</p>"
                     f'<div class="pictures">{shown}</div>')
    return "\n".join(parts)


PLOTS = [
    ("client", "Error against the client's run time", "client_ms", "client, ms per frame", "network"),
    ("server", "Error against the server's run time", "server_ms", "server, ms per frame", "network"),
    ("both", "Error against the run time of both", "both_ms", "both, ms per frame", "network"),
    ("bytes", "Error against bytes", "bytes", "bytes to the client per frame", "network"),
    # Not the figure `staleness`: that is 0 for a mask that was predicted for exactly the time of its display.
    ("staleness", "Error against staleness", "latency", "time from request to display, ms", None),
]
SCALES = [("pixels", "pixels, both eyes"), ("lights", "lights"), ("triangles", "triangles"), ("clients", "clients")]


def draw(rows):
    """Returns name -> (title, SVG), the fits, and the description of each point."""
    points, drawn, fits = plots.Points(), {}, []
    modes = [r for r in rows if r["part"] == "mode"]
    everywhere = tables.on_every_network(modes)
    for name, title, x, label, columns in PLOTS:
        shown = everywhere if columns else modes
        svg = plots.error_against(name, shown, x, label, columns, points)
        if svg:
            drawn[name] = (title, svg)
    for axis, label in SCALES:
        svg, fitted = plots.scaling(axis, rows, axis, label, points)
        fits += fitted
        if svg:
            drawn[axis] = (f"Run time against {axis}", svg)
    return drawn, fits, points.told


def make(header, rows):
    """Returns (name -> SVG, the page)."""
    drawn, fits, told = draw(rows)
    networks = {r["network"]: r["network_words"] for r in rows}
    header = header | {"networks": "; ".join(f"{name}: {words}" for name, words in networks.items()) + " (in each direction)"}
    said = "".join(f"<dt>{html.escape(k)}<dd>{html.escape(str(v))}" for k, v in header.items())
    sections = "".join(f'<section><h2>{html.escape(title)}</h2><div class="plot">{svg}</div></section>\n'
                       for title, svg in drawn.values())
    page = PAGE.format(style=STYLE, header=said, plots=sections, tables=tables.all_of(rows, fits),
                       pictures=worst_pictures(rows), script=SCRIPT,
                       told=json.dumps(told).replace("</", "<\\/"))
    return {name: svg for name, (_, svg) in drawn.items()}, page


STYLE = """
body { font: 14px/1.45 system-ui, sans-serif; margin: 2em auto; max-width: 1180px; padding: 0 1em; color: #222; }
h1 { font-size: 22px; } h2 { font-size: 17px; margin-top: 2em; } h3 { font-size: 14px; margin: 1.4em 0 0; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: 2px 1em; font-size: 12px; }
dt { color: #666; } dd { margin: 0; overflow-wrap: anywhere; }
table { border-collapse: collapse; font-size: 12px; } caption { text-align: left; padding: 4px 0; color: #555; }
th, td { padding: 2px 12px 2px 0; text-align: left; border-bottom: 1px solid #eee; vertical-align: top; }
td.n, th.n { text-align: right; font-variant-numeric: tabular-nums; }
.plot svg { max-width: 100%; height: auto; } .point { cursor: pointer; } .point:hover { stroke-width: 3px; }
.pictures { display: flex; flex-wrap: wrap; gap: 6px; } figure { margin: 0; }
img { width: 180px; image-rendering: auto; } figcaption { font-size: 11px; color: #666; }
#told { position: fixed; display: none; background: #222; color: #fff; font-size: 12px; padding: 6px 9px;
  border-radius: 4px; white-space: pre; pointer-events: none; z-index: 9; }
@media print { section { break-inside: avoid; } #told { display: none !important; } }
"""

SCRIPT = """
const told = JSON.parse(document.getElementById('points').textContent);
const tip = document.getElementById('told');
for (const point of document.querySelectorAll('.point')) {
  const title = point.querySelector('title');
  if (title) title.remove();  // one tip is enough
  const text = told[Number(point.id.slice('point-'.length))];
  point.addEventListener('mouseover', event => {
    tip.textContent = text;
    tip.style.display = 'block';
    tip.style.left = Math.min(event.clientX + 12, innerWidth - tip.offsetWidth - 8) + 'px';
    tip.style.top = Math.min(event.clientY + 12, innerHeight - tip.offsetHeight - 8) + 'px';
  });
  point.addEventListener('mouseout', () => { tip.style.display = 'none'; });
}
document.body.dataset.points = String(told.length);
"""

PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>Error and run time</title><style>{style}</style></head>
<body>
<h1>Error and run time</h1>
<dl>{header}</dl>
{plots}
{tables}
<h2>The worst frame of each mode</h2>
<p>The shown picture, the reference, and the error map of FLIP: black is no error, yellow the largest.</p>
{pictures}
<div id="told"></div>
<script type="application/json" id="points">{told}</script>
<script>{script}</script>
</body></html>
"""
