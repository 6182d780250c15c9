// SPDX-License-Identifier: GPL-3.0-or-later
const PALETTE = ["#0072B2", "#D55E00", "#009E73", "#E69F00", "#CC79A7", "#56B4E9"]; // of texts
const MARKS = ["circle", "square", "diamond", "triangle-up", "x", "cross"];
const VIRIDIS = ["#440154", "#482878", "#3e4989", "#31688e", "#26828e", "#1f9e89", "#35b779", "#6ece58", "#b5de2b", "#fde725"];
const FADED = "#dde2e6"; // cases outside of the selected ranges
const FAILED = "#8c8c8c";
const TOOLTIP_LINES = 10;
const CROWD = 500; // cases with smaller marks
const SPACING = 112; // pixels between axes, at least
const FRAME = { top: 84, bottom: 18, side: 64, height: 440 };
const HANDLE = 40; // pixels, as wide as a finger needs
const CLICK = 4; // pixels; a shorter drag is a click
const NAMES = 5;

/** Text as plotly.js shows it literally. */
const literal = (text) => text.replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/>/g, "&gt;");
const digits = (value) => String(Number(value.toPrecision(6)));

/** Value of a case on an axis as text. */
function written(axis, i) {
  const value = axis.values[i];
  return value === null ? "no value" : axis.words.length ? axis.words[value] : digits(value);
}

/** Least and largest value of an axis, and the map of values to 0 (least) … 1 (largest) with its inverse. */
function scaleOf(axis) {
  const map = axis.log ? Math.log10 : (value) => value;
  const low = axis.values.reduce((a, value) => (value === null ? a : Math.min(a, value)), Infinity);
  const high = axis.values.reduce((a, value) => (value === null ? a : Math.max(a, value)), -Infinity);
  const from = map(low), width = map(high) - from;
  return { low, high, part: (value) => (map(value) - from) / width,
    at: (part) => (axis.log ? 10 ** (from + part * width) : from + part * width) };
}

/** Round numbers within an axis, or its texts, with their labels. */
function ticksOf(axis) {
  if (axis.words.length) return axis.words.map((word, i) => [i, word]);
  const { low, high } = scaleOf(axis);
  if (axis.log) {
    const first = Math.ceil(Math.log10(low) - 1e-9), last = Math.floor(Math.log10(high) + 1e-9);
    const every = Math.ceil((last - first + 1) / 6);
    const powers = Array.from({ length: last - first + 1 }, (_, i) => first + i);
    return powers.filter((_, i) => i % every === 0).map((power) => [10 ** power, digits(10 ** power)]);
  }
  const rough = (high - low) / 5, power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find((factor) => factor * power >= 0.999 * rough);
  const first = Math.ceil(low / step - 1e-9), last = Math.floor(high / step + 1e-9);
  return Array.from({ length: last - first + 1 }, (_, i) => [(first + i) * step, digits((first + i) * step)]);
}

function viridis(part) {
  const place = Math.min(Math.max(part, 0), 1) * (VIRIDIS.length - 1), i = Math.min(Math.floor(place), VIRIDIS.length - 2);
  const channel = (colour, at) => parseInt(colour.slice(at, at + 2), 16);
  const mix = (at) => Math.round(channel(VIRIDIS[i], at) + (place - i) * (channel(VIRIDIS[i + 1], at) - channel(VIRIDIS[i], at)));
  return `rgb(${mix(1)}, ${mix(3)}, ${mix(5)})`;
}

/** Colour of each case by an axis; without one all are blue. */
function coloursOf(axis, count) {
  if (!axis) return Array(count).fill(PALETTE[0]);
  const scale = scaleOf(axis);
  const colour = (value) => (axis.words.length ? PALETTE[value % PALETTE.length] : viridis(scale.part(value)));
  return axis.values.map((value) => (value === null ? FAILED : colour(value)));
}

const chosenAxis = (batch, select) => (select.value === "" ? null : batch.axes[select.value]);

