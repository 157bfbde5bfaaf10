//! Tests of the coordinates of other engines against numbers that these engines gave.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{DMatrix, DVector};

use super::{Engine, EngineCoordinates};
use crate::dynamics::{frame_jacobian, inverse_dynamics, mass_matrix};
use crate::model::Model;
use crate::spatial::Representation;

/// The numbers of a table, row by row; a triangle is one of a symmetric matrix.
fn table(text: &str) -> DMatrix<f64> {
    let row = |line: &str| -> Vec<f64> {
        let words = line.split_whitespace();
        words.map(|word| word.parse().unwrap()).collect()
    };
    let rows: Vec<Vec<f64>> = text.trim().lines().map(row).collect();
    let n = rows.iter().map(Vec::len).max().unwrap();
    let at = |i: usize, k: usize| rows[i].get(k).copied();
    DMatrix::from_fn(rows.len(), n, |i, k| at(i, k).unwrap_or_else(|| rows[k][i]))
}

/// A robot in an engine at a state: its quantities in the engine's coordinates.
struct At<'a> {
    model: &'a Model,
    theirs: EngineCoordinates<'a>,
    q: DVector<f64>,
    v: DVector<f64>,
}

impl<'a> At<'a> {
    fn new(model: &'a Model, engine: Engine, names: &[&str], q: &[f64], v: &[f64]) -> Self {
        let theirs = EngineCoordinates::new(model, engine);
        let theirs = theirs.with_joint_order(names).unwrap();
        let state = theirs.state_from(q, v);
        Self {
            model,
            theirs,
            q: state.q,
            v: state.v,
        }
    }

    fn mass_matrix(&self) -> DMatrix<f64> {
        let q = self.q.as_slice();
        let T = self.theirs.tangent_map(q);
        &T * mass_matrix(self.model, q) * T.transpose()
    }

    fn jacobian(&self, frame: &str) -> DMatrix<f64> {
        let (q, frame) = (self.q.as_slice(), self.model.find_frame(frame).unwrap());
        let J = frame_jacobian(self.model, q, frame, Representation::Mixed);
        J * self.theirs.tangent_map(q).transpose()
    }

    /// Forces for an acceleration.
    fn forces(&self, a: &[f64]) -> DVector<f64> {
        let (q, v) = (self.q.as_slice(), self.v.as_slice());
        let a = self.theirs.acceleration_from(q, v, a);
        let tau = inverse_dynamics(self.model, q, v, a.as_slice());
        self.theirs.tangent_to(q, tau.as_slice())
    }
}

#[track_caller]
fn assert_close(found: &DMatrix<f64>, expected: &DMatrix<f64>) {
    let error = (found - expected).amax();
    assert!(error < 1e-8, "{error:e}: {found} {expected}");
}

const TWO_BRANCHES: &str = "<robot name='two'>
<link name='torso'><inertial><origin xyz='0.1 0 0'/><mass value='3'/><inertia ixx='0.1' ixy='0' ixz='0' iyy='0.2' iyz='0' izz='0.25'/></inertial></link>
<link name='b'><inertial><origin xyz='0 0.2 0'/><mass value='1'/><inertia ixx='0.1' ixy='0' ixz='0' iyy='0.2' iyz='0' izz='0.25'/></inertial></link>
<link name='a'><inertial><origin xyz='0 0 0.3'/><mass value='2'/><inertia ixx='0.1' ixy='0' ixz='0' iyy='0.2' iyz='0' izz='0.25'/></inertial></link>
<joint name='zeta' type='continuous'><parent link='torso'/><child link='b'/><origin xyz='0 0.5 0'/><axis xyz='1 0 0'/></joint>
<joint name='alpha' type='prismatic'><parent link='torso'/><child link='a'/><origin xyz='0 -0.5 0'/><axis xyz='0 1 0'/><limit lower='-1' upper='1' effort='1' velocity='1'/></joint></robot>";

