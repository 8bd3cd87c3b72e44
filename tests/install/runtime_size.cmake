# SPDX-License-Identifier: Apache-2.0
# The runtime for any language is small: its shared library, stripped, is below 300 KiB. The rows of hulls, for two
# instruction sets, are 64 of them.
# Usage: cmake -DLIBRARY=FILE -DSTRIP=PROGRAM -DWORK=FOLDER -P runtime_size.cmake
execute_process(COMMAND ${STRIP} -o ${WORK}/stripped.so ${LIBRARY} COMMAND_ERROR_IS_FATAL ANY)
file(SIZE ${WORK}/stripped.so bytes)
message(STATUS "${bytes} bytes")
if(bytes GREATER_EQUAL 307200)
  message(FATAL_ERROR "the runtime's shared library has ${bytes} bytes: 307,199 are allowed")
endif()