/** Shows the scatter plot; returns a function that highlights cases, all of them for null. */
function showScatter(batch) {
  const plot = $("scatter-plot"), [across, up, colour] = ["x", "y", "colour"].map((name) => $(`scatter-${name}`));
  across.value = batch.keys ? 0 : 1;
  up.value = batch.keys && batch.keys < batch.axes.length ? batch.keys : batch.keys ? 1 : 0;
  colour.value = batch.keys > 1 ? 1 : "";
  let highlighted = null;

  const tooltip = (i, axes) => {
    const shown = [...new Set([...axes, ...batch.axes.filter((axis) => axis.key)])].slice(0, TOOLTIP_LINES);
    const lines = shown.map((axis) => literal(`${axis.label}: ${written(axis, i)}`));
    return [`<b>${literal(batch.names[i])}</b>`, ...lines].join("<br>");
  };
  const layoutOf = (axis) => {
    const title = { text: literal(axis.label) };
    if (axis.log) return { title, type: "log", exponentformat: "power" };
    if (!axis.words.length) return { title };
    return { title, tickvals: axis.words.map((_, i) => i), ticktext: axis.words.map(literal), range: [-0.5, axis.words.length - 0.5] };
  };
  const size = batch.names.length > CROWD ? 6 : 9;
  const trace = (name, cases, axes, marker) => ({ type: "scatter", mode: "markers", name: literal(name), marker: { size, ...marker },
    x: cases.map((i) => axes[0].values[i]), y: cases.map((i) => axes[1].values[i]), text: cases.map((i) => tooltip(i, axes)),
    hovertemplate: "%{text}<extra></extra>", unselected: { marker: { opacity: 0.12 } },
    ...(highlighted ? { selectedpoints: cases.flatMap((i, place) => (highlighted[i] ? [place] : [])) } : {}) });
  /** A trace without marks, for the bar of the colours: each mark has its own, also on a logarithmic scale. */
  const colourBar = (axis) => {
    const scale = scaleOf(axis), ticks = ticksOf(axis), shades = VIRIDIS.map((shade, i) => [i / (VIRIDIS.length - 1), shade]);
    const bar = { title: { text: literal(axis.label), side: "right" }, thickness: 14, outlinewidth: 0,
      tickvals: ticks.map(([value]) => scale.part(value)), ticktext: ticks.map(([, text]) => text) };
    return { type: "scatter", mode: "markers", x: [null], y: [null], hoverinfo: "skip",
      marker: { color: [0], cmin: 0, cmax: 1, showscale: true, colorscale: shades, colorbar: bar } };
  };

  const draw = () => {
    const by = chosenAxis(batch, colour), axes = [chosenAxis(batch, across), chosenAxis(batch, up), ...(by ? [by] : [])];
    const here = batch.names.map((_, i) => i).filter((i) => axes[0].values[i] !== null && axes[1].values[i] !== null);
    const done = here.filter((i) => batch.done[i]), failed = here.filter((i) => !batch.done[i]);
    const data = [];
    if (by && by.words.length) {
      const groups = by.words.map((word, k) => [word, done.filter((i) => by.values[i] === k),
        { color: PALETTE[k % PALETTE.length], symbol: MARKS[k % MARKS.length] }]);
      groups.push(["no value", done.filter((i) => by.values[i] === null), { color: FAILED, symbol: "circle" }]);
      for (const [word, cases, marker] of groups) if (cases.length) data.push(trace(word, cases, axes, marker));
    } else {
      const colours = coloursOf(by, batch.names.length);
      data.push(by ? trace("", done, axes, { color: done.map((i) => colours[i]) }) : trace("done", done, axes, { color: PALETTE[0] }));
    }
    if (failed.length) data.push(trace("failed", failed, axes, { color: FAILED, symbol: "x" }));
    Plotly.react(plot, by && !by.words.length ? [...data, colourBar(by)] : data,
      { xaxis: layoutOf(axes[0]), yaxis: layoutOf(axes[1]), template: STYLE }, CONFIG);
    showLegend(plot, data.length > 1 ? data : []);
  };
  for (const select of [across, up, colour]) select.addEventListener("change", draw);
  draw();
  return (cases) => {
    highlighted = cases;
    draw();
  };
}

/** A title in lines of some sixteen characters, broken at dots and spaces. */
function linesOf(title) {
  const lines = [""];
  for (const part of title.match(/[^. ]+[. ]?|[. ]/g) || [title]) {
    if (lines[lines.length - 1] && (lines[lines.length - 1] + part).trimEnd().length > 16) lines.push("");
    lines[lines.length - 1] += part;
  }
  return lines.slice(-5);
}

function svg(name, attributes, ...children) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  element.append(...children);
  return element;
}

