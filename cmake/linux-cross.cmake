# SPDX-License-Identifier: MIT
# Another processor under Linux, whose programs the user-mode emulator runs; the preset names compiler and flags.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR ${SD_TRIPLE})
set(CMAKE_C_COMPILER ${SD_TRIPLE}-gcc)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
set(CMAKE_C_FLAGS_INIT "${SD_CPU_FLAGS}")
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES SD_TRIPLE SD_CPU_FLAGS)
