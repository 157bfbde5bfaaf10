//! Users' functions over the scalar with their types erased: the scalars that a program compiles of each are named here.

use std::sync::Arc;

use crate::scalar::traced::{Graph, Port, trace};
use crate::scalar::{Dual, Scalar, is_more_than_values};

/// A function of some numbers to some numbers, over the scalar.
pub(super) trait NumberFunction: Send + Sync + 'static {
    fn evaluate<T: Scalar>(&self, x: &[T], out: &mut [T]);
}

/// A [`NumberFunction`] with its type erased, whose derivatives are taken in `N` directions at once.
pub(super) trait Erased<const N: usize>: Send + Sync {
    fn value(&self, x: &[f64], out: &mut [f64]);

    fn first(&self, x: &[Dual<f64, N>], out: &mut [Dual<f64, N>]);

    fn second(&self, x: &[Dual<Dual<f64, 1>, N>], out: &mut [Dual<Dual<f64, 1>, N>]);

    /// The function for numbers without values.
    fn graph(&self, inputs: usize, outputs: usize) -> Graph;
}

/// Erases the type of a function.
pub(super) fn erase<const N: usize>(function: impl NumberFunction) -> Arc<dyn Erased<N>> {
    Arc::new(function)
}

impl<F: NumberFunction, const N: usize> Erased<N> for F {
    fn value(&self, x: &[f64], out: &mut [f64]) {
        self.evaluate(x, out);
    }

    fn first(&self, x: &[Dual<f64, N>], out: &mut [Dual<f64, N>]) {
        self.evaluate(x, out);
    }

    fn second(&self, x: &[Dual<Dual<f64, 1>, N>], out: &mut [Dual<Dual<f64, 1>, N>]) {
        self.evaluate(x, out);
    }

    fn graph(&self, inputs: usize, outputs: usize) -> Graph {
        trace(|t| {
            let x = t.input(Port::vector("inputs", inputs));
            let mut y = vec![0.0.into(); outputs];
            self.evaluate(&x, &mut y);
            t.output(Port::vector("outputs", outputs), &y);
        })
    }
}

/// Evaluates a function over any scalar.
///
/// Values come from the function, derivatives by the chain rule:  f(x) + Σ ∂f/∂xᵢ ξᵢ + ½ Σ ∂²f/∂xᵢ∂xⱼ ξᵢ ξⱼ  with ξ = x − value of x, lane by lane.
/// Numbers without values go through what the function does with them, with all their derivatives.
///
/// * `x` – at most `INPUTS` numbers
/// * `out` – at most `OUTPUTS` numbers, which are zero
/// * `what` – the function, for a message
///
/// # Panics
/// If derivatives of a higher order are asked for.
pub(super) fn evaluate<T: Scalar, const N: usize, const INPUTS: usize, const OUTPUTS: usize>(
    function: &dyn Erased<N>,
    what: &str,
    x: &[T],
    out: &mut [T],
) {
    if const { !T::HAS_VALUES } {
        let graph = function.graph(x.len(), out.len());
        return out.copy_from_slice(&graph.replay(x));
    }
    assert!(
        T::ORDER <= 2,
        "{what} given as a function has first and second derivatives only"
    );
    for lane in 0..T::LANES {
        let mut values = [0.0; INPUTS];
        let pairs = values.iter_mut().zip(x);
        pairs.for_each(|(out, x)| *out = x.value(lane));
        let at = Lane {
            function,
            lane,
            values: &values[..x.len()],
        };
        match is_more_than_values::<T>() {
            true => at.add_series::<T, INPUTS, OUTPUTS>(x, out),
            false => at.add_values::<T, OUTPUTS>(out),
        }
    }
}

/// A function at the values of one lane.
struct Lane<'a, const N: usize> {
    function: &'a dyn Erased<N>,
    lane: usize,
    values: &'a [f64],
}

impl<const N: usize> Lane<'_, N> {
    fn number<T: Scalar>(&self, value: f64) -> T {
        T::from_values(|lane| if lane == self.lane { value } else { 0.0 })
    }

    fn add_values<T: Scalar, const OUTPUTS: usize>(&self, out: &mut [T]) {
        let mut y = [0.0; OUTPUTS];
        let y = &mut y[..out.len()];
        self.function.value(self.values, y);
        let pairs = out.iter_mut().zip(y);
        pairs.for_each(|(out, y)| *out += self.number(*y));
    }

    /// Adds the value and the terms of first and, where they are asked for, second order.
    fn add_series<T: Scalar, const INPUTS: usize, const OUTPUTS: usize>(
        &self,
        x: &[T],
        out: &mut [T],
    ) {
        let used = self.values.len();
        let change = |k: usize| x[k] - self.number::<T>(self.values[k]);
        for first in (0..used.max(1)).step_by(N) {
            let mut y = [Dual::from(0.0); OUTPUTS];
            let y = &mut y[..out.len()];
            let seeded = self.seeded::<f64, INPUTS>(first, |x, _| x);
            self.function.first(&seeded[..used], y);
            for (out, y) in out.iter_mut().zip(y) {
                if first == 0 {
                    *out += self.number(y.re);
                }
                for (k, &slope) in (first..used).zip(&y.eps) {
                    *out += change(k) * self.number::<T>(slope);
                }
            }
        }
        if T::ORDER == 2 {
            self.add_second::<T, INPUTS, OUTPUTS>(&change, out);
        }
    }

    /// Row by row: the slopes along one direction, each with its derivatives.
    fn add_second<T: Scalar, const INPUTS: usize, const OUTPUTS: usize>(
        &self,
        change: &impl Fn(usize) -> T,
        out: &mut [T],
    ) {
        let used = self.values.len();
        for row in 0..used {
            let along = |x: f64, k: usize| Dual::<f64, 1>::new(x, [f64::from(u8::from(k == row))]);
            for first in (0..used).step_by(N) {
                let mut y = [Dual::from(0.0); OUTPUTS];
                let y = &mut y[..out.len()];
                let seeded = self.seeded::<Dual<f64, 1>, INPUTS>(first, along);
                self.function.second(&seeded[..used], y);
                for (out, y) in out.iter_mut().zip(y) {
                    for (k, slope) in (first..used).zip(&y.eps) {
                        let [second] = slope.eps;
                        if second != 0.0 {
                            *out += change(row) * change(k) * self.number::<T>(0.5 * second);
                        }
                    }
                }
            }
        }
    }

    /// The values as numbers of which some, from the first on, are variables.
    fn seeded<S: Scalar, const INPUTS: usize>(
        &self,
        first: usize,
        number: impl Fn(f64, usize) -> S,
    ) -> [Dual<S, N>; INPUTS] {
        let mut out = [Dual::from(0.0); INPUTS];
        for (k, (out, &x)) in out.iter_mut().zip(self.values).enumerate() {
            let x = number(x, k);
            *out = match k.checked_sub(first) {
                Some(direction) if direction < N => Dual::variable(x, direction),
                _ => Dual::constant_of(x),
            };
        }
        out
    }
}
