//! A growing polytope inside the differences of two shapes that overlap: its face nearest to the origin tends to the least depth.

use crate::nested::IntoNested;
use nalgebra::Vector3;

use super::difference::Difference;
use crate::collision::guard::plane_across;
use crate::scalar::MapEach;

/// Most vertices; the faces of a closed polytope are twice as many.
pub(super) const MAX_VERTICES: usize = 128;
const MAX_FACES: usize = 2 * MAX_VERTICES;

/// A triangle, counter-clockwise from outside.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    pub(super) vertices: [usize; 3],
    /// Outward unit normal.
    pub(super) normal: Vector3<f64>,
    /// Distance of its plane from the origin.
    pub(super) distance: f64,
}

/// A polytope of triangles about the origin.
#[derive(Clone, Debug)]
pub(super) struct Polytope {
    vertices: [Vector3<f64>; MAX_VERTICES],
    n_vertices: usize,
    faces: [Face; MAX_FACES],
    n_faces: usize,
    /// Least height of a point above a face that it sees, m.
    least_height: f64,
}

/// Part of the size of differences by which points of one plane differ.
const COPLANAR: f64 = 1e-11;

const NO_FACE: Face = Face {
    vertices: [0; 3],
    normal: Vector3::new(0.0, 0.0, 0.0),
    distance: f64::INFINITY,
};

/// Edges of faces that were removed: those of two cancel.
struct Rim {
    edges: [[usize; 2]; MAX_FACES],
    len: usize,
}

impl Default for Rim {
    fn default() -> Self {
        Self {
            edges: [[0; 2]; MAX_FACES],
            len: 0,
        }
    }
}

impl Rim {
    /// Adds an edge, or removes its twin. One that has no room is left out; a rim never has more edges than there are faces.
    fn add(&mut self, [a, b]: [usize; 2]) {
        match self.edges[..self.len]
            .iter()
            .position(|edge| *edge == [b, a])
        {
            Some(twin) => {
                self.len -= 1;
                self.edges[twin] = self.edges[self.len];
            }
            None if self.len < MAX_FACES => {
                self.edges[self.len] = [a, b];
                self.len += 1;
            }
            None => {}
        }
    }
}

impl Polytope {
    /// The tetrahedron of four points.
    ///
    /// * `size` – of the differences, m
    pub(super) fn new(points: &[Vector3<f64>; 4], size: f64) -> Self {
        let mut own = Self {
            vertices: [Vector3::zeros(); MAX_VERTICES],
            n_vertices: 4,
            faces: [NO_FACE; MAX_FACES],
            n_faces: 0,
            least_height: COPLANAR * size,
        };
        own.vertices[..4].copy_from_slice(points);
        let [a, b, c, d] = points;
        let positive = (b - a).cross(&(c - a)).dot(&(d - a)) > 0.0;
        for [i, j, k] in [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]] {
            own.add_face(if positive { [i, j, k] } else { [i, k, j] });
        }
        own
    }

    pub(super) fn faces(&self) -> &[Face] {
        &self.faces[..self.n_faces]
    }

    /// The faces, the nearest to the origin first.
    pub(super) fn sorted(&mut self) -> &[Face] {
        self.faces[..self.n_faces].sort_unstable_by(|a, b| a.distance.total_cmp(&b.distance));
        self.faces()
    }

    /// Index of the face nearest to the origin.
    pub(super) fn nearest(&self) -> usize {
        let mut best = 0;
        for (k, face) in self.faces().iter().enumerate() {
            if face.distance < self.faces[best].distance {
                best = k;
            }
        }
        best
    }

    /// Whether there is room for another vertex.
    pub(super) fn has_room(&self) -> bool {
        self.n_vertices < MAX_VERTICES && self.n_faces + 2 * MAX_VERTICES / 8 < MAX_FACES
    }

    /// Adds a vertex outside of a face: faces that it sees give way to those between it and their rim. `false` where these do not fit, or where it sees faces
    /// without a rim, which only rounding makes.
    pub(super) fn add_vertex(&mut self, point: Vector3<f64>, seen_face: usize) -> bool {
        let new = self.n_vertices;
        self.vertices[new] = point;
        self.n_vertices += 1;
        let mut rim = Rim::default();
        self.remove_face(seen_face, &mut rim);
        let mut k = 0;
        while k < self.n_faces {
            let face = &self.faces[k];
            if face.normal.dot(&point) - face.distance > self.least_height {
                self.remove_face(k, &mut rim);
            } else {
                k += 1;
            }
        }
        let fits = self.n_faces + rim.len <= MAX_FACES;
        if fits {
            let edges = rim.edges[..rim.len].iter();
            edges.for_each(|&[a, b]| self.add_face([a, b, new]));
        }
        fits && rim.len > 0
    }

    /// Removes a face; the last takes its place.
    fn remove_face(&mut self, index: usize, rim: &mut Rim) {
        let [a, b, c] = self.faces[index].vertices;
        for edge in [[a, b], [b, c], [c, a]] {
            rim.add(edge);
        }
        self.n_faces -= 1;
        self.faces[index] = self.faces[self.n_faces];
    }

    /// Adds a face; one without an area has no normal, and is never the nearest.
    fn add_face(&mut self, vertices: [usize; 3]) {
        let [a, b, c] = vertices.map_each(|k| self.vertices[k]);
        let normal = (b - a).cross(&(c - a)).try_normalize(f64::MIN_POSITIVE);
        let face = match normal {
            Some(normal) => Face {
                vertices,
                normal,
                distance: normal.dot(&a),
            },
            None => Face {
                vertices,
                ..NO_FACE
            },
        };
        self.faces[self.n_faces] = face;
        self.n_faces += 1;
    }
}

/// The beginning of a polytope: a tetrahedron, or where all differences lie in a plane (or on a line, or are one) a unit normal of it.
pub(super) enum Start {
    Tetrahedron([Vector3<f64>; 4]),
    Flat(Vector3<f64>),
}

/// Part of the size of differences below which they count as flat.
const FLAT: f64 = 1e-12;

/// Completes points of differences to a tetrahedron.
pub(super) fn tetrahedron(difference: &Difference<'_>, points: &[Vector3<f64>]) -> Start {
    let least = FLAT * difference.size;
    let p = points[0];
    // The point that lies farthest by some measure, of those given and of those farthest along some directions either way.
    let farthest = |directions: &[Vector3<f64>], measure: &dyn Fn(&Vector3<f64>) -> f64| {
        let ends = directions.iter().nested(|&d| [d, -d]);
        let found = points
            .iter()
            .copied()
            .chain(ends.map(|d| difference.support(&d)));
        let measured = found.map(|x| (measure(&x).abs(), x));
        measured.fold((0.0, p), |a, b| if b.0 > a.0 { b } else { a })
    };
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    let (length, q) = farthest(&axes, &|x| (x - p).norm());
    if length <= least {
        return Start::Flat(Vector3::z());
    }
    let u = (q - p) / length;
    let sides = plane_across(&u);
    let (width, r) = farthest(&sides, &|x| (x - p).cross(&u).norm());
    if width <= least {
        return Start::Flat(sides[0]);
    }
    let normal = u.cross(&(r - p)).normalize();
    let (height, s) = farthest(&[normal], &|x| (x - p).dot(&normal));
    if height <= least {
        return Start::Flat(normal);
    }
    Start::Tetrahedron([p, q, r, s])
}