/** Shows parallel coordinates; `highlight` is called with the cases within all selected ranges, null without a range. */
function showParallel(batch, highlight) {
  const plot = $("parallel-plot"), colour = $("parallel-colour"), clear = $("parallel-clear"), count = $("parallel-count");
  const [canvas, drawing] = [plot.querySelector("canvas"), plot.querySelector("svg")];
  const scales = batch.axes.map(scaleOf), ranges = new Map(); // from axis to [low, high], parts of its length
  const tall = FRAME.height - FRAME.top - FRAME.bottom;
  const parts = batch.axes.map((axis, k) => axis.values.map((value) => (value === null ? null : scales[k].part(value))));
  colour.value = batch.keys < batch.axes.length ? batch.keys : "";
  plot.style.height = `${FRAME.height}px`;
  plot.style.minWidth = `${2 * FRAME.side + (batch.axes.length - 1) * SPACING}px`;
  const left = (k) => FRAME.side + (k * (plot.clientWidth - 2 * FRAME.side)) / (batch.axes.length - 1);
  const top = (part) => FRAME.top + (1 - part) * tall;

  const inside = (part, [low, high]) => part !== null && part >= low && part <= high;
  const within = () => (ranges.size ? batch.names.map((_, i) => [...ranges].every(([k, ends]) => inside(parts[k][i], ends))) : null);

  const drawLines = () => {
    const pen = canvas.getContext("2d"), density = window.devicePixelRatio || 1, selected = within();
    canvas.width = Math.round(plot.clientWidth * density);
    canvas.height = Math.round(FRAME.height * density);
    pen.scale(density, density);
    pen.lineWidth = 1.5;
    const colours = coloursOf(chosenAxis(batch, colour), batch.names.length);
    const all = batch.names.map((_, i) => i), chosen = all.filter((i) => !selected || selected[i]);
    const stroke = (i, shade) => {
      pen.strokeStyle = shade;
      pen.beginPath();
      let open = false;
      parts.forEach((values, k) => {
        if (values[i] !== null) pen[open ? "lineTo" : "moveTo"](left(k), top(values[i]));
        open = values[i] !== null;
      });
      pen.stroke();
    };
    pen.globalAlpha = 0.8;
    if (selected) for (const i of all) if (!selected[i]) stroke(i, FADED);
    pen.globalAlpha = Math.max(0.2, Math.min(0.85, 10 / Math.sqrt(chosen.length + 1)));
    for (const i of chosen) stroke(i, batch.done[i] ? colours[i] : FAILED);
    const names = chosen.slice(0, NAMES).map((i) => batch.names[i]).join(", ") + (chosen.length > NAMES ? ", …" : "");
    count.textContent = selected ? `${chosen.length} of ${all.length} cases${chosen.length ? `: ${names}` : ""}` : "";
    clear.disabled = !selected;
  };

  /** Ends of the range of an axis as text. */
  const said = (k) => {
    if (!ranges.has(k)) return "all";
    const ends = ranges.get(k), axis = batch.axes[k];
    if (!axis.words.length) return ends.map((end) => digits(scales[k].at(end))).join(" to ");
    return axis.words.filter((_, i) => inside(scales[k].part(i), ends)).join(", ") || "none";
  };
  const bars = [], handles = [];
  const drawRange = (k) => {
    const [low, high] = ranges.get(k) || [0, 0];
    bars[k].setAttribute("y", top(high));
    bars[k].setAttribute("height", (high - low) * tall);
    handles[k].setAttribute("aria-valuenow", ranges.has(k) ? (low + high) / 2 : 0.5);
    handles[k].setAttribute("aria-valuetext", said(k));
  };
  const choose = (k, range) => {
    if (range) ranges.set(k, range.map((end) => Math.min(Math.max(end, 0), 1)).sort((a, b) => a - b));
    else ranges.delete(k);
    drawRange(k);
    drawLines();
  };
  const finish = () => highlight(within());

  const move = (k, key) => {
    const [low, high] = ranges.get(k) || [0.4, 0.6], half = (high - low) / 2, step = 0.05;
    if (key === "Escape" || key === "Delete") return choose(k, null);
    const middle = (low + high) / 2 + (key === "ArrowUp" ? step : key === "ArrowDown" ? -step : 0);
    const length = Math.max(half + (key === "+" ? step / 2 : key === "-" ? -step / 2 : 0), step / 2);
    const within = Math.min(Math.max(middle, length), 1 - length);
    return choose(k, length < 0.5 ? [within - length, within + length] : [0, 1]);
  };
  const listen = (k) => {
    const handle = handles[k], at = (event) => 1 - (event.clientY - drawing.getBoundingClientRect().top - FRAME.top) / tall;
    let begun = null;
    handle.addEventListener("pointerdown", (event) => {
      begun = { y: event.clientY, part: at(event) };
      handle.setPointerCapture(event.pointerId);
    });
    handle.addEventListener("pointermove", (event) => {
      if (begun && Math.abs(event.clientY - begun.y) >= CLICK) choose(k, [begun.part, at(event)]);
    });
    const end = (event) => {
      if (begun && Math.abs(event.clientY - begun.y) < CLICK) choose(k, null);
      begun = null;
      finish();
    };
    for (const name of ["pointerup", "pointercancel"]) handle.addEventListener(name, end);
    handle.addEventListener("keydown", (event) => {
      if (!["ArrowUp", "ArrowDown", "+", "-", "Escape", "Delete"].includes(event.key)) return;
      event.preventDefault();
      move(k, event.key);
      finish();
    });
  };

  const drawAxes = () => {
    drawing.setAttribute("width", plot.clientWidth);
    drawing.setAttribute("height", FRAME.height);
    drawing.replaceChildren(...batch.axes.map((axis, k) => {
      const x = left(k), lines = linesOf(axis.label);
      const spans = lines.map((line, n) => svg("tspan", { x, y: FRAME.top - 14 * (lines.length - n) }, line));
      const title = svg("text", { "text-anchor": "middle", class: axis.key ? "key" : "quantity" }, svg("title", {}, axis.label), ...spans);
      const ticks = ticksOf(axis).map(([value, text]) => {
        const place = { x: x - 6, y: top(scales[k].part(value)) + 4, "text-anchor": "end", class: "tick" };
        return svg("text", place, text.length > 14 ? `${text.slice(0, 13)}…` : text);
      });
      bars[k] = svg("rect", { x: x - 7, width: 14, class: "range" });
      handles[k] = svg("rect", { x: x - HANDLE / 2, y: FRAME.top - 6, width: HANDLE, height: tall + 12, class: "handle", tabindex: 0,
        role: "slider", "aria-label": axis.label, "aria-orientation": "vertical", "aria-valuemin": 0, "aria-valuemax": 1 });
      listen(k);
      drawRange(k);
      const line = svg("line", { x1: x, x2: x, y1: FRAME.top, y2: FRAME.top + tall, class: "line" });
      return svg("g", {}, line, ...ticks, title, bars[k], handles[k]);
    }));
  };
  const drawRamp = () => {
    const axis = chosenAxis(batch, colour), ramp = $("parallel-ramp"), swatch = document.createElement("i");
    ramp.replaceChildren();
    if (!axis) return;
    if (axis.words.length) {
      axis.words.forEach((word, i) => {
        const patch = swatch.cloneNode();
        patch.style.background = PALETTE[i % PALETTE.length];
        ramp.append(patch, word);
      });
      return;
    }
    const { low, high } = scaleOf(axis);
    swatch.className = "wide";
    swatch.style.background = `linear-gradient(to right, ${VIRIDIS.join(", ")})`;
    ramp.append(digits(low), swatch, digits(high), document.createTextNode(` ${axis.label}`));
  };
  const draw = () => {
    drawAxes();
    drawLines();
  };
  colour.addEventListener("change", () => {
    drawRamp();
    drawLines();
  });
  clear.addEventListener("click", () => {
    ranges.clear();
    bars.forEach((_, k) => drawRange(k));
    drawLines();
    finish();
  });
  let width = plot.clientWidth;
  new ResizeObserver(() => {
    if (plot.clientWidth === width) return;
    width = plot.clientWidth;
    draw();
  }).observe(plot);
  drawRamp();
  draw();
}

