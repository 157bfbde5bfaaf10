//! One call of XLA.

use std::borrow::Cow;
use std::ffi::{CString, c_int, c_void};

use super::abi::{
    Api, Attributes, Buffer, Buffers, CallFrame, EXECUTE, ErrorArguments, F32, F64,
    INVALID_ARGUMENT, METADATA, MetadataExtension, STRING, Text, VERSION,
};

/// A call that is to be executed.
pub(super) struct Frame<'a> {
    api: &'a Api,
    arguments: &'a Buffers,
    results: &'a Buffers,
    attributes: &'a Attributes,
}

impl<'a> Frame<'a> {
    /// The call of a frame; `None` if XLA only asks for the version, which is answered, or goes through another stage than the execution.
    ///
    /// # Safety
    /// The frame is one of XLA's, which stays for `'a`.
    pub(super) unsafe fn open(frame: *mut CallFrame) -> Option<Self> {
        // SAFETY: the caller promises a frame; its extensions are as `abi` has them.
        unsafe {
            let frame = &*frame;
            if let Some(extension) = frame.extension.as_ref()
                && extension.kind == METADATA
            {
                let asked = frame.extension.cast::<MetadataExtension>();
                let version = &raw mut (*(*asked).metadata).version;
                ((*version).major, (*version).minor) = VERSION;
                return None;
            }
            let api = frame.api.as_ref()?;
            (frame.stage == EXECUTE).then_some(Self {
                api,
                arguments: &frame.arguments,
                results: &frame.results,
                attributes: &frame.attributes,
            })
        }
    }

    /// An error for XLA, which frees it.
    pub(super) fn error(&self, text: &str) -> *mut c_void {
        let text = CString::new(text.replace('\0', " ")).unwrap_or_default();
        let mut arguments = ErrorArguments {
            struct_size: size_of::<ErrorArguments>(),
            extension: std::ptr::null_mut(),
            message: text.as_ptr(),
            code: INVALID_ARGUMENT,
        };
        // SAFETY: the function is XLA's, and copies the text.
        unsafe { (self.api.create_error)(&raw mut arguments) }
    }

    /// The text of an attribute.
    pub(super) fn text(&self, name: &str) -> Result<&'a str, String> {
        let all = self.attributes;
        // SAFETY: XLA has as many kinds, names and values as it says; those of the kind of texts are texts.
        let found = unsafe {
            let names = slice(all.names, all.count);
            let at = names.iter().position(|own| bytes(*own) == name.as_bytes());
            at.filter(|&at| *all.kinds.add(at) == STRING)
                .map(|at| bytes((*all.values.add(at)).cast::<Text>()))
        };
        let found = found.and_then(|bytes| std::str::from_utf8(bytes).ok());
        found.ok_or_else(|| format!("the attribute {name} is missing"))
    }

    /// The numbers of all arguments; those of single precision are converted.
    pub(super) fn arguments(&self) -> Result<Vec<Cow<'a, [f64]>>, String> {
        // SAFETY: XLA has the numbers that types and shapes state, and nothing writes to them during the call.
        let one = |buffer: &'a Buffer| unsafe {
            match buffer.kind {
                F64 => Ok(Cow::Borrowed(slice(
                    buffer.data.cast::<f64>(),
                    count(buffer),
                ))),
                F32 => {
                    let numbers = slice(buffer.data.cast::<f32>(), count(buffer));
                    Ok(Cow::Owned(numbers.iter().map(|&x| x.into()).collect()))
                }
                other => Err(no_type(other)),
            }
        };
        buffers(self.arguments)?.into_iter().map(one).collect()
    }

    /// Fills all results; in single precision the numbers are rounded.
    pub(super) fn fill(
        &self,
        fill: impl FnOnce(&mut [&mut [f64]]) -> Result<(), String>,
    ) -> Result<(), String> {
        let all = buffers(self.results)?;
        if let Some(other) = all.iter().find(|buffer| !matches!(buffer.kind, F64 | F32)) {
            return Err(no_type(other.kind));
        }
        let rounded = |buffer: &&&Buffer| buffer.kind == F32;
        let numbers = |buffer: &&Buffer| vec![0.0; usize::try_from(count(buffer)).unwrap_or(0)];
        let mut wide: Vec<Vec<f64>> = all.iter().filter(rounded).map(numbers).collect();
        let mut next = wide.iter_mut();
        let of = |buffer: &&'a Buffer| match buffer.kind {
            F32 => next.next().map_or(&mut [][..], Vec::as_mut_slice),
            // SAFETY: XLA has memory for the numbers that type and shape say, of which this call is the only user.
            _ => unsafe { slice_mut(buffer.data.cast::<f64>(), count(buffer)) },
        };
        let mut out: Vec<&mut [f64]> = all.iter().map(of).collect();
        fill(&mut out)?;
        for (buffer, wide) in all.iter().filter(rounded).zip(&wide) {
            // SAFETY: as above.
            let out = unsafe { slice_mut(buffer.data.cast::<f32>(), count(buffer)) };
            out.iter_mut()
                .zip(wide)
                .for_each(|(out, &x)| *out = x as f32);
        }
        Ok(())
    }
}

/// Number of numbers of an array.
fn count(buffer: &Buffer) -> i64 {
    // SAFETY: XLA has as many lengths as it says.
    unsafe { slice(buffer.lengths, buffer.rank) }
        .iter()
        .product()
}

fn no_type(kind: c_int) -> String {
    format!("the numbers are of XLA's type {kind}, not of single or double precision")
}

fn buffers(all: &Buffers) -> Result<Vec<&Buffer>, String> {
    // SAFETY: XLA has as many buffers as it says.
    let found = unsafe { slice(all.buffers, all.count).iter().map(|b| b.as_ref()) };
    found
        .collect::<Option<_>>()
        .ok_or_else(|| "an array is missing".to_owned())
}

/// # Safety
/// There are so many items, or none.
unsafe fn slice<'a, T>(start: *const T, count: i64) -> &'a [T] {
    match usize::try_from(count) {
        Ok(count) if count > 0 && !start.is_null() => {
            // SAFETY: as the caller promises.
            unsafe { std::slice::from_raw_parts(start, count) }
        }
        _ => &[],
    }
}

/// # Safety
/// There are so many items, or none, and nothing else uses them.
unsafe fn slice_mut<'a, T>(start: *mut T, count: i64) -> &'a mut [T] {
    match usize::try_from(count) {
        Ok(count) if count > 0 && !start.is_null() => {
            // SAFETY: as the caller promises.
            unsafe { std::slice::from_raw_parts_mut(start, count) }
        }
        _ => &mut [],
    }
}

/// # Safety
/// The text is one of XLA's.
unsafe fn bytes<'a>(text: *const Text) -> &'a [u8] {
    // SAFETY: as the caller promises; a text has the bytes that it says.
    unsafe {
        text.as_ref().map_or(&[], |text| {
            slice(text.start, i64::try_from(text.length).unwrap_or(0))
        })
    }
}
