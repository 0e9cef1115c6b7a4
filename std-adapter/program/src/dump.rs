//! `trisap run --dump-svg`: draws a frame, cut through its middle across its thinnest axis: the leaves of the tree, its planes,
//! and the boxes.

use crate::setup::Engine;
use crate::source::Source;
use anyhow::{Context, Result, anyhow, ensure};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use trisap::{Aabb, Config, LeafView, OwnedWorld, PlaneView};

/// Which frame to draw, and where to.
pub(crate) struct Dump {
    frame: u32,
    file: PathBuf,
}

impl Dump {
    /// From the values of the option, for a source of so many frames.
    pub(crate) fn new(values: &[String], frames: u32) -> Result<Self> {
        let [frame, file] = values else { return Err(anyhow!("--dump-svg takes a frame and a file")) };
        let number =
            frame.parse().with_context(|| format!("--dump-svg: '{frame}' is no number of a frame"))?;
        ensure!(
            number < frames,
            "--dump-svg: there is no frame {number}; there are frames 0 to {}",
            frames - 1
        );
        Ok(Self { frame: number, file: file.into() })
    }

    /// Steps to the frame with a configuration that is known to suffice, and draws it.
    pub(crate) fn draw(&self, source: &mut Source, config: &Config, engine: &Engine) -> Result<()> {
        source.rewind()?;
        let mut owned = OwnedWorld::<u32>::new(config)?;
        let mut world = owned.world();
        for number in 0..=self.frame {
            let boxes = source.next_frame()?.context("the scene has become shorter")?;
            if number == 0 {
                world.insert_many(boxes)?;
            }
            engine.with_executor(|executor| {
                world.set_kernels(engine.kernels).on(executor).step_over(boxes).map(drop)
            })?;
        }
        // The boxes of the world: those that were refused have stayed.
        let ids: Vec<_> = (0..config.capacity.objects).filter_map(|slot| world.id_at(slot)).collect();
        let boxes: Vec<_> = ids.iter().filter_map(|id| world.aabb(*id)).collect();
        let large: Vec<_> = world.large().filter_map(|id| world.aabb(id)).collect();
        let scene = Scene {
            title: format!("{}, frame {}", source.name(), self.frame),
            leaves: world.leaves().collect(),
            planes: world.planes().collect(),
            boxes,
            large,
        };
        write(&self.file, &scene.svg())
    }
}

fn write(file: &Path, text: &str) -> Result<()> {
    std::fs::write(file, text).with_context(|| file.display().to_string())
}

/// What is drawn.
struct Scene {
    title: String,
    leaves: Vec<LeafView>,
    planes: Vec<PlaneView>,
    boxes: Vec<Aabb>,
    large: Vec<Aabb>,
}

/// The height of the picture, or its width where that is larger.
const SIZE: f32 = 1000.0;

const STYLE: &str = "svg{background:#fff}rect,line{fill:none;vector-effect:non-scaling-stroke}\
    .leaf{fill:#7fb2e5;fill-opacity:.08;stroke:#4a90d9;stroke-width:.5}.plane{stroke:#1f5fa8;stroke-width:1.5}\
    .box{fill:#e8a33d;fill-opacity:.35;stroke:#8a5a0b;stroke-width:.75}\
    .large{fill:#c0392b;fill-opacity:.12;stroke:#c0392b;stroke-width:1}";