/** Lets the heads of the table of all cases sort it: numbers by value, cells without text last. */
function showCases(batch) {
  const heads = [...document.querySelectorAll("#cases-table th")], body = document.querySelector("#cases-table tbody");
  const cell = (text) => {
    const one = document.createElement("td");
    one.textContent = text;
    return one;
  };
  heads.forEach((head, column) => {
    const texts = batch.rows.map((row) => row[column]);
    const numeric = texts.every((text) => text === "" || Number.isFinite(Number(text)));
    head.querySelector("button").addEventListener("click", () => {
      const sign = head.getAttribute("aria-sort") === "ascending" ? -1 : 1;
      for (const one of heads) one.removeAttribute("aria-sort");
      head.setAttribute("aria-sort", sign > 0 ? "ascending" : "descending");
      const compare = (a, b) => (numeric ? Number(a) - Number(b) : a.localeCompare(b, "en", { numeric: true }));
      const later = (i, j) => (texts[i] === "") - (texts[j] === "") || sign * compare(texts[i], texts[j]) || i - j;
      const order = texts.map((_, i) => i).sort(later);
      body.replaceChildren(...order.slice(0, batch.most).map((i) => {
        const row = document.createElement("tr");
        row.append(...batch.rows[i].map(cell));
        return row;
      }));
    });
  });
}

function showBatch(batch) {
  const highlight = $("scatter-plot") ? showScatter(batch) : () => {};
  if ($("parallel-plot")) showParallel(batch, highlight);
  showCases(batch);
}
