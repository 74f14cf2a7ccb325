//! polyreel as a frei0r plug-in, for ffmpeg, MLT (melt, Kdenlive, Shotcut) and GStreamer.
//!
//! The functions are those of `frei0r.h` 1.2. Wrong use by a host gives the input picture back: no error here ends
//! the host.

pub mod abi;
pub mod parameters;
mod shared;
mod stream;

use std::ffi::{c_int, c_uint, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};

use std::sync::Arc;

use polyreel_core::{Rgba, Size};

use abi::{ParamInfo, PluginInfo};
use parameters::{COUNT, Kind, PARAMETERS, Values};
use shared::Shared;

/// The instance that [`f0r_construct`] returns. It is cheap: renderer and threads are made with the first frame.
#[derive(Debug)]
pub struct Instance {
    size: Size,
    values: Values,
    stream: Option<Arc<Shared>>,
}

impl Instance {
    /// Renders `input` into `output`; where that fails, copies it and says why on standard error.
    fn update(&mut self, time: f64, input: &[Rgba], output: &mut [Rgba]) {
        let outcome = catch_unwind(AssertUnwindSafe(|| self.render(time, input, output)));
        let why = match outcome {
            Ok(Ok(())) => return,
            Ok(Err(error)) => error.to_string(),
            Err(_) => "a fault of polyreel's own (see above)".into(),
        };
        // The mesh may be inconsistent after a panic.
        self.stream = None;
        output.copy_from_slice(input);
        // A host may have closed standard error.
        let _ = std::io::Write::write_fmt(
            &mut std::io::stderr(),
            format_args!("polyreel: the frame at {time} is passed through as it is: {why}\n"),
        );
    }

    fn render(
        &mut self,
        time: f64,
        input: &[Rgba],
        output: &mut [Rgba],
    ) -> polyreel_core::Result<()> {
        let options = self.values.options();
        let size = self.size;
        let stream =
            self.stream.get_or_insert_with(|| Shared::find(size, time, shared::is_in_mlt()));
        stream.in_turn(time, |stream| stream.render(size, &options, time, input, output))
    }
}

/// Called once when the plug-in is loaded. Returns 1: success.
#[unsafe(no_mangle)]
pub extern "C" fn f0r_init() -> c_int {
    1
}

/// Called once before the plug-in is unloaded.
#[unsafe(no_mangle)]
pub extern "C" fn f0r_deinit() {}

/// Writes the description of the plug-in.
///
/// # Safety
/// `info` points to memory for a [`PluginInfo`], or is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn f0r_get_plugin_info(info: *mut PluginInfo) {
    if info.is_null() {
        return;
    }
    let plugin = PluginInfo {
        name: c"polyreel".as_ptr(),
        author: c"the polyreel developers".as_ptr(),
        plugin_type: abi::FILTER,
        color_model: abi::RGBA8888,
        frei0r_version: abi::FREI0R_MAJOR_VERSION,
        major_version: 0,
        minor_version: 2,
        num_params: COUNT as c_int,
        explanation: c"Low-poly art, coherent from frame to frame".as_ptr(),
    };
    // SAFETY: the caller gives memory for it.
    unsafe { info.write(plugin) };
}

/// Writes the description of parameter `index`.
///
/// # Safety
/// `info` points to memory for a [`ParamInfo`], or is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn f0r_get_param_info(info: *mut ParamInfo, index: c_int) {
    let parameter = usize::try_from(index).ok().and_then(|index| PARAMETERS.get(index));
    let Some(parameter) = parameter.filter(|_| !info.is_null()) else { return };
    let kind = match parameter.kind {
        Kind::Switch => abi::BOOL,
        Kind::Number => abi::DOUBLE,
    };
    let (name, explanation) = (parameter.name.as_ptr(), parameter.explanation.as_ptr());
    // SAFETY: the caller gives memory for it.
    unsafe { info.write(ParamInfo { name, kind, explanation }) };
}

/// Makes an instance for frames of `width` x `height`, any size.
#[unsafe(no_mangle)]
pub extern "C" fn f0r_construct(width: c_uint, height: c_uint) -> *mut c_void {
    let instance =
        Instance { size: Size::new(width, height), values: Values::default(), stream: None };
    Box::into_raw(Box::new(instance)).cast()
}

/// Ends an instance.
///
/// # Safety
/// `instance` came from [`f0r_construct`] and is not used again, or is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn f0r_destruct(instance: *mut c_void) {
    if !instance.is_null() {
        // SAFETY: it was made by `Box::into_raw` of this type.
        let instance = unsafe { Box::from_raw(instance.cast::<Instance>()) };
        let _ = catch_unwind(AssertUnwindSafe(|| drop(instance)));
    }
}

