//! Our side of the comparison of distances with `MuJoCo`: answers pairs of shapes, one a line; `nearest.py` asks.
//!
//! A line has two shapes, each as `KIND COUNT NUMBERS... x y z` and the rotation by rows; the answer is the distance, both points and the normal.

use std::io::BufRead;
use std::sync::Arc;

use dualbody::collision::{Hull, Shape, nearest_features, witness};
use dualbody::spatial::Transform;
use nalgebra::{Matrix3, Vector3};

fn main() {
    if std::env::args().any(|argument| argument == "--test") {
        let answer =
            answer("sphere 1 0.5 0 0 0 1 0 0 0 1 0 0 0 1 sphere 1 0.5 2 0 0 1 0 0 0 1 0 0 0 1");
        assert_eq!(answer, "1 0.5 0 0 1.5 0 0 1 0 0");
        return;
    }
    for line in std::io::stdin().lock().lines() {
        println!("{}", answer(&line.expect("a line of text")));
    }
}

fn answer(line: &str) -> String {
    let mut words = line.split_whitespace();
    let [(a, x), (b, y)] = [(); 2].map(|()| read(&mut words));
    let Some(found) = nearest_features(&a, &x, &b, &y) else {
        return "none".to_owned();
    };
    let found = witness(&found, &a, &x, &b, &y);
    let [p, q] = found.points;
    let vectors = [p, q, found.normal];
    let numbers = vectors.iter().flat_map(|v| v.iter());
    let all = std::iter::once(&found.distance).chain(numbers);
    all.map(f64::to_string).collect::<Vec<_>>().join(" ")
}

fn read<'a>(words: &mut impl Iterator<Item = &'a str>) -> (Shape, Transform<f64>) {
    let kind = words.next().expect("a kind of shape");
    let mut number = || -> f64 {
        let word = words.next().expect("another number");
        word.parse().expect("a number")
    };
    let count = number() as usize;
    let sizes: Vec<f64> = (0..count).map(|_| number()).collect();
    let translation = Vector3::from_fn(|_, _| number());
    let rotation = Matrix3::from_row_iterator((0..9).map(|_| number()));
    (shape(kind, &sizes), Transform::new(rotation, translation))
}

fn shape(kind: &str, sizes: &[f64]) -> Shape {
    match (kind, sizes) {
        ("sphere", &[radius]) => Shape::Sphere { radius },
        ("capsule", &[radius, half_length]) => Shape::Capsule {
            radius,
            half_length,
        },
        ("box", &[x, y, z]) => Shape::Box {
            half_extents: [x, y, z],
        },
        ("cylinder", &[radius, half_length]) => Shape::Cylinder {
            radius,
            half_length,
        },
        ("ellipsoid", &[x, y, z]) => Shape::Ellipsoid {
            semi_axes: [x, y, z],
        },
        ("half-space", []) => Shape::HalfSpace,
        ("hull", all) => {
            let points = all.chunks(3).map(Vector3::from_column_slice);
            let hull = Hull::new(points.collect()).expect("finite points");
            Shape::Hull {
                hull: Arc::new(hull),
                scale: [1.0; 3],
            }
        }
        _ => panic!("no shape is a {kind:?} of {} numbers", sizes.len()),
    }
}
