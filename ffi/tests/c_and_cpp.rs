//! Installs the library as a user would, then compiles and runs the C and C++ tests of `tests/cpp` against it.
//!
//! Needs gcc, g++ and CMake. A test that needs more (clang, pkg-config, valgrind, Bullet) says that it is skipped where that is
//! missing; with `TRISAP_NO_SKIP` set, it fails.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::LazyLock;

/// Warnings are mistakes, here and for those who include the headers.
const WARNINGS: [&str; 6] = ["-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Wconversion", "-Werror"];
/// With what a complaint needs of debug information, the lines: all of it takes as long again to compile.
pub(crate) const SANITIZERS: [&str; 3] = ["-g1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"];
pub(crate) const STATIC: [&str; 1] = ["-l:libtrisap.a"];

/// Where this test run has installed the library.
static PREFIX: LazyLock<PathBuf> = LazyLock::new(|| {
    let (build, prefix) = (scratch("install"), scratch("prefix"));
    // What an older version of this test has installed is not there for a consumer to find.
    remove(&prefix);
    let mut configure = cmake();
    configure.arg("-S").arg(repository().join("ffi")).arg("-B").arg(&build);
    succeed(configure.arg("-DCMAKE_BUILD_TYPE=Release").arg("-DCMAKE_INSTALL_LIBDIR=lib"));
    succeed(cmake().arg("--build").arg(&build));
    succeed(cmake().arg("--install").arg(&build).arg("--prefix").arg(&prefix));
    prefix
});

/// CMake, which has cargo build into one folder for all of these tests.
fn cmake() -> Command {
    let mut cmake = Command::new("cmake");
    cmake.env("CARGO_TARGET_DIR", scratch("build"));
    cmake
}

fn remove(folder: &Path) {
    if folder.exists() {
        std::fs::remove_dir_all(folder).expect("a folder of this test");
    }
}

fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("ffi is a folder of the repository")
}

fn sources() -> PathBuf {
    repository().join("tests/cpp")
}

pub(crate) fn scratch(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

fn run(command: &mut Command) -> Output {
    command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"))
}

/// Runs the command, which must succeed, and returns what it printed.
pub(crate) fn succeed(command: &mut Command) -> String {
    let output = run(command);
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let (printed, complained) = (text(&output.stdout), text(&output.stderr));
    assert!(output.status.success(), "{command:?}: {}\n{printed}\n{complained}", output.status);
    print!("{printed}");
    printed
}

/// Whether the command can be run; if not, why the test is skipped.
pub(crate) fn available(command: &str, needed_for: &str) -> bool {
    let works = Command::new(command).arg("--version").output().is_ok_and(|output| output.status.success());
    works || skip(&format!("{command} is not installed: {needed_for}"))
}

/// Says that a test is skipped, also where the test harness keeps output to itself.
fn skip(reason: &str) -> bool {
    assert!(std::env::var_os("TRISAP_NO_SKIP").is_none(), "skipped: {reason}");
    writeln!(std::io::stderr(), "skipped: {reason}").expect("an open standard error");
    false
}

/// A program to be compiled.
pub(crate) struct Program {
    compile: Command,
    path: PathBuf,
}

impl Program {
    fn c(source: &str, name: &str) -> Self {
        Self::new("gcc", "-std=c11", &sources().join(source), name)
    }

    fn cpp(standard: &str, source: &str, name: &str) -> Self {
        Self::cpp_by("g++", standard, source, name)
    }

    pub(crate) fn cpp_by(compiler: &str, standard: &str, source: &str, name: &str) -> Self {
        Self::new(compiler, standard, &sources().join(source), name)
    }

    fn new(compiler: &str, standard: &str, source: &Path, name: &str) -> Self {
        let path = scratch(name);
        let mut compile = Command::new(compiler);
        compile.arg(standard).args(WARNINGS).arg("-I").arg(PREFIX.join("include"));
        compile.arg(source).arg("-o").arg(&path).arg("-L").arg(PREFIX.join("lib")).arg("-pthread");
        Self { compile, path }
    }

    pub(crate) fn with<'a>(mut self, arguments: impl IntoIterator<Item = &'a str>) -> Self {
        self.compile.args(arguments);
        self
    }

    /// Compiles it and returns how to run it.
    pub(crate) fn build(mut self) -> Command {
        succeed(&mut self.compile);
        let mut program = Command::new(self.path);
        program.env("LD_LIBRARY_PATH", PREFIX.join("lib"));
        program
    }
}

