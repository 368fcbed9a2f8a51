# SPDX-License-Identifier: MIT
# The outside functions a kernel library calls: memset and memcpy, and no heap, no I/O, no libm.
execute_process(COMMAND ${NM} --undefined-only --format=posix ${LIBRARY} OUTPUT_VARIABLE symbols RESULT_VARIABLE failed)
if(failed)
  message(FATAL_ERROR "nm failed on ${LIBRARY}")
endif()
string(REGEX MATCHALL "[A-Za-z_][A-Za-z0-9_.]* U" calls "${symbols}")
foreach(call ${calls})
  string(REPLACE " U" "" call ${call})
  if(NOT call MATCHES "^(memset|memcpy|_GLOBAL_OFFSET_TABLE_|sd_.*)$")
    message(FATAL_ERROR "${LIBRARY} calls ${call}")
  endif()
endforeach()
