//! The page of `trisap report` in a browser: every figure is drawn, labelled with units and readable, in the light and in
//! the dark scheme, on a desk and on a phone.
//!
//! Needs Debian's `chromium`. Without it the test says that it is skipped; with `TRISAP_NO_SKIP` set, it fails.
//!
//! It can look at a report that was made before, and leave a picture of it:
//!
//! ```sh
//! cargo run --release -- report
//! TRISAP_REPORT=trisap-report TRISAP_SCREENSHOT=report.png cargo test -p trisap-program page::
//! ```
//!
//! (Both paths count from the root of the repository.)

use serde::Deserialize;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

type Result<T = ()> = std::result::Result<T, Box<dyn Error>>;

const BROWSER: &str = "chromium";
const PHONE: u32 = 390;
const DESK: u32 = 1100;

/// Looks at the page from within and leaves what it sees at its end.
const LOOK: &str = r#"<script>
const colour = (element, name) => getComputedStyle(element)[name];
const figures = [...document.querySelectorAll("figure")].map(figure => {
  const svg = figure.querySelector("svg"), box = svg.getBoundingClientRect();
  const texts = [...svg.querySelectorAll("text")].map(text => {
    const at = text.getBoundingClientRect();
    return {
      text: text.textContent.trim(), colour: colour(text, "fill"),
      size: parseFloat(colour(text, "fontSize")) * box.width / svg.viewBox.baseVal.width,
      inside: at.left >= box.left - 1 && at.right <= box.right + 1 && at.top >= box.top - 1 && at.bottom <= box.bottom + 1,
    };
  });
  const lines = [...svg.querySelectorAll("polyline, line, circle")].filter(line => {
    const at = line.getBoundingClientRect();
    return at.width + at.height > 0;
  });
  const strokes = new Set(lines.map(line => colour(line, "stroke")).concat(lines.map(line => colour(line, "fill"))));
  const legend = [...figure.querySelectorAll(".legend li")].map(entry => ({
    name: entry.textContent.trim(), drawn: strokes.has(colour(entry.querySelector("i"), "borderTopColor")),
  }));
  return {
    caption: figure.querySelector("figcaption").textContent, width: box.width, height: box.height,
    dots: svg.querySelectorAll("circle").length, texts, legend,
  };
});
const seen = document.createElement("pre");
seen.id = "seen";
seen.textContent = JSON.stringify({
  figures, background: colour(document.body, "backgroundColor"), ink: colour(document.body, "color"),
  width: innerWidth, needed: document.documentElement.scrollWidth,
});
document.body.append(seen);
</script>"#;

#[derive(Deserialize)]
struct Seen {
    figures: Vec<Figure>,
    background: String,
    ink: String,
    /// Of the window, and what the page wants.
    width: u32,
    needed: u32,
}

#[derive(Deserialize)]
struct Figure {
    caption: String,
    width: f64,
    height: f64,
    dots: usize,
    texts: Vec<Text>,
    legend: Vec<Entry>,
}

#[derive(Deserialize)]
struct Text {
    text: String,
    colour: String,
    /// Of the letters, in pixels.
    size: f64,
    inside: bool,
}