fn recordings() -> [PathBuf; 3] {
    ["brownian_cubes_8000", "freefall_cubes_1000", "gravity_assorted_1000"]
        .map(|name| repository().join("tests/recordings").join(name).with_extension("aabbs"))
}

#[test]
fn c11() {
    for test in ["life", "misuse", "regressions"] {
        let source = format!("{test}.c");
        succeed(&mut Program::c(&source, test).with(SANITIZERS).with(STATIC).build());
        succeed(&mut Program::c(&source, &format!("{test}_shared")).with(["-O2", "-ltrisap"]).build());
    }
}

#[test]
fn cpp17_and_cpp20() {
    for standard in ["-std=c++17", "-std=c++20"] {
        for test in ["wrapper", "owner", "jobs"] {
            let name = format!("{test}{standard}");
            let program = Program::cpp(standard, &format!("{test}.cpp"), &name);
            succeed(&mut program.with(SANITIZERS).with(["-O1"]).with(STATIC).build());
        }
    }
}

/// A pool of a library, shared by several worlds.
#[test]
fn jobs_of_tbb() {
    if !Path::new("/usr/include/oneapi/tbb").exists() {
        skip("libtbb-dev is not installed: no world shares tasks with oneTBB");
        return;
    }
    let program = Program::cpp("-std=c++17", "jobs.cpp", "jobs_tbb").with(["-O2", "-DWITH_TBB"]);
    succeed(&mut program.with(STATIC).with(["-ltbb"]).build());
}

/// No package has enkiTS: `TRISAP_ENKITS` names the folder of its sources.
#[test]
fn jobs_of_enkits() {
    let Some(folder) = std::env::var_os("TRISAP_ENKITS") else {
        writeln!(std::io::stderr(), "skipped: TRISAP_ENKITS names no sources of enkiTS")
            .expect("an open standard error");
        return;
    };
    let mut program = Program::cpp("-std=c++17", "jobs.cpp", "jobs_enkits").with(["-O2", "-DWITH_ENKITS"]);
    program.compile.arg("-isystem").arg(Path::new(&folder).join("src"));
    succeed(&mut program.with(STATIC).build());
}

#[test]
fn recorded_pairs_are_those_of_brute_force() {
    // Brute force takes its time under the sanitizers: a few frames there, all of them without.
    let source = "recordings.cpp";
    let quick = Program::cpp("-std=c++20", source, "recordings").with(["-O3", "-ltrisap"]).build();
    let watched = Program::cpp("-std=c++17", source, "recordings_watched");
    let watched = watched.with(SANITIZERS).with(["-O1"]).with(STATIC).build();
    for recording in recordings() {
        succeed(Command::new(quick.get_program()).env("LD_LIBRARY_PATH", PREFIX.join("lib")).arg(&recording));
        succeed(Command::new(watched.get_program()).arg(&recording).arg("3"));
    }
}

/// Brute force is slow: `TRISAP_EFFORT` multiplies the number of sequences; with 20 they are a thousand.
#[test]
fn random_operations_match_brute_force() {
    let effort = std::env::var("TRISAP_EFFORT").map_or(1, |effort| effort.parse().expect("a number"));
    let sequences = 50 * effort;
    let source = "operations.cpp";
    let program = Program::cpp("-std=c++20", source, "operations").with(["-O2"]).with(STATIC).build();
    let watched = Program::cpp("-std=c++17", source, "operations_watched");
    let watched = watched.with(SANITIZERS).with(["-O1"]).with(STATIC).build();
    succeed(Command::new(program.get_program()).arg(sequences.to_string()));
    // Others under the sanitizers.
    succeed(Command::new(watched.get_program()).args(["12", "10001"]));
}

