//! `trisap record`: records a rigid-body simulation.

use crate::Outcome;
use crate::args::RecordArgs;
use anyhow::Result;

#[cfg(not(feature = "record"))]
pub(crate) fn record(_args: &RecordArgs) -> Result<Outcome> {
    anyhow::bail!(
        "this build has no physics engine to record; build it with one: \
         cargo run --release --features record -- record …"
    )
}

#[cfg(feature = "record")]
pub(crate) fn record(args: &RecordArgs) -> Result<Outcome> {
    use crate::{progress, split};
    use trisap::scene::Setup;

    let (bodies, splits) = split::bodies(args.n, split::MOST_BODIES)?;
    let setup =
        Setup { kind: args.scene.into(), objects: args.objects.into(), count: bodies, seed: args.seed };
    let bar = progress::bar(args.skip.saturating_add(args.frames), "simulating");
    let output = simulated::Output { path: args.out.clone(), splits, frames: args.frames };
    simulated::write(&setup, args.skip, &[output], &|| bar.inc(1))?;
    bar.finish_and_clear();
    eprintln!("wrote {} boxes in {} frames to {}", args.n, args.frames, args.out.display());
    Ok(Outcome::Good)
}

#[cfg(feature = "record")]
pub(crate) mod simulated {
    use crate::simulate::Simulation;
    use crate::split;
    use anyhow::{Context, Result};
    use std::fs::File;
    use std::io::BufWriter;
    use std::path::PathBuf;
    use trisap::recording::{Header, Writer};
    use trisap::scene::Setup;
    use trisap::{Aabb, Boxes};

    /// A recording to be written.
    pub(crate) struct Output {
        pub(crate) path: PathBuf,
        /// How often bodies are split into 8 boxes each.
        pub(crate) splits: u32,
        pub(crate) frames: u32,
    }

    /// Writes recordings of one simulation, from frame `skip` on. Calls `done` after each frame.
    pub(crate) fn write(setup: &Setup, skip: u32, outputs: &[Output], done: &dyn Fn()) -> Result<()> {
        let mut writers = Vec::new();
        for output in outputs {
            let scale = split::scale(output.splits);
            let world = setup.world();
            let header = Header {
                scene: setup.kind.name().into(),
                objects: setup.objects.name().into(),
                count: setup.count * 8_u32.pow(output.splits),
                frames: output.frames,
                world: Aabb::new(world.min.map(|x| x * scale), world.max.map(|x| x * scale)),
            };
            let name = || output.path.display().to_string();
            let file = File::create(&output.path).with_context(name)?;
            writers.push(Writer::new(BufWriter::new(file), header).with_context(name)?);
        }
        let mut simulation = Simulation::new(setup);
        let mut boxes = Vec::new();
        let most = outputs.iter().map(|output| output.frames).max().unwrap_or(0);
        for frame in 0..skip.saturating_add(most) {
            if frame > 0 {
                simulation.advance();
            }
            for (output, writer) in outputs.iter().zip(&mut writers) {
                if (skip..skip.saturating_add(output.frames)).contains(&frame) {
                    boxes.clear();
                    simulation.for_each_body(|body| split::boxes(body, output.splits, &mut boxes));
                    let name = || output.path.display().to_string();
                    writer.write_frame(Boxes::new(&boxes)).with_context(name)?;
                }
            }
            done();
        }
        for (output, writer) in outputs.iter().zip(writers) {
            writer.finish().with_context(|| output.path.display().to_string())?;
        }
        Ok(())
    }
}
