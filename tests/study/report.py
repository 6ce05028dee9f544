"""The report: one HTML file without external parts. It has plots, pictures and tables."""
import base64
import html
import io
import json
from typing import NamedTuple

from PIL import Image

import plots
import tables
from rows import METRICS, on_every_network

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
                     f"{row['size']} px; FLIP {row['error.flip.p99']:.4f} (99 %), {row['flip']:.4f} (median); PSNR "
                     f"{row['psnr']:.1f} dB, SSIM {row['ssim']:.4f} (medians)</p>"
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


class Plot(NamedTuple):
    title: str
    svg: str
    size: str = ""  # width and height of an eye, and the metric, if the reader chooses them
    metric: str = ""


def draw(rows):
    """Returns name -> Plot, the fits, and the description of each point."""
    points, drawn, fits = plots.Points(), {}, []
    everywhere = on_every_network(rows)
    for name, title, x, label, columns in PLOTS:
        shown = everywhere if columns else [r for r in rows if r["part"] == "mode"]
        for (size,), own in plots.grouped(shown, "size").items():
            for metric in METRICS:
                own_name = f"{name}-{metric.shown}-{size}"
                svg = plots.error_against(own_name, own, x, label, columns, points, metric)
                if svg:
                    drawn[own_name] = Plot(title, svg, str(size), metric.label)
    for axis, label in SCALES:
        svg, fitted = plots.scaling(axis, rows, axis, label, points)
        fits += fitted
        if svg:
            drawn[axis] = Plot(f"Run time against {axis}", svg)
    return drawn, fits, points.told


def choice(name, label, values):
    """Buttons of which one is pressed: the page shows the plots with its value."""
    return f"<span>{label}: " + "".join(
        f'<label><input type="radio" name="{name}" value="{html.escape(value)}"{"" if i else " checked"}>'
        f"{html.escape(value)}</label> " for i, value in enumerate(values)) + "</span>"


def plot_sections(drawn):
    """A section for each title."""
    sections = []
    for title, own in plots.grouped([p._asdict() for p in drawn.values()], "title").items():
        inside = "".join(f'<div class="plot" data-size="{p["size"]}" data-metric="{p["metric"]}">{p["svg"]}</div>'
                         for p in own)
        sections.append(f"<section><h2>{html.escape(title[0])}</h2>{inside}</section>\n")
    return "".join(sections)


def make(header, rows):
    """Returns (name -> SVG, the page)."""
    drawn, fits, told = draw(rows)
    networks = {r["network"]: r["network_words"] for r in rows}
    header = header | {"networks": "; ".join(f"{name}: {words}" for name, words in networks.items()) + " (in each direction)"}
    said = "".join(f"<dt>{html.escape(k)}<dd>{html.escape(str(v))}" for k, v in header.items())
    sizes = list(dict.fromkeys(p.size for p in drawn.values() if p.size))
    choices = (choice("metric", "Metric", [m.label for m in METRICS])
               + choice("size", "Pixels per side of an eye", sizes))
    page = PAGE.format(style=STYLE, header=said, choices=choices, plots=plot_sections(drawn),
                       tables=tables.all_of(rows, fits), pictures=worst_pictures(rows), script=SCRIPT,
                       told=json.dumps(told).replace("</", "<\\/"))
    return {name: plot.svg for name, plot in drawn.items()}, page


STYLE = """
body { font: 14px/1.45 system-ui, sans-serif; margin: 2em auto; max-width: 1180px; padding: 0 1em; color: #222; }
h1 { font-size: 22px; } h2 { font-size: 17px; margin-top: 2em; } h3 { font-size: 14px; margin: 1.4em 0 0; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: 2px 1em; font-size: 12px; }
dt { color: #666; } dd { margin: 0; overflow-wrap: anywhere; }
table { border-collapse: collapse; font-size: 12px; } caption { text-align: left; padding: 4px 0; color: #555; }
th, td { padding: 2px 12px 2px 0; text-align: left; border-bottom: 1px solid #eee; vertical-align: top; }
td.n, th.n { text-align: right; font-variant-numeric: tabular-nums; }
.choices { position: sticky; top: 0; z-index: 5; background: #fff; padding: 6px 0; border-bottom: 1px solid #ddd; }
.choices span { margin-right: 2em; } summary { font-size: 12px; color: #555; cursor: pointer; }
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
const chosen = name => document.querySelector(`input[name=${name}]:checked`)?.value;
function showChosen() {
  for (const plot of document.querySelectorAll('.plot'))
    plot.hidden = ['size', 'metric'].some(name => plot.dataset[name] && plot.dataset[name] !== chosen(name));
}
for (const button of document.querySelectorAll('.choices input')) button.addEventListener('change', showChosen);
showChosen();
document.body.dataset.points = String(told.length);
"""

PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>Error and run time</title><style>{style}</style></head>
<body>
<h1>Error and run time</h1>
<dl>{header}</dl>
<div class="choices">{choices}</div>
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
