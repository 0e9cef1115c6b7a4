//! What the report says of the machine that it was made on.

use serde::Serialize;
use std::{env, fmt, fs};

#[derive(Serialize)]
pub(super) struct Machine {
    processor: String,
    system: String,
    kernels: &'static str,
    version: &'static str,
    optimised: bool,
}

impl Machine {
    pub(super) fn this() -> Self {
        let known = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let model = known.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
        Self {
            processor: model.map_or("an unknown processor".into(), |(_, model)| model.trim().to_owned()),
            system: format!("{} on {}", env::consts::OS, env::consts::ARCH),
            kernels: trisap::Kernels::detect().name(),
            version: env!("CARGO_PKG_VERSION"),
            optimised: !cfg!(debug_assertions),
        }
    }
}

impl fmt::Display for Machine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { processor, system, kernels, version, .. } = self;
        write!(
            f,
            "trisap {version} on {processor}, {system}, one thread, {kernels} kernels where nothing else is said."
        )?;
        if !self.optimised {
            f.write_str(" BUILT FOR DEBUGGING: the times mean nothing.")?;
        }
        Ok(())
    }
}
