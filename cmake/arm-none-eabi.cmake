# SPDX-License-Identifier: MIT
# Bare-metal Arm; the preset names the core in SD_CPU_FLAGS.
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR arm)
set(CMAKE_C_COMPILER arm-none-eabi-gcc)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
set(CMAKE_C_FLAGS_INIT "-mthumb ${SD_CPU_FLAGS} -ffunction-sections -fdata-sections")
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES SD_CPU_FLAGS)
