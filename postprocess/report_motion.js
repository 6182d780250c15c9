// SPDX-License-Identifier: GPL-3.0-or-later
const MILLISECONDS = 80; // of a frame
const MARGIN = { l: 0, r: 0, t: 60, b: 0 }; // with room for the colours above the body
const FLAT = { lighting: { ambient: 1, diffuse: 0, specular: 0, fresnel: 0 } };
const ROUND = { lighting: { ambient: 0.75, diffuse: 0.5, specular: 0.05 } };
const SEE_THROUGH = 0.35;
const COLOURS = { "-1": "RdBu", 1: "Viridis" }; // of fields that have a sign, and that have none

/** Components of a unit vector along v. */
const unit = (v) => v.map((part) => part / Math.hypot(...v));

/** How wide and how high a box is as it is seen from the eye, z being up. */
function seenSize(size, eye) {
  const [x, y, z] = unit(eye), right = unit([-y, x, 0]), up = [-z * right[1], z * right[0], x * right[1] - y * right[0]];
  return [right, up].map((axis) => size.reduce((sum, side, i) => sum + side * Math.abs(axis[i]), 0));
}

/** The camera and the size of the scene; both follow the size of the window. */
function sceneOf(motion, plot) {
  const plane = motion.dim === 2;
  const [low, high] = motion.box;
  const size = high.map((end, axis) => end - low[axis]);
  const [beside, below] = plane ? [112, 84] : [40, 40]; // pixels for the axes
  const [across, upwards] = plane ? size : seenSize(size, motion.eye);
  const tall = MARGIN.t + below + ((plot.clientWidth - beside) * upwards) / across;
  plot.style.height = `${Math.round(Math.max(300, Math.min(0.7 * innerHeight, tall)))}px`;

  // In an orthographic scene half of the plot's height is one unit of the aspect ratio.
  const half = () => (plot.clientHeight - MARGIN.t) / 2;
  const ratio = (zoom) => {
    const pixels = Math.min((plot.clientWidth - beside) / across, (2 * half() - below) / upwards);
    const unit = (zoom * pixels) / half();
    return { x: unit * size[0], y: unit * size[1], z: plane ? 0.01 : unit * size[2] };
  };
  const camera = () => {
    const projection = { type: "orthographic" }, [x, y, z] = motion.eye;
    if (!plane) return { eye: { x, y, z }, center: { x: 0, y: 0, z: 0 }, up: { x: 0, y: 0, z: 1 }, projection };
    const lift = (12 - below / 2) / half(); // labels stand below the body, none above
    return { eye: { x: 0, y: lift, z: 1.5 }, center: { x: 0, y: lift, z: 0 }, up: { x: 0, y: 1, z: 0 }, projection };
  };
  const [first, second, third] = motion.axes || ["x", "y", "z"];
  const axis = (name, i) => ({ title: { text: plane ? `${name} (m)` : name }, range: [low[i], high[i]], showbackground: false,
    gridcolor: "#e8ebee", zeroline: false, showspikes: false, tickfont: { size: 12 }, tickangle: 0,
    nticks: plane ? 6 : Math.max(2, Math.round((6 * size[i]) / Math.max(...size))) });
  const scene = { xaxis: { ...axis(first, 0), ...motion.ticks }, yaxis: axis(second, 1),
    zaxis: plane ? { visible: false, range: [-1, 1] } : axis(third, 2),
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

/** A body's numbers by frame. Points of the cut are carried between two nodes. */
function framesOf(motion) {
  if (motion.frames) return motion.frames;
  const points = numbers(motion.points), moved = numbers(motion.displacement.values), count = points.length / motion.dim;
  const pairs = motion.cut ? numbers(motion.cut.pairs) : [], weight = motion.cut ? numbers(motion.cut.weight) : [];
  const values = motion.fields.map((field) => numbers(field.values));
  const withCut = (nodes) => {
    const all = new Float32Array(count + weight.length);
    all.set(nodes);
    for (let i = 0; i < weight.length; i++) {
      all[count + i] = nodes[pairs[i]] + weight[i] * (nodes[pairs[weight.length + i]] - nodes[pairs[i]]);
    }
    return all;
  };
  const position = (frame) => [0, 1, 2].map((axis) => {
    if (axis >= motion.dim) return new Float32Array(count + weight.length);
    const start = (frame * motion.dim + axis) * count;
    const moving = (_, i) => points[axis * count + i] + motion.displacement.scale * moved[start + i];
    return withCut(Float32Array.from({ length: count }, moving));
  });
  const colours = (field, frame) => {
    const { scale } = motion.fields[field], own = values[field].subarray(frame * count, (frame + 1) * count);
    return withCut(Float32Array.from(own, (value) => scale * value));
  };
  return { position, colours, length: motion.times.length };
}

/** Coordinates of joined pairs of points, one after the other. */
function segments(edges, coordinate) {
  const line = [];
  for (let i = 0; i < edges.length; i += 2) line.push(coordinate[edges[i]], coordinate[edges[i + 1]], null);
  return line;
}

/** Columns of a table that is packed row after row. */
function columns(array, count) {
  const all = numbers(array), length = all.length / count;
  return Array.from({ length: count }, (_, i) => all.subarray(i * length, (i + 1) * length));
}

/** The trace of an obstacle and how it is placed in a frame. */
function obstacleOf(obstacle, dim) {
  const shapes = obstacle.shapes.map(({ points, faces }) => ({ points: columns(points, dim), faces: columns(faces, 3) }));
  const offset = obstacle.offset && columns(obstacle.offset, dim);
  const trace = { type: "mesh3d", name: "", hoverinfo: "text", text: obstacle.name, color: "#b4bcc3", opacity: dim === 2 ? 1 : 0.4,
    ...(dim === 2 ? FLAT : ROUND) };
  const place = (frame) => {
    const { points, faces } = shapes[obstacle.shape[frame]];
    ["x", "y", "z"].forEach((name, axis) => {
      const own = points[axis] || new Float32Array(points[0].length);
      trace[name] = offset && axis < dim ? own.map((value) => value + offset[axis][frame]) : own;
    });
    [trace.i, trace.j, trace.k] = faces;
  };
  return { trace, place };
}

/** Vectors of a field of the boundary as arrows that end at its nodes. */
function arrowsOf(field, dim) {
  const at = numbers(field.at), values = numbers(field.arrows.values), { scale } = field.arrows;
  return (frame, place) => {
    const line = [[], [], []];
    at.forEach((node, i) => {
      const end = place.map((coordinate) => coordinate[node]);
      const way = [0, 1, 2].map((axis) => (axis < dim ? scale * values[(frame * dim + axis) * at.length + i] : 0));
      if (!way.some((part) => part)) return;
      const [x, y, z] = way, aside = x || y ? [-y, x, 0] : [0, z, 0];
      const barb = (side) => end.map((part, axis) => part - 0.3 * way[axis] + 0.12 * side * aside[axis]);
      for (const path of [[end.map((part, axis) => part - way[axis]), end], [barb(1), end, barb(-1)]]) {
        for (const point of path) point.forEach((part, axis) => line[axis].push(part));
        line.forEach((part) => part.push(null));
      }
    });
    return line;
  };
}

/** All traces of a body, and how they are posed: in a frame, with a field's colours, solid, see-through or cut open. */
function bodyOf(motion) {
  const { position, colours } = framesOf(motion), faces = columns(motion.faces, 3), edges = numbers(motion.edges);
  const cut = motion.cut && columns(motion.cut.faces, 3);
  const touching = motion.touching && { ...motion.touching, nodes: numbers(motion.touching.nodes), on: numbers(motion.touching.on) };
  const obstacles = motion.obstacles.map((obstacle) => obstacleOf(obstacle, motion.dim));
  const ribbons = motion.fields.map((field) => field.edges && { edges: numbers(field.edges), arrows: arrowsOf(field, motion.dim) });
  const body = { type: "mesh3d", hovertemplate: "%{intensity:.3g}<extra></extra>", ...(motion.dim === 2 ? FLAT : ROUND),
    colorbar: { orientation: "h", x: 0.5, xanchor: "center", y: 1, yanchor: "bottom", len: 0.9, thickness: 12, outlinewidth: 0,
      title: { side: "top", text: "" } } };
  const lines = (color, width) => ({ type: "scatter3d", mode: "lines", hoverinfo: "skip", line: { color, width } });
  const outline = lines("#1c2126", 2), ribbon = lines("#1c2126", 9), arrows = lines("#0072b2", 3);
  const looks = touching && touching.marks ? touching.marks : [{ name: touching ? "in contact" : "", color: "#d55e00" }];
  const contacts = looks.map(({ name, ...look }) => ({ type: "scatter3d", mode: "markers", hoverinfo: "skip", ...(name && { name }),
    marker: { size: 4, ...look, ...(look.symbol && { size: 6, line: { color: "#1c2126", width: 1 } }) } }));
  const put = (trace, [x, y, z]) => Object.assign(trace, { x, y, z });

  const pose = (frame, field, mode) => {
    const place = position(frame), values = colours(field, frame), marks = ribbons[field];
    const { label, least, largest } = motion.fields[field], signed = least < 0, far = Math.max(-least, largest) || 1;
    const colour = { cmin: signed ? -far : 0, cmax: far, colorscale: COLOURS[signed ? -1 : 1] };
    [body.i, body.j, body.k] = mode === "cut" && cut ? cut : faces;
    Object.assign(put(body, place), colour, { opacity: mode === "see-through" ? SEE_THROUGH : 1 }).colorbar.title.text = label;
    // What acts on a plane body's boundary alone is not smeared into it.
    body.intensity = marks && marks.edges.length ? new Float32Array(values.length) : values;
    put(outline, place.map((coordinate) => segments(edges, coordinate)));
    contacts.forEach((contact, mark) => {
      const on = touching ? touching.nodes.filter((_, i) => touching.on[frame * touching.nodes.length + i] === mark + 1) : [];
      put(contact, place.map((coordinate) => Array.from(on, (node) => coordinate[node])));
      if (contact.marker.line && motion.dim === 2) contact.z = contact.z.map(() => 1); // above the obstacle
    });
    put(ribbon, place.map((coordinate) => (marks ? segments(marks.edges, coordinate) : [])));
    Object.assign(ribbon.line, colour, { color: marks ? segments(marks.edges, values).map((value) => value ?? 0) : [] });
    put(arrows, marks ? marks.arrows(frame, place) : [[], [], []]);
    obstacles.forEach((obstacle) => obstacle.place(frame));
  };
  return { pose, traces: [body, outline, ...contacts, ribbon, arrows, ...obstacles.map(({ trace }) => trace)] };
}

/** Draws one body, or several that the same controls drive. */
function showMotion(motions) {
  const slider = $("frame"), select = $("field"), mode = $("mode"), { times, unit } = motions[0];
  const plots = motions.map((_, i) => $(i ? `body-plot-${i + 1}` : "body-plot")), round = motions[0].revolved;
  let bodies, scenes;
  const pose = () => {
    bodies.forEach((body) => body.pose(Number(slider.value), select.value, mode ? mode.value : "solid"));
    const time = `${times[slider.value].toPrecision(4)} ${unit}`;
    $("now").textContent = `t = ${time}`;
    slider.setAttribute("aria-valuetext", time);
  };
  const show = () => {
    pose();
    plots.forEach((plot) => Plotly.redraw(plot));
  };

  const look = (times) => scenes.forEach((scene) => scene.look(times));
  const begin = () => {
    const drawn = round ? motions.map((motion) => revolved(motion, mode.value)) : motions;
    bodies = drawn.map(bodyOf);
    pose();
    scenes = drawn.map((motion, i) => sceneOf(motion, plots[i]));
    plots.forEach((plot, i) => {
      Plotly.newPlot(plot, bodies[i].traces, { template: STYLE, scene: scenes[i].scene, margin: MARGIN }, CONFIG);
      showLegend(plot, bodies[i].traces);
    });
    look(1);
  };

  slider.value = motions[0].start;
  begin();
  $("nearer").addEventListener("click", () => look(1.5));
  $("farther").addEventListener("click", () => look(1 / 1.5));
  $("whole").addEventListener("click", () => scenes.forEach((scene) => scene.whole()));
  addEventListener("resize", () => look(1));
  slider.addEventListener("input", show);
  for (const choice of [select, mode]) if (choice) choice.addEventListener("change", round && choice === mode ? begin : show);
  playOn(slider, show);
}

/** The button that plays the frames. */
function playOn(slider, show) {
  const play = $("play");
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
