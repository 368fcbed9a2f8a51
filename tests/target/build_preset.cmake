# SPDX-License-Identifier: MIT
# Configures and builds one preset, where anything changed, and looks whether the libraries are there.
# Objects alone are of the long set.
if(PRESET MATCHES "cortex-r" AND NOT DEFINED ENV{SD_FULL})
  return()
endif()
set(folder ${SOURCE}/build/${PRESET})
foreach(step "--preset;${PRESET}" "--build;--preset;${PRESET}")
  execute_process(COMMAND ${CMAKE_COMMAND} ${step} WORKING_DIRECTORY ${SOURCE} RESULT_VARIABLE failed
                  OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(failed)
    message(FATAL_ERROR "cmake ${step} failed:\n${output}")
  endif()
endforeach()
foreach(library crank/libsd_crank.a torque/libsd_torque.a ecu/libsd_ecu.a)
  if(NOT EXISTS ${folder}/firmware/${library})
    message(FATAL_ERROR "${folder}/firmware/${library} was not built")
  endif()
endforeach()