/// Ten thousand sequences with growth at random moments.
#[test]
fn a_world_that_grows_says_what_a_large_one_says() {
    let program =
        Program::cpp("-std=c++17", "growth.cpp", "growth").with(SANITIZERS).with(["-O1"]).with(STATIC);
    let printed = succeed(&mut program.build());
    assert!(printed.contains("grown for objects"), "{printed}");
}

#[test]
fn the_first_lines_of_the_readme_run() {
    let readme = std::fs::read_to_string(repository().join("README.md")).expect("the README");
    let (_, lines) = readme.split_once("```cpp\n").expect("C++");
    let (lines, _) = lines.split_once("```").expect("an end");
    let around = "#include <cstdio>\n#include <trisap.hpp>\n#include <vector>\n\
        struct Body { float min[3], max[3]; };\n\
        static void collide(Body &a, Body &b) { std::printf(\"%g %g\\n\", a.min[0], b.min[0]); }\n\
        static bool play(std::vector<Body> &bodies) {\nLINES\nreturn true;\n}\n\
        int main() {\n\
        std::vector<Body> bodies{{{0, 0, 0}, {2, 2, 2}}, {{5, 5, 5}, {6, 6, 6}}, {{1, 1, 1}, {3, 3, 3}}}, none;\n\
        return play(bodies) && play(none) ? 0 : 1;\n}\n";
    let source = scratch("readme.cpp");
    std::fs::write(&source, around.replace("LINES", lines)).expect("a file of this test");
    let program = Program::new("g++", "-std=c++17", &source, "readme");
    let printed = succeed(&mut program.with(["-D_GLIBCXX_ASSERTIONS"]).with(SANITIZERS).with(STATIC).build());
    assert_eq!(printed, "0 1\n");
}

/// With the header's own warnings: each piece of C is a function of its own, behind what it defines.
#[test]
fn the_c_of_the_manual_compiles() {
    let manual = std::fs::read_to_string(repository().join("ffi/README.md")).expect("the manual");
    let mut program = "#include <stddef.h>\n#include <stdlib.h>\n#include <trisap.h>\n\
        struct body { float min[3], max[3]; };\n\
        extern struct body bodies[];\n\
        extern trisap_aabb aabbs[], spawn;\n\
        extern trisap_boxes boxes;\n\
        extern trisap_id ids[], parked[], own;\n\
        extern trisap_result result;\n\
        extern trisap_status status;\n\
        extern trisap_world *world;\n\
        extern float eye[], direction[];\n\
        extern size_t count, parked_count;\n\
        extern void *engine;\n\
        void end_contact(uint32_t, uint32_t), begin_contact(uint32_t, uint32_t), narrow_phase(uint32_t, uint32_t);\n\
        void engine_parallel(void *, const char *, uint32_t, void (*)(void *), void *);\n"
        .to_owned();
    let pieces: Vec<&str> =
        manual.split("```c\n").skip(1).filter_map(|piece| piece.split("```").next()).collect();
    for (number, piece) in pieces.iter().enumerate() {
        let defines = piece.starts_with("static ") || piece.starts_with("#include");
        let (before, lines) = piece.split_once("\n\n").filter(|_| defines).unwrap_or(("", piece));
        program += &format!("{before}\nvoid piece{number}(void);\nvoid piece{number}(void) {{\n{lines}}}\n");
    }
    assert!(pieces.len() > 5 && pieces.iter().any(|piece| piece.contains("trisap_world_set_enabled")));
    let source = scratch("manual.c");
    std::fs::write(&source, program).expect("a file of this test");
    let without = ["-Wno-shadow", "-Wno-unused-variable", "-Wno-unused-but-set-variable", "-c"];
    succeed(&mut Program::new("gcc", "-std=c11", &source, "manual").with(without).compile);
}

#[test]
fn the_example_of_rollback_runs() {
    let source = repository().join("ffi/examples/rollback.cpp");
    let program = Program::new("g++", "-std=c++17", &source, "rollback").with(["-O1"]).with(SANITIZERS);
    let printed = succeed(&mut program.with(STATIC).build());
    assert!(printed.starts_with("120 frames, gone back by 8 every 8: the same pairs"), "{printed}");
}

