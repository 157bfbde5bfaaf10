//! Rotations and poses for `dualbody.spatial`: functions of few numbers.

use dualbody::spatial::{Motion, Quaternion, Transform};
use nalgebra::{Matrix3, Matrix6, Vector3};

use crate::prelude::*;

/// A question about rotations, by its name: numbers in, numbers out. Quaternions are (w, x, y, z), matrices row by row.
#[pyfunction]
pub(crate) fn _rotation(question: &str, x: Vec<f64>) -> PyResult<Vec<f64>> {
    let quaternion = |at: usize| Quaternion::from_slice(&x[at..at + 4]);
    Ok(match (question, x.len()) {
        ("from_matrix", 9) => numbers(&Quaternion::from_matrix(&Matrix3::from_row_slice(&x))),
        ("to_matrix", 4) => quaternion(0).to_matrix().transpose().as_slice().to_vec(),
        ("times", 8) => numbers(&(quaternion(0) * quaternion(4))),
        ("exp", 3) => numbers(&Quaternion::exp(&Vector3::from_column_slice(&x))),
        ("log", 4) => quaternion(0).log().as_slice().to_vec(),
        ("from_roll_pitch_yaw", 3) => numbers(&Quaternion::from_roll_pitch_yaw([x[0], x[1], x[2]])),
        ("to_roll_pitch_yaw", 4) => quaternion(0).to_roll_pitch_yaw().to_vec(),
        _ => return Err(unknown(question, x.len())),
    })
}

/// A question about a pose, by its name: quaternion and translation in, numbers out.
#[pyfunction]
pub(crate) fn _pose(question: &str, x: Vec<f64>) -> PyResult<Vec<f64>> {
    if question == "exp" && x.len() == 6 {
        let motion = Motion::from_array(std::array::from_fn(|k| x[k]));
        return Ok(pose_numbers(&Transform::exp(&motion)));
    }
    if x.len() != 7 {
        return Err(unknown(question, x.len()));
    }
    let rotation = Quaternion::from_slice(&x[..4]).to_matrix();
    let pose = Transform::new(rotation, Vector3::new(x[4], x[5], x[6]));
    Ok(match question {
        "adjoint" => rows(&pose.adjoint()),
        "adjoint_inverse" => rows(&pose.inverse().adjoint()),
        "force_adjoint" => rows(&pose.force_adjoint()),
        "force_adjoint_inverse" => rows(&pose.inverse().force_adjoint()),
        "log" => pose.log().to_array().to_vec(),
        _ => return Err(unknown(question, x.len())),
    })
}

fn numbers(q: &Quaternion<f64>) -> Vec<f64> {
    vec![q.w, q.xyz.x, q.xyz.y, q.xyz.z]
}

fn pose_numbers(pose: &Transform<f64>) -> Vec<f64> {
    let mut out = numbers(&Quaternion::from_matrix(&pose.rotation));
    out.extend(pose.translation.iter());
    out
}

fn rows(matrix: &Matrix6<f64>) -> Vec<f64> {
    matrix.transpose().as_slice().to_vec()
}

fn unknown(question: &str, n: usize) -> PyErr {
    invalid!("\"{question}\" of {n} numbers")
}
