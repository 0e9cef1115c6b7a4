//! Compiles the C++ sides of the peers that are switched on.

use std::{
    env,
    path::{Path, PathBuf},
    process::Command,
};

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=cpp");
    let on = |feature: &str| env::var(format!("CARGO_FEATURE_{feature}")).is_ok();
    // Asked only where a peer is compiled from the sources in a package.
    let package = |name: &str| Packages::read().folder(name);

    if on("PHYSX") {
        // As the crate compiles PhysX itself: its headers depend on these.
        let physx = package("physx-sys").join("physx");
        let mut build = shim();
        build.include(physx.join("physx/include")).include(physx.join("pxshared/include"));
        build.define("PX_PHYSX_STATIC_LIB", None).define("DISABLE_CUDA_PHYSX", None);
        build.file("cpp/physx.cpp").compile("peer_physx");
    }
    if on("EMBREE") {
        native().file("cpp/embree.cpp").file("cpp/embree_queries.cpp").compile("peer_embree");
        println!("cargo:rustc-link-lib=embree3");
    }
    if on("CGAL") {
        native().file("cpp/cgal.cpp").compile("peer_cgal");
        println!("cargo:rustc-link-lib=tbb");
    }
    if on("BULLET") {
        native().include("/usr/include/bullet").file("cpp/bullet.cpp").compile("peer_bullet");
        println!("cargo:rustc-link-lib=BulletCollision");
        println!("cargo:rustc-link-lib=LinearMath");
    }
    if on("BOX3D") {
        let box3d = package("boxddd-sys").join("third-party/box3d");
        let include = [box3d.join("include"), box3d.join("src")];
        native().includes(&include).file("cpp/box3d.cpp").compile("peer_box3d");
        let mut build = native();
        build.cpp(false).std("c17").flag("-ffp-contract=off").includes(&include);
        build.define("_POSIX_C_SOURCE", "199309L");
        build.files(sources(&box3d.join("src"), "c")).compile("box3d");
    }
    if on("JOLT") {
        let jolt = package("joltc-sys").join("JoltC/JoltPhysics");
        let mut build = shim();
        // The switches of Jolt's own `Distribution` build for x86-64.
        for flag in
            ["-mavx2", "-mbmi", "-mpopcnt", "-mlzcnt", "-mf16c", "-mfma", "-mfpmath=sse", "-ffp-contract=off"]
        {
            build.flag(flag);
        }
        for level in ["SSE4_1", "SSE4_2", "AVX", "AVX2", "LZCNT", "TZCNT", "F16C", "FMADD"] {
            build.define(&format!("JPH_USE_{level}"), None);
        }
        build.define("JPH_OBJECT_LAYER_BITS", "16").include(&jolt);
        build.file("cpp/jolt.cpp").files(sources(&jolt.join("Jolt"), "cpp")).compile("peer_jolt");
    }
}

/// All files in a folder with this ending.
fn sources(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in folder.read_dir().expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            found.extend(sources(&path, ending));
        } else if path.extension().is_some_and(|e| e == ending) {
            found.push(path);
        }
    }
    found.sort();
    found
}

fn shim() -> cc::Build {
    let mut build = cc::Build::new();
    build.cpp(true).std("c++17").opt_level(3).define("NDEBUG", None).warnings(false);
    build
}

/// For what is compiled here whole, and has no switch of its own for the CPU.
fn native() -> cc::Build {
    let mut build = shim();
    build.flag("-march=native");
    build
}

/// Where cargo keeps the sources of the packages in the lock file.
struct Packages(String);

impl Packages {
    fn read() -> Self {
        let cargo = env::var("CARGO").expect("cargo names itself");
        let output = Command::new(cargo)
            .args(["metadata", "--format-version=1", "--locked", "--all-features"])
            .output()
            .expect("cargo metadata runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        Self(String::from_utf8(output.stdout).expect("metadata are UTF-8"))
    }

    /// The folder of a package.
    fn folder(&self, name: &str) -> PathBuf {
        let folder = self.0.split("\"manifest_path\":\"").skip(1).find_map(|rest| {
            let folder = rest.split('"').next()?.strip_suffix("/Cargo.toml")?;
            let version = folder.rsplit('/').next()?.strip_prefix(name)?.strip_prefix('-')?;
            version.starts_with(|c: char| c.is_ascii_digit()).then(|| PathBuf::from(folder))
        });
        folder.unwrap_or_else(|| panic!("{name} is not among the packages"))
    }
}
