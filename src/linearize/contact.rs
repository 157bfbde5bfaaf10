//! Jacobians of the acceleration under forces of contact that a solver found, by the implicit function theorem twice.
//!
//! The acceleration a and the forces f at the points, along their axes, obey
//!
//! > ID(q, v, a) = τ + Jᵀ f,  and the laws for  y = J ã − w + R f,
//!
//! where ã is a with the turning of axes that carry linear velocities, and w and R are what the laws ask. At fixed f, the first says how a
//! changes, and with it how y does: what a point asks and bears depends on the pose and the velocity of its body, so one evaluation
//! on dual numbers in these directions tells all, and the joints that carry the body do the rest. Then the solver says how the forces
//! follow, and the first how a does.
//!
//! The accelerations of all directions are found by halves, M = Lᵀ D L, where J keeps its zeros: with Lᵀ X = Jᵀ and Lᵀ Z = δID − δτ − δJᵀ f,
//! J δa = −Xᵀ D⁻¹ Z at fixed f, and −δa = L⁻¹ D⁻¹ (Z − X δf).

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::chain::Chain;
use super::touch::{Local, Touch};
use crate::autodiff::{AccelerationDerivatives, BLOCK, Blocks, Dual};
use crate::contact::ContactLaw;
use crate::dynamics::kinetic_energy_gradient_into;
use crate::joint::MAX_NV;
use crate::model::Model;
use crate::model::manifold::v_range;
use crate::scalar::{Lanes, Scalar};
use crate::sim::{ROWS, Simulator, Solution};
use crate::spatial::{Force, Motion, SPATIAL};

/// Working memory for what contact adds to Jacobians.
#[derive(Clone, Debug)]
pub(super) struct ContactColumns {
    /// Force on each body, in the body.
    external: Vec<Force<f64>>,
    chain: Chain,
    /// ã.
    seen: Vec<f64>,
    /// How the motions of a body at v, ã and a response turn with each coordinate.
    turns: [Vec<Motion<f64>>; 3],
    /// M⁻¹ Jᵀ of a row.
    response: Vec<f64>,
    momenta: Vec<(Motion<f64>, Force<f64>)>,
    /// ∂G of a row and itself.
    mobility: Vec<f64>,
    /// ∂y, then ∂f, of all rows.
    rows: Blocks,
    memory: Vec<Lanes<BLOCK>>,
}

impl ContactColumns {
    pub(super) fn new(simulator: &Simulator) -> Self {
        let (model, nv) = (simulator.model(), simulator.model().nv());
        let points = simulator.contacts().map_or(0, |c| c.points().len());
        Self {
            external: vec![Force::zero(); model.n_bodies()],
            chain: Chain::default(),
            seen: vec![0.0; nv],
            turns: std::array::from_fn(|_| Vec::with_capacity(nv)),
            response: vec![0.0; nv],
            momenta: vec![(Motion::zero(), Force::zero()); model.n_bodies()],
            mobility: vec![0.0; nv],
            rows: Blocks::new(ROWS * points, 2 * nv + simulator.nu()),
            memory: Vec::with_capacity(2 * ROWS * points),
        }
    }

    /// Computes ∂y at fixed forces and accelerations, adds −∂Jᵀ f to the columns, and gives the forces on the bodies.
    pub(super) fn press(
        &mut self,
        simulator: &Simulator,
        (v, a): (&[f64], &[f64]),
        solution: &Solution<'_, f64>,
        columns: &mut Blocks,
    ) -> &[Force<f64>] {
        let (model, constrained) = (simulator.model(), &*solution.constrained);
        let kinematics = &solution.contact.kinematics;
        let rows = constrained.rows();
        let width = 2 * model.nv() + simulator.nu();
        self.rows.resize(rows.count(), width);
        self.external.fill(Force::zero());
        self.see(model, (v, a), solution);
        let contacts = simulator.contacts().expect("points of contact");
        let mut last = None;
        for (n, i) in constrained.touching().enumerate() {
            let body = contacts.points()[i].body;
            if last.replace(body) != Some(body) {
                self.chain.follow(model, kinematics, body);
                self.chain.turns(v, &mut self.turns[0]);
                self.chain.turns(&self.seen, &mut self.turns[1]);
            }
            let (pose, velocity) = (kinematics.pose(Some(body)), kinematics.velocity(Some(body)));
            let touch = Touch::new(simulator, i, (&pose, &velocity));
            let (first, axes) = (ROWS * n, touch.unit_forces());
            let forces = &rows.forces()[first..first + ROWS];
            let seen = self.chain.motion(&self.seen);
            let y = touch.rows(simulator, i, (&seen, rows.mobility(first)), forces);
            for row in 0..ROWS {
                self.external[body.0] += axes[row].scaled(forces[row]);
                self.add_row(model, first + row, &y[row], &axes[row]);
            }
            self.add_force(&touch.force(forces), columns);
            if matches!(contacts.laws()[i], ContactLaw::RelaxedRigid(_)) {
                self.find_mobility(model, solution, (first, &axes[0]), &touch);
                for (row, y) in y.iter().enumerate() {
                    for (k, x) in self.mobility.iter().enumerate() {
                        *self.rows.at(first + row, k) += y.by_mobility() * x;
                    }
                }
            }
        }
        &self.external
    }

