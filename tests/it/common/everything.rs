//! Every dynamics function of the crate in one list of numbers, so that a property of all of them is tested on all
//! of them.

use dualbody::autodiff::VectorFunction;
use dualbody::dynamics::{
    AbaScratch, BaseFrame, BaseQuantity, MassMatrixFactor, MomentumFrame, RneaScratch,
    add_frame_force, average_velocity, average_velocity_jacobian, bias_forces, center_of_mass,
    center_of_mass_acceleration, center_of_mass_jacobian, center_of_mass_velocity,
    centroidal_momentum_rate, coriolis_matrix, elastic_energy, forward_dynamics,
    forward_dynamics_into, forward_dynamics_vjp, forward_kinematics, frame_acceleration,
    frame_bias_acceleration, frame_jacobian, frame_jacobian_derivative, frame_pose, frame_pose_at,
    frame_velocity, gravity_forces, inverse_dynamics, inverse_dynamics_into, inverse_dynamics_vjp,
    joint_torque_regressor, kinetic_energy, kinetic_energy_regressor, locked_inertia, mass_matrix,
    mass_matrix_inverse, momentum, momentum_matrix, passive_forces, potential_energy,
    potential_energy_regressor,
};
use dualbody::model::{FrameId, Model};
use dualbody::spatial::{Force, Representation, Transform};
use dualbody::{Integrator, Over, Scalar, Simulator, State};

pub(crate) const REPRESENTATIONS: [Representation; 3] = Representation::ALL;
pub(crate) const MOMENTUM_FRAMES: [MomentumFrame; 3] = [
    MomentumFrame::Centroidal,
    MomentumFrame::World,
    MomentumFrame::Base,
];
pub(crate) const INTEGRATORS: [Integrator; 3] = [
    Integrator::SemiImplicitEuler,
    Integrator::ImplicitVelocity,
    Integrator::RungeKutta4,
];

/// Named blocks of numbers.
#[derive(Default)]
pub(crate) struct Results<T> {
    pub(crate) names: Vec<&'static str>,
    pub(crate) numbers: Vec<T>,
}

impl<T: Scalar> Results<T> {
    fn add(&mut self, name: &'static str, numbers: &[T]) {
        self.names.extend(std::iter::repeat_n(name, numbers.len()));
        self.numbers.extend_from_slice(numbers);
    }

    fn add_pose(&mut self, name: &'static str, pose: &Transform<T>) {
        self.add(name, pose.rotation.as_slice());
        self.add(name, pose.translation.as_slice());
    }
}

/// Evaluates everything at (q, v, w); `w` serves as acceleration and as joint force.
pub(crate) fn everything<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    w: &[T],
) -> Results<T> {
    let mut out = Results {
        names: Vec::new(),
        numbers: Vec::new(),
    };
    out.add("mass_matrix", mass_matrix(model, q).as_slice());
    out.add(
        "inverse_dynamics",
        inverse_dynamics(model, q, v, w).as_slice(),
    );
    out.add(
        "forward_dynamics",
        forward_dynamics(model, q, v, w).as_slice(),
    );
    out.add(
        "mass_matrix_inverse",
        mass_matrix_inverse(model, q).as_slice(),
    );
    out.add("coriolis_matrix", coriolis_matrix(model, q, v).as_slice());
    let mut solution = w.to_vec();
    MassMatrixFactor::new(model, &mass_matrix(model, q)).solve(&mut solution);
    out.add("MassMatrixFactor::solve", &solution);
    out.add("bias_forces", bias_forces(model, q, v).as_slice());
    out.add("gravity_forces", gravity_forces(model, q).as_slice());
    out.add("center_of_mass", center_of_mass(model, q).as_slice());
    out.add("kinetic_energy", &[kinetic_energy(model, q, v)]);
    out.add("potential_energy", &[potential_energy(model, q)]);
    add_adjoints(&mut out, model, q, v, w);
    add_frames(&mut out, model, q, v, w);
    add_parameters_and_representations(&mut out, model, q, v, w);
    add_centroidal(&mut out, model, q, v, w);
    add_with_external_forces(&mut out, model, q, v, w);
    add_manifold(&mut out, model, q, v, w);
    out
}

