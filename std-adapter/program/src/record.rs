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
    use crate::simulate::Simulation;
    use crate::{progress, split};
    use anyhow::Context;
    use std::fs::File;
    use std::io::BufWriter;
    use trisap::recording::{Header, Writer};
    use trisap::scene::Setup;
    use trisap::{Aabb, Boxes};

    let (bodies, splits) = split::bodies(args.n)?;
    let setup =
        Setup { kind: args.scene.into(), objects: args.objects.into(), count: bodies, seed: args.seed };
    let scale = split::scale(splits);
    let world = setup.world();
    let header = Header {
        scene: setup.kind.name().into(),
        objects: setup.objects.name().into(),
        count: args.n,
        frames: args.frames,
        world: Aabb::new(world.min.map(|x| x * scale), world.max.map(|x| x * scale)),
    };
    let name = || args.out.display().to_string();
    let file = File::create(&args.out).with_context(name)?;
    let mut writer = Writer::new(BufWriter::new(file), header).with_context(name)?;

    let frames = args.skip.saturating_add(args.frames);
    let bar = progress::bar(frames, "simulating");
    let mut simulation = Simulation::new(&setup);
    let mut boxes = Vec::with_capacity(args.n as usize);
    for frame in 0..frames {
        if frame > 0 {
            simulation.advance();
        }
        if frame >= args.skip {
            boxes.clear();
            simulation.for_each_body(|body| split::boxes(body, splits, &mut boxes));
            writer.write_frame(Boxes::new(&boxes)).with_context(name)?;
        }
        bar.inc(1);
    }
    writer.finish().with_context(name)?;
    bar.finish_and_clear();
    eprintln!("wrote {} boxes in {} frames to {}", args.n, args.frames, name());
    Ok(Outcome::Good)
}
