//! The drawing of a frame: a well-formed SVG with the leaves, planes and boxes that the cut meets.

use std::error::Error;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use trisap::recording::Recording;
use trisap::{Boxes, Capacity, Config, OwnedWorld};

type Result<T = ()> = std::result::Result<T, Box<dyn Error>>;

const RECORDING: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/recordings/freefall_cubes_1000.aabbs");

fn draw(frame: &str, file: &Path, extra: &[&str]) -> Result<Output> {
    let mut trisap = Command::new(env!("CARGO_BIN_EXE_trisap"));
    Ok(trisap.arg("run").args(extra).arg("--dump-svg").arg(frame).arg(file).output()?)
}

#[test]
fn a_frame_is_drawn() -> Result {
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("frame.svg");
    for frame in [0, 12] {
        let output = draw(&frame.to_string(), &file, &[RECORDING])?;
        assert!(output.status.success(), "{output:?}");
        let text = fs::read_to_string(&file)?;
        let svg = roxmltree::Document::parse(&text)?;
        let root = svg.root_element();
        assert_eq!(root.tag_name().name(), "svg");
        let of = |class: &str| root.children().filter(|node| node.attribute("class") == Some(class)).count();

        let recording = Recording::open(RECORDING)?;
        let mut owned = OwnedWorld::<u32>::new(&Config::new(Capacity::for_objects(1000)))?;
        let mut world = owned.world();
        let boxes =
            |frame: usize| Ok::<_, Box<dyn Error>>(Boxes::padded(recording.frame(frame).ok_or("no frame")?));
        world.insert_many(boxes(0)?)?;
        for number in 0..=frame {
            world.step_over(boxes(number)?)?;
        }
        let boxes: Vec<_> = (0..1000).filter_map(|slot| boxes(frame).ok()?.get(slot)).collect();
        let low = [0, 1, 2].map(|k| boxes.iter().map(|aabb| aabb.min[k]).fold(f32::INFINITY, f32::min));
        let high = [0, 1, 2].map(|k| boxes.iter().map(|aabb| aabb.max[k]).fold(f32::NEG_INFINITY, f32::max));
        // Across the thinnest axis.
        let side = |k: &usize| high[*k] - low[*k];
        let thin = [2, 1, 0].into_iter().min_by(|a, b| side(a).total_cmp(&side(b))).ok_or("an axis")?;
        let cut = low[thin] + (high[thin] - low[thin]) / 2.0;
        let is_cut = |min: [f32; 3], max: [f32; 3]| min[thin] <= cut && cut <= max[thin];
        let expected = boxes.iter().filter(|aabb| is_cut(aabb.min, aabb.max)).count();
        assert!(expected > 10 && expected < 1000);
        assert_eq!(of("box") + of("large"), expected);
        let leaves = world.leaves().filter(|leaf| is_cut(leaf.cell.min, leaf.cell.max)).count();
        assert!(leaves > 1);
        assert_eq!(of("leaf"), leaves);
        let planes =
            world.planes().filter(|plane| plane.axis != thin && is_cut(plane.cell.min, plane.cell.max));
        assert_eq!(of("plane"), planes.count());

        // Everything is inside of the picture.
        let number = |node: roxmltree::Node<'_, '_>, name: &str| -> f32 {
            node.attribute(name).and_then(|text| text.parse().ok()).unwrap_or(f32::NAN)
        };
        let (width, height) = (number(root, "width"), number(root, "height"));
        for rect in root.children().filter(|node| node.tag_name().name() == "rect") {
            assert!(number(rect, "x") >= 0.0 && number(rect, "y") >= 0.0, "{rect:?}");
            assert!(number(rect, "x") + number(rect, "width") <= width * 1.001, "{rect:?}");
            assert!(number(rect, "y") + number(rect, "height") <= height * 1.001, "{rect:?}");
        }
    }
    Ok(())
}

#[test]
fn a_scene_without_a_tree_is_drawn_too() -> Result {
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("small.svg");
    let output = draw("1", &file, &["--scene", "gravity", "-n", "40", "--frames", "3", "--json"])?;
    assert!(output.status.success(), "{output:?}");
    let text = fs::read_to_string(&file)?;
    let svg = roxmltree::Document::parse(&text)?;
    let classes: Vec<_> = svg.descendants().filter_map(|node| node.attribute("class")).collect();
    assert!(!classes.is_empty() && classes.iter().all(|class| *class == "box"), "{classes:?}");
    Ok(())
}

#[test]
fn what_cannot_be_drawn_is_refused() -> Result {
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("frame.svg");
    for (frame, file, why) in [
        ("40", file.as_path(), "there are frames 0 to 39"),
        ("first", &file, "'first' is no number"),
        ("0", folder.path(), folder.path().to_str().ok_or("a path that is no text")?),
    ] {
        let output = draw(frame, file, &[RECORDING])?;
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        assert!(String::from_utf8(output.stderr)?.contains(why), "{frame}");
    }
    assert!(!file.exists());
    Ok(())
}
