//! The program as its users call it: output, exit codes, errors.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::{fs, str};
use trisap::Boxes;
use trisap::recording::{Reader, Recording};
use trisap::scene::real::{Kind, Scene, Setup};

type Result<T = ()> = std::result::Result<T, Box<dyn Error>>;

const RECORDING: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/recordings/freefall_cubes_1000.aabbs");

fn trisap(args: &[&str]) -> Result<Output> {
    Ok(Command::new(env!("CARGO_BIN_EXE_trisap")).args(args).output()?)
}

/// The standard output of a call that succeeds.
fn stdout(args: &[&str]) -> Result<String> {
    let output = trisap(args)?;
    let stderr = str::from_utf8(&output.stderr)?;
    assert!(output.status.success(), "{args:?}: {stderr}");
    // Progress is for terminals.
    assert_eq!(stderr, "", "{args:?}");
    Ok(String::from_utf8(output.stdout)?)
}

/// What a call that is refused says.
fn refused(args: &[&str]) -> Result<String> {
    let output = trisap(args)?;
    assert_eq!(output.status.code(), Some(2), "{args:?}");
    assert!(output.stdout.is_empty(), "{args:?}");
    let stderr = String::from_utf8(output.stderr)?;
    assert!(stderr.starts_with("error: "), "{args:?}: {stderr}");
    Ok(stderr)
}

fn json(args: &[&str]) -> Result<serde_json::Value> {
    Ok(serde_json::from_str(&stdout(&[args, &["--json"]].concat())?)?)
}

fn path(path: &Path) -> Result<&str> {
    path.to_str().ok_or_else(|| "a path that is no text".into())
}

/// The shipped recording, changed.
fn changed(folder: &Path, change: impl FnOnce(&mut Vec<u8>)) -> Result<PathBuf> {
    let mut bytes = fs::read(RECORDING)?;
    change(&mut bytes);
    let file = folder.join("changed.aabbs");
    fs::write(&file, bytes)?;
    Ok(file)
}

#[test]
fn without_arguments_the_shipped_recording_is_checked() -> Result {
    let text = stdout(&[])?;
    assert!(text.contains("the built-in recording freefall_cubes_1000.aabbs"), "{text}");
    assert!(text.contains("check    passed: the pairs of every frame are those of brute force"), "{text}");
    Ok(())
}

#[test]
fn every_kind_of_run_passes_its_check() -> Result {
    let recording = ["run", RECORDING, "--check"];
    let scene = ["run", "--check", "--frames", "6", "-n", "900", "--scene"];
    for args in [
        [&recording[..], &["--events", "--threads", "2"]].concat(),
        [&recording[..], &["--mode", "fat", "--margin", "0.2", "--events"]].concat(),
        [&recording[..], &["--margin", "0.05", "--kernels", "scalar"]].concat(),
        [&scene[..], &["brownian", "--seed", "7"]].concat(),
        [&scene[..], &["freefall", "--objects", "assorted", "--mode", "fat"]].concat(),
        [&scene[..], &["gravity", "--events", "--objects", "cubes"]].concat(),
        [&scene[..], &["ground", "--events"]].concat(),
        [&scene[..], &["ground:inf", "--mode", "fat"]].concat(),
        [&scene[..], &["town", "--threads", "2", "--seed", "7"]].concat(),
        // The independent sweep; more pairs than there is room for at first.
        vec!["run", "--check", "--frames", "2", "-n", "5000", "--scene", "gravity", "--objects", "assorted"],
    ] {
        let report = json(&args)?;
        assert_eq!(report["check"]["passed"], true, "{args:?}: {report}");
    }
    Ok(())
}

