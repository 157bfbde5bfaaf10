//! A quadruped that is thrown about for 100,000 steps under each contact model, and then left alone: every step is finite, keeps its quaternion a rotation and
//! gains no energy, and at the end nothing creeps.
//!
//! ```sh
//! cargo bench --bench endurance
//! ```
//!
//! A check rather than a measurement. It is here because it takes minutes without optimisation; as a test, without `--bench`, it takes a tenth of the throws, and does not wait for the rest.

#[path = "common/robots.rs"]
#[expect(dead_code, reason = "shared with other benches")]
mod robots;

use std::time::Instant;

use dualbody::cone::Status;
use dualbody::contact::{
    ContactLaw, Contacts, RelaxedRigid, Rigid, SoftContact, SolverOptions, Terrain,
};
use dualbody::dynamics::{kinetic_energy, potential_energy};
use dualbody::sim::{Actuation, StepScratch};
use dualbody::{Integrator, Simulator, State};
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};
use robots::asset;

/// So many throws, with so many steps after each, and so many steps of rest at the end: 100,000 in all.
const THROWS: usize = 160;
const STEPS: usize = 500;
const REST: usize = 20_000;
/// The last steps, of five seconds, in which nothing may creep.
const LAST: usize = 2_500;
/// Dampers at the joints, N·m·s/rad.
const DAMPING: f64 = 0.5;
/// Largest gain of a free body in a flight of one second with the spin of a throw, by the first order of the step, as a part of its energy.
const DRIFT: f64 = 0.02;

fn quadruped(law: ContactLaw) -> Simulator {
    let mut model = asset("quadruped");
    for k in 6..model.nv() {
        model = model.with_damping(k, DAMPING);
    }
    let contacts = Contacts::new(&model, Terrain::flat(0.0), law);
    let actuation = Actuation::from_model(&model);
    Simulator::new(model)
        .with_contacts(contacts)
        .with_actuation(actuation)
        .with_integrator(Integrator::ImplicitVelocity)
        .with_time_step(2e-3)
}

/// Takes steps without input, in place.
struct Run {
    simulator: Simulator,
    scratch: StepScratch<f64>,
    state: State,
    next: State,
}

impl Run {
    fn new(simulator: Simulator) -> Self {
        let mut state = simulator.neutral_state();
        state.q[2] = 0.5;
        Self {
            scratch: StepScratch::new(&simulator),
            next: state.clone(),
            state,
            simulator,
        }
    }

    fn energy(&self) -> f64 {
        let (model, state) = (self.simulator.model(), &self.state);
        let (q, v) = (state.q.as_slice(), state.v.as_slice());
        kinetic_energy(model, q, v) + potential_energy(model, q)
    }

    /// Steps that each are finite, keep the quaternion a rotation, and gain no energy over that at the start.
    fn advance(&mut self, steps: usize) {
        let start = self.energy();
        for k in 0..steps {
            let (next, scratch) = (&mut self.next, &mut self.scratch);
            self.simulator
                .step_into(&self.state, &[0.0; 12], scratch, next);
            std::mem::swap(&mut self.state, &mut self.next);
            assert!(self.state.is_finite(), "step {k}");
            let length = self.state.q.rows(3, 4).norm();
            assert!((length - 1.0).abs() < 1e-9, "step {k}: {length}");
            let now = self.energy();
            assert!(
                now < start * (1.0 + DRIFT) + 0.1,
                "step {k}: {start} becomes {now}"
            );
        }
    }

    fn throw(&mut self, rng: &mut impl RngExt) {
        for k in 0..6 {
            let most = if k < 3 { 2.0 } else { 8.0 };
            self.state.v[k] += most * rng.random_range(-1.0..1.0);
        }
    }

    /// Left alone, it lies still in the end.
    fn comes_to_rest(&mut self) {
        self.advance(REST - LAST);
        let rest = self.state.clone();
        self.advance(LAST);
        let crept = self.state.deviation(self.simulator.model(), &rest).amax();
        assert!(self.state.v.amax() < 1e-6, "{}", self.state.v);
        assert!(crept < 1e-6, "crept by {crept:e}");
    }

    fn status(&self) -> Status {
        let report = self.simulator.contact_report(&self.state, &[0.0; 12]);
        report.certificate.status
    }
}

/// Throws and a rest. Returns how many of the states looked at had forces of a regularised problem.
fn throw_about_and_let_lie(simulator: Simulator, throws: usize) -> usize {
    let contacts = simulator.contacts().expect("contacts");
    let acceptable = contacts.solver_options().acceptable > 0.0;
    let mut run = Run::new(simulator);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    let mut regularized = 0;
    for throw in 0..throws {
        run.throw(&mut rng);
        for _ in 0..5 {
            run.advance(STEPS / 5);
            match run.status() {
                Status::Converged => {}
                Status::Acceptable if acceptable => {}
                Status::Regularized => regularized += 1,
                other => panic!("throw {throw}: {other:?}"),
            }
        }
    }
    if throws == THROWS {
        run.comes_to_rest();
    }
    regularized
}

/// Runs a case, in which at most so many of the states looked at may have had forces of a regularised problem.
fn check(name: &str, simulator: Simulator, throws: usize, most_regularized: usize) {
    let start = Instant::now();
    let regularized = throw_about_and_let_lie(simulator, throws);
    assert!(regularized <= most_regularized, "{name}: {regularized}");
    let seconds = start.elapsed().as_secs_f64();
    let steps = throws * STEPS + if throws == THROWS { REST } else { 0 };
    println!(
        "{name:40} {steps:7} steps {seconds:7.1} s, {regularized} of {} states regularised",
        5 * throws
    );
}

/// The rigid contact of trunk and feet, with as few digits as its solver is content with where it can have no more.
fn rigid(acceptable: f64) -> Simulator {
    let law = ContactLaw::Rigid(Rigid {
        restitution: 0.2,
        ..Rigid::default()
    });
    let simulator = quadruped(law);
    let links = ["trunk", "FR_foot", "FL_foot", "RR_foot", "RL_foot"];
    let contacts = simulator.contacts().expect("contacts").clone();
    let contacts = contacts.with_links(simulator.model(), &links);
    let contacts = contacts.expect("links");
    let options = SolverOptions {
        acceptable,
        ..contacts.solver_options()
    };
    simulator.with_contacts(contacts.with_solver_options(options))
}

fn main() {
    let throws = match std::env::args().any(|argument| argument == "--bench") {
        true => THROWS,
        false => THROWS / 10,
    };
    let relaxed = ContactLaw::RelaxedRigid(RelaxedRigid::default());
    check("relaxed rigid", quadruped(relaxed), throws, 0);
    let mass = asset("quadruped").total_mass();
    let soft = ContactLaw::Soft(SoftContact::estimate(mass, 4, 2e-3));
    check("soft", quadruped(soft), throws, 0);
    // Impacts of many redundant corners at once are the hardest problems: now and then one is solved regularised, which its status reports.
    for acceptable in [0.0, SolverOptions::default().acceptable] {
        let name = format!("rigid, acceptable from {acceptable:e} on");
        check(&name, rigid(acceptable), throws, throws.div_ceil(20));
    }
}
