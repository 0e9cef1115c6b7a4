//! The machine that the firmware is built on: it computes what the boards must come to.

/// Writes to the console.
pub fn print(text: &str) {
    std::print!("{text}");
}

/// The first argument of the command line.
pub fn argument(buffer: &mut [u8]) -> &[u8] {
    let given = std::env::args().nth(1).unwrap_or_default();
    let len = given.len().min(buffer.len());
    buffer[..len].copy_from_slice(&given.as_bytes()[..len]);
    &buffer[..len]
}

/// Does `work`; nobody counts its instructions here.
pub fn instructions(work: impl FnOnce()) -> Option<u32> {
    work();
    None
}

/// Does nothing.
pub fn spin(_rounds: u32) {}

/// Does `work`; nobody measures its stack here.
pub fn stack(work: impl FnOnce()) -> Option<usize> {
    work();
    None
}
