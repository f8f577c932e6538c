//! The program: a window, and commands.

fn main() -> std::process::ExitCode {
    bvhscope::cli::main()
}
