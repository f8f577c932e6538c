//! The commands: one file each. Parses a session, calls the library, prints.

use std::process::ExitCode;

/// Runs the program with the process's arguments: 0 done, 1 failed, 2 wrong usage.
pub fn main() -> ExitCode {
    todo!()
}
