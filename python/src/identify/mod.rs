//! System identification.
//!
//! Data and problems are described by Python classes in `dualbody.identify`; the functions here read them.
//!
//! | file | what it is |
//! |---|---|
//! | `data` | experiments, their preparation, data |
//! | `regressor` | regressors, base parameters, motions that excite |
//! | `estimate` | weighted and consistent least squares, the report |
//! | `robot` | identified robots: prediction, validation |
//! | `shooting` | fits through the simulator |

mod data;
mod estimate;
mod regressor;
mod robot;
mod shooting;

pub(crate) use data::{_hold_back, _prepare};
pub(crate) use estimate::{_consistent, _estimate, _identified, _intervals, _report};
pub(crate) use regressor::{_base_parameters, _excite, _excited, _regressor, _regressor_matrix};
pub(crate) use robot::{_predict, _validate};
pub(crate) use shooting::_shoot;