// Made with Pinocchio 4.1: buildModelFromXML(TWO_BRANCHES, JointModelFreeFlyer()), rnea and crba at the numbers below, in its own order.
#[test]
fn forces_and_mass_matrix_equal_those_of_pinocchio_in_its_order() {
    let names = ["universe", "root_joint", "alpha", "zeta"];
    let q = [
        0.1,
        0.2,
        0.3,
        0.0,
        0.6,
        0.0,
        0.8,
        0.2,
        0.7_f64.cos(),
        0.7_f64.sin(),
    ];
    let v = [0.1, -0.2, 0.3, 0.4, -0.5, 0.6, -0.3, 0.9];
    let a = [1.0, 2.0, 3.0, -1.0, -2.0, -3.0, 0.5, -0.7];
    let tau = [
        -51.28157357,
        12.01879566,
        33.82090666,
        -2.78353447,
        -9.58578077,
        -2.90439028,
        5.612,
        0.3208922,
    ];
    let alpha = [0.0, 2.0, 0.0, -0.6, 0.0, 0.0, 2.0, 0.0];
    let zeta = [
        0.0,
        -0.12884354,
        0.15296844,
        0.21648422,
        0.0,
        0.0,
        0.0,
        0.14,
    ];
    let model = Model::from_urdf_str(TWO_BRANCHES).unwrap();
    let at = At::new(&model, Engine::Pinocchio, &names, &q, &v);
    let error = at.forces(&a) - DVector::from_column_slice(&tau);
    assert!(error.amax() < 1e-8, "{error}");
    let M = at.mass_matrix();
    for (row, expected) in [(6, alpha), (7, zeta)] {
        let error = M.row(row).transpose() - DVector::from_column_slice(&expected);
        assert!(error.amax() < 1e-8, "{error}");
    }
}

// Made with JaxSim 0.9.0 (jax 0.10.2, 64 bits) of the same robot as SDF, in the mixed representation: free_floating_mass_matrix, link.jacobian
// of `b`, inverse_dynamics at the numbers below. It sorts joints by name.
#[test]
fn quantities_equal_those_of_jaxsim_in_its_order() {
    let q = [0.1, 0.2, 0.3, 0.7, 0.1, -0.5, 0.5, 0.2, 0.7];
    let v = [0.1, -0.2, 0.3, 0.4, -0.5, 0.6, -0.3, 0.9];
    let a = [1.0, 2.0, 3.0, -1.0, -2.0, -3.0, 0.5, -0.7];
    let tau = "4.105273547 14.998535163 75.586235568 -5.807182022 3.798857702 -4.192393215 -5.8138464 0.313111869";
    let M = "
6
0 6
0 0 6
0 -0.57077626 -0.261035014 1.102310725
0.57077626 0 0.479680872 0.214970135 1.107889573
0.261035014 -0.479680872 0 -0.161227601 -0.003690852 1.105736576
-1.6 0.96 -0.72 0 -0.36 -0.48 2
0.011293767 -0.159744698 0.119808523 0 0.129890531 0.173187375 0 0.14";
    let J = "
1 0 0 0 -0.18 -0.24 0 0
0 1 0 0.18 0 -0.4 0 0
0 0 1 0.24 0.4 0 0 0
0 0 0 1 0 0 0 0
0 0 0 0 1 0 0 0.6
0 0 0 0 0 1 0 0.8";
    let model = Model::from_urdf_str(TWO_BRANCHES).unwrap();
    let at = At::new(&model, Engine::JaxSim, &["alpha", "zeta"], &q, &v);
    assert_close(&at.mass_matrix(), &table(M));
    assert_close(&at.jacobian("b"), &table(J));
    let forces = DMatrix::from_row_slice(1, 8, at.forces(&a).as_slice());
    assert_close(&forces, &table(tau));
}

/// Joints of the quadruped as `MuJoCo` lists them.
const LEGS: [&str; 13] = [
    "floating_base",
    "FR_hip_joint",
    "FR_thigh_joint",
    "FR_calf_joint",
    "FL_hip_joint",
    "FL_thigh_joint",
    "FL_calf_joint",
    "RR_hip_joint",
    "RR_thigh_joint",
    "RR_calf_joint",
    "RL_hip_joint",
    "RL_thigh_joint",
    "RL_calf_joint",
];

