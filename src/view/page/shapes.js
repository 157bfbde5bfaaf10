// Triangles of the shapes, of unit size: a matrix and a scale along the axes make the others of them.

/** Corners on a ring about z. */
const ring = (n, radius, z) => Array.from({ length: n + 1 }, (_, k) => {
  const angle = (2 * Math.PI * k) / n;
  return [radius * Math.cos(angle), radius * Math.sin(angle), z];
});

/** A surface between rows of vertices { position, normal }. */
function surface(rows) {
  const positions = [], normals = [], indices = [], width = rows[0].length;
  for (const { position, normal } of rows.flat()) {
    positions.push(...position);
    normals.push(...normal);
  }
  for (let i = 0; i + 1 < rows.length; i++)
    for (let j = 0; j + 1 < width; j++) {
      const a = i * width + j, b = a + width;
      indices.push(a, a + 1, b, b, a + 1, b + 1);
    }
  return { positions, normals, indices };
}

function joined(...parts) {
  const out = { positions: [], normals: [], indices: [] };
  for (const part of parts) {
    const first = out.positions.length / 3;
    for (const x of part.positions) out.positions.push(x);
    for (const x of part.normals) out.normals.push(x);
    for (const i of part.indices) out.indices.push(first + i);
  }
  return out;
}

/** Edges of length 1. */
function boxShape() {
  const faces = [];
  for (let axis = 0; axis < 3; axis++)
    for (const side of [-1, 1]) {
      const normal = [0, 0, 0];
      normal[axis] = side;
      const vertex = (u, v) => {
        const position = [0, 0, 0];
        position[axis] = side / 2;
        position[(axis + 1) % 3] = u / 2;
        position[(axis + 2) % 3] = v / 2;
        return { position, normal };
      };
      faces.push(surface([[vertex(-1, -1), vertex(-1, 1)], [vertex(1, -1), vertex(1, 1)]]));
    }
  return joined(...faces);
}

/** Radius 1. */
function sphereShape(rows = 20, columns = 36) {
  const at = (i) => (Math.PI * i) / rows;
  const row = (i) => ring(columns, Math.sin(at(i)), Math.cos(at(i)));
  return surface(Array.from({ length: rows + 1 }, (_, i) => row(i).map((p) => ({ position: p, normal: p }))));
}

/** Surface of revolution between two radii at two heights, with its ends closed. */
function coneShape(lower, upper, from, to, n = 40) {
  const slope = (lower - upper) / (to - from);
  const around = (radius, z) => ring(n, radius, z).map((position, k) => {
    const angle = (2 * Math.PI * k) / n;
    return { position, normal: unit([Math.cos(angle), Math.sin(angle), slope]) };
  });
  const end = (radius, z, normal) => surface([0, radius].map((r) => ring(n, r, z).map((position) => ({ position, normal }))));
  return joined(surface([around(lower, from), around(upper, to)]), end(lower, from, [0, 0, -1]), end(upper, to, [0, 0, 1]));
}

/** Radius 1, length 1 along z. */
const cylinderShape = () => coneShape(1, 1, -0.5, 0.5);

/** The tip of an arrow: radius 1 at z = 0, a point at z = 1. */
const tipShape = () => coneShape(1, 0, 0, 1, 24);

/** A mesh file's triangles, with edges smoothed where neighbours differ by less than this. */
const CREASE = Math.cos((35 * Math.PI) / 180);

/** Every corner of a triangle gets the mean normal of the triangles around it that lie almost in its plane. */
function meshShape(mesh) {
  const vertices = decode(mesh.positions), corners = decode(mesh.triangles);
  const count = corners.length / 3, faceNormals = [], around = new Map();
  const vertex = (i) => [vertices[3 * i], vertices[3 * i + 1], vertices[3 * i + 2]];
  // Normals in the mesh's own proportions: positions are scaled to its box.
  const size = subtract(mesh.bounds[1], mesh.bounds[0]).map((x) => x || 1e-9);
  const real = (i) => vertex(i).map((x, axis) => x * size[axis]);
  for (let t = 0; t < count; t++) {
    const [a, b, c] = [0, 1, 2].map((k) => real(corners[3 * t + k]));
    faceNormals.push(cross(subtract(b, a), subtract(c, a)));
    for (let k = 0; k < 3; k++) {
      const i = corners[3 * t + k];
      if (!around.has(i)) around.set(i, []);
      around.get(i).push(t);
    }
  }
  const units = faceNormals.map(unit);
  const positions = new Float32Array(corners.length * 3), normals = new Float32Array(corners.length * 3);
  corners.forEach((i, k) => {
    const own = units[Math.floor(k / 3)];
    let sum = [0, 0, 0];
    for (const t of around.get(i)) if (dot(units[t], own) > CREASE) sum = add(sum, faceNormals[t]);
    // The shader divides normals by the scale, which is that of the box.
    const normal = unit(norm(sum) > 0 ? sum : own).map((x, axis) => x * size[axis]);
    positions.set(vertex(i), 3 * k);
    normals.set(normal, 3 * k);
  });
  return { positions, normals, indices: Uint32Array.from(corners, (_, k) => k) };
}
