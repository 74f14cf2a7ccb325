//! A custom sink: takes the finished pictures of any input that polyreel reads.
//!
//! ```sh
//! cargo run --release --example sink -- samples/planet.gif
//! ```

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use polyreel::{Buffers, Origin, Picture, Result, Settings, Sink, SourceOptions, Stop, open, run};

/// Adds up the light of all pictures.
struct Meter(Arc<AtomicU64>);

impl Sink for Meter {
    fn write(&mut self, picture: Picture, _: Option<Origin>) -> Result<Buffers> {
        let bytes = picture.frame.pixels().as_flattened();
        let light: u64 = bytes.iter().map(|&byte| u64::from(byte)).sum();
        self.0.fetch_add(light, Ordering::Relaxed);
        // The next picture is painted in the buffers of this one.
        Ok(picture.frame.into_buffers())
    }

    fn finish(self: Box<Self>) -> Result<()> {
        Ok(())
    }
}

fn main() -> Result<()> {
    let inputs: Vec<_> = std::env::args_os().skip(1).collect();
    let input = open(&inputs, &SourceOptions::default())?;
    let light = Arc::new(AtomicU64::new(0));
    let sink = Box::new(Meter(Arc::clone(&light)));
    let summary =
        run(move || input.start(), sink, &Settings::default(), &mut (), &Stop::default())?;
    println!("{} frames, light {}", summary.frames, light.load(Ordering::Relaxed));
    Ok(())
}
