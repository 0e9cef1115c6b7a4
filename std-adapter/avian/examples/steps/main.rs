//! Whole steps of avian3d with its own broad phase and with trisap's:
//!
//!     cargo +1.97.1 run --release --manifest-path std-adapter/avian/Cargo.toml --example steps [SCENE...]

mod scenes;

use avian3d::collider_tree::{ColliderTreeDiagnostics, ColliderTreeSystems};
use avian3d::prelude::*;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use rustix::time::{ClockId, clock_gettime};
use std::time::Duration;
use trisap_avian::TrisapBroadPhasePlugin;

const FRAMES: usize = 300;
/// What comes first is not timed: all colliders are new then.
const FIRST: usize = 5;

/// The time that the process has had of the CPU, in ms, at the seams of a step.
#[derive(Resource, Default)]
struct Stamps {
    start: f64,
    before: f64,
    after: f64,
    end: f64,
}

fn now() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 * 1e3 + time.tv_nsec as f64 * 1e-6
}

fn measured_app(scene: &str, with_trisap: bool) -> Option<App> {
    let physics = PhysicsPlugins::default().build();
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin));
    if with_trisap {
        let broad_phase = TrisapBroadPhasePlugin::<()>::default();
        app.add_plugins(physics.disable::<BvhBroadPhasePlugin>().add(broad_phase));
    } else {
        app.add_plugins(physics);
    }
    // As avian's own benches.
    app.insert_resource(Time::from_hz(60.0))
        .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f64(1.0 / 60.0)))
        .insert_resource(SubstepCount(4))
        .init_resource::<Stamps>();
    app.add_systems(
        PhysicsSchedule,
        (
            (|mut stamps: ResMut<Stamps>| stamps.start = now()).before(PhysicsStepSystems::First),
            (|mut stamps: ResMut<Stamps>| stamps.before = now())
                .after(ColliderTreeSystems::UpdateAabbs)
                .before(BroadPhaseSystems::CollectCollisions),
            (|mut stamps: ResMut<Stamps>| stamps.after = now())
                .after(BroadPhaseSystems::CollectCollisions)
                .before(BroadPhaseSystems::Last),
            (|mut stamps: ResMut<Stamps>| stamps.end = now()).after(PhysicsStepSystems::Last),
        ),
    );
    scenes::add(&mut app, scene)?;
    app.finish();
    app.cleanup();
    Some(app)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Medians of a scene's frames.
struct Medians {
    colliders: usize,
    step: f64,
    broad_phase: f64,
    /// Share of the step, in percent.
    share: f64,
    /// The same in the ten frames in which it is highest.
    busiest: f64,
    /// Share of the upkeep of avian's trees, by its own clock.
    trees: f64,
}

fn measure(mut app: App) -> Medians {
    let (mut steps, mut broad_phases, mut shares, mut trees) = (vec![], vec![], vec![], vec![]);
    for frame in 0..FRAMES {
        app.update();
        if frame < FIRST {
            continue;
        }
        let stamps = app.world().resource::<Stamps>();
        let (step, broad_phase) = (stamps.end - stamps.start, stamps.after - stamps.before);
        let upkeep = app.world().resource::<ColliderTreeDiagnostics>();
        steps.push(step);
        broad_phases.push(broad_phase);
        shares.push(broad_phase / step * 100.0);
        trees.push((upkeep.update + upkeep.optimize).as_secs_f64() * 1e3 / step * 100.0);
    }
    Medians {
        colliders: app.world_mut().query::<&Collider>().iter(app.world()).count(),
        step: median(steps),
        broad_phase: median(broad_phases),
        busiest: shares.chunks(10).map(|ten| median(ten.to_vec())).fold(0.0, f64::max),
        share: median(shares),
        trees: median(trees),
    }
}

fn main() {
    let mut names: Vec<String> = std::env::args().skip(1).collect();
    if names.is_empty() {
        names = scenes::NAMES.iter().map(ToString::to_string).collect();
    }
    println!(
        "| scene | colliders | broad phase | step, ms | its pairs, ms | share | highest of ten frames | trees |"
    );
    println!("|---|---:|---|---:|---:|---:|---:|---:|");
    for name in names {
        for (who, with_trisap) in [("avian", false), ("trisap", true)] {
            let Some(app) = measured_app(&name, with_trisap) else {
                eprintln!("{name}: no such scene; there are {}", scenes::NAMES.join(", "));
                std::process::exit(2);
            };
            let Medians { colliders, step, broad_phase, share, busiest, trees } = measure(app);
            println!(
                "| {name} | {colliders} | {who} | {step:.2} | {broad_phase:.3} | {share:.1} % | {busiest:.1} % | {trees:.1} % |"
            );
        }
    }
}
