# Runs the portfile in PORT as vcpkg would, with stand-ins for what it calls, and installs to PACKAGES. vcpkg itself does more: it
# builds twice, and looks at what was installed.
cmake_minimum_required(VERSION 3.18)

set(CURRENT_PORT_DIR "${PORT}")
set(CURRENT_PACKAGES_DIR "${PACKAGES}")
set(VCPKG_LIBRARY_LINKAGE dynamic)

function(run)
    execute_process(COMMAND ${ARGV} RESULT_VARIABLE result)
    if(result)
        message(FATAL_ERROR "${ARGV}: ${result}")
    endif()
endfunction()

function(vcpkg_cmake_configure)
    cmake_parse_arguments(PARSE_ARGV 0 arg "" "SOURCE_PATH" "OPTIONS")
    run("${CMAKE_COMMAND}" -S "${arg_SOURCE_PATH}" -B "${PACKAGES}-build" -DCMAKE_BUILD_TYPE=Release
        "-DCMAKE_INSTALL_PREFIX=${PACKAGES}" -DCMAKE_INSTALL_LIBDIR=lib ${arg_OPTIONS})
endfunction()

function(vcpkg_cmake_install)
    run("${CMAKE_COMMAND}" --build "${PACKAGES}-build")
    run("${CMAKE_COMMAND}" --install "${PACKAGES}-build")
endfunction()

# Moves the package to share/trisap; a file of the package finds the prefix from there.
function(vcpkg_cmake_config_fixup)
    cmake_parse_arguments(PARSE_ARGV 0 arg "" "CONFIG_PATH" "")
    file(MAKE_DIRECTORY "${PACKAGES}/share")
    file(RENAME "${PACKAGES}/${arg_CONFIG_PATH}" "${PACKAGES}/share/trisap")
    file(READ "${PACKAGES}/share/trisap/trisapConfig.cmake" config)
    string(REPLACE "\${CMAKE_CURRENT_LIST_DIR}/../../../" "\${CMAKE_CURRENT_LIST_DIR}/../../" config "${config}")
    file(WRITE "${PACKAGES}/share/trisap/trisapConfig.cmake" "${config}")
endfunction()

function(vcpkg_fixup_pkgconfig)
    if(NOT EXISTS "${PACKAGES}/lib/pkgconfig/trisap.pc")
        message(FATAL_ERROR "no trisap.pc")
    endif()
endfunction()

function(vcpkg_install_copyright)
    cmake_parse_arguments(PARSE_ARGV 0 arg "" "" "FILE_LIST")
    foreach(file IN LISTS arg_FILE_LIST)
        file(READ "${file}" text)
        file(APPEND "${PACKAGES}/share/trisap/copyright" "${text}\n")
    endforeach()
endfunction()

include("${PORT}/portfile.cmake")
file(SIZE "${PACKAGES}/share/trisap/copyright" length)
if(length LESS 10000)
    message(FATAL_ERROR "licences are missing")
endif()
