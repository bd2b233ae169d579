//! `sma`: identify shape-memory-alloy actuators from recordings.

fn main() -> std::process::ExitCode {
    sma_cli::run()
}
