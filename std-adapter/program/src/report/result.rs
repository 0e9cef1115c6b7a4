//! What an experiment has found out: figures and tables, and what the checks say.

use serde::Serialize;

/// One experiment's part of the page.
#[derive(Default, Serialize)]
pub(super) struct Section {
    pub(super) id: &'static str,
    pub(super) title: &'static str,
    /// Paragraphs.
    pub(super) text: Vec<String>,
    #[serde(skip)]
    pub(super) bars: Vec<Bars>,
    #[serde(skip)]
    pub(super) figures: Vec<Figure>,
    pub(super) tables: Vec<Table>,
    pub(super) verdict: Verdict,
}

/// Bars side by side: one number for each thing.
pub(super) struct Bars {
    pub(super) title: String,
    /// Of all numbers; and whether low or high ones are good.
    pub(super) unit: &'static str,
    pub(super) note: &'static str,
    pub(super) decimals: usize,
    pub(super) bars: Vec<(String, f64)>,
}

/// A chart of lines.
pub(super) struct Figure {
    pub(super) title: String,
    /// What dashes are, and whether low or high is good.
    pub(super) note: &'static str,
    pub(super) x: Axis,
    pub(super) y: Axis,
    pub(super) series: Vec<Series>,
}

/// An axis: its label names the unit.
pub(super) struct Axis {
    pub(super) label: &'static str,
    pub(super) scale: Scale,
}

#[derive(Clone, Copy, PartialEq)]
pub(super) enum Scale {
    /// From zero on.
    Linear,
    /// By powers of ten; for values above zero alone.
    Logarithmic,
}

impl Axis {
    pub(super) const fn linear(label: &'static str) -> Self {
        Self { label, scale: Scale::Linear }
    }

    pub(super) const fn logarithmic(label: &'static str) -> Self {
        Self { label, scale: Scale::Logarithmic }
    }
}

/// A line of a chart.
pub(super) struct Series {
    /// None where the legend says it elsewhere.
    pub(super) name: String,
    pub(super) points: Vec<(f64, f64)>,
    /// What is measured has a full line with dots; what it is compared with is dashed.
    pub(super) reference: bool,
    /// Which colour; a measured line and its reference share one.
    pub(super) colour: usize,
}

/// A table, on the page and as CSV.
#[derive(Serialize)]
pub(super) struct Table {
    /// The name of the CSV file.
    pub(super) id: &'static str,
    pub(super) title: String,
    /// The titles of the columns, with units.
    pub(super) columns: Vec<&'static str>,
    pub(super) rows: Vec<Vec<Value>>,
}

/// What stands in a table's cell.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub(super) enum Value {
    Text(String),
    Count(u64),
    /// With so many decimals on the page.
    Number(f64, #[serde(skip)] usize),
    Missing,
}

impl From<&str> for Value {
    fn from(text: &str) -> Self {
        Self::Text(text.into())
    }
}

impl From<u64> for Value {
    fn from(count: u64) -> Self {
        Self::Count(count)
    }
}

impl From<u32> for Value {
    fn from(count: u32) -> Self {
        Self::Count(count.into())
    }
}

/// A share in per cent.
pub(super) fn percent(part: f64, whole: f64) -> Value {
    if whole > 0.0 { Value::Number(100.0 * part / whole, 2) } else { Value::Missing }
}

/// A time in milliseconds.
pub(super) fn milliseconds(time: f64) -> Value {
    Value::Number(time, 4)
}

/// What comparing pairs with an independent method has shown, over some frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(super) struct Verdict {
    /// Frames that were compared.
    pub(super) frames: u64,
    /// Pairs that the independent method found.
    pub(super) pairs: u64,
    /// Those that were not reported.
    pub(super) misses: u64,
    /// Whatever else is wrong: pairs that are reported twice or do not belong there, events, counts.
    pub(super) faults: u64,
}

impl Verdict {
    pub(super) fn add(&mut self, other: Self) {
        self.frames += other.frames;
        self.pairs += other.pairs;
        self.misses += other.misses;
        self.faults += other.faults;
    }

    pub(super) fn is_good(&self) -> bool {
        self.misses == 0 && self.faults == 0
    }
}
