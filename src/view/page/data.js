// The data of the page, as Rust wrote it; see html.rs, scene.rs and motion.rs.

/** Decodes a blob: the bytes of a typed array, little-endian, in base64. */
function decode(blob) {
  const text = atob(blob.data);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  switch (blob.type) {
    case "f64": return new Float64Array(bytes.buffer);
    case "f32": return new Float32Array(bytes.buffer);
    case "u32": return new Uint32Array(bytes.buffer);
    case "unit": return Float32Array.from(new Int16Array(bytes.buffer), (x) => x / 32767);
    default: throw new Error(`unknown type of numbers: ${blob.type}`);
  }
}

const data = JSON.parse(document.getElementById("data").textContent);

/** A copy of a plot with its numbers decoded. */
const decodePlot = (plot) => ({
  ...plot,
  lines: plot.lines.map((line) => ({ name: line.name, values: decode(line.values) })),
});

/** Points of contact: six numbers each, position and force; those of moment k are from starts[k] to starts[k + 1]. */
function decodeContacts({ counts, values }) {
  const starts = [0];
  for (const count of decode(counts)) starts.push(starts[starts.length - 1] + count);
  return { starts, values: decode(values) };
}

/** What moves, or null for a robot without a motion. */
const motion = data.motion && {
  recorded: data.motion.recorded,
  times: decode(data.motion.times),
  series: data.motion.series.map(decodePlot),
  robots: data.motion.robots.map((robot) => ({
    positions: decode(robot.positions),
    rotations: decode(robot.rotations),
    plots: robot.plots.map(decodePlot),
    contacts: robot.contacts && decodeContacts(robot.contacts),
    forces: robot.forces.map((force) => ({ frame: force.frame, values: decode(force.values) })),
  })),
};

/** An element with properties and children; text only ever goes through textContent. */
function element(tag, properties = {}, ...children) {
  const node = Object.assign(document.createElement(tag), properties);
  node.append(...children);
  return node;
}

const byId = (id) => document.getElementById(id);