#[derive(Deserialize)]
struct Entry {
    name: String,
    drawn: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Scheme {
    Light,
    Dark,
}

#[test]
fn every_figure_is_drawn_and_labelled() -> Result {
    if !Command::new(BROWSER).arg("--version").output().is_ok_and(|output| output.status.success()) {
        assert!(env::var_os("TRISAP_NO_SKIP").is_none(), "{BROWSER} is not installed");
        eprintln!("skipped: {BROWSER} is not installed: nobody looks at the page");
        return Ok(());
    }
    let folder = tempfile::tempdir()?;
    let page = fs::read_to_string(report(folder.path())?.join("report.html"))?;
    for other in ["src=", "url(", "@import", "<link", "<script"] {
        assert!(!page.contains(other), "the page needs something else: {other}");
    }
    let looked_at = folder.path().join("looked_at.html");
    fs::write(&looked_at, page.replace("</body>", &format!("{LOOK}</body>")))?;

    let captions = |seen: &Seen| seen.figures.iter().map(|figure| figure.caption.clone()).collect::<Vec<_>>();
    let mut all = Vec::new();
    for scheme in [Scheme::Light, Scheme::Dark] {
        for width in [DESK, PHONE] {
            let seen = look(&looked_at, scheme, width)?;
            let here = format!("{scheme:?}, {width} wide");
            check(&seen, scheme, &here)?;
            all.push(captions(&seen));
        }
    }
    assert!(all.windows(2).all(|two| two[0] == two[1]));
    assert!(all[0].len() >= 14, "figures are missing: {:?}", all[0]);
    let plain = folder.path().join("plain.html");
    fs::write(&plain, page.replace("</style>", "p, nav, details { display: none; }</style>"))?;
    screenshot(&plain)
}

/// The folder of a report: one that was made before, or the least one, made here.
fn report(folder: &Path) -> Result<PathBuf> {
    if let Some(made) = env::var_os("TRISAP_REPORT") {
        return Ok(repository().join(made));
    }
    let out = folder.join("report");
    let output =
        Command::new(env!("CARGO_BIN_EXE_trisap")).args(["report", "--least", "--out"]).arg(&out).output()?;
    assert!(output.status.success(), "{output:?}");
    Ok(out)
}

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn browser(page: &Path, scheme: Scheme, size: &str) -> Command {
    let mut command = Command::new(BROWSER);
    // Its sandbox does not work inside those of build machines.
    command.args(["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"]);
    command.arg(format!("--window-size={size}"));
    command
        .arg(format!("--blink-settings=preferredColorScheme={}", if scheme == Scheme::Dark { 0 } else { 1 }));
    command.arg(format!("--user-data-dir={}", page.with_extension("profile").display()));
    command.arg(format!("file://{}", page.display()));
    command
}

fn look(page: &Path, scheme: Scheme, width: u32) -> Result<Seen> {
    let output = browser(page, scheme, &format!("{width},900")).arg("--dump-dom").output()?;
    let text = String::from_utf8(output.stdout)?;
    let seen = text.split_once("<pre id=\"seen\">").and_then(|(_, rest)| rest.split_once("</pre>"));
    let (json, _) = seen.ok_or_else(|| format!("the page has not told what it sees: {:?}", output.stderr))?;
    let json = json.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
    Ok(serde_json::from_str(&json)?)
}

fn check(seen: &Seen, scheme: Scheme, here: &str) -> Result {
    assert!(seen.needed <= seen.width, "{here}: the page is {} wide", seen.needed);
    let light = luminance(&seen.background)? > 0.5;
    assert_eq!(light, scheme == Scheme::Light, "{here}: the background is {}", seen.background);
    assert!(contrast(&seen.ink, &seen.background)? > 4.5, "{here}: the text cannot be read");
    for Figure { caption, width, height, dots, texts, legend } in &seen.figures {
        let here = format!("{here}: {caption}");
        assert!(*width > 250.0 && *height > 150.0, "{here}: {width} by {height}");
        assert!(*dots >= 2, "{here}: no line is drawn");
        // Labels with units of both axes, and numbers at both.
        let units = texts.iter().filter(|text| text.text.ends_with(')') && text.text.contains('(')).count();
        assert_eq!(units, 2, "{here}: labels with units");
        let numbers = texts.iter().filter(|text| text.text.starts_with(|c: char| c.is_ascii_digit())).count();
        assert!(numbers >= 4, "{here}: {numbers} numbers");
        for Text { text, colour, size, inside } in texts {
            assert!(inside, "{here}: '{text}' is cut off");
            assert!(*size >= 10.0, "{here}: the letters of '{text}' are {size} pixels high");
            assert!(contrast(colour, &seen.background)? > 4.5, "{here}: '{text}' is {colour}");
        }
        assert!(!legend.is_empty(), "{here}: no legend");
        for Entry { name, drawn } in legend {
            assert!(drawn, "{here}: nothing has the colour of '{name}'");
        }
    }
    Ok(())
}

/// The first figures, for the README.
fn screenshot(page: &Path) -> Result {
    let wanted = env::var_os("TRISAP_SCREENSHOT").map(|path| repository().join(path));
    let target = wanted.unwrap_or_else(|| Path::new(env!("CARGO_TARGET_TMPDIR")).join("report.png"));
    let argument = format!("--screenshot={}", target.display());
    let output = browser(page, Scheme::Light, "1100,800").arg(argument).output()?;
    let picture = fs::read(&target).map_err(|error| format!("{error}: {output:?}"))?;
    assert!(picture.starts_with(b"\x89PNG"));
    assert!(picture.len() < 200_000, "{} bytes are too many for a repository", picture.len());
    Ok(())
}

/// By the formula of the web's accessibility guidelines, from `rgb(r, g, b)`.
fn luminance(colour: &str) -> Result<f64> {
    let numbers = colour.trim_start_matches(|c: char| !c.is_ascii_digit()).trim_end_matches(')');
    let parts: Vec<f64> =
        numbers.split(',').map(|part| part.trim().parse()).collect::<std::result::Result<_, _>>()?;
    let [r, g, b] = parts[..] else { return Err(format!("no colour: {colour}").into()) };
    let linear = |part: f64| {
        let share = part / 255.0;
        if share <= 0.04045 { share / 12.92 } else { ((share + 0.055) / 1.055).powf(2.4) }
    };
    Ok(0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b))
}

fn contrast(a: &str, b: &str) -> Result<f64> {
    let (a, b) = (luminance(a)?, luminance(b)?);
    Ok((a.max(b) + 0.05) / (a.min(b) + 0.05))
}
