# Takes debug information out of a static library: `cmake -DAR= -DSTRIP= -DLIBRARY= -P strip.cmake`. What Rust's own standard library
# brings of it in members of their own (.dwo) goes as a whole: some versions of strip refuse an archive with such members.
execute_process(COMMAND "${AR}" t "${LIBRARY}" OUTPUT_VARIABLE members)
string(REGEX MATCHALL "[^\n\r]+[.]dwo" split "${members}")
if(split)
    execute_process(COMMAND "${AR}" d "${LIBRARY}" ${split} RESULT_VARIABLE failed)
endif()
if(NOT failed)
    execute_process(COMMAND "${STRIP}" --strip-debug "${LIBRARY}" RESULT_VARIABLE failed)
endif()
if(failed)
    message(FATAL_ERROR "trisap: ${LIBRARY} cannot be stripped: ${failed}")
endif()