#[test]
fn the_report_counts() -> Result {
    let report = json(&["run", RECORDING, "--check", "--events", "--frames", "8", "--kernels", "scalar"])?;
    assert_eq!(report["objects"], 1000);
    assert_eq!(report["frames"], 8);
    assert_eq!(report["settings"]["kernels"], "scalar");
    assert_eq!(report["settings"]["index_bits"], 16);
    assert_eq!(report["check"]["pairs"], report["pairs"]["total"]);
    let frames: u64 =
        report["paths"].as_object().ok_or("no paths")?.values().filter_map(|n| n.as_u64()).sum();
    assert_eq!(frames, 8);
    assert!(report["step_ms"]["median"].as_f64() > Some(0.0));
    assert!(report["bytes"]["per_object"].as_f64() > report["bytes"]["per_object_without_pairs"].as_f64());
    Ok(())
}

/// The boxes of a frame as text, as CSV and as others write it.
#[test]
fn pairs_of_boxes_as_text() -> Result {
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("boxes.csv");
    let boxes =
        [[0.0, 0.0, 0.0, 1.0, 1.0, 1.0], [5.0, 0.0, 0.0, 6.0, 1.0, 1.0], [0.1, 1.0, -0.5, 0.3, 2e0, 1.0]];
    for (head, by) in [("min x,min y,min z,max x,max y,max z\n", ","), ("# boxes\n\n", " "), ("", " ;\t")] {
        let line = |numbers: &[f64; 6]| numbers.map(|x| x.to_string()).join(by) + "\r\n";
        fs::write(&file, head.to_owned() + &boxes.iter().map(line).collect::<String>())?;
        assert_eq!(stdout(&["pairs", path(&file)?])?, "0 2\n", "{by}");
        assert_eq!(stdout(&["pairs", path(&file)?, "--threads", "2"])?, "0 2\n", "{by}");
    }
    for (text, says) in [
        ("0 0 0 1 1 1\n0 0 0 1 1\n", "line 2: not six numbers"),
        ("x\n1 2 3 4 5 six", "line 2: not six numbers"),
        ("1 0 0 1 1 1\n2 0 0 1 1 1\n", "box 1"),
    ] {
        fs::write(&file, text)?;
        let said = refused(&["pairs", path(&file)?])?;
        assert!(said.contains(says), "{said}");
    }
    Ok(())
}

#[test]
fn pairs_are_those_of_the_frame() -> Result {
    let recording = Recording::open(RECORDING)?;
    for (frame, extra) in [(0, vec![]), (17, vec!["--threads", "2"]), (39, vec!["--kernels", "scalar"])] {
        let boxes = Boxes::padded(recording.frame(frame).ok_or("no such frame")?);
        let boxes: Vec<_> = (0..boxes.len()).filter_map(|k| boxes.get(k)).collect();
        let mut expected = String::new();
        for (a, low) in boxes.iter().enumerate() {
            for (b, high) in boxes.iter().enumerate().skip(a + 1).filter(|(_, high)| low.overlaps(high)) {
                assert!(low.overlaps(high));
                expected += &format!("{a} {b}\n");
            }
        }
        let number = frame.to_string();
        assert_eq!(stdout(&[&["pairs", RECORDING, "--frame", &number], &extra[..]].concat())?, expected);
    }
    Ok(())
}

#[test]
fn every_real_scene_can_be_run_and_printed() -> Result {
    let help = stdout(&["run", "--help"])?;
    for kind in Kind::ALL {
        let name = kind.name();
        let report = json(&["run", "--scene", name, "-n", "400", "--frames", "12", "--check", "--events"])?;
        assert_eq!(report["check"]["passed"], true, "{name}: {report}");
        assert_eq!((&report["objects"], &report["frames"]), (&400.into(), &12.into()), "{name}");
        assert!(
            help.contains(&format!("- {name}:")) && help.contains(kind.text()),
            "{name} is not in the help"
        );

        let mut scene = Scene::new(Setup { kind, count: 400, seed: 3 })?;
        (0..11).for_each(|_| scene.advance());
        let boxes = scene.boxes();
        let mut expected = String::new();
        for (a, low) in boxes.iter().enumerate() {
            for (b, _) in boxes.iter().enumerate().skip(a + 1).filter(|(_, high)| low.overlaps(high)) {
                expected += &format!("{a} {b}\n");
            }
        }
        let args = ["pairs", "--scene", name, "-n", "400", "--seed", "3", "--frame", "11"];
        assert_eq!(stdout(&args)?, expected, "{name}");
    }
    Ok(())
}