    /// ã, and what its turning changes in y.
    fn see(&mut self, model: &Model, (v, a): (&[f64], &[f64]), solution: &Solution<'_, f64>) {
        let rows = solution.constrained.rows();
        self.seen.copy_from_slice(a);
        for body in model.independent() {
            let own = v_range(body);
            let mut rates = [Dual::<MAX_NV>::from(0.0); MAX_NV];
            for (k, &v) in v[own.clone()].iter().enumerate() {
                rates[k] = Dual::variable(v, k);
            }
            body.joint.turning(&rates[..own.len()], |k, x| {
                self.seen[own.start + k] += x.re;
                for row in 0..rows.count() {
                    let entry = rows.row(row)[own.start + k];
                    for (l, slope) in own.clone().zip(x.eps) {
                        *self.rows.at(row, model.nv() + l) += entry * slope;
                    }
                }
            });
        }
    }

    /// ∂y of a row from what it does locally and how the joints move the body, at fixed mobility.
    fn add_row(&mut self, model: &Model, row: usize, y: &Local, axis: &Force<f64>) {
        let [by_v, by_a, _] = &self.turns;
        let coordinates = self.chain.coordinates.iter().zip(by_v).zip(by_a);
        for ((&(k, S), turn), turn_of_seen) in coordinates {
            let by_q = y.by_pose(&S) + y.by_velocity(turn) + turn_of_seen.power(axis);
            *self.rows.at(row, k) += by_q;
            *self.rows.at(row, model.nv() + k) += y.by_velocity(&S);
        }
    }

    /// −∂(Jᵀ F) at fixed J: forces follow the pose of the body; that J follows it is the part of inverse dynamics.
    fn add_force(&self, force: &[Local; SPATIAL], columns: &mut Blocks) {
        for &(l, by) in &self.chain.coordinates {
            let change = Force::from_array(force.map(|x| x.by_pose(&by)));
            for (k, S) in &self.chain.coordinates {
                *columns.at(*k, l) -= S.power(&change);
            }
        }
    }

    /// ∂(J M⁻¹ Jᵀ) of a row and itself: with its response s,  2 δJ s − sᵀ δM s.
    fn find_mobility(
        &mut self,
        model: &Model,
        solution: &Solution<'_, f64>,
        (row, axis): (usize, &Force<f64>),
        touch: &Touch,
    ) {
        let constrained = &*solution.constrained;
        let halves = constrained.rows().halves();
        let response = self.response.iter_mut().zip(halves);
        response.for_each(|(s, x)| *s = x[row]);
        constrained.factor().solve_from_world(&mut self.response);
        kinetic_energy_gradient_into(
            model,
            &solution.contact.kinematics,
            &self.response,
            &mut self.momenta,
            &mut self.mobility,
        );
        self.mobility.iter_mut().for_each(|x| *x *= -2.0);
        let along = touch.along(0, &self.chain.motion(&self.response));
        self.chain.turns(&self.response, &mut self.turns[2]);
        for (&(k, S), turn) in self.chain.coordinates.iter().zip(&self.turns[2]) {
            self.mobility[k] += 2.0 * (along.by_pose(&S) + turn.power(axis));
        }
    }

