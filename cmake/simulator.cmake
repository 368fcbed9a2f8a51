# SPDX-License-Identifier: MIT
# sd_simulator_library(NAME SOURCES... LINKS... [PRIVATE_LINKS...]): a library of what simulates, designs and scores: matrices and figures,
# no bytes from elsewhere. The preset asan takes the optimised build's, so that each is compiled once and the sanitizers' time is spent
# where they find something: firmware, hal, readers and the tests themselves. The preset asan-full compiles and watches these too.
option(SD_SANITIZE_SIMULATOR "with SD_SANITIZE: what simulates, designs and scores as well" OFF)

function(sd_simulator_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS;PRIVATE_LINKS" ${ARGN})
  if(NOT SD_SANITIZE OR SD_SANITIZE_SIMULATOR)
    add_library(${name} STATIC ${ARG_SOURCES})
    target_link_libraries(${name} PUBLIC ${ARG_LINKS} PRIVATE ${ARG_PRIVATE_LINKS})
    set_property(GLOBAL APPEND PROPERTY SD_SIMULATOR_LIBRARIES ${name})
    return()
  endif()
  file(RELATIVE_PATH folder ${PROJECT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
  set(archive ${PROJECT_SOURCE_DIR}/build/host/${folder}/lib${name}.a)
  add_library(${name} STATIC IMPORTED GLOBAL)
  set_target_properties(${name} PROPERTIES IMPORTED_LOCATION ${archive})
  target_link_libraries(${name} INTERFACE ${ARG_LINKS} ${ARG_PRIVATE_LINKS})
  add_dependencies(${name} simulator)
  set_property(GLOBAL APPEND PROPERTY SD_SIMULATOR_ARCHIVES ${archive})
endfunction()

# After the last of them: the target simulator, which builds them all.
function(sd_simulator_target)
  get_property(libraries GLOBAL PROPERTY SD_SIMULATOR_LIBRARIES)
  get_property(archives GLOBAL PROPERTY SD_SIMULATOR_ARCHIVES)
  if(archives)
    add_custom_target(simulator COMMAND ${PROJECT_SOURCE_DIR}/tools/build host simulator BYPRODUCTS ${archives}
                      COMMENT "The host preset's simulator")
    return()
  endif()
  add_custom_target(simulator)
  add_dependencies(simulator ${libraries})
endfunction()
