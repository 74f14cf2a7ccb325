//! Files of pictures, in and out, through real encoders and decoders.

mod again;
mod animations;
mod broken;
mod formats;
mod gif_in;
mod gif_out;
pub(crate) mod given;
mod outputs;
mod sequences;
mod stills;
