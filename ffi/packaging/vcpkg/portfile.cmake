# An overlay port: vcpkg install trisap --overlay-ports=ffi/packaging/vcpkg. It builds the check-out or the unpacked source archive
# that it stands in. Needs Rust.
get_filename_component(SOURCE_PATH "${CURRENT_PORT_DIR}/../../.." ABSOLUTE)

string(COMPARE EQUAL "${VCPKG_LIBRARY_LINKAGE}" dynamic TRISAP_SHARED)
set(TRISAP_TARGET "")
if(VCPKG_TARGET_IS_WINDOWS AND VCPKG_TARGET_IS_MINGW)
    set(TRISAP_TARGET x86_64-pc-windows-gnu)
elseif(VCPKG_TARGET_IS_OSX AND VCPKG_TARGET_ARCHITECTURE STREQUAL arm64)
    set(TRISAP_TARGET aarch64-apple-darwin)
endif()

vcpkg_cmake_configure(
    SOURCE_PATH "${SOURCE_PATH}/ffi"
    OPTIONS
        -DTRISAP_SHARED=${TRISAP_SHARED}
        -DTRISAP_TARGET=${TRISAP_TARGET}
)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH lib/cmake/trisap)
vcpkg_fixup_pkgconfig()
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include" "${CURRENT_PACKAGES_DIR}/debug/share"
     "${CURRENT_PACKAGES_DIR}/share/licenses")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE-MIT" "${SOURCE_PATH}/LICENSE-APACHE"
    "${SOURCE_PATH}/ffi/packaging/THIRD-PARTY")
