//! The Jacobians of the step as a graph.

use nalgebra::DVector;

use super::origin::origin;
use super::ports::state_and_input;
use crate::autodiff::CHUNK;
use crate::scalar::traced::{Graph, Port, trace};
use crate::scalar::{Dual, Over, Scalar, Traced};
use crate::sim::{Simulator, State, StepScratch};

/// Traces the Jacobians of the step, δx⁺ = A δx + B δu in tangent coordinates: inputs as those of [`step`](super::step()), outputs `A`
/// and `B`, those of [`Simulator::linearize`].
///
/// Where no solver finds forces, [`Simulator::linearize`] itself is recorded, which differentiates along the tree. Through the solver of contact and
/// constraints dual numbers go along with the step, some directions at a time, in its last step alone.
///
/// # Panics
/// If the step decides on values, with the place: see [what can be traced](crate::scalar::traced).
#[inline]
pub fn linearization(simulator: &Simulator) -> Graph {
    let (n, nu) = (simulator.n_tangent(), simulator.nu());
    let graph = trace(|t| {
        let (state, u) = state_and_input(t, simulator);
        let columns = if simulator.needs_solver() {
            columns_of_step(simulator, &state, &u)
        } else {
            let step = simulator.linearize_over(&state, &u);
            step.a.iter().chain(&step.b).copied().collect()
        };
        let (a, b) = columns.split_at(n * n);
        t.output(Port::matrix("A", n, n), a);
        t.output(Port::matrix("B", n, nu), b);
    });
    graph.with_origin(origin(simulator.model()))
}

/// A number with its derivatives in some directions, to be recorded.
type Number = Dual<Traced, CHUNK>;

/// A and B, column after column, of the step on dual numbers. Inlined as what calls it, or the library would compile the step over these.
#[inline]
fn columns_of_step(simulator: &Simulator, state: &State<Traced>, u: &[Traced]) -> Vec<Traced> {
    let width = simulator.n_tangent() + simulator.nu();
    let mut columns = Vec::with_capacity(simulator.n_tangent() * width);
    let mut scratch = StepScratch::new(simulator);
    for first in (0..width).step_by(CHUNK) {
        let directions = Directions {
            simulator,
            state,
            u,
            first,
        };
        let changes = directions.step(&mut scratch);
        for direction in 0..CHUNK.min(width - first) {
            columns.extend(changes.iter().map(|x| x.eps[direction]));
        }
    }
    columns
}

/// Some directions in which a step is differentiated, from `first` on, of state and input together.
struct Directions<'a, P> {
    simulator: &'a Simulator<P>,
    state: &'a State<Traced>,
    u: &'a [Traced],
    first: usize,
}

impl<P: Scalar> Directions<'_, P>
where
    Number: Over<P>,
{
    /// δ of the k-th number.
    fn along(&self, k: usize) -> Number {
        match k.checked_sub(self.first) {
            Some(direction) if direction < CHUNK => Number::variable(Traced::from(0.0), direction),
            _ => Number::constant_of(Traced::from(0.0)),
        }
    }

    /// x ⊕ δx
    fn moved(&self) -> State<Number> {
        let model = self.simulator.model();
        let lift = |x: &DVector<Traced>| x.map(Number::constant_of);
        let dq: Vec<Number> = (0..model.nv()).map(|k| self.along(k)).collect();
        let mut out = State {
            q: model.integrate(lift(&self.state.q).as_slice(), &dq),
            v: lift(&self.state.v),
            contact: lift(&self.state.contact),
        };
        let rest = out.v.iter_mut().chain(&mut out.contact);
        for (k, x) in rest.enumerate() {
            *x += self.along(model.nv() + k);
        }
        out
    }

    /// δx⁺ of a step, in tangent coordinates.
    fn step(&self, scratch: &mut StepScratch<Number>) -> Vec<Number> {
        let (n, moved) = (self.simulator.n_tangent(), self.moved());
        let moved_u = |(k, &u): (usize, &Traced)| self.along(n + k) + Number::constant_of(u);
        let u: Vec<Number> = self.u.iter().enumerate().map(moved_u).collect();
        let mut next = moved.clone();
        self.simulator.step_into(&moved, &u, scratch, &mut next);
        self.change(&next)
    }

    /// The difference of a state from its value.
    fn change(&self, next: &State<Number>) -> Vec<Number> {
        let mut value = next.clone();
        let numbers = value.numbers_mut();
        numbers.for_each(|x| *x = Number::constant_of(x.re));
        let change = next.deviation(self.simulator.model(), &value);
        change.as_slice().to_vec()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Model;
    use crate::constraint::Anchor;
    use crate::contact::{ContactLaw, Contacts, SoftContact, Terrain};
    use crate::model::samples;
    use crate::sim::{FrameActuator, Integrator};
    use crate::tests::OTHER_ALGORITHM;
    use rand::SeedableRng;
    use rand::rngs::Xoshiro256PlusPlus;

    /// Asserts that the graph gives A and B at a state where it was not recorded.
    fn assert_traced(simulator: &Simulator, state: &State) {
        let u: Vec<f64> = (0..simulator.nu()).map(|k| (k as f64).sin()).collect();
        let inputs: Vec<f64> = state.numbers().chain(&u).copied().collect();
        let graph = linearization(simulator);
        let found = graph.evaluate(&inputs).expect("slow motion");
        let step = simulator.linearize(state, &u);
        let expected: Vec<f64> = step.a.iter().chain(&step.b).copied().collect();
        let largest = expected.iter().fold(1.0, |most: f64, x| x.abs().max(most));
        for (k, (found, expected)) in found.iter().zip(&expected).enumerate() {
            let off = (found - expected).abs();
            let by = simulator.integrator();
            assert!(off < OTHER_ALGORITHM * largest, "{by:?}, {k}: {off:e}");
        }
    }

    #[test]
    fn graphs_with_thrusters_give_the_jacobians_of_all_integrators() {
        let model = samples::arm();
        let tip = *model.link_names().last().expect("a link");
        let tip = Anchor::frame(&model, tip).expect("a link of the robot");
        let jet = FrameActuator::thruster("jet", tip, [0.1, 0.2, 0.9], 0.1);
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(2);
        let state = State::random(&model, &mut rng, 1.0);
        for integrator in [
            Integrator::SemiImplicitEuler,
            Integrator::ImplicitVelocity,
            Integrator::RungeKutta4,
        ] {
            let simulator = Simulator::new(model.clone()).with_integrator(integrator);
            assert_traced(&simulator, &state);
            assert_traced(&simulator.with_frame_actuators(vec![jet.clone()]), &state);
        }
    }

    #[test]
    #[cfg(feature = "formats")]
    fn graphs_on_soft_ground_give_the_jacobians() {
        let path = format!("{}/assets/sphere.urdf", env!("CARGO_MANIFEST_DIR"));
        let model = Model::from_urdf_file(path).expect("an asset");
        let law = ContactLaw::Soft(SoftContact::estimate(1.0, 1, 1e-2));
        let contacts = Contacts::new(&model, Terrain::incline(0.2), law);
        let simulator = Simulator::new(model).with_contacts(contacts);
        let mut state = simulator.neutral_state();
        for height in [0.0, 0.09, 10.0] {
            state.q[2] = height;
            state.v[1] = 0.3;
            assert_traced(&simulator, &state);
        }
    }
}
