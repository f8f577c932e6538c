//! The one table of settings: a flag's name, its help, how a session's value is written and how it is read. The command
//! line, its help, and *Copy command* are derived from it.

use super::Session;

/// Why a flag's value was refused: which flag, what was given, what is allowed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FlagError {
    #[error("there is no flag --{flag}")]
    UnknownFlag { flag: String },
    #[error("--{flag} '{value}': {reason}")]
    Value { flag: &'static str, value: String, reason: String },
}

/// One flag.
pub struct Flag {
    /// Without the dashes.
    pub name: &'static str,
    /// `NAME`, `N`, `WxH` ...; `None` for a switch.
    pub value_name: Option<&'static str>,
    pub help: &'static str,
    /// The choices of a closed set.
    pub choices: fn() -> Vec<&'static str>,
    pub read: fn(&mut Session, &str) -> Result<(), FlagError>,
    /// The text that `read` takes back; `None` where the flag is a switch that is off, or there is nothing to say.
    pub write: fn(&Session) -> Option<String>,
}

/// Every flag, in the order of `--help`.
pub fn flags() -> &'static [Flag] {
    todo!()
}

/// `bvhscope render SCENE --out FILE` with every flag that differs from the default: the command that makes the same
/// picture without a window. Quoted for a POSIX shell.
pub fn command_line(session: &Session, out: &str) -> String {
    let _ = (session, out);
    todo!()
}
