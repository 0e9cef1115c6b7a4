//! `trisap report`: measures how fast and how right trisap is here, and writes it down as a page and as data.
//!
//! Each experiment is a file that turns the [`Lab`] into a [`Section`]; nothing but [`measure`] takes the time of a step.

mod as_printed;
mod chart;
mod clip;
mod files;
mod hard_cases;
mod lab;
mod machine;
mod margins;
mod measure;
mod movers;
mod page;
mod paper;
mod parts;
mod plan;
mod precision;
mod printed;
mod real_scenes;
#[cfg(feature = "record")]
mod recordings;
mod result;
mod scaling;
mod sizes;
mod speeds;
mod threads;
mod ties;

use crate::Outcome;
use crate::args::{ReportArgs, SectionName};
use crate::figures::grouped;
use anyhow::{Context, Result};
use clap::ValueEnum;
use files::Data;
use lab::Lab;
use machine::Machine;
use page::Answer;
use plan::Plan;
use result::{Section, Verdict};
use sizes::Size;
use std::fs;

pub(crate) fn report(args: &ReportArgs) -> Result<Outcome> {
    fs::create_dir_all(&args.out).with_context(|| args.out.display().to_string())?;
    let plan = match (args.least, args.quick) {
        (true, _) => Plan::least(),
        (false, true) => Plan::quick(),
        (false, false) => Plan::full(),
    };
    let lab = Lab::new(plan, args.out.join("recordings"));
    #[cfg(feature = "record")]
    if lab.plan.recorded {
        lab.record_all()?;
    }
    let (sections, mut answer) = sections(&lab, &args.sections)?;
    lab.bar.finish_and_clear();

    let mut sum = Verdict::default();
    sections.iter().for_each(|section| sum.add(section.verdict));
    answer.push((grouped(sum.misses), format!("misses in {} steps that were checked", grouped(sum.frames))));
    let (machine, plan) = (Machine::this(), lab.plan.name);
    files::write(&args.out, "report.html", &page::page(&machine, plan, &answer, &sections, &sum)?)?;
    files::write_data(&args.out, &Data { machine: &machine, plan, verdict: sum, sections: &sections })?;
    println!(
        "wrote {}; {} steps compared, {} misses, {} other faults",
        args.out.join("report.html").display(),
        grouped(sum.frames),
        grouped(sum.misses),
        grouped(sum.faults)
    );
    Ok(if sum.is_good() { Outcome::Good } else { Outcome::CheckFailed })
}

/// The sections that were asked for; without a wish, all. And what the page begins with.
fn sections(lab: &Lab, wanted: &[SectionName]) -> Result<(Vec<Section>, Answer)> {
    let is_wanted = |name: &SectionName| wanted.is_empty() || wanted.contains(name);
    let names: Vec<SectionName> = SectionName::value_variants().iter().copied().filter(is_wanted).collect();
    let needs_sizes =
        |name: &SectionName| matches!(name, SectionName::Scaling | SectionName::Paper | SectionName::Ties);
    let sizes = if names.iter().any(needs_sizes) { sizes::sizes(lab)? } else { Vec::new() };
    let section = |name| match name {
        SectionName::Margins => margins::margins(lab),
        SectionName::Scaling => Ok(scaling::scaling(&sizes)),
        SectionName::Paper => Ok(paper::paper(&sizes)),
        SectionName::Movers => movers::movers(lab),
        SectionName::Speeds => speeds::speeds(lab),
        SectionName::Parts => parts::parts(lab),
        SectionName::Threads => threads::threads(lab),
        SectionName::Precision => precision::precision(lab),
        SectionName::Ties => Ok(ties::ties(&sizes)),
        SectionName::HardCases => hard_cases::hard_cases(lab),
        SectionName::RealScenes => real_scenes::real_scenes(lab),
    };
    let mut made = names.into_iter().map(section).collect::<Result<Vec<_>>>()?;
    if let Some(first) = made.first_mut() {
        first.text.push(lab.origin().into());
    }
    Ok((made, sizes::middle(&sizes).map(answer).unwrap_or_default()))
}

/// What somebody wants to know first.
fn answer(size: &Size) -> Answer {
    let (time, pairs) = (size.best().median, size.best().pairs_per_object() * f64::from(size.count));
    let times = size.as_printed.median / time;
    let answer = [
        (grouped(size.count.into()), "boxes, all of which move"),
        (format!("{time:.2} ms"), "a step on one thread"),
        (grouped(pairs as u64), "pairs in each step"),
        (format!("{times:.0} times"), "as fast as the method of the paper"),
    ];
    answer.map(|(number, of)| (number, of.to_owned())).into()
}