#[test]
fn a_bad_box_harms_only_itself() -> Result {
    let folder = tempfile::tempdir()?;
    // NaN into the third box of the second frame.
    let at = 304 + 1000 * 32 + 2 * 32;
    let file = changed(folder.path(), |bytes| bytes[at..at + 4].copy_from_slice(&f32::NAN.to_le_bytes()))?;
    let report = json(&["run", path(&file)?, "--check", "--events"])?;
    assert_eq!(report["rejected"], 1);
    assert_eq!(report["check"]["passed"], true);

    let file = changed(folder.path(), |bytes| bytes[304..308].copy_from_slice(&f32::NAN.to_le_bytes()))?;
    let text = refused(&["run", path(&file)?])?;
    assert!(text.contains("frame 0: box 0 has NaN"), "{text}");
    Ok(())
}

#[test]
fn files_that_are_no_recordings_are_refused() -> Result {
    let folder = tempfile::tempdir()?;
    let missing = folder.path().join("missing.aabbs");
    assert!(refused(&["run", path(&missing)?])?.contains("missing.aabbs"));
    assert!(refused(&["run", path(folder.path())?])?.starts_with("error: "));
    type Change = fn(&mut Vec<u8>);
    let changes: [(Change, &str); 5] = [
        (Vec::clear, "not a recording: a header takes 304 bytes, the file has 0"),
        (|bytes| bytes.truncate(5000), "cut off"),
        (|bytes| bytes.push(0), "too long"),
        (|bytes| bytes[256..260].copy_from_slice(&(-1_i32).to_le_bytes()), "-1 objects"),
        (|bytes| bytes[256..264].copy_from_slice(&[0x7f; 8]), "cut off"),
    ];
    for (change, why) in changes {
        let file = changed(folder.path(), change)?;
        for args in [vec!["run", path(&file)?], vec!["pairs", path(&file)?, "--frame", "0"]] {
            let text = refused(&args)?;
            assert!(text.contains(why) && text.contains("changed.aabbs"), "{text}");
        }
    }
    Ok(())
}

#[test]
fn wrong_usage_is_refused() -> Result {
    for (args, why) in [
        (vec!["fly"], "fly"),
        (vec!["run", RECORDING, "--scene", "brownian"], "cannot be used with"),
        (vec!["run", "-n", "10"], "--scene"),
        (vec!["run", "--scene", "tornado"], "brownian"),
        (vec!["run", "--scene", "brownian", "-n", "0"], "0 is not in"),
        (vec!["run", "--scene", "ground:2e4"], "ground:inf"),
        (vec!["run", "--scene", "town", "-n", "99"], "the scene 'town' has 100 to 134217728 boxes, not 99"),
        (vec!["run", "--scene", "spawn", "-n", "65537"], "1 to 65536 boxes, not 65537"),
        (vec!["run", "--scene", "town", "--objects", "cubes"], "boxes of its own"),
        (vec!["record", "--scene", "town", "--out", "town.aabbs"], "gravity"),
        (vec!["run", "--threads", "0"], "0 is not in"),
        (vec!["run", "--threads", "33"], "33 is not in"),
        (vec!["run", "--frames", "0"], "0 is not in"),
        (vec!["run", "--margin=-1"], "0 or more"),
        (vec!["run", "--margin", "NaN"], "0 or more"),
        (vec!["run", "--kernels", "mmx"], "auto, scalar"),
        (vec!["pairs", RECORDING], "--frame"),
        (vec!["pairs", "--scene", "moon", "--frame", "0"], "lognormal"),
        (vec!["pairs", RECORDING, "--frame", "40"], "there are frames 0 to 39"),
        (vec!["record", "--scene", "gravity"], "--out"),
        (vec!["layout"], "<N>"),
    ] {
        let text = refused(&args)?;
        assert!(text.contains(why), "{args:?}: {text}");
    }
    Ok(())
}