    /// From what the acceleration balances at fixed forces to −∂a.
    pub(super) fn solve(
        &mut self,
        solution: Solution<'_, f64>,
        acceleration: &mut AccelerationDerivatives,
    ) {
        let AccelerationDerivatives {
            columns, factor, ..
        } = acceleration;
        for (z, y) in columns.blocks_mut().zip(self.rows.blocks_mut()) {
            factor.solve_from_tips(z);
            let halves = solution.constrained.rows().halves();
            for (k, (z, x)) in z.iter().zip(halves).enumerate() {
                let scaled = *z * factor.reciprocal(k);
                let rows = y.iter_mut().zip(x);
                rows.for_each(|(y, &x)| *y = scaled.mul_add_real(-x, *y));
            }
        }
        let solver = solution.constrained.solver_mut();
        solver.respond(self.rows.blocks_mut(), &mut self.memory);
        let rows = solution.constrained.rows();
        for (z, f) in columns.blocks_mut().zip(self.rows.blocks()) {
            for (z, x) in z.iter_mut().zip(rows.halves()) {
                let forces = f.iter().zip(x);
                *z = forces.fold(*z, |z, (f, &x)| f.mul_add_real(-x, z));
            }
            factor.solve_from_world(z);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::contact::{ContactLaw, Contacts, RelaxedRigid, Rigid, Terrain};
    use crate::linearize::dense::{self, DenseScratch};
    use crate::{Linearization, Model, Simulator, State};
    use rand::SeedableRng;
    use rand::rngs::Xoshiro256PlusPlus;

    fn laws() -> [ContactLaw; 2] {
        [
            ContactLaw::Rigid(Rigid {
                restitution: 0.3,
                ..Rigid::default()
            }),
            ContactLaw::RelaxedRigid(RelaxedRigid::default()),
        ]
    }

    fn simulator(robot: &str, terrain: &Terrain, law: ContactLaw) -> Simulator {
        let path = format!("{}/assets/{robot}.urdf", env!("CARGO_MANIFEST_DIR"));
        let model = Model::from_urdf_file(path).unwrap();
        let contacts = Contacts::new(&model, terrain.clone(), law);
        let feet = |link: &&str| link.contains("foot") || link.contains("ankle");
        let links = model
            .links()
            .iter()
            .map(|link| model.frames()[link.frame.0].name.as_str());
        let feet: Vec<&str> = links.filter(feet).collect();
        let contacts = if feet.is_empty() {
            contacts
        } else {
            contacts.with_links(&model, &feet).unwrap()
        };
        Simulator::new(model).with_contacts(contacts)
    }

    /// The robot lowered until its lowest point is a little in the ground.
    fn lower(simulator: &Simulator, state: &mut State) {
        let contacts = simulator.contacts().unwrap();
        for _ in 0..20 {
            let points = contacts.states(simulator.model(), state.q.as_slice(), state.v.as_slice());
            let deepest = points
                .iter()
                .map(|p| p.depth)
                .fold(f64::NEG_INFINITY, f64::max);
            state.q[2] += deepest - 5e-4;
        }
    }

    /// Largest difference of A and B, beside their largest entry.
    fn difference(simulator: &Simulator, state: &State, u: &[f64]) -> f64 {
        let actual = simulator.linearize(state, u);
        let mut expected = Linearization::zeros(simulator);
        let mut scratch = DenseScratch::new(simulator);
        let next = simulator.step(state, u);
        dense::linearize(simulator, (state, u, &next), &mut scratch, &mut expected);
        let pairs = actual.a.iter().zip(&expected.a);
        let pairs: Vec<_> = pairs.chain(actual.b.iter().zip(&expected.b)).collect();
        let largest = |x: &dyn Fn(&(&f64, &f64)) -> f64| pairs.iter().map(x).fold(0.0, f64::max);
        largest(&|(a, b)| (*a - *b).abs()) / (1.0 + largest(&|(_, b)| b.abs()))
    }

    #[test]
    fn jacobians_with_contact_equal_those_of_the_dense_step() {
        /// Where forces are redundant, the ridge that makes them unique magnifies rounding.
        const ROBOTS: [(&str, f64); 4] = [
            ("sphere", 1e-13),
            ("box", 1e-6),
            ("quadruped", 1e-13),
            ("humanoid", 1e-12),
        ];
        let terrains = [Terrain::flat(0.0), Terrain::incline(0.2)];
        for (robot, tolerance) in ROBOTS {
            let mut touching = 0;
            for (terrain, law) in terrains.iter().flat_map(|t| laws().map(|law| (t, law))) {
                let simulator = simulator(robot, terrain, law);
                let mut rng = Xoshiro256PlusPlus::seed_from_u64(7);
                let u: Vec<f64> = (0..simulator.nu()).map(|k| (k as f64).sin()).collect();
                for (speed, tilted) in [(0.0, false), (0.05, false), (0.0, true), (2.0, true)] {
                    let mut state = State::random(simulator.model(), &mut rng, speed);
                    if !tilted {
                        state.q.copy_from(&simulator.neutral_state::<f64>().q);
                    }
                    lower(&simulator, &mut state);
                    let forces = simulator.contact_report(&state, &u).forces;
                    touching += forces.iter().filter(|f| f.norm() > 0.0).count();
                    let error = difference(&simulator, &state, &u);
                    let case = format!("{robot} {terrain:?} {law:?} at {speed}, {tilted}");
                    assert!(error < tolerance, "{case}: {error:e}");
                }
            }
            assert!(touching > 10, "{robot}: {touching}");
        }
    }
}
