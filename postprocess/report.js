"use strict";

const FONT = { family: 'system-ui, "Liberation Sans", Arial, sans-serif', size: 14, color: "#1c2126" };
const MILLISECONDS = 80; // of a frame
const MARGIN = { l: 0, r: 0, t: 60, b: 0 }; // with room for the colours above the body
const TOUCH = matchMedia("(pointer: coarse)").matches; // a finger that drags wants to scroll the page
const CONFIG = { responsive: true, displayModeBar: false, scrollZoom: false };
const AXIS = { automargin: true, gridcolor: "#e8ebee", zeroline: false, linecolor: "#98a2ab", ticks: "outside",
  tickcolor: "#98a2ab", title: { standoff: 10 } };
const STYLE = { layout: { font: FONT, xaxis: AXIS, yaxis: AXIS, margin: { l: 10, r: 14, t: 12, b: 10 }, hovermode: "closest",
  hoverlabel: { font: { size: 14 } }, paper_bgcolor: "rgba(0,0,0,0)", showlegend: false, dragmode: TOUCH ? false : "zoom" } };
const FLAT = { lighting: { ambient: 1, diffuse: 0, specular: 0, fresnel: 0 } };
const ROUND = { lighting: { ambient: 0.75, diffuse: 0.5, specular: 0.05 } };

const $ = (id) => document.getElementById(id);
const decoded = (text) => Uint8Array.from(atob(text), (character) => character.charCodeAt(0)).buffer;

async function unpacked(id) {
  const stream = new Blob([decoded($(id).textContent)]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).text();
}