#[test]
fn layouts_are_printed() -> Result {
    let text = stdout(&["layout", "1000", "100000", "4294967295"])?;
    let lines: Vec<Vec<&str>> = text.lines().skip(1).map(|line| line.split_whitespace().collect()).collect();
    assert_eq!(lines[0][..2], ["1,000", "4,000"]);
    // Too many for a lean world.
    assert_eq!(lines[0][2], "-");
    assert!(lines[0][3..].iter().all(|&cell| cell != "-"), "{text}");
    // Too many for 16 bits, and too many at all.
    assert_eq!(lines[1][2..5], ["-"; 3]);
    assert_ne!(lines[1][5], "-", "{text}");
    assert_eq!(lines[2][2..], ["-"; 6]);
    Ok(())
}

#[test]
fn a_report_is_a_page_and_its_data() -> Result {
    let folder = tempfile::tempdir()?;
    let out = folder.path().join("report");
    let text = stdout(&["report", "--least", "--out", path(&out)?])?;
    assert!(text.contains("report.html") && text.contains("0 misses, 0 other faults"), "{text}");
    let report: serde_json::Value = serde_json::from_str(&fs::read_to_string(out.join("report.json"))?)?;
    let sections = report["sections"].as_array().ok_or("no sections")?;
    let page = fs::read_to_string(out.join("report.html"))?;
    let mut ids = Vec::new();
    for section in sections {
        let id = section["id"].as_str().ok_or("no id")?;
        assert!(page.contains(&format!("<section id=\"{id}\">")), "{id}");
        for table in section["tables"].as_array().ok_or("no tables")? {
            let id = table["id"].as_str().ok_or("no id")?;
            let rows = table["rows"].as_array().ok_or("no rows")?;
            let csv = fs::read_to_string(out.join(format!("{id}.csv")))?;
            assert!(!rows.is_empty() && csv.lines().count() == rows.len() + 1, "{id}");
        }
        ids.push(id);
    }
    let all = [
        "real_scenes",
        "scaling",
        "paper",
        "movers",
        "speeds",
        "threads",
        "parts",
        "hard_cases",
        "precision",
        "ties",
        "margins",
    ];
    assert_eq!(ids, all);
    // Something was compared in every section that measures on its own, and nothing was wrong.
    let frames = |id: &str| {
        let section = sections.iter().find(|section| section["id"] == id);
        section.and_then(|section| section["verdict"]["frames"].as_u64())
    };
    for id in
        ["margins", "scaling", "paper", "movers", "speeds", "parts", "precision", "hard_cases", "real_scenes"]
    {
        assert!(frames(id) > Some(10), "{id}: {:?}", frames(id));
    }
    assert!(page.contains("ANOTHER MACHINE"), "printed figures are not marked");
    // The paper's method stands beside trisap in every line of both tables.
    for table in ["table_1", "table_2"] {
        let csv = fs::read_to_string(out.join(format!("{table}.csv")))?;
        let mut lines = csv.lines().map(|line| line.split(',').collect::<Vec<_>>());
        let titles = lines.next().ok_or("no titles")?;
        for title in ["trisap (ms)", "the paper's method (ms)"] {
            let at = titles.iter().position(|of| *of == title).ok_or("no such column")?;
            assert!(lines.clone().all(|line| line[at].parse().is_ok_and(|time: f64| time > 0.0)), "{title}");
        }
    }
    Ok(())
}

