//! The gradient in the parameters of terms: a term is evaluated over numbers with derivatives in its parameters, and its results are weighted.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::ops::Range;

use super::adjoint::{AdjointMemory, AdjointSink};
use super::delassus::ALONG;
use super::local::{BODY_DIRECTIONS, OfBody};
use super::sink::{BodyRow, BodySink, CoordinateSink, DerivativePoint, Normal, Own};
use super::weights::TermWeights;
use crate::dynamics::{ParameterSlots, Sweep};
use crate::model::BodyId;
use crate::scalar::{Dual, Scalar};
use crate::sim::parameter_slots::{PartSlots, add_to_last, add_to_part};
use crate::spatial::{Force, Motion};

/// The gradient in parameters, and the weights that all has.
pub(crate) struct Numbers<'a, T: Scalar> {
    at: &'a DerivativePoint<'a, T>,
    weights: &'a TermWeights<'a, T>,
    /// Before its pass inward.
    sweep: &'a Sweep<T>,
    memory: &'a AdjointMemory<T>,
    /// Of all parameters, or of those of the model, which are the first.
    parameters: &'a mut [T],
}

impl<'a, T: Scalar> Numbers<'a, T> {
    /// Starts when a sink has taken all forces and rows.
    pub(crate) fn of(sink: &'a mut AdjointSink<'_, '_, T>) -> Self {
        Self {
            at: sink.at,
            weights: sink.weights,
            sweep: sink.sweep,
            memory: sink.memory,
            parameters: sink.out.parameters,
        }
    }

    /// Places of the parameters of parts, and of those of the model.
    pub(super) fn slots(&self) -> (&PartSlots, &ParameterSlots) {
        (&self.memory.slots, &self.sweep.slots)
    }

    /// μ.
    pub(super) fn mu(&self) -> &[T] {
        self.weights.mu
    }

    /// λ, of y of a row.
    pub(super) fn row_weight(&self, row: usize) -> T {
        self.weights.y[row]
    }

    /// Weight of the friction, or the bound, of a block.
    pub(super) fn block_weight(&self, block: usize) -> T {
        let weight = self.weights.friction.get(block);
        weight.copied().unwrap_or(T::zero())
    }

    /// A sum of all that a term states where it acts.
    pub(super) fn sum<const N: usize>(&self, on: Option<BodyId>) -> WeightedSum<'_, T, N> {
        WeightedSum {
            at: self.at,
            weights: self.weights,
            memory: self.memory,
            W: self.moved(on),
            second: None,
            value: Dual::from(0.0),
        }
    }

    /// A sum of all that a term states where it acts between two bodies.
    pub(super) fn sum_between<const N: usize>(
        &self,
        [first, second]: [Option<BodyId>; 2],
    ) -> WeightedSum<'_, T, N> {
        WeightedSum {
            second: Some((second, self.moved(second))),
            ..self.sum(first)
        }
    }

    /// The motion that the rates μ give to a body.
    fn moved(&self, on: Option<BodyId>) -> Motion<T> {
        on.map_or_else(Motion::zero, |body| self.sweep.bodies[body.0].W)
    }

    /// The motion that ã gives to a body.
    pub(super) fn seen(&self, on: Option<BodyId>) -> Motion<T> {
        let seen = on.and_then(|body| self.sweep.seen.get(body.0));
        seen.map_or_else(Motion::zero, |seen| seen.U)
    }

    /// The gradient in the parameters of a part; `None` if not requested.
    pub(super) fn parameters(&mut self, part: &Range<usize>) -> Option<&mut [T]> {
        self.parameters.get_mut(part.clone())
    }

    /// Whether it is requested in parameters that are not the model's.
    pub(super) fn has_parts(&self) -> bool {
        self.parameters.len() > self.sweep.slots.len
    }

    /// Adds a derivative in the time step, the last of all parameters, where it is requested.
    pub(super) fn add_time_step(&mut self, slope: T) {
        if self.has_parts() {
            add_to_last(self.parameters, slope);
        }
    }

    /// Adds derivatives to the parameters of a part, as many as it has.
    pub(super) fn add(&mut self, part: &Range<usize>, slopes: &[T]) {
        add_to_part(self.parameters, part, slopes, T::one());
    }
}

/// A weighted sum with its derivatives in some numbers.
pub(super) struct WeightedSum<'a, T: Scalar, const N: usize> {
    at: &'a DerivativePoint<'a, T>,
    weights: &'a TermWeights<'a, T>,
    memory: &'a AdjointMemory<T>,
    /// The motion that the rates μ give to the body.
    pub(super) W: Motion<T>,
    /// Another body, and its.
    second: Option<(Option<BodyId>, Motion<T>)>,
    pub(super) value: Dual<T, N>,
}

impl<T: Scalar, const N: usize> WeightedSum<'_, T, N> {
    /// Adds changes of entries of the contact state, from a first one.
    pub(super) fn add_rates(&mut self, first: usize, rates: &[Dual<T, N>]) {
        self.value += self.weights.rates(first, rates);
    }
}

impl<T: Scalar, const N: usize> CoordinateSink<Dual<T, N>> for WeightedSum<'_, T, N> {
    fn coordinate(&mut self, k: usize, _: Option<usize>, force: Dual<T, N>) {
        self.value -= force.each(|x| x * self.weights.mu[k]);
    }

    fn coupled(&mut self, k: usize, _: usize, force: Dual<T, N>) {
        self.coordinate(k, None, force);
    }

    fn resistance(&mut self, k: usize, resistance: Dual<T, N>) {
        let weight = self.weights.mu[k] * self.at.a[k] + self.memory.by_resistance[k];
        self.value += resistance.each(|x| x * weight);
    }

    fn coordinate_row(&mut self, row: usize, _: usize, _: Option<usize>, y: Dual<T, N>) {
        self.value += y.each(|x| x * self.weights.y[row]);
    }
}

impl<T: Scalar> BodySink<T> for WeightedSum<'_, T, BODY_DIRECTIONS> {
    fn force(&mut self, on: Option<BodyId>, force: &Force<OfBody<T>>, _: Own) {
        let second = self.second.as_ref().filter(|(body, _)| *body == on);
        let W = second.map_or(&self.W, |(_, W)| W);
        self.value += TermWeights::force(force, W);
    }

    fn rows(&mut self, rows: &[BodyRow<T>], _: Own) {
        self.value += self.weights.rows(rows);
    }

    fn rates(&mut self, first: usize, rates: &[OfBody<T>]) {
        self.add_rates(first, rates);
    }

    fn friction(&mut self, block: usize, friction: OfBody<T>) {
        if let Some(&slope) = self.weights.friction.get(block) {
            self.value += friction.each(|x| x * slope);
        }
    }

    fn delassus(&mut self, rows: &[BodyRow<T>], normal: &Normal<'_, T>) {
        let of_row = |(row, _): &&(usize, [Motion<T>; 2])| *row == rows[0].row;
        if let Some((_, V)) = self.memory.along_normals.iter().find(of_row) {
            let along = (normal.along)(V);
            self.value += along.each(|x| x * T::constant(ALONG));
        }
    }
}
