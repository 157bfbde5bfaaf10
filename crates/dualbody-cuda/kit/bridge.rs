//! Arrays of the GPU for `dlpack.py` beside this, by functions of C.

#![expect(
    unsafe_code,
    reason = "functions of C, and tensors that foreign libraries own"
)]

use dualbody_cuda::{CudaError, Device, Dlpack, Numbers, Real};

/// A tensor of numbers ½, 1½, … on the first GPU, which its deleter frees; null, with the reason on stderr, if that fails.
///
/// * `bits` – 32 or 64, of a number
#[unsafe(no_mangle)]
pub extern "C" fn kit_give(rows: usize, count: usize, bits: i32) -> *mut std::ffi::c_void {
    let made = match bits {
        32 => given::<f32>(rows, count).and_then(Numbers::into_dlpack),
        _ => given::<f64>(rows, count).and_then(Numbers::into_dlpack),
    };
    match made {
        Ok(tensor) => tensor.into_raw().cast(),
        Err(error) => {
            eprintln!("{error}");
            std::ptr::null_mut()
        }
    }
}

/// Copies a tensor of the first GPU, calls its deleter, and gives the sum of its numbers; NaN, with the reason on stderr, if that fails.
///
/// # Safety
/// The tensor must be one of `DLPack`, version 1, whose deleter nothing else calls.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn kit_take(
    tensor: *mut std::ffi::c_void,
    rows: usize,
    count: usize,
    bits: i32,
) -> f64 {
    // SAFETY: guaranteed by the caller.
    let tensor = unsafe { Dlpack::from_raw(tensor.cast()) };
    let Ok(tensor) = tensor else {
        return f64::NAN;
    };
    let found = match bits {
        32 => {
            given::<f32>(rows, count).and_then(|own| sum_of(own, |a| a.copy_from_dlpack(&tensor)))
        }
        _ => given::<f64>(rows, count).and_then(|own| sum_of(own, |a| a.copy_from_dlpack(&tensor))),
    };
    found.unwrap_or_else(|error| {
        eprintln!("{error}");
        f64::NAN
    })
}

fn given<R: Real>(rows: usize, count: usize) -> Result<Numbers<R>, CudaError> {
    let mut out = Numbers::zeros(&Device::new(0)?, rows, count)?;
    let numbers: Vec<R> = (0..rows * count)
        .map(|k| R::from_f64(k as f64 + 0.5))
        .collect();
    out.upload(&numbers)?;
    Ok(out)
}

fn sum_of<R: Real>(
    mut own: Numbers<R>,
    copy: impl FnOnce(&mut Numbers<R>) -> Result<(), CudaError>,
) -> Result<f64, CudaError> {
    copy(&mut own)?;
    Ok(own.download()?.iter().map(|x| x.to_f64()).sum())
}
