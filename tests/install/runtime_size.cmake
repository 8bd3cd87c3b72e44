# SPDX-License-Identifier: Apache-2.0
# The runtime for any language is small: its shared library, stripped, is below 320 KiB. The rows of hulls, for two
# instruction sets, are 80 of them.
# Usage: cmake -DLIBRARY=FILE -DSTRIP=PROGRAM -DWORK=FOLDER -P runtime_size.cmake
execute_process(COMMAND ${STRIP} -o ${WORK}/stripped.so ${LIBRARY} COMMAND_ERROR_IS_FATAL ANY)
file(SIZE ${WORK}/stripped.so bytes)
message(STATUS "${bytes} bytes")
if(bytes GREATER_EQUAL 327680)
  message(FATAL_ERROR "the runtime's shared library has ${bytes} bytes: 327,679 are allowed")
endif()