#[test]
fn the_example_engine_runs() {
    let source = repository().join("ffi/examples/engine.cpp");
    let flags = ["-Wno-conversion", "-O2"];
    let program =
        Program::new("g++", "-std=c++17", &source, "engine").with(flags).with(SANITIZERS).with(STATIC);
    let printed = succeed(&mut program.build());
    assert!(printed.lines().count() == 4 && printed.contains("frame 120: "), "{printed}");
    // The job system's own races, if it had any. trisap itself is not instrumented.
    let program = Program::new("g++", "-std=c++17", &source, "engine_threads").with(flags).with(STATIC);
    assert_eq!(printed, succeed(&mut program.with(["-g1", "-fsanitize=thread"]).build()));
}

#[test]
fn sanitizers_are_active() {
    let program = Program::c("broken.c", "broken").with(SANITIZERS).with(STATIC).build();
    succeed(&mut Command::new(program.get_program()));
    for (what, message) in [
        ("address", "heap-buffer-overflow"),
        ("undefined", "signed integer overflow"),
        ("leak", "detected memory leaks"),
    ] {
        let output = run(Command::new(program.get_program()).arg(what));
        let complaint = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && complaint.contains(message), "{what}: {complaint}");
    }
}

/// The sanitizers see what C and C++ do; valgrind sees the library, too.
#[test]
fn valgrind() {
    if !available("valgrind", "the library's own memory accesses are not watched") {
        return;
    }
    let watch = |program: &Command| {
        let mut valgrind = Command::new("valgrind");
        valgrind.args(["--quiet", "--error-exitcode=9", "--leak-check=full"]).arg(program.get_program());
        valgrind
    };
    for test in ["life", "misuse", "regressions"] {
        let program = Program::c(&format!("{test}.c"), &format!("{test}_valgrind"));
        succeed(&mut watch(&program.with(["-g1"]).with(STATIC).build()));
    }
    let program = Program::cpp("-std=c++17", "recordings.cpp", "recordings_valgrind");
    let program = program.with(["-g1", "-O2"]).with(STATIC).build();
    succeed(watch(&program).arg(&recordings()[1]).arg("2"));
    // Proof that it looks.
    let program = Program::c("broken.c", "broken_valgrind").with(["-g1"]).with(STATIC).build();
    assert_eq!(run(watch(&program).arg("address")).status.code(), Some(9));
}

/// The functions that the header declares.
fn declared() -> Vec<String> {
    let header = std::fs::read_to_string(repository().join("include/trisap.h")).expect("the header");
    let code = header.lines().filter(|line| !line.trim_start().starts_with("//"));
    let mut names: Vec<String> = code
        .filter_map(|line| {
            let (before, _) = line.split_once('(')?;
            let name = before.rsplit([' ', '*']).next()?;
            name.starts_with("trisap_").then(|| name.to_owned())
        })
        .collect();
    names.sort();
    names
}

#[test]
fn exported_symbols_are_those_of_the_header() {
    let declared = declared();
    assert!(declared.len() > 30 && declared.contains(&"trisap_world_step".to_owned()), "{declared:?}");

    let shared = PREFIX.join("lib/libtrisap.so");
    let symbols = |option: &str, file: &Path| {
        let listed = succeed(Command::new("nm").args(["-D", option]).arg(file));
        let fields: Vec<Vec<String>> =
            listed.lines().map(|line| line.split_whitespace().map(str::to_owned).collect()).collect();
        fields
    };
    let exported: Vec<String> =
        symbols("--defined-only", &shared).iter().map(|fields| fields[2].clone()).collect();
    assert_eq!(exported, declared);

    // It asks nobody for more than this; weak symbols are the C runtime's.
    for fields in symbols("--undefined-only", &shared) {
        let name = fields[1].split('@').next().expect("a name");
        let known = ["abort", "bcmp", "memcpy", "memmove", "memset", "memcmp"].contains(&name);
        assert!(fields[0] == "w" || known, "libtrisap.so needs {name}");
    }

    // In the archive no other names are there, not even hidden ones, which a program that links it would see.
    let listed = succeed(Command::new("readelf").arg("-sW").arg(PREFIX.join("lib/libtrisap.a")));
    let mut visible: Vec<&str> = listed
        .lines()
        .map(|line| line.split_whitespace().collect::<Vec<_>>())
        .filter(|fields| fields.len() == 8 && ["GLOBAL", "WEAK"].contains(&fields[4]) && fields[6] != "UND")
        .map(|fields| fields[7])
        .collect();
    visible.sort_unstable();
    assert_eq!(visible, declared);
}

