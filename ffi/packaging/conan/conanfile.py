"""Conan 2: `conan create ffi/packaging/conan`. Packages the check-out or the unpacked source archive that it stands in."""

import os
import re

from conan import ConanFile
from conan.tools.cmake import CMake, CMakeToolchain, cmake_layout
from conan.tools.files import copy, load


class Trisap(ConanFile):
    name = "trisap"
    description = "Broad-phase collision detection in memory that the caller lends"
    license = "MIT OR Apache-2.0"
    topics = ("collision-detection", "broad-phase", "physics", "game-development")
    package_type = "library"
    settings = "os", "arch", "compiler", "build_type"
    options = {"shared": [True, False]}
    default_options = {"shared": False}

    @property
    def _root(self):
        return os.path.join(self.recipe_folder, "..", "..", "..")

    def set_version(self):
        text = load(self, os.path.join(self._root, "ffi", "src", "version.rs"))
        numbers = re.findall(r"TRISAP_VERSION_(?:MAJOR|MINOR|PATCH): u32 = (\d+)", text)
        self.version = ".".join(numbers)

    def export_sources(self):
        built = ("target/*", "*/target/*", "build/*", "*/build/*", "*/node_modules/*", ".git/*")
        copy(self, "*", src=self._root, dst=self.export_sources_folder, excludes=built)

    def configure(self):
        # Its interface is C.
        self.settings.rm_safe("compiler.libcxx")
        self.settings.rm_safe("compiler.cppstd")

    def layout(self):
        cmake_layout(self, src_folder=".")

    def generate(self):
        toolchain = CMakeToolchain(self)
        toolchain.cache_variables["TRISAP_SHARED"] = bool(self.options.shared)
        targets = {("Windows", "gcc"): "x86_64-pc-windows-gnu", ("Macos", "armv8"): "aarch64-apple-darwin"}
        for key in ((str(self.settings.os), str(self.settings.compiler)), (str(self.settings.os), str(self.settings.arch))):
            if key in targets:
                toolchain.cache_variables["TRISAP_TARGET"] = targets[key]
        toolchain.generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure(build_script_folder="ffi")
        cmake.build()

    def package(self):
        CMake(self).install()
        copy(self, "*", src=os.path.join(self.package_folder, "share", "licenses", "trisap"),
             dst=os.path.join(self.package_folder, "licenses"))

    def package_info(self):
        self.cpp_info.libs = ["trisap"]
        self.cpp_info.set_property("cmake_file_name", "trisap")
        self.cpp_info.set_property("cmake_target_name", "trisap::trisap")
        self.cpp_info.set_property("pkg_config_name", "trisap")
