//! Derivatives of a function of the table at a point, by dual numbers: along directions, and of weighted sums.

use dualbody::Model;
use dualbody::scalar::CHUNK;

use crate::{Dual, Memory, Own, Prepared, Robot, is_configuration};

/// Numbers in which a function has derivatives: rows of arguments, then parameters of the model if they are given.
pub struct Point<'a> {
    /// The robot that the function belongs to.
    pub robot: Robot<'a, f64>,
    /// Names of the arguments.
    pub names: &'a [&'static str],
    /// Their rows.
    pub x: &'a [&'a [f64]],
    /// Parameters of the model.
    pub parameters: Option<&'a [f64]>,
}

/// The robot on dual numbers, with memory: what a thread keeps.
pub struct Lifted {
    own: Own<Dual>,
    memory: Memory<Dual>,
}

/// Directions of each input, row by row, `None` where it does not change.
pub type Directions<'a> = [Option<&'a [f64]>];

impl Lifted {
    /// The robot with its own parameters, or with others.
    pub fn new(robot: Robot<'_, f64>, parameters: Option<&[Dual]>) -> Self {
        let own = robot.over(parameters);
        let memory = Memory::new(own.robot().model());
        Self { own, memory }
    }

    fn call(&mut self, f: &Prepared<Dual>, x: &[Vec<Dual>], y: &mut [Dual]) {
        let rows: Vec<&[Dual]> = x.iter().map(Vec::as_slice).collect();
        f(self.own.robot(), &mut self.memory, &rows, y);
    }
}

/// Numbers with derivatives.
fn seeded(x: &[f64], slope: impl Fn(usize, usize) -> f64) -> Vec<Dual> {
    let one = |(j, &x): (usize, &f64)| Dual::new(x, std::array::from_fn(|lane| slope(j, lane)));
    x.iter().enumerate().map(one).collect()
}

/// Matrices between changes of coordinates and tangent vectors, row by row; `None` where these are the same.
struct Tangent {
    /// `nq` × `nv`.
    integrate: Vec<f64>,
    /// `nv` × `nq`.
    difference: Vec<f64>,
    nq: usize,
    nv: usize,
}

impl Tangent {
    fn of(model: &Model, q: &[f64]) -> Option<Self> {
        let (nq, nv) = (model.nq(), model.nv());
        let rows = |m: nalgebra::DMatrix<f64>| m.transpose().as_slice().to_vec();
        (nq != nv).then(|| Self {
            integrate: rows(model.integrate_jacobian(q)),
            difference: rows(model.difference_jacobian(q)),
            nq,
            nv,
        })
    }

    /// The part of a change of coordinates that a motion makes.
    fn projected(&self, dq: &[f64]) -> Vec<f64> {
        let tangent: Vec<f64> = (0..self.nv)
            .map(|i| dot(&self.difference[i * self.nq..][..self.nq], dq))
            .collect();
        (0..self.nq)
            .map(|i| dot(&self.integrate[i * self.nv..][..self.nv], &tangent))
            .collect()
    }

