# SPDX-License-Identifier: MIT
# Compiles a line with a kernel's own include paths and definitions: hal.h must stay out of reach both ways.
string(REPLACE "," ";" includes "${INCLUDES}")
string(REPLACE "," ";" definitions "${DEFINITIONS}")
list(TRANSFORM includes PREPEND -I)
list(TRANSFORM definitions PREPEND -D)
# A file a kernel: these tests run beside one another.
set(probe ${KERNEL}_probe.c)
file(WRITE ${probe} "#include PROBE\nint probe;\n")

function(compile header result)
  execute_process(COMMAND ${COMPILER} ${includes} ${definitions} "-DPROBE=\"${header}\"" -fsyntax-only ${probe}
                  RESULT_VARIABLE failed ERROR_VARIABLE message)
  set(${result} "${failed};${message}" PARENT_SCOPE)
endfunction()

compile(sd_status.h control)
if(NOT control MATCHES "^0")
  message(FATAL_ERROR "the control, a header the kernel may include, does not compile: ${control}")
endif()
compile(hal.h by_name)
if(NOT by_name MATCHES "No such file")
  message(FATAL_ERROR "a kernel finds hal.h by name: ${by_name}")
endif()
compile(${HAL} by_path)
if(NOT by_path MATCHES "a kernel must not include hal.h")
  message(FATAL_ERROR "a kernel may include hal.h by its path: ${by_path}")
endif()
