//! Runs the tests once for each mutant, until one fails.

use crate::list::Mutant;
use std::collections::HashSet;
use std::fs::{self, File, OpenOptions};
use std::io::Write;
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// A run of tests: processor seconds that it may take, a program and its arguments.
struct Stage {
    seconds: u64,
    words: Vec<String>,
}

#[derive(PartialEq)]
enum End {
    Passed,
    Failed,
    RanForEver,
}

impl Stage {
    fn run(&self, number: u32) -> End {
        // Of the processor, so that a busy machine makes no mutant look endless; and memory, of which an endless loop may ask for all.
        let mut child = Command::new("sh")
            .args(["-c", "ulimit -t \"$0\" && ulimit -v 8000000 && exec \"$@\"", &self.seconds.to_string()])
            .args(&self.words)
            .env("TRISAP_MUTANT", number.to_string())
            .env("RUST_BACKTRACE", "0")
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .process_group(0)
            .spawn()
            .unwrap_or_else(|error| panic!("{}: {error}", self.words[0]));
        let start = Instant::now();
        let mut pause = Duration::from_millis(2);
        loop {
            if let Some(status) = child.try_wait().expect("a child") {
                return match status.signal() {
                    _ if status.success() => End::Passed,
                    Some(XCPU | KILL) => End::RanForEver,
                    _ => End::Failed,
                };
            }
            // Whoever waits for ever takes no processor.
            if start.elapsed() > Duration::from_secs(20 * self.seconds) {
                child.kill().expect("a child that runs");
                child.wait().expect("a child");
                return End::RanForEver;
            }
            std::thread::sleep(pause);
            pause = (pause * 2).min(Duration::from_millis(50));
        }
    }
}

/// What ends a process that has used up its processor seconds.
const XCPU: i32 = 24;
const KILL: i32 = 9;

/// A line of `stages` is a stage; those before are cheaper or see more. The results are added to a file, in which what stands is
/// not run again.
pub fn all(list: &[Mutant], numbers: &[u32], stages: &Path, results: &Path, jobs: usize) {
    let text = fs::read_to_string(stages).expect("the stages");
    let stages: Vec<Stage> = text
        .lines()
        .map(|line| {
            let mut words = line.split_whitespace().map(str::to_owned);
            let seconds = words.next().and_then(|word| word.parse().ok()).expect("seconds");
            Stage { seconds, words: words.collect() }
        })
        .collect();
    for stage in &stages {
        assert!(stage.run(0) == End::Passed, "fails without a mutant: {:?}", stage.words);
    }
    let done: HashSet<u32> = fs::read_to_string(results)
        .unwrap_or_default()
        .lines()
        .filter_map(|line| line.split_whitespace().next()?.parse().ok())
        .collect();
    let rest = Mutex::new(
        numbers.iter().copied().filter(|number| !done.contains(number)).collect::<Vec<_>>().into_iter(),
    );
    let file: Mutex<File> =
        Mutex::new(OpenOptions::new().create(true).append(true).open(results).expect("a file"));
    let one = || {
        loop {
            let Some(number) = rest.lock().expect("no panic").next() else { return };
            let start = Instant::now();
            let mut verdict = "survived".to_owned();
            for (stage, index) in stages.iter().zip(1..) {
                match stage.run(number) {
                    End::Passed => continue,
                    End::Failed => verdict = format!("killed-{index}"),
                    End::RanForEver => verdict = format!("for-ever-{index}"),
                }
                break;
            }
            let name = &list[number as usize - 1].name;
            let line = format!("{number} {verdict} {:.1} {name}\n", start.elapsed().as_secs_f64());
            file.lock().expect("no panic").write_all(line.as_bytes()).expect("room on the disk");
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..jobs {
            scope.spawn(one);
        }
    });
}