impl Scene {
    fn svg(&self) -> String {
        let (low, high) = extent(&self.boxes);
        let view = View::new(low, high);
        let across = view.across;
        let cut = low[across] + (high[across] - low[across]) / 2.0;
        let is_cut = |bounds: &Aabb| bounds.min[across] <= cut && cut <= bounds.max[across];
        // A leaf ends where the next one begins.
        let holds = |cell: &Aabb| {
            cell.min[across] <= cut && cut < cell.max[across]
                || cell.max[across] == f32::INFINITY && is_cut(cell)
        };
        let leaves: Vec<_> = self.leaves.iter().filter(|leaf| holds(&leaf.cell)).collect();
        let boxes: Vec<_> = self.boxes.iter().filter(|bounds| is_cut(bounds)).collect();

        let mut svg = String::new();
        let [width, height] = view.size;
        let mut line = |text: String| writeln!(svg, "{text}").unwrap_or_default();
        line(format!(
            r#"<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}">"#
        ));
        line(format!("<title>{}</title>", escaped(&self.title)));
        line(format!(
            "<desc>Cut at {} = {cut}: {} of {} leaves, {} of {} boxes.</desc>",
            NAMES[across],
            leaves.len(),
            self.leaves.len(),
            boxes.len(),
            self.boxes.len()
        ));
        line(format!("<style>{STYLE}</style>"));
        for leaf in leaves {
            line(view.rect("leaf", &leaf.cell, &format!("{} objects", leaf.objects)));
        }
        for bounds in boxes {
            let class = if self.large.contains(bounds) { "large" } else { "box" };
            line(view.rect(class, bounds, &format!("{:?} to {:?}", bounds.min, bounds.max)));
        }
        // A plane along the cut does not show.
        for plane in self.planes.iter().filter(|plane| plane.axis != across && holds(&plane.cell)) {
            let mut flat = plane.cell;
            flat.min[plane.axis] = plane.position;
            flat.max[plane.axis] = plane.position;
            let [x1, y1, x2, y2] = view.corners(&flat);
            let title =
                format!("<title>{} = {}, level {}</title>", NAMES[plane.axis], plane.position, plane.depth);
            line(format!(r#"<line class="plane" x1="{x1}" y1="{y1}" x2="{x2}" y2="{y2}">{title}</line>"#));
        }
        line("</svg>".into());
        svg
    }
}

/// Between which corners the boxes are; sides at infinity do not count.
fn extent(boxes: &[Aabb]) -> ([f32; 3], [f32; 3]) {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for corner in boxes.iter().flat_map(|bounds| [bounds.min, bounds.max]) {
        for k in (0..3).filter(|k| corner[*k].is_finite()) {
            low[k] = low[k].min(corner[k]);
            high[k] = high[k].max(corner[k]);
        }
    }
    for k in 0..3 {
        if low[k] > high[k] {
            (low[k], high[k]) = (0.0, 0.0);
        }
    }
    (low, high)
}

const NAMES: [&str; 3] = ["x", "y", "z"];

/// From the scene to the picture, whose second axis points down.
struct View {
    /// The axis that is cut: the thinnest one, the last of equal ones.
    across: usize,
    /// Those that are drawn, to the right and upwards.
    axes: [usize; 2],
    low: [f32; 3],
    high: [f32; 3],
    scale: f32,
    size: [f32; 2],
}

impl View {
    fn new(low: [f32; 3], high: [f32; 3]) -> Self {
        let side = |k: usize| high[k] - low[k];
        let across = if side(2) <= side(0).min(side(1)) { 2 } else { usize::from(side(1) <= side(0)) };
        let axes = [[1, 2], [0, 2], [0, 1]][across];
        let sides = axes.map(side);
        let scale = SIZE / sides[0].max(sides[1]).max(f32::MIN_POSITIVE);
        // Something to see also of a flat scene.
        let size = sides.map(|side| (side * scale).max(1.0));
        Self { across, axes, low, high, scale, size }
    }

    /// Left, top, right, bottom; what reaches beyond the scene is cut off.
    fn corners(&self, bounds: &Aabb) -> [f32; 4] {
        let at = |x: f32, k: usize| x.clamp(self.low[k], self.high[k]);
        let [right, up] = self.axes;
        let x = |x: f32| (at(x, right) - self.low[right]) * self.scale;
        let y = |y: f32| (self.high[up] - at(y, up)) * self.scale;
        [x(bounds.min[right]), y(bounds.max[up]), x(bounds.max[right]), y(bounds.min[up])]
    }

    fn rect(&self, class: &str, bounds: &Aabb, title: &str) -> String {
        let [left, top, right, bottom] = self.corners(bounds);
        let (width, height) = (right - left, bottom - top);
        format!(
            r#"<rect class="{class}" x="{left}" y="{top}" width="{width}" height="{height}"><title>{title}</title></rect>"#
        )
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