#[test]
fn the_shared_library_is_named_by_its_abi() {
    let dynamic = succeed(Command::new("readelf").arg("-dW").arg(PREFIX.join("lib/libtrisap.so")));
    let abi = trisap_ffi::version::TRISAP_ABI_VERSION;
    let name = format!("[libtrisap.so.{abi}]");
    assert!(dynamic.lines().any(|line| line.contains("SONAME") && line.contains(&name)), "{dynamic}");
    // cargo-c installs it under the name that the manifest says.
    let library = include_str!("../Cargo.toml").split("[package.metadata.capi.library]").nth(1);
    assert!(library.is_some_and(|library| library.contains(&format!("version = \"{abi}.0.0\""))));
}

/// An installed tree that was moved to another place.
fn moved_prefix(name: &str) -> PathBuf {
    let moved = scratch(name);
    remove(&moved);
    succeed(Command::new("cp").arg("-R").arg(&*PREFIX).arg(&moved));
    moved
}

/// How to configure the consumer that takes trisap in in some way.
fn consumer(by: &str, build: &Path) -> Command {
    let mut configure = cmake();
    configure.arg("-S").arg(sources().join("consumers/cmake")).arg("-B").arg(build);
    configure.arg(format!("-Dtrisap_by={by}"));
    configure
}

#[test]
fn cmake_finds_it() {
    let prefix = moved_prefix("cmake prefix");
    let build = scratch("cmake build");
    remove(&build);
    let configure = |version: &str| {
        let mut configure = consumer("find_package", &build);
        configure.arg(format!("-DCMAKE_PREFIX_PATH={}", prefix.display()));
        configure.arg(format!("-Dtrisap_wanted={version}"));
        configure
    };
    succeed(&mut configure("0.1"));
    test_consumer(&build);
    // What it cannot be is refused.
    for version in ["0.2", "1.0", "0.1.99"] {
        assert!(!run(&mut configure(version)).status.success(), "{version}");
    }
}

/// The build tree of trisap is a part of that of another project.
#[test]
fn cmake_takes_it_in() {
    // Cargo has built the same by then.
    LazyLock::force(&PREFIX);
    for by in ["FetchContent", "add_subdirectory"] {
        let build = scratch(&format!("cmake {by}"));
        remove(&build);
        succeed(consumer(by, &build).arg("-DCMAKE_BUILD_TYPE=Release"));
        test_consumer(&build);
        // Of what a project only takes in nothing is installed.
        let installed = scratch(&format!("{by} prefix"));
        remove(&installed);
        succeed(cmake().arg("--install").arg(&build).arg("--prefix").arg(&installed));
        assert!(!installed.join("include").exists());
    }
}

fn test_consumer(build: &Path) {
    succeed(cmake().arg("--build").arg(build));
    let printed = succeed(Command::new("ctest").arg("--test-dir").arg(build));
    assert!(printed.contains("100% tests passed, 0 tests failed out of 6"), "{printed}");
}

/// Two compilers, all standards, and what engines turn off. The C header is good for C++11, too.
#[test]
fn compilers_and_standards() {
    let compilers = [("gcc", "g++"), ("clang", "clang++")];
    for (c, cpp) in compilers {
        if !available(c, "one compiler less is tested") {
            continue;
        }
        let consumers = sources().join("consumers");
        let run = |program: Program| {
            let printed = succeed(&mut program.with(STATIC).build());
            assert!(printed.contains("1 pair"), "{printed}");
        };
        run(Program::new(c, "-std=c11", &consumers.join("main.c"), &format!("c11_{c}")));
        // A language counts for what comes behind it.
        let mut program = Program::new(cpp, "-std=c++11", &consumers.join("main.c"), &format!("c++11_{c}"));
        let mut arguments: Vec<_> = program.compile.get_args().map(std::ffi::OsStr::to_owned).collect();
        let source = arguments.iter().position(|argument| argument == consumers.join("main.c").as_os_str());
        let source = source.expect("the source is an argument");
        arguments.splice(source..=source, ["-xc++".into(), arguments[source].clone(), "-xnone".into()]);
        program.compile = Command::new(cpp);
        program.compile.args(arguments);
        run(program);
        for standard in ["-std=c++17", "-std=c++20"] {
            let without = ["-fno-exceptions", "-fno-rtti"];
            let name = format!("{standard}_{c}");
            run(Program::new(cpp, standard, &consumers.join("main.cpp"), &name).with(without));
            let name = format!("wrapper{standard}_{c}");
            let wrapper = Program::cpp_by(cpp, standard, "wrapper.cpp", &name);
            succeed(
                &mut wrapper
                    .with(without)
                    .with(["-fsyntax-only", "-Wno-unused-command-line-argument"])
                    .compile,
            );
        }
    }
}