    /// Derivatives in coordinates from those in the tangent.
    fn to_coordinates(&self, slopes: &[f64], out: &mut [f64]) {
        for (j, out) in out.iter_mut().enumerate() {
            *out = (0..self.nv)
                .map(|i| slopes[i] * self.difference[i * self.nq + j])
                .sum();
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl Point<'_> {
    /// Number of inputs, parameters included.
    fn count(&self) -> usize {
        self.x.len() + usize::from(self.parameters.is_some())
    }

    /// The entries of an input.
    fn input(&self, i: usize) -> &[f64] {
        self.x.get(i).copied().or(self.parameters).unwrap_or(&[])
    }

    fn tangent(&self, i: usize) -> Option<Tangent> {
        let is_one = self.names.get(i).is_some_and(|name| is_configuration(name));
        is_one
            .then(|| Tangent::of(self.robot.model(), self.x[i]))
            .flatten()
    }

    /// The function where inputs have derivatives: slope(input, number, lane).
    fn evaluate(
        &self,
        f: &Prepared<Dual>,
        kept: &mut Lifted,
        slope: &dyn Fn(usize, usize, usize) -> f64,
        y: &mut [Dual],
    ) {
        let with = |i: usize| seeded(self.input(i), |j, lane| slope(i, j, lane));
        let rows: Vec<Vec<Dual>> = (0..self.x.len()).map(with).collect();
        match self.parameters {
            None => kept.call(f, &rows, y),
            Some(_) => Lifted::new(self.robot, Some(&with(self.x.len()))).call(f, &rows, y),
        }
    }

    /// Derivatives along directions, one after the other: each a row of the result.
    ///
    /// * `directions` – of each input, as many rows as there are directions
    pub fn push(
        &self,
        f: &Prepared<Dual>,
        kept: &mut Lifted,
        directions: &Directions<'_>,
        out: &mut [f64],
        width: usize,
    ) {
        let of = |i: usize| -> Option<Vec<f64>> {
            let all = (*directions.get(i)?)?;
            let rows = all.chunks(self.input(i).len().max(1));
            Some(match self.tangent(i) {
                Some(tangent) => rows.flat_map(|row| tangent.projected(row)).collect(),
                None => all.to_vec(),
            })
        };
        let moved: Vec<Option<Vec<f64>>> = (0..self.count()).map(of).collect();
        let mut y = vec![Dual::from(0.0); width];
        for (k, out) in out.chunks_mut((CHUNK * width).max(1)).enumerate() {
            let slope = |i: usize, j: usize, lane: usize| {
                let at = (k * CHUNK + lane) * self.input(i).len() + j;
                moved[i]
                    .as_ref()
                    .and_then(|all| all.get(at))
                    .map_or(0.0, |&x| x)
            };
            self.evaluate(f, kept, &slope, &mut y);
            for (lane, out) in out.chunks_mut(width).enumerate() {
                out.iter_mut()
                    .zip(&y)
                    .for_each(|(out, y)| *out = y.eps[lane]);
            }
        }
    }

    /// Derivatives of weighted sums of the results in an input: a row for each row of weights.
    pub fn pull(
        &self,
        f: &Prepared<Dual>,
        kept: &mut Lifted,
        i: usize,
        weights: &[f64],
        out: &mut [f64],
        width: usize,
    ) {
        let (tangent, own) = (self.tangent(i), self.input(i).len());
        let n = tangent.as_ref().map_or(own, |tangent| tangent.nv);
        let count = weights.len() / width.max(1);
        let (mut y, mut slopes) = (vec![Dual::from(0.0); width], vec![0.0; count * n]);
        for first in (0..n).step_by(CHUNK) {
            let slope = |input: usize, j: usize, lane: usize| match &tangent {
                _ if input != i || first + lane >= n => 0.0,
                Some(tangent) => tangent.integrate[j * n + first + lane],
                None => f64::from(u8::from(j == first + lane)),
            };
            self.evaluate(f, kept, &slope, &mut y);
            for (weights, slopes) in weights.chunks(width.max(1)).zip(slopes.chunks_mut(n)) {
                for (lane, slope) in slopes[first..].iter_mut().take(CHUNK).enumerate() {
                    *slope = weights.iter().zip(&y).map(|(w, y)| w * y.eps[lane]).sum();
                }
            }
        }
        self.write(tangent.as_ref(), &slopes, out);
    }

    /// Writes derivatives in an input, tangent ones in coordinates.
    fn write(&self, tangent: Option<&Tangent>, slopes: &[f64], out: &mut [f64]) {
        match tangent {
            None => out.copy_from_slice(slopes),
            Some(tangent) => {
                let rows = slopes
                    .chunks(tangent.nv.max(1))
                    .zip(out.chunks_mut(tangent.nq));
                rows.for_each(|(slopes, out)| tangent.to_coordinates(slopes, out));
            }
        }
    }

    /// Writes derivatives in the tangent of an input, row by row.
    pub fn write_slopes(&self, i: usize, slopes: &[f64], out: &mut [f64]) {
        self.write(self.tangent(i).as_ref(), slopes, out);
    }
}
