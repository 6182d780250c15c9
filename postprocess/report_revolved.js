// SPDX-License-Identifier: GPL-3.0-or-later
const SEGMENTS = 48; // around the axis
const OPENED = Math.PI / 2; // angle that is cut out of an opened body
const ARROW_PLANES = 8; // half planes in which a body in space has arrows

const range = (count) => Array.from({ length: count }, (_, i) => i);

/** A vector (across the axis, along it) at an angle about the axis, with the components of a plane or of space. */
function turned(turn, dim, across, along) {
  return dim === 2 ? [Math.cos(turn) * across, along] : [Math.cos(turn) * across, Math.sin(turn) * across, along];
}

/** Copies of some nodes of a half section at angles about the axis, one angle after the other; `number` returns that of a node's copy. */
function copiesOf(nodes, turns, first = 0) {
  const own = new Map(Array.from(nodes, (node, i) => [node, i]));
  const number = (node, turn) => first + turn * nodes.length + own.get(node);
  return { nodes, turns, number, end: first + nodes.length * turns.length };
}

/** Both columns of a table of pairs. */
function ends(pairs) {
  const all = numbers(pairs);
  return [0, 1].map((side) => all.filter((_, i) => i % 2 === side));
}

/** Tables of equal columns one below the other, as numbers() returns them: one column after the other. */
function stacked(Kind, ...tables) {
  return Kind.from(range(tables[0].length).flatMap((column) => tables.flatMap((table) => Array.from(table[column]))));
}

/** Columns of the triangles that edges, with the body to their left, sweep from each angle to the next one. */
function swept([starts, stops], copies, closed) {
  const faces = [[], [], []], count = copies.turns.length;
  for (let turn = 0; turn < (closed ? count : count - 1); turn++) {
    const next = (turn + 1) % count;
    starts.forEach((start, i) => {
      const a = copies.number(start, turn), b = copies.number(stops[i], turn);
      const c = copies.number(stops[i], next), d = copies.number(start, next);
      for (const face of [[a, c, b], [a, d, c]]) face.forEach((node, corner) => faces[corner].push(node));
    });
  }
  return faces;
}

/** Columns of the triangles of the half section at one angle, counterclockwise or, `back`, clockwise. */
function sectionAt(motion, copies, turn, back) {
  const [x, y] = columns(motion.points, 2), faces = columns(motion.faces, 3), found = [[], [], []];
  faces[0].forEach((a, i) => {
    const b = faces[1][i], c = faces[2][i];
    const left = (x[b] - x[a]) * (y[c] - y[a]) > (y[b] - y[a]) * (x[c] - x[a]);
    (left === back ? [a, c, b] : [a, b, c]).forEach((node, corner) => found[corner].push(copies.number(node, turn)));
  });
  return found;
}

/** The nodes in contact in all copies. */
function touchingCopies(touching, copies, frames) {
  const nodes = numbers(touching.nodes), on = numbers(touching.on), turns = range(copies.turns.length);
  const rows = range(frames).map((frame) => Array.from(on.subarray(frame * nodes.length, (frame + 1) * nodes.length)));
  return { ...touching, nodes: Int32Array.from(turns.flatMap((turn) => Array.from(nodes, (node) => copies.number(node, turn)))),
    on: Uint8Array.from(rows.flatMap((row) => turns.flatMap(() => row))) };
}

/** A field of a part of the boundary: its arrows, in space in some half planes; edges of their own colour only in the plane. */
function fieldCopies(field, copies, dim, frames) {
  if (!field.edges) return field;
  const at = numbers(field.at), values = numbers(field.arrows.values), count = at.length;
  const every = dim === 2 ? 1 : Math.ceil(copies.turns.length / ARROW_PLANES);
  const shown = range(copies.turns.length).filter((turn) => turn % every === 0), arrows = [];
  for (let frame = 0; frame < frames; frame++) {
    const [across, along] = [0, 1].map((axis) => values.subarray((2 * frame + axis) * count, (2 * frame + axis + 1) * count));
    for (let axis = 0; axis < dim; axis++) {
      for (const turn of shown) across.forEach((part, i) => arrows.push(turned(copies.turns[turn], dim, part, along[i])[axis]));
    }
  }
  const copied = (nodes) => Int32Array.from(shown.flatMap((turn) => Array.from(nodes, (node) => copies.number(node, turn))));
  return { ...field, edges: copied(dim === 2 ? numbers(field.edges) : []), at: copied(at),
    arrows: { values: Float32Array.from(arrows), scale: field.arrows.scale } };
}

