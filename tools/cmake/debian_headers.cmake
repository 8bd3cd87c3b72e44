# SPDX-License-Identifier: Apache-2.0
# Of toolchain files: the libraries of headers only, which are the same for every machine, from Debian's packages. They
# are found in a folder that has nothing else: /usr/include also has the headers of this machine's C library.
set(headers ${CMAKE_BINARY_DIR}/debian)
foreach(name IN ITEMS include/CLI include/eigen3 include/nlohmann include/tiny_gltf.h include/xxhash.h include/stb share/cmake/CLI11
    share/cmake/nlohmann_json share/eigen3)
  if(EXISTS /usr/${name})
    get_filename_component(folder ${headers}/${name} DIRECTORY)
    file(MAKE_DIRECTORY ${folder})
    file(CREATE_LINK /usr/${name} ${headers}/${name} SYMBOLIC)
  endif()
endforeach()
set(CMAKE_FIND_ROOT_PATH ${headers})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
