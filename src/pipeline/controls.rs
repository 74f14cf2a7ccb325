//! Options that can change while the pipeline runs.

use std::sync::{Arc, PoisonError, RwLock};

use crate::error::Result;
use crate::options::Options;

/// The options of a run, which can change while it runs. Clones are the same controls.
#[derive(Clone, Debug, Default)]
pub struct Controls(Arc<RwLock<Arc<Options>>>);

impl Controls {
    /// Controls with the initial `options`.
    ///
    /// # Errors
    /// When an option is out of range.
    pub fn new(options: Options) -> Result<Self> {
        options.validate()?;
        Ok(Self(Arc::new(RwLock::new(Arc::new(options)))))
    }

    /// The current options: the same `Arc` until they change.
    pub fn options(&self) -> Arc<Options> {
        // No code panics while it holds the lock, and an Arc is always complete.
        self.0.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Changes the options for all frames that are admitted from now on.
    ///
    /// # Errors
    /// When an option is out of range; nothing is changed then.
    pub fn set(&self, options: Options) -> Result<()> {
        options.validate()?;
        let mut current = self.0.write().unwrap_or_else(PoisonError::into_inner);
        if **current != options {
            *current = Arc::new(options);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::Points;

    #[test]
    fn clones_are_the_same_controls() {
        let controls = Controls::new(Options::default()).expect("sound options");
        let before = controls.options();
        controls.clone().set(Options { seed: 4, ..Options::default() }).expect("sound options");
        assert_eq!(before.seed, 0, "what was handed out stays as it is");
        assert_eq!(controls.options().seed, 4);
    }

    #[test]
    fn what_is_out_of_range_changes_nothing() {
        let wrong = Options { points: Points::Count(0), ..Options::default() };
        Controls::new(wrong.clone()).expect_err("no points");
        let controls = Controls::default();
        let before = controls.options();
        controls.set(wrong).expect_err("no points");
        controls.set(Options::default()).expect("sound options");
        assert!(Arc::ptr_eq(&before, &controls.options()), "nothing was changed");
    }
}
