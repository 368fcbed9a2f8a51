# SPDX-License-Identifier: MIT
# sd_firmware_library(NAME SOURCES... LINKS...): a firmware library with the house's warnings as errors.
# sd_kernel(NAME SOURCES... LINKS...): the same for a kernel, which sees its own folder and what it links,
# never hal/: there is no include path to it, and SD_KERNEL makes hal.h refuse a relative include too.
set(SD_WARNINGS -Wall -Wextra -Wconversion -Wsign-conversion -Wdouble-promotion -Wshadow -Werror)

function(sd_firmware_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  target_include_directories(${name} PUBLIC ${CMAKE_CURRENT_SOURCE_DIR})
  target_link_libraries(${name} PUBLIC ${ARG_LINKS})
  target_compile_options(${name} PRIVATE ${SD_WARNINGS} -O2)
endfunction()

function(sd_kernel name)
  sd_firmware_library(${name} ${ARGN})
  target_compile_definitions(${name} PRIVATE SD_KERNEL=1)
endfunction()