#[test]
fn a_report_has_the_sections_that_were_asked_for() -> Result {
    let folder = tempfile::tempdir()?;
    stdout(&[
        "report",
        "--least",
        "--section",
        "ties",
        "--section",
        "hard-cases",
        "--out",
        path(folder.path())?,
    ])?;
    let report: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(folder.path().join("report.json"))?)?;
    let sections = report["sections"].as_array().ok_or("no sections")?;
    let ids: Vec<_> = sections.iter().map(|section| &section["id"]).collect();
    assert_eq!(ids, ["hard_cases", "ties"]);
    assert!(!folder.path().join("movers.csv").exists());
    Ok(())
}

#[cfg(not(feature = "record"))]
#[test]
fn recording_without_an_engine_says_how_to_get_one() -> Result {
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("out.aabbs");
    let text = refused(&["record", "--scene", "gravity", "--out", path(&file)?])?;
    assert!(text.contains("--features record") && !file.exists(), "{text}");
    Ok(())
}

#[cfg(feature = "record")]
#[test]
fn what_is_recorded_can_be_run() -> Result {
    let folder = tempfile::tempdir()?;
    let record = |name: &str, extra: &[&str]| -> Result<PathBuf> {
        let file = folder.path().join(name);
        let base = ["record", "--frames", "5", "--out", path(&file)?, "-n"];
        let output = trisap(&[&base, extra].concat())?;
        assert!(output.status.success(), "{output:?}");
        Ok(file)
    };
    for scene in ["brownian", "freefall", "gravity"] {
        let assorted = ["200", "--objects", "assorted", "--scene", scene];
        let file = record("a.aabbs", &assorted)?;
        assert_eq!(json(&["run", path(&file)?, "--check"])?["check"]["passed"], true);
        assert_eq!(fs::read(&file)?, fs::read(record("b.aabbs", &assorted)?)?, "{scene}");
        let skipped = Recording::open(record("c.aabbs", &[&assorted[..], &["--skip", "2"]].concat())?)?;
        assert_eq!(skipped.frame(0), Recording::open(&file)?.frame(2));
    }
    // Split once: 4,001 bodies.
    let file = record("split.aabbs", &["32008", "--scene", "freefall"])?;
    let reader = Reader::open(&file)?;
    assert_eq!((reader.header().count, reader.header().frames), (32_008, 5));
    assert!((reader.header().world.max[0] - (10.0_f32 * 4001.0).cbrt()).abs() < 1e-3);

    let out = path(&file)?;
    assert!(
        refused(&["record", "--scene", "gravity", "-n", "32001", "--out", out])?.contains("a multiple of 8")
    );
    assert_eq!(Reader::open(&file)?.header().count, 32_008, "the file was harmed");
    Ok(())
}

#[test]
fn the_shipped_recording_is_sound() -> Result {
    let mut reader = Reader::open(RECORDING)?;
    assert_eq!((reader.header().count, reader.header().frames), (1000, 40));
    let mut frames = 0;
    while let Some(frame) = reader.next_frame()? {
        let boxes = Boxes::padded(frame);
        assert!((0..boxes.len()).all(|k| boxes.get(k).is_some_and(|aabb| aabb.is_valid())));
        frames += 1;
    }
    assert_eq!(frames, 40);
    Ok(())
}

#[test]
fn a_page_shows_a_scene_without_anything_else() -> Result {
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("view.html");
    let out = file.to_str().ok_or("a path that is no text")?;
    stdout(&["view", "--scene", "pile", "-n", "300", "--frames", "4", "--out", out])?;
    let page = fs::read_to_string(&file)?;
    for other in ["src=", "url(", "@import", "<link", "{data}", "{pairs}", "{up}"] {
        assert!(!page.contains(other), "the page needs something else: {other}");
    }
    // Four frames of 13 bytes a box, in letters.
    assert!(page.len() > 4 * 300 * 13 / 3 * 4);
    let many = ["view", "--scene", "pile", "-n", "5000000", "--frames", "4000", "--out", out];
    assert!(refused(&many)?.contains("take --frames 1 or fewer boxes"));
    Ok(())
}