/// The libraries say nothing of the machine that built them, and their licences are installed with them.
#[test]
fn nothing_of_this_machine_is_installed() {
    let home = std::env::var("CARGO_HOME").or_else(|_| std::env::var("HOME")).expect("a home");
    for library in ["libtrisap.a", "libtrisap.so"] {
        let bytes = std::fs::read(PREFIX.join("lib").join(library)).expect("a library");
        for path in [repository().to_str().expect("UTF-8"), &home, env!("CARGO_TARGET_TMPDIR")] {
            let found = bytes.windows(path.len()).position(|window| window == path.as_bytes());
            assert_eq!(found, None, "{library} names {path}");
        }
        // They are stripped.
        let sections = succeed(Command::new("readelf").arg("-SW").arg(PREFIX.join("lib").join(library)));
        assert!(!sections.contains(".debug_"), "{library} has debug information");
    }
    let licences = PREFIX.join("share/licenses/trisap");
    let third = std::fs::read_to_string(licences.join("THIRD-PARTY")).expect("licences of others");
    let mut tree = Command::new(env!("CARGO"));
    tree.args(["tree", "--locked", "--package", "trisap-ffi", "--edges", "normal,no-proc-macro"]);
    let tree = succeed(tree.args(["--prefix", "none", "--target", "all"]).current_dir(repository()));
    let mut crates = 0;
    for name in tree.lines().filter_map(|line| line.split(' ').next()) {
        let ours = name.starts_with("trisap");
        assert!(ours || third.lines().any(|line| line.starts_with(name)), "{name}");
        crates += usize::from(!ours);
    }
    assert!(crates > 0 && licences.join("LICENSE-MIT").exists() && licences.join("LICENSE-APACHE").exists());
}

#[test]
fn pkg_config_finds_it() {
    if !available("pkg-config", "the pkg-config file is not tested")
        || !available("make", "the pkg-config file is not tested")
    {
        return;
    }
    let prefix = moved_prefix("pkg_config_prefix");
    let build = scratch("pkg-config build");
    std::fs::create_dir_all(&build).expect("a folder of this test");
    let mut make = Command::new("make");
    make.arg("-B").arg("-f").arg(sources().join("consumers/pkg-config/Makefile"));
    make.arg(format!("SOURCES={}", sources().join("consumers").display()));
    succeed(make.current_dir(&build).env("PKG_CONFIG_PATH", prefix.join("lib/pkgconfig")));
    for program in ["c_shared", "c_static", "cpp_shared"] {
        let printed = succeed(&mut Command::new(build.join(program)));
        assert!(printed.contains("1 pair"), "{printed}");
    }
}

/// The folder of a package of `tests/cpp/hosts`, as cargo has unpacked it.
fn host(metadata: &str, package: &str) -> Option<PathBuf> {
    let path = metadata.split('"').find(|text| {
        let folder = text.strip_suffix("/Cargo.toml").and_then(|folder| folder.rsplit('/').next());
        folder.is_some_and(|folder| folder.starts_with(package))
    })?;
    Path::new(path).parent().map(Path::to_owned)
}

