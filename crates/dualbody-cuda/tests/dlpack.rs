//! Tensors of `DLPack`, which need no GPU as long as their numbers are not read.

#![expect(
    unsafe_code,
    reason = "tensors are made of an address and read as foreign libraries do"
)]

use std::sync::Arc;

use dualbody_cuda::{CudaError, Dlpack, check_dlpack, dlpack_of};

/// Codes of `DLPack`'s header: a device of CUDA, floating-point numbers.
const CUDA: u32 = 2;
const FLOAT: u8 = 2;
/// Where the numbers would be.
const ADDRESS: u64 = 0x7000_0000;
const DEVICE: i32 = 3;
const SHAPE: [usize; 2] = [7, 100];

fn tensor(owner: Arc<()>) -> Dlpack {
    // SAFETY: the numbers are not read.
    let made = unsafe { dlpack_of::<f32, _>(owner, ADDRESS, SHAPE, DEVICE) };
    made.expect("a tensor")
}

#[test]
fn tensors_say_what_they_are_and_their_deleter_frees_the_owner_once() {
    let owner = Arc::new(());
    let raw = tensor(Arc::clone(&owner)).into_raw();
    assert_eq!(Arc::strong_count(&owner), 2);
    // SAFETY: the tensor lives until its deleter is called, and has two sizes and strides.
    unsafe {
        let all = (*raw).dl_tensor;
        let address = (all.data as u64, all.byte_offset);
        let device = (all.device.device_type.0, all.device.device_id);
        let number = (all.dtype.code.0, all.dtype.bits, all.dtype.lanes);
        assert_eq!(((*raw).version.major, all.ndim), (1, 2));
        assert_eq!(address, (ADDRESS, 0));
        assert_eq!(device, (CUDA, DEVICE));
        assert_eq!(number, (FLOAT, 32, 1));
        assert_eq!(std::slice::from_raw_parts(all.shape, 2), [7, 100]);
        assert_eq!(std::slice::from_raw_parts(all.strides, 2), [100, 1]);
        (*raw).deleter.expect("a deleter")(raw);
    }
    assert_eq!(Arc::strong_count(&owner), 1);
    let other = tensor(Arc::clone(&owner));
    assert_eq!(Arc::strong_count(&owner), 2);
    // On any thread.
    std::thread::spawn(|| drop(other)).join().expect("an end");
    assert_eq!(Arc::strong_count(&owner), 1);
}

#[test]
fn numbers_are_of_the_precision_of_the_array() {
    // SAFETY: the numbers are not read.
    let made = unsafe { dlpack_of::<f64, _>((), ADDRESS, SHAPE, DEVICE) };
    let made = made.expect("a tensor");
    check_dlpack::<f64>(&made, SHAPE, DEVICE).expect("the same precision");
    let found = check_dlpack::<f32>(&made, SHAPE, DEVICE);
    refused(found, "has numbers");
}

#[track_caller]
fn refused(found: Result<(), CudaError>, reason: &str) {
    let error = found.expect_err(reason).to_string();
    assert!(error.contains(reason), "{error}");
}

#[test]
fn tensors_that_do_not_fit_are_refused_with_the_reason() {
    let own = tensor(Arc::new(()));
    check_dlpack::<f32>(&own, SHAPE, DEVICE).expect("the same sizes");
    let turned = "the shape [7, 100], not [100, 7]";
    refused(check_dlpack::<f32>(&own, [100, 7], DEVICE), turned);
    refused(check_dlpack::<f64>(&own, SHAPE, DEVICE), "has numbers");
    let elsewhere = "device 3 of kind 2, not on device 0";
    refused(check_dlpack::<f32>(&own, SHAPE, 0), elsewhere);
    // SAFETY: the largest size does not fit into DLPack, so that there is no tensor.
    let too_large = unsafe { dlpack_of::<f32, _>((), ADDRESS, [1, usize::MAX], DEVICE) };
    let error = too_large.map(drop).expect_err("no tensor").to_string();
    assert!(error.contains("too large for DLPack"), "{error}");
}

#[test]
fn tensors_with_gaps_or_columns_are_refused() {
    for strides in [[1, 7], [128, 1]] {
        let raw = tensor(Arc::new(())).into_raw();
        // SAFETY: the tensor is alive, has two strides, and nothing else refers to it.
        let made = unsafe {
            *(*raw).dl_tensor.strides = strides[0];
            *(*raw).dl_tensor.strides.add(1) = strides[1];
            Dlpack::from_raw(raw).expect("a tensor")
        };
        refused(check_dlpack::<f32>(&made, SHAPE, DEVICE), "has gaps");
    }
}
