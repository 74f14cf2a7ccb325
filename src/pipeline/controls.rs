//! Options that can change while the pipeline runs.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, PoisonError, RwLock};

use crate::error::Result;
use crate::options::Options;

/// The options of a run, which can change while it runs. Clones are the same controls.
#[derive(Clone, Debug, Default)]
pub struct Controls {
    options: Arc<RwLock<Arc<Options>>>,
    full_detail: Arc<AtomicBool>,
}

impl Controls {
    /// Controls with the initial `options`.
    ///
    /// # Errors
    /// When an option is out of range.
    pub fn new(options: Options) -> Result<Self> {
        options.validate()?;
        Ok(Self { options: Arc::new(RwLock::new(Arc::new(options))), ..Self::default() })
    }

    /// The current options: the same `Arc` until they change.
    pub fn options(&self) -> Arc<Options> {
        // No code panics while it holds the lock, and an Arc is always complete.
        self.options.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Changes the options for all frames that are admitted from now on.
    ///
    /// # Errors
    /// When an option is out of range; nothing is changed then.
    pub fn set(&self, options: Options) -> Result<()> {
        options.validate()?;
        let mut current = self.options.write().unwrap_or_else(PoisonError::into_inner);
        if **current != options {
            *current = Arc::new(options);
        }
        Ok(())
    }

    /// Whether frames that are admitted from now on have full detail, whatever the budget. At first they do not.
    pub fn set_full_detail(&self, full: bool) {
        self.full_detail.store(full, Ordering::Relaxed);
    }

    /// See [`Controls::set_full_detail`].
    pub(super) fn is_full_detail(&self) -> bool {
        self.full_detail.load(Ordering::Relaxed)
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