/** Numbers as report_parts.py packs them; rows of a table one after the other. */
function numbers(array) {
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
  const { color, symbol, dash } = trace.mode === "markers" ? trace.marker : trace.line;
  const mark = trace.mode === "markers" ? shapes[symbol || "circle"]
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

/** The camera and the size of the scene; both follow the size of the window. */
function sceneOf(motion, plot) {
  const plane = motion.dim === 2;
  const [low, high] = motion.box.map((corner, side) => corner.map((end) => end + (side ? 0.02 : -0.02) * motion.size));
  const size = high.map((end, axis) => end - low[axis]), width = plot.clientWidth;
  const [beside, below] = plane ? [112, 84] : [0, 0]; // pixels for the axes
  const tall = plane ? MARGIN.t + below + ((width - beside) * size[1]) / size[0] : MARGIN.t + 0.8 * width;
  plot.style.height = `${Math.round(Math.max(280, Math.min(0.7 * innerHeight, tall)))}px`;

  // In an orthographic scene half of the plot's height is one unit of the aspect ratio.
  const half = () => (plot.clientHeight - MARGIN.t) / 2;
  const ratio = (zoom) => {
    const wide = plot.clientWidth, high = 2 * half();
    const pixels = plane ? Math.min((wide - beside) / size[0], (high - below) / size[1])
      : (1.15 * Math.min(wide, high)) / Math.hypot(...size);
    const unit = (zoom * pixels) / half();
    return { x: unit * size[0], y: unit * size[1], z: plane ? 0.01 : unit * size[2] };
  };
  const camera = () => {
    const projection = { type: "orthographic" };
    if (!plane) return { eye: { x: 0.9, y: -1.5, z: 0.45 }, center: { x: 0, y: 0, z: 0 }, up: { x: 0, y: 0, z: 1 }, projection };
    const y = (12 - below / 2) / half(); // labels stand below the body, none above
    return { eye: { x: 0, y, z: 1.5 }, center: { x: 0, y, z: 0 }, up: { x: 0, y: 1, z: 0 }, projection };
  };
  const axis = (name, i) => ({ title: { text: plane ? `${name} (m)` : name }, range: [low[i], high[i]], showbackground: false,
    gridcolor: "#e8ebee", zeroline: false, showspikes: false, tickfont: { size: 12 }, nticks: 6, tickangle: 0 });
  const scene = { xaxis: axis("x", 0), yaxis: axis("y", 1), zaxis: plane ? { visible: false, range: [-1, 1] } : axis("z", 2),
    aspectmode: "manual", aspectratio: ratio(1), camera: camera(), dragmode: plane ? "pan" : "turntable" };

  let zoom = 1;
  const look = (times) => {
    zoom *= times;
    // On a plane body that is seen as a whole there is nothing to drag.
    plot.style.pointerEvents = TOUCH && plane && zoom === 1 ? "none" : "";
    const seen = structuredClone(plot.layout.scene.camera);
    for (const axis of plane ? ["x", "y"] : []) seen.eye[axis] = seen.center[axis] *= times; // what was in the middle stays there
    Plotly.relayout(plot, { "scene.aspectratio": ratio(zoom), "scene.camera": seen });
  };
  const whole = () => {
    look(1 / zoom);
    Plotly.relayout(plot, { "scene.camera": camera() });
  };
  return { scene, look, whole };
}

function showMotion(motion) {
  const plot = $("body-plot"), slider = $("frame"), play = $("play"), select = $("field");
  const points = numbers(motion.points), moved = numbers(motion.displacement.values), count = points.length / motion.dim;
  const faces = numbers(motion.faces), edges = numbers(motion.edges);
  const fields = motion.fields.map((field) => ({ ...field, values: numbers(field.values) }));
  const touching = motion.touching && { nodes: numbers(motion.touching.nodes), on: numbers(motion.touching.on) };

  /** Coordinates of all nodes in a frame. */
  const position = (frame) => [0, 1, 2].map((axis) => {
    if (axis >= motion.dim) return new Float32Array(count);
    const start = (frame * motion.dim + axis) * count;
    return Float32Array.from({ length: count }, (_, i) => points[axis * count + i] + motion.displacement.scale * moved[start + i]);
  });
  const colours = (frame) => {
    const { values, scale } = fields[select.value];
    return Float32Array.from(values.subarray(frame * count, (frame + 1) * count), (value) => scale * value);
  };
  const outline = (coordinate) => {
    const line = [];
    for (let i = 0; i < edges.length; i += 2) line.push(coordinate[edges[i]], coordinate[edges[i + 1]], null);
    return line;
  };
  const contacts = (coordinate, frame) => {
    const { nodes, on } = touching;
    return Array.from(nodes.filter((_, i) => on[frame * nodes.length + i]), (node) => coordinate[node]);
  };

  const [i, j, k] = [0, 1, 2].map((corner) => faces.slice((corner * faces.length) / 3, ((corner + 1) * faces.length) / 3));
  const body = { type: "mesh3d", i, j, k, colorscale: "Viridis", hovertemplate: "%{intensity:.3g}<extra></extra>",
    ...(motion.dim === 2 ? FLAT : ROUND), cmin: 0,
    colorbar: { orientation: "h", x: 0.5, xanchor: "center", y: 1, yanchor: "bottom", len: 0.9, thickness: 12, outlinewidth: 0,
      title: { side: "top", text: "" } } };
  const edge = { type: "scatter3d", mode: "lines", hoverinfo: "skip", line: { color: "#1c2126", width: 2 } };
  const contact = { type: "scatter3d", mode: "markers", name: "in contact", hoverinfo: "skip", marker: { color: "#d55e00", size: 4 } };
  const traces = [body, ...(edges.length ? [edge] : []), ...(touching ? [contact] : [])];
  if (motion.obstacle) {
    const corners = numbers(motion.obstacle), [x, y, z] = [0, 4, 8].map((start) => corners.slice(start, start + 4));
    traces.push({ type: "mesh3d", x, y, z: z.length ? z : [0, 0, 0, 0], i: [0, 0], j: [1, 2], k: [2, 3], hoverinfo: "skip",
      color: "#b4bcc3", opacity: motion.dim === 2 ? 1 : 0.45, ...FLAT });
  }

  const pose = () => {
    const frame = Number(slider.value), at = position(frame), { label, largest } = fields[select.value];
    const place = (trace, of) => Object.assign(trace, { x: of(at[0]), y: of(at[1]), z: of(at[2]) });
    place(body, (coordinate) => coordinate);
    Object.assign(body, { intensity: colours(frame), cmax: largest || 1 }).colorbar.title.text = label;
    if (edges.length) place(edge, outline);
    if (touching) place(contact, (coordinate) => contacts(coordinate, frame));
    const time = `${motion.times[frame].toPrecision(4)} ${motion.unit}`;
    $("now").textContent = `t = ${time}`;
    slider.setAttribute("aria-valuetext", time);
  };
  const show = () => {
    pose();
    Plotly.redraw(plot);
  };

  pose();
  const { scene, look, whole } = sceneOf(motion, plot);
  Plotly.newPlot(plot, traces, { template: STYLE, scene, margin: MARGIN }, CONFIG);
  showLegend(plot, traces);
  look(1);
  $("nearer").addEventListener("click", () => look(1.5));
  $("farther").addEventListener("click", () => look(1 / 1.5));
  $("whole").addEventListener("click", whole);
  addEventListener("resize", () => look(1));
  slider.addEventListener("input", show);
  select.addEventListener("change", show);

  let playing = null;
  const stop = () => {
    clearInterval(playing);
    playing = null;
    play.textContent = "Play";
  };
  const step = () => {
    slider.value = Number(slider.value) + 1;
    show();
    if (slider.value === slider.max) stop();
  };
  play.addEventListener("click", () => {
    if (playing) return stop();
    if (slider.value === slider.max) slider.value = 0;
    play.textContent = "Pause";
    playing = setInterval(step, MILLISECONDS);
  });
}

async function start() {
  if (!("DecompressionStream" in window)) throw new Error("this page needs a browser of 2023 or later");
  const library = document.createElement("script");
  library.textContent = await unpacked("plotly-code");
  document.head.append(library);
  const page = JSON.parse(await unpacked("data"));
  if (page.motion) showMotion(page.motion);
  for (const [name, views] of Object.entries(page.charts)) showChart(name, views);
  document.documentElement.dataset.ready = "";
}

start().catch((error) => {
  $("trouble").textContent = `The charts could not be drawn: ${error.message}.`;
  $("trouble").hidden = false;
  throw error;
});
