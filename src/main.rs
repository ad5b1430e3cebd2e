//! The command line: parses and dispatches.

use std::process::ExitCode;

fn main() -> ExitCode {
    solidtrace::cli::run()
}