fn add_adjoints<P: Scalar, T: Over<P>>(
    out: &mut Results<T>,
    model: &Model<P>,
    q: &[T],
    v: &[T],
    w: &[T],
) {
    let weights: Vec<T> = (0..model.nv())
        .map(|k| T::constant(0.7 - 0.3 * k as f64))
        .collect();
    let inverse = inverse_dynamics_vjp(model, q, v, w, &weights);
    for slopes in [inverse.q, inverse.v, inverse.a, inverse.parameters] {
        out.add("inverse_dynamics_vjp", slopes.as_slice());
    }
    let forward = forward_dynamics_vjp(model, q, v, w, &weights);
    for slopes in [forward.q, forward.v, forward.tau, forward.parameters] {
        out.add("forward_dynamics_vjp", slopes.as_slice());
    }
}

fn add_frames<P: Scalar, T: Over<P>>(
    out: &mut Results<T>,
    model: &Model<P>,
    q: &[T],
    v: &[T],
    w: &[T],
) {
    let last = FrameId(model.frames().len() - 1);
    let kinematics = forward_kinematics(model, q, v);
    out.add_pose("frame_pose", &frame_pose(model, q, last));
    out.add_pose("frame_pose_at", &frame_pose_at(model, &kinematics, last));
    for representation in REPRESENTATIONS {
        out.add(
            "frame_velocity",
            &frame_velocity(model, q, v, last, representation).to_array(),
        );
        out.add(
            "frame_jacobian",
            frame_jacobian(model, q, last, representation).as_slice(),
        );
        out.add(
            "frame_acceleration",
            &frame_acceleration(model, q, v, w, last, representation).to_array(),
        );
        out.add(
            "frame_bias_acceleration",
            &frame_bias_acceleration(model, q, v, last, representation).to_array(),
        );
        out.add(
            "frame_jacobian_derivative",
            frame_jacobian_derivative(model, q, v, last, representation).as_slice(),
        );
    }
    for body in 0..model.n_bodies() {
        let id = Some(dualbody::model::BodyId(body));
        out.add_pose("forward_kinematics", &kinematics.pose(id));
        out.add("forward_kinematics", &kinematics.velocity(id).to_array());
    }
}

fn add_with_external_forces<P: Scalar, T: Over<P>>(
    out: &mut Results<T>,
    model: &Model<P>,
    q: &[T],
    v: &[T],
    w: &[T],
) {
    let kinematics = forward_kinematics(model, q, v);
    let mut external = vec![Force::zero(); model.n_bodies()];
    let force = Force::from_array([0.3, -1.0, 0.7, 2.0, 0.1, -0.4].map(T::constant));
    for (frame, representation) in
        (0..model.frames().len()).zip(REPRESENTATIONS.into_iter().cycle())
    {
        add_frame_force(
            model,
            &kinematics,
            FrameId(frame),
            &force,
            representation,
            &mut external,
        );
    }
    let mut numbers = vec![T::zero(); model.nv()];
    inverse_dynamics_into(
        model,
        q,
        v,
        w,
        &external,
        &mut RneaScratch::new(model),
        &mut numbers,
    );
    out.add("inverse_dynamics with external forces", &numbers);
    forward_dynamics_into(
        model,
        q,
        v,
        w,
        &external,
        &mut AbaScratch::new(model),
        &mut numbers,
    );
    out.add("forward_dynamics with external forces", &numbers);
}

fn add_manifold<P: Scalar, T: Over<P>>(
    out: &mut Results<T>,
    model: &Model<P>,
    q: &[T],
    v: &[T],
    w: &[T],
) {
    let moved = model.integrate(q, v);
    out.add("integrate", moved.as_slice());
    out.add(
        "difference",
        model.difference(q, moved.as_slice()).as_slice(),
    );
    out.add(
        "interpolate",
        model
            .interpolate(q, moved.as_slice(), T::constant(0.3))
            .as_slice(),
    );
    for integrator in INTEGRATORS {
        let simulator = Simulator::new(model.clone())
            .with_time_step(0.01)
            .with_integrator(integrator);
        let u: Vec<T> = simulator.actuated().iter().map(|&k| w[k]).collect();
        let next = simulator.step(&State::new(q, v), &u);
        out.add("step", next.q.as_slice());
        out.add("step", next.v.as_slice());
    }
}