/** The half section of an obstacle with its mirror image or, in space, the surface that its curve sweeps. */
function obstacleCopies(obstacle, dim) {
  const shapes = obstacle.shapes.map((shape) => {
    const [across, along] = columns(shape.points, 2), nodes = range(across.length), corners = columns(shape.faces, 3);
    const copies = copiesOf(nodes, dim === 2 ? [0, Math.PI] : range(SEGMENTS).map((i) => (2 * Math.PI * i) / SEGMENTS));
    const points = copies.turns.flatMap((turn) => nodes.map((node) => turned(turn, dim, across[node], along[node])));
    const halves = [0, 1].map((turn) => corners.map((corner) => corner.map((node) => copies.number(node, turn))));
    return { points: stacked(Float32Array, range(dim).map((axis) => points.map((point) => point[axis]))),
      faces: stacked(Int32Array, ...(dim === 2 ? halves : [swept(ends(shape.curve), copies, true)])) };
  });
  if (!obstacle.offset) return { ...obstacle, shapes };
  const up = columns(obstacle.offset, 2)[1], still = new Float32Array(up.length);
  return { ...obstacle, shapes, offset: stacked(Float32Array, [...Array(dim - 1).fill(still), up]) };
}

/** Ticks of an axis that counts the radius to both sides. */
function ticksTo(far) {
  const power = 10 ** Math.floor(Math.log10(far / 2)), step = power * [5, 2, 1].find((digit) => digit * power <= far / 2);
  const count = Math.floor(far / step), tickvals = range(2 * count + 1).map((i) => (i - count) * step);
  return { tickvals, ticktext: tickvals.map((value) => String(Number(Math.abs(value).toPrecision(6)))) };
}

/** The copies in a picture: those that carry the surface and its marks, and those of the sections of an opened body, which have their
 * own points, so that light does not round their edges. */
function copiesIn(motion, mode, rim) {
  const everyone = range(numbers(motion.points).length / 2);
  if (mode === "full") return [copiesOf(everyone, [0, Math.PI]), copiesOf(everyone, [])];
  const closed = mode === "revolved", [x, y] = motion.revolved.eye, way = closed ? 2 * Math.PI : 2 * Math.PI - OPENED;
  const parts = Math.round((SEGMENTS * way) / (2 * Math.PI)), start = closed ? 0 : Math.atan2(y, x) + OPENED / 2;
  const outer = copiesOf([...new Set([...rim[0], ...rim[1]])], range(closed ? parts : parts + 1).map((i) => start + (way * i) / parts));
  return [outer, copiesOf(everyone, closed ? [] : [start, start + way], outer.end)];
}

/** The motion of a body of revolution as bodyOf() draws it: of its half section, its full one, or its surface, whole or cut open. */
function revolved(motion, mode) {
  if (mode === "half") return motion;
  const dim = mode === "full" ? 2 : 3, rim = ends(motion.revolved.rim), copies = copiesIn(motion, mode, rim), [outer, inner] = copies;
  const sections = dim === 2 ? outer : inner;
  const faces = range(sections.turns.length).map((turn) => sectionAt(motion, sections, turn, turn === 1));
  if (dim === 3) faces.push(swept(rim, outer, mode === "revolved"));
  const edges = range(sections.turns.length).flatMap((turn) =>
    range(rim[0].length).flatMap((i) => rim.map((side) => sections.number(side[i], turn))));

  const frames = framesOf(motion), of = copies.flatMap(({ nodes, turns }) => turns.flatMap(() => nodes));
  const turns = copies.flatMap((own) => own.turns.flatMap((turn) => own.nodes.map(() => turn)));
  const [cosine, sine] = [Math.cos, Math.sin].map((part) => Float64Array.from(turns, part));
  const position = (frame) => {
    const [across, along] = frames.position(frame), up = Float32Array.from(of, (node) => along[node]);
    const [x, y] = [cosine, sine].map((part) => Float32Array.from(of, (node, i) => part[i] * across[node]));
    return dim === 2 ? [x, up, new Float32Array(of.length)] : [x, y, up];
  };
  const colours = (field, frame) => {
    const values = frames.colours(field, frame);
    return Float32Array.from(of, (node) => values[node]);
  };

  const [low, high] = motion.box, far = Math.max(-low[0], high[0]), sides = Array(dim - 1).fill(far);
  return { ...motion, dim, box: [[...sides.map((side) => -side), low[1]], [...sides, high[1]]], eye: motion.revolved.eye,
    axes: dim === 2 ? motion.axes : ["", "", motion.axes[1]], ticks: dim === 2 ? ticksTo(far) : {},
    frames: { ...frames, position, colours }, faces: stacked(Int32Array, ...faces), edges: Int32Array.from(edges),
    touching: motion.touching && touchingCopies(motion.touching, outer, frames.length),
    fields: motion.fields.map((field) => fieldCopies(field, outer, dim, frames.length)),
    obstacles: motion.obstacles.map((obstacle) => obstacleCopies(obstacle, dim)) };
}