/// Sets parameter `index` to the double at `value`.
///
/// # Safety
/// `instance` came from [`f0r_construct`] and no other thread uses it now; `value` points to a double.
/// Either may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn f0r_set_param_value(
    instance: *mut c_void,
    value: *const c_void,
    index: c_int,
) {
    // SAFETY: the caller owns the instance for the time of the call.
    let instance = unsafe { instance.cast::<Instance>().as_mut() };
    // SAFETY: both kinds of parameter are doubles.
    let value = unsafe { value.cast::<f64>().as_ref() };
    if let (Some(instance), Some(&value), Ok(index)) = (instance, value, usize::try_from(index)) {
        instance.values.set(index, value);
    }
}

/// Writes parameter `index` to the double at `value`.
///
/// # Safety
/// As [`f0r_set_param_value`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn f0r_get_param_value(
    instance: *mut c_void,
    value: *mut c_void,
    index: c_int,
) {
    // SAFETY: the caller owns the instance for the time of the call.
    let instance = unsafe { instance.cast::<Instance>().as_ref() };
    // SAFETY: both kinds of parameter are doubles.
    let value = unsafe { value.cast::<f64>().as_mut() };
    if let (Some(instance), Some(value), Ok(index)) = (instance, value, usize::try_from(index))
        && let Some(set) = instance.values.get(index)
    {
        *value = set;
    }
}

/// Renders the picture at `input` into the one at `output`; both hold width x height pixels of four bytes.
///
/// # Safety
/// `instance` came from [`f0r_construct`] and no other thread uses it now; the pictures have its size and
/// do not overlap.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn f0r_update(
    instance: *mut c_void,
    time: f64,
    input: *const u32,
    output: *mut u32,
) {
    // SAFETY: the caller owns the instance for the time of the call.
    let instance = unsafe { instance.cast::<Instance>().as_mut() };
    let Some(instance) = instance.filter(|_| !input.is_null() && !output.is_null()) else { return };
    let pixels = instance.size.pixels();
    // SAFETY: the host gives this many pixels of four bytes each.
    let input = unsafe { std::slice::from_raw_parts(input.cast::<Rgba>(), pixels) };
    // SAFETY: as above, and nothing else looks at the output now.
    let output = unsafe { std::slice::from_raw_parts_mut(output.cast::<Rgba>(), pixels) };
    instance.update(time, input, output);
}

/// As [`f0r_update`]; a filter has one input, and the others are ignored.
///
/// # Safety
/// As [`f0r_update`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn f0r_update2(
    instance: *mut c_void,
    time: f64,
    first: *const u32,
    _second: *const u32,
    _third: *const u32,
    output: *mut u32,
) {
    // SAFETY: what holds for `f0r_update` holds here.
    unsafe { f0r_update(instance, time, first, output) };
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ptr;

    fn update(instance: *mut c_void, size: usize) -> Vec<u32> {
        let (input, mut output) = (vec![0xff40_80c0; size], vec![0; size]);
        // SAFETY: both pictures have as many pixels as the instance.
        unsafe { f0r_update(instance, 0.0, input.as_ptr(), output.as_mut_ptr()) };
        output
    }

    #[test]
    fn a_host_gets_a_picture_of_any_size() {
        for (width, height) in [(1, 1), (7, 3), (64, 48), (333, 17)] {
            let instance = f0r_construct(width, height);
            let output = update(instance, (width * height) as usize);
            assert!(output.iter().all(|&pixel| pixel == 0xff40_80c0), "{width}x{height}");
            // SAFETY: it is not used again.
            unsafe { f0r_destruct(instance) };
        }
    }

    #[test]
    fn what_cannot_be_rendered_is_passed_through() {
        // Wider than any frame may be.
        let width = polyreel_core::MAX_SIDE + 1;
        let instance = f0r_construct(width, 1);
        assert!(update(instance, width as usize).iter().all(|&pixel| pixel == 0xff40_80c0));
        // SAFETY: it is not used again.
        unsafe { f0r_destruct(instance) };
    }

    #[test]
    fn a_host_may_hand_over_nothing() {
        // SAFETY: null is allowed everywhere.
        unsafe {
            f0r_destruct(ptr::null_mut());
            f0r_get_plugin_info(ptr::null_mut());
            f0r_get_param_info(ptr::null_mut(), 0);
            f0r_set_param_value(ptr::null_mut(), ptr::null(), 0);
            f0r_update(ptr::null_mut(), 0.0, ptr::null(), ptr::null_mut());
        }
    }

    fn get(instance: *mut c_void, index: c_int) -> f64 {
        let mut value = 0.0_f64;
        // SAFETY: the instance is ours and the value a double.
        unsafe { f0r_get_param_value(instance, (&raw mut value).cast(), index) };
        value
    }

    #[test]
    fn parameters_come_back_as_they_were_set() {
        let instance = f0r_construct(8, 8);
        for (parameter, index) in PARAMETERS.iter().zip(0..) {
            assert_eq!(get(instance, index), parameter.default);
            let value = 0.75_f64;
            // SAFETY: the instance is ours and the value a double.
            unsafe { f0r_set_param_value(instance, (&raw const value).cast(), index) };
            assert_eq!(get(instance, index), value);
        }
        // SAFETY: it is not used again.
        unsafe { f0r_destruct(instance) };
    }
}