fn add_parameters_and_representations<P: Scalar, T: Over<P>>(
    out: &mut Results<T>,
    model: &Model<P>,
    q: &[T],
    v: &[T],
    w: &[T],
) {
    out.add(
        "joint_torque_regressor",
        joint_torque_regressor(model, q, v, w).as_slice(),
    );
    out.add(
        "kinetic_energy_regressor",
        kinetic_energy_regressor(model, q, v).as_slice(),
    );
    out.add(
        "potential_energy_regressor",
        potential_energy_regressor(model, q).as_slice(),
    );
    out.add("passive_forces", passive_forces(model, q, v).as_slice());
    out.add("elastic_energy", &[elastic_energy(model, q)]);
    for to in Representation::ALL {
        let base = BaseFrame::new(model, to);
        out.add(
            "velocity_to_representation",
            base.to_representation(q, BaseQuantity::Velocity, v)
                .as_slice(),
        );
        out.add(
            "force_to_representation",
            base.to_representation(q, BaseQuantity::Force, w).as_slice(),
        );
        out.add(
            "acceleration_to_representation",
            base.to_representation(q, BaseQuantity::Acceleration { v }, w)
                .as_slice(),
        );
        out.add(
            "mass_matrix_to_representation",
            base.mass_matrix(q).as_slice(),
        );
    }
}

fn add_centroidal<P: Scalar, T: Over<P>>(
    out: &mut Results<T>,
    model: &Model<P>,
    q: &[T],
    v: &[T],
    w: &[T],
) {
    out.add(
        "center_of_mass_velocity",
        center_of_mass_velocity(model, q, v).as_slice(),
    );
    out.add(
        "center_of_mass_jacobian",
        center_of_mass_jacobian(model, q).as_slice(),
    );
    out.add(
        "center_of_mass_acceleration",
        center_of_mass_acceleration(model, q, v, w).as_slice(),
    );
    out.add(
        "centroidal_momentum_rate",
        &centroidal_momentum_rate(model, q, v, w).to_array(),
    );
    for frame in MOMENTUM_FRAMES {
        out.add("momentum", &momentum(model, q, v, frame).to_array());
        out.add(
            "momentum_matrix",
            momentum_matrix(model, q, frame).as_slice(),
        );
        out.add(
            "locked_inertia",
            locked_inertia(model, q, frame).to_matrix().as_slice(),
        );
        if model.n_bodies() > 2 {
            // Two thin rods in a line have no inertia about it.
            out.add(
                "average_velocity",
                &average_velocity(model, q, v, frame).to_array(),
            );
            out.add(
                "average_velocity_jacobian",
                average_velocity_jacobian(model, q, frame).as_slice(),
            );
        }
    }
}

/// [`everything`] as a function of (δq, v, w) at a configuration.
pub(crate) struct EverythingAt<'a> {
    pub(crate) model: &'a Model,
    pub(crate) q: &'a [f64],
}

impl EverythingAt<'_> {
    pub(crate) fn names(&self) -> Vec<&'static str> {
        let zeros = vec![0.0; self.model.nv()];
        everything(self.model, self.q, &zeros, &zeros).names
    }
}

impl VectorFunction for EverythingAt<'_> {
    fn n_outputs(&self) -> usize {
        self.names().len()
    }

    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let nv = self.model.nv();
        let q: Vec<T> = self.q.iter().map(|&q| T::constant(q)).collect();
        let q = self.model.integrate(&q, &x[..nv]);
        y.copy_from_slice(
            &everything(self.model, q.as_slice(), &x[nv..2 * nv], &x[2 * nv..]).numbers,
        );
    }
}
