//! The rule that no flag is accepted and ignored: what does nothing beside the other flags, or in this scene, is wrong usage.

use crate::failure::Failure;

/// A flag, and what it needs to do anything.
pub(crate) struct Need {
    pub(crate) flag: &'static str,
    pub(crate) is_given: bool,
    /// Whether there is what it needs.
    pub(crate) is_met: bool,
    /// What that is: "an .mp4".
    pub(crate) needs: &'static str,
}

/// Fails where a flag was given that would do nothing, in the order of the list.
pub(crate) fn check(needs: &[Need]) -> Result<(), Failure> {
    match needs.iter().find(|need| need.is_given && !need.is_met) {
        Some(Need { flag, needs, .. }) => Err(would_do_nothing(flag, needs)),
        None => Ok(()),
    }
}

/// What is said of a flag that does nothing without what it needs.
pub(crate) fn would_do_nothing(flag: &str, needs: &str) -> Failure {
    Failure::Usage(format!("{flag} would do nothing here: it needs {needs}: leave it out"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_given_in_vain_is_wrong_usage() {
        let need = |is_given, is_met| Need { flag: "--fps", is_given, is_met, needs: "frames" };
        assert!(check(&[need(false, false), need(true, true), need(false, true)]).is_ok());
        let line = check(&[need(true, true), need(true, false)]).unwrap_err().line().unwrap();
        assert_eq!(line, "--fps would do nothing here: it needs frames: leave it out");
    }
}
