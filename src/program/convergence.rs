//! The error after each step of refinement, as figures and as a plot.

use std::fmt::Write as _;

use polyreel::frame::Frame;
use polyreel::metric::mse::psnr;
use polyreel::refine::Refined;

use crate::program::plot::{self, COLOURS, Line, Place};

/// Mean squared errors before the first step and after each, over all channels, 0..65025.
pub(crate) struct Convergence {
    errors: Vec<f64>,
}

impl Convergence {
    /// From the squared errors `seen` before every step, and the result.
    pub(crate) fn new(frame: &Frame, mut seen: Vec<f64>, refined: &Refined) -> Self {
        // If it was stopped, the error was seen once more than there were steps.
        seen.truncate(refined.steps as usize);
        seen.push(refined.error_after);
        // Red, green, blue; in frames that are not opaque alpha is a channel as well.
        let channels = if frame.is_opaque() { 3 } else { 4 };
        let values = (channels * frame.size().pixels()) as f64;
        Self { errors: seen.iter().map(|error| error / values).collect() }
    }

    /// One line for each step; an infinite PSNR is left out.
    pub(crate) fn csv(&self) -> String {
        let mut text = String::from("step,mse,psnr_db\n");
        for (step, &mse) in self.errors.iter().enumerate() {
            let psnr = Some(psnr(mse)).filter(|psnr| psnr.is_finite());
            let psnr = psnr.map_or_else(String::new, |psnr| psnr.to_string());
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{step},{mse},{psnr}");
        }
        text
    }

    /// The plot, a file of its own.
    pub(crate) fn svg(&self) -> String {
        let place =
            |step: usize| Place { label: step.to_string(), name: format!("after step {step}") };
        let places: Vec<_> = (0..self.errors.len()).map(place).collect();
        let line = Line {
            name: "MSE".to_owned(),
            colour: COLOURS[0],
            dashed: false,
            values: self.errors.iter().copied().map(Some).collect(),
        };
        let title = match self.errors.len() {
            1 => "Mean squared error; no step of refinement was done",
            _ => "Mean squared error after each step of refinement",
        };
        plot::file(title, &places, &[line])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use polyreel::geom::Size;

    #[test]
    fn every_step_has_its_error() {
        let frame = Frame::filled(Size::new(10, 10), [1, 2, 3, 255]).expect("a sound size");
        let refined = Refined { steps: 2, error_after: 0.0, ..Refined::default() };
        for seen in [vec![30_000.0, 3000.0], vec![30_000.0, 3000.0, 0.0]] {
            let found = Convergence::new(&frame, seen, &refined);
            let lines: Vec<_> = found.csv().lines().map(str::to_owned).collect();
            assert_eq!(lines.len(), 4, "{lines:?}");
            assert!(lines[1].starts_with("0,100,28.13") && lines[3] == "2,0,", "{lines:?}");
            assert_eq!(found.svg().matches("<circle").count(), 3);
        }
        let none = Convergence::new(&frame, vec![9.0], &Refined::default());
        assert_eq!(none.csv().lines().count(), 2);
        assert!(none.svg().contains("no step"), "{}", none.svg());
    }
}
