// SPDX-License-Identifier: GPL-3.0-or-later
const FONT = { family: 'system-ui, "Liberation Sans", Arial, sans-serif', size: 14, color: "#1c2126" };
const TOUCH = matchMedia("(pointer: coarse)").matches; // a finger that drags wants to scroll the page
const CONFIG = { responsive: true, displayModeBar: false, scrollZoom: false };
const AXIS = { automargin: true, gridcolor: "#e8ebee", zeroline: false, linecolor: "#98a2ab", ticks: "outside",
  tickcolor: "#98a2ab", title: { standoff: 10 } };
const STYLE = { layout: { font: FONT, xaxis: AXIS, yaxis: AXIS, margin: { l: 10, r: 14, t: 12, b: 10 }, hovermode: "closest",
  hoverlabel: { font: { size: 14 } }, paper_bgcolor: "rgba(0,0,0,0)", showlegend: false, dragmode: TOUCH ? false : "zoom" } };

const $ = (id) => document.getElementById(id);
const decoded = (text) => Uint8Array.from(atob(text), (character) => character.charCodeAt(0)).buffer;

async function unpacked(id) {
  const stream = new Blob([decoded($(id).textContent)]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).text();
}

/** Numbers as report_parts.py packs them, or unpacked already; rows of a table one after the other. */
function numbers(array) {
  if (ArrayBuffer.isView(array)) return array;
  const kinds = { f4: Float32Array, i2: Int16Array, u2: Uint16Array, u1: Uint8Array, i4: Int32Array };
  return new kinds[array.dtype](decoded(array.bdata));
}

/** What a curve looks like, to stand beside its name. */
function sample(trace) {
  const dashes = { dash: "7 4", dot: "2 4", dashdot: "7 3 2 3" };
  const shapes = {
    circle: '<circle cx="14" cy="8" r="5"', square: '<rect x="9" y="3" width="10" height="10"',
    diamond: '<path d="M14 2l6 6-6 6-6-6z"', "triangle-up": '<path d="M14 2l6 11H8z"',
    x: '<path d="M9 3l10 10M19 3L9 13" stroke-width="3"', cross: '<path d="M14 2v12M8 8h12" stroke-width="3"',
  };
  const filled = trace.mode === "markers" || trace.type === "bar";
  const { color, symbol, dash } = filled ? trace.marker : trace.line;
  const mark = filled ? shapes[trace.type === "bar" ? "square" : symbol || "circle"]
    : `<path d="M0 8h28" stroke-width="2.5" stroke-dasharray="${dashes[dash] || ""}"`;
  return `<svg width="28" height="16" aria-hidden="true">${mark} fill="${color}" stroke="${color}"/></svg>`;
}

/** A button for each named curve, which shows or hides it; plotly's own legend takes no keyboard. */
function showLegend(plot, traces) {
  const buttons = traces.flatMap((trace, index) => {
    if (!trace.name) return [];
    const button = document.createElement("button");
    button.type = "button";
    button.innerHTML = sample(trace);
    button.append(trace.name);
    button.setAttribute("aria-pressed", "true");
    button.addEventListener("click", () => {
      const on = button.getAttribute("aria-pressed") === "false";
      button.setAttribute("aria-pressed", on);
      Plotly.restyle(plot, { visible: on }, [index]);
    });
    return [button];
  });
  plot.parentElement.querySelector(".legend").replaceChildren(...buttons);
}

function showChart(name, views) {
  const plot = $(`${name}-plot`), select = $(`${name}-view`);
  const draw = () => {
    // plotly.js keeps what it is given and changes it.
    const { data, layout } = structuredClone(views[select ? select.value : Object.keys(views)[0]]);
    Plotly.react(plot, data, { ...layout, template: STYLE }, CONFIG);
    showLegend(plot, data.filter((trace) => trace.name).length > 1 ? data : []);
  };
  draw();
  if (select) select.addEventListener("change", draw);
}

async function start() {
  if (!("DecompressionStream" in window)) throw new Error("this page needs a browser of 2023 or later");
  const library = document.createElement("script");
  library.textContent = await unpacked("plotly-code");
  document.head.append(library);
  const page = JSON.parse(await unpacked("data"));
  if (page.motions.length) showMotion(page.motions);
  for (const [name, views] of Object.entries(page.charts)) showChart(name, views);
  if (page.batch) showBatch(page.batch);
  document.documentElement.dataset.ready = "";
}

start().catch((error) => {
  $("trouble").textContent = `The charts could not be drawn: ${error.message}.`;
  $("trouble").hidden = false;
  throw error;
});
