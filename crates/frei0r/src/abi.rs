//! The structures and numbers of the frei0r interface, version 1.2 (`frei0r.h`).

use std::ffi::{c_char, c_int};

/// `F0R_PLUGIN_TYPE_FILTER`: one picture in, one out.
pub const FILTER: c_int = 0;
/// `F0R_COLOR_MODEL_RGBA8888`: red, green, blue, alpha, one byte each.
pub const RGBA8888: c_int = 1;
/// `FREI0R_MAJOR_VERSION`.
pub const FREI0R_MAJOR_VERSION: c_int = 1;
/// `F0R_PARAM_BOOL`: a double, true from 0.5 on.
pub const BOOL: c_int = 0;
/// `F0R_PARAM_DOUBLE`: a double, 0 to 1.
pub const DOUBLE: c_int = 1;

/// `f0r_plugin_info_t`.
#[repr(C)]
#[derive(Debug)]
pub struct PluginInfo {
    /// The plug-in's name.
    pub name: *const c_char,
    /// Who made it.
    pub author: *const c_char,
    /// [`FILTER`].
    pub plugin_type: c_int,
    /// [`RGBA8888`].
    pub color_model: c_int,
    /// [`FREI0R_MAJOR_VERSION`].
    pub frei0r_version: c_int,
    /// The plug-in's own version.
    pub major_version: c_int,
    /// The plug-in's own version.
    pub minor_version: c_int,
    /// Number of parameters.
    pub num_params: c_int,
    /// What it does, or null.
    pub explanation: *const c_char,
}

/// `f0r_param_info_t`.
#[repr(C)]
#[derive(Debug)]
pub struct ParamInfo {
    /// The parameter's name.
    pub name: *const c_char,
    /// [`BOOL`] or [`DOUBLE`].
    pub kind: c_int,
    /// What it does.
    pub explanation: *const c_char,
}
