//! A fixed clip through the whole chain on one thread, for counting instructions: see
//! `.ci/count-instructions`. The clip is painted before `count_this` is entered.

mod chain;
mod film;

use std::hint::black_box;

use chain::Chain;
use polyreel::frame::Frame;
use polyreel::geom::Size;
use polyreel::options::Options;

/// Frames of the clip. The first is fresh, the others are carried.
const FRAMES: u64 = 8;

fn main() {
    let clip = film::shot(Size::new(320, 180), FRAMES);
    let options = Options { refine: Some(1), ..Options::default() };
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    // Counting is turned on for a thread: that one does all the work.
    one.install(|| count_this(&clip, &options));
}

/// What is counted.
#[inline(never)]
fn count_this(clip: &[Frame], options: &Options) {
    let mut chain = Chain::new(options, Some(film::form(clip[0].size())));
    for frame in clip {
        let picture = black_box(chain.render(frame, |_| ()));
        chain.recycle(picture);
    }
}