#[test]
fn adapters_fit_the_job_systems_of_others() {
    let manifest = sources().join("hosts/Cargo.toml");
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["metadata", "--locked", "--format-version", "1", "--manifest-path"]).arg(manifest);
    let output = run(&mut cargo);
    if !output.status.success() {
        skip(&format!(
            "no headers of Jolt, Box3D and PhysX: {}",
            String::from_utf8_lossy(&output.stderr).trim()
        ));
        return;
    }
    let metadata = String::from_utf8_lossy(&output.stdout);
    let folder =
        |package: &str| host(&metadata, package).unwrap_or_else(|| panic!("cargo names no {package}"));
    let program = |name: &str, headers: &[PathBuf]| {
        let mut program = Program::cpp("-std=c++17", &format!("hosts/{name}.cpp"), &format!("hosts_{name}"));
        for headers in headers {
            program.compile.arg("-isystem").arg(headers);
        }
        program
    };

    let box3d = [folder("boxddd-sys").join("third-party/box3d/include")];
    succeed(&mut program("box3d", &box3d).with(SANITIZERS).with(STATIC).build());
    let physx = folder("physx-sys").join("physx");
    let physx = [physx.join("physx/include"), physx.join("pxshared/include")];
    succeed(&mut program("physx", &physx).with(["-DNDEBUG"]).with(SANITIZERS).with(STATIC).build());
    let jolt = [folder("joltc-sys").join("JoltC/JoltPhysics")];
    succeed(&mut program("jolt", &jolt).with(["-c"]).compile);
}

/// As on a machine without Debian's packages: all that the script finds is what it needs to begin.
#[test]
fn packages_that_cannot_be_made_are_skipped() {
    let folder = scratch("few_commands");
    remove(&folder);
    std::fs::create_dir_all(&folder).expect("a folder of this test");
    for command in ["bash", "dirname", "mkdir", "tr"] {
        let paths = std::env::var_os("PATH").expect("a path");
        let found = std::env::split_paths(&paths).map(|path| path.join(command)).find(|path| path.exists());
        std::os::unix::fs::symlink(found.expect(command), folder.join(command))
            .expect("a folder of this test");
    }
    let packages = || {
        let mut packages = Command::new(folder.join("bash"));
        packages.arg(sources().join("packages.sh")).args(["windows", "macos", "conan"]);
        packages.env_remove("TRISAP_NO_SKIP").env("PATH", &folder).env("CARGO_TARGET_DIR", &folder);
        packages
    };
    let said = succeed(&mut packages());
    assert_eq!(said.lines().filter(|line| line.starts_with("skipped: ")).count(), 3, "{said}");
    assert!(!run(packages().env("TRISAP_NO_SKIP", "1")).status.success(), "nothing is skipped");
}

/// A program of `tests/cpp/bullet`; none where Bullet is not installed.
fn bullet_program(source: &str, name: &str, flags: &[&str]) -> Option<Command> {
    if !Path::new("/usr/include/bullet").exists() {
        skip("libbullet-dev is not installed: Bullet does not run on trisap");
        return None;
    }
    let program = Program::cpp("-std=c++17", &format!("bullet/{source}.cpp"), name);
    let program = program.with(["-isystem", "/usr/include/bullet"]).with(flags.iter().copied()).with(STATIC);
    Some(program.with(["-lBulletDynamics", "-lBulletCollision", "-lLinearMath"]).build())
}

#[test]
fn bullet() {
    let Some(mut program) = bullet_program("simulate", "bullet", &["-O2"]) else { return };
    let printed = succeed(&mut program);
    assert_eq!(printed.matches("broad phase a step").count(), 3);
    // The times are worth to be seen.
    for line in printed.lines().filter(|line| line.contains("broad phase a step")) {
        writeln!(std::io::stderr(), "{line}").expect("an open standard error");
    }
}

/// Rays from threads, rules that change, boxes with NaN.
#[test]
fn bullet_between_steps() {
    let flags = [&SANITIZERS[..], &["-O1"]].concat();
    let Some(mut program) = bullet_program("changes", "bullet_changes", &flags) else { return };
    succeed(&mut program);
    // What the adapter itself does on threads; `tests/threads.sh` watches the library, too.
    let flags = ["-O1", "-g1", "-fsanitize=thread"];
    let watched = bullet_program("changes", "bullet_threads", &flags).expect("Bullet");
    succeed(Command::new(watched.get_program()).arg("threads"));
}
