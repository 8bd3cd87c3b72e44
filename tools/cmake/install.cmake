# SPDX-License-Identifier: Apache-2.0
# The CMake package `spheretree`. Two export sets, so that a program that only needs the Apache rooms never looks for
# oneTBB.
include(CMakePackageConfigHelpers)
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/spheretree)

set(permissive_targets spheretree_core spheretree_runtime spheretree_runtime_c spheretree_tissue)
set(permissive_headers libruntime/core/include/ libruntime/runtime/include/ libruntime/tissue/include/)
if(TARGET spheretree_scene)
  list(APPEND permissive_targets spheretree_scene spheretree_scene_c)
  list(APPEND permissive_headers libruntime/scene/include/)
endif()
if(TARGET spheretree_servo_c)
  list(APPEND permissive_targets spheretree_servo_c)
  list(APPEND permissive_headers libruntime/servo/include/)
endif()
foreach(room IN ITEMS formats device)
  if(TARGET spheretree_${room})
    list(APPEND permissive_targets spheretree_${room})
    list(APPEND permissive_headers ${room}/include/)
  endif()
endforeach()
install(TARGETS ${permissive_targets} EXPORT spheretree_targets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY ${permissive_headers} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(EXPORT spheretree_targets NAMESPACE spheretree:: DESTINATION ${package_folder})

# For programs in C and others, without CMake: `pkg-config --cflags --libs spheretree-runtime`. The paths are relative
# to the file, so that an installation can be moved.
set(pkgconfig_folder ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
file(RELATIVE_PATH pkgconfig_to_prefix ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
function(install_pkgconfig name library description)
  configure_file(tools/cmake/library.pc.in ${CMAKE_CURRENT_BINARY_DIR}/${name}.pc @ONLY)
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/${name}.pc DESTINATION ${pkgconfig_folder})
endfunction()
install_pkgconfig(spheretree-runtime spheretree_runtime "Haptic steps on sphere-trees, in C")
if(TARGET spheretree_scene_c)
  install_pkgconfig(spheretree-scene spheretree_scene "Haptic steps on sphere-trees with scene files, soft tissue and distances, in C")
endif()

if(TARGET spheretree_servo_c)
  install_pkgconfig(spheretree-servo spheretree_servo "Servo loop and haptic devices for engines, in C")
endif()

if(SPHERETREE_BUILDER)
  # CGAL is headers only and stays behind; what its arithmetic links does not.
  target_link_libraries(spheretree_builder PRIVATE $<INSTALL_INTERFACE:gmp> $<INSTALL_INTERFACE:mpfr>)
  install(TARGETS spheretree_builder EXPORT spheretree_builder_targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
  install(DIRECTORY libspheretree/include/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  install(EXPORT spheretree_builder_targets NAMESPACE spheretree:: DESTINATION ${package_folder})
endif()

configure_package_config_file(tools/cmake/spheretree-config.cmake.in ${CMAKE_CURRENT_BINARY_DIR}/spheretree-config.cmake
  INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/spheretree-config-version.cmake COMPATIBILITY SameMajorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/spheretree-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/spheretree-config-version.cmake
  DESTINATION ${package_folder})
install(FILES LICENSE LICENSE-APACHE-2.0 LICENSE-GPL-3.0 DESTINATION ${CMAKE_INSTALL_DOCDIR})
if(TARGET spheretree-tetrahedra)
  install(FILES LICENSE-AGPL-3.0 DESTINATION ${CMAKE_INSTALL_DOCDIR})
endif()