// Made with MuJoCo 4.0.0 of assets/quadruped.urdf as `to_mjcf` writes it: mj_fullM, mj_jacBody of `FL_calf` (position above rotation) and mj_rne with
// accelerations, at the numbers below, in its own order.
#[test]
fn quantities_of_a_quadruped_equal_those_of_mujoco() {
    let q = "0.1 -0.2 0.5 0.7 0.1 -0.5 0.5 0.1 0.8 -1.6 -0.2 0.7 -1.5 0.3 0.9 -1.4 -0.1 0.6 -1.7";
    let v = "0.3 -0.4 0.5 0.6 -0.7 0.8 1 -1.1 1.2 -1.3 1.4 -1.5 0.9 -0.8 0.7 -0.6 0.5 -0.4";
    let a = "1 -2 3 -4 5 -6 0.5 -0.25 0.75 1 -1 2 -2 3 -3 0.1 0.2 -0.3";
    let tau = "12.71850653 -28.98218897 175.7915342 -2.440280797 -0.3348334283 -1.799302445 -1.047508716 -0.2082397716 -0.3107086675 -0.3429457263 -0.4921406634 -0.2398160446 -0.9973553662 -0.006071742325 -0.3363834631 0.05138392613 -0.4874590435 -0.2695556429";
    let M = "
13.741
0 13.741
0 0 13.741
-0.2877413847 0.1406888999 -0.1055166749 0.1552450509
-0.0722569473 -0.2784999467 -0.2107622683 0.002150057967 0.3844940356
0.09634259641 -0.07697911641 0.01778942363 -0.01384131182 0.002048764731 0.3784709928
-0.01633268015 0.08421429234 -0.06316071926 0.02696782851 0.01152092697 0.01042261643 0.02347033835
-0.01676863049 -0.06326593034 -0.03809874023 -0.003758806996 0.01612063457 -0.006995368019 -0.002242400012 0.02151574057
0.01144958471 0.003151641025 -0.02738119529 0.00289076364 0.01106615946 -0.001515928945 0.001855364223 0.006957103957 0.007344838234
-0.1099408228 0.0005657590905 -0.0004243193179 0.028474849 -0.01046975119 0.01324768018 0 0 0 0.02540110847
-0.02040660449 -0.05871695922 -0.04801749949 0.003111732358 0.01856779766 0.005574452015 0 0 0 0.001853334767 0.02270893014
0.01653832284 -0.0002323257822 -0.02484322019 -0.002875219615 0.01165300876 0.0002897573852 0 0 0 -0.001855364223 0.007553698737 0.007344838234
-0.03688254186 0.0799288781 -0.05994665858 0.02766980893 -0.01171567635 -0.02274940658 0 0 0 0 0 0 0.02495323934
-0.01478191634 -0.07410054909 -0.02992223824 -0.005139775561 0.03199936746 0.001015581206 0 0 0 0 0 0 -0.003169026698 0.02389794597
0.005131598815 -0.003920317343 -0.02913852248 0.001961012283 0.005792374422 -0.001665472246 0 0 0 0 0 0 0.001276859275 0.008148206653 0.007344838234
-0.1074253399 -0.009716029662 0.007287022247 0.02620539617 0.01436484153 -0.01470110186 0 0 0 0 0 0 0 0 0 0.02271934819
-0.01136607924 -0.05241486791 -0.04928524825 0.001799730101 0.02379231191 0.006458132702 0 0 0 0 0 0 0 0 0 0.001014442641 0.02033029924
0.01832017666 0.008392438916 -0.02201576215 -0.003533884149 0.001576793487 0.001492175559 0 0 0 0 0 0 0 0 0 -0.002268135011 0.006364383289 0.007344838234";
    let J = "
1 0 0 -0.1924978596 0.03099387753 -0.04132517004 0 0 0 -0.1642978596 -0.09624295438 0 0 0 0 0 0 0
0 1 0 0.01675927365 -0.06688050973 -0.03444856325 0 0 0 0.04683927365 -0.1603105347 0 0 0 0 0 0 0
0 0 1 -0.01256945524 -0.1580492964 -0.09758788022 0 0 0 -0.03512945524 -0.07097764582 0 0 0 0 0 0 0
0 0 0 0 -0.8 -0.6 0 0 0 0 -0.6648516638 -0.6648516638 0 0 0 0 0 0
0 0 0 0.6 0.48 -0.64 0 0 0 0.6 0.5975803291 0.5975803291 0 0 0 0 0 0
0 0 0 0.8 -0.36 0.48 0 0 0 0.8 -0.4481852468 -0.4481852468 0 0 0 0 0 0";
    let model = Model::from_urdf_file("assets/quadruped.urdf").unwrap();
    let [q, v, a] = [q, v, a].map(table);
    let at = At::new(&model, Engine::MuJoCo, &LEGS, q.as_slice(), v.as_slice());
    let (nq, nv) = at
        .theirs
        .state_to(&crate::State::new(at.q.as_slice(), at.v.as_slice()));
    assert!((nq.transpose() - &q).amax() < 1e-15 && (nv.transpose() - &v).amax() < 1e-15);
    assert_close(&at.mass_matrix(), &table(M));
    assert_close(&at.jacobian("FL_calf"), &table(J));
    let forces = DMatrix::from_row_slice(1, 18, at.forces(a.as_slice()).as_slice());
    // Ten digits of the weight.
    assert!((&forces - table(tau)).amax() < 1e-7, "{forces}");
}
