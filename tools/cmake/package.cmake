# SPDX-License-Identifier: GPL-3.0-or-later
# Manual pages and shell completion, made by the programs of themselves, and Debian packages: `cpack -G DEB` in the
# build folder.
function(spheretree_install_reference program)
  if(CMAKE_CROSSCOMPILING OR SPHERETREE_SANITIZE_THREADS)
    return()
  endif()
  set(folder ${CMAKE_CURRENT_BINARY_DIR}/reference)
  set(files ${folder}/${program}.1 ${folder}/${program}.bash ${folder}/${program}.zsh ${folder}/${program}.fish)
  add_custom_command(OUTPUT ${files} VERBATIM DEPENDS ${program}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${folder}
    COMMAND ${program} --manual > ${folder}/${program}.1
    COMMAND ${program} --completion bash > ${folder}/${program}.bash
    COMMAND ${program} --completion zsh > ${folder}/${program}.zsh
    COMMAND ${program} --completion fish > ${folder}/${program}.fish)
  add_custom_target(${program}_reference ALL DEPENDS ${files})
  install(FILES ${folder}/${program}.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
  install(FILES ${folder}/${program}.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME ${program})
  install(FILES ${folder}/${program}.zsh DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions RENAME _${program})
  install(FILES ${folder}/${program}.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d)
endfunction()

if(SPHERETREE_TOOLS)
  spheretree_install_reference(spheretree)
  spheretree_install_reference(haptic-player)
endif()

if(PROJECT_IS_TOP_LEVEL)
  set(CPACK_GENERATOR DEB)
  set(CPACK_PACKAGE_CONTACT "The spheretree developers <spheretree@localhost>")
  set(CPACK_PACKAGE_DESCRIPTION_SUMMARY ${PROJECT_DESCRIPTION})
  set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
  set(CPACK_STRIP_FILES ON)
  set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
  set(CPACK_DEBIAN_PACKAGE_SECTION science)
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
  # spheretree; and, for the interpreter that it was built for, python3-spheretree, which needs nothing of the other.
  set(CPACK_DEB_COMPONENT_INSTALL ON)
  set(CPACK_COMPONENTS_ALL Unspecified)
  set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_NAME spheretree)
  set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_RECOMMENDS "fonts-dejavu-core, librsvg2-bin")
  if(SPHERETREE_PYTHON_PACKAGE_NEEDS)
    list(APPEND CPACK_COMPONENTS_ALL python3_package)
    set(CPACK_DEBIAN_PYTHON3_PACKAGE_PACKAGE_NAME python3-spheretree)
    set(CPACK_DEBIAN_PYTHON3_PACKAGE_PACKAGE_SECTION python)
    set(CPACK_DEBIAN_PYTHON3_PACKAGE_PACKAGE_DEPENDS ${SPHERETREE_PYTHON_PACKAGE_NEEDS})
    set(CPACK_COMPONENT_PYTHON3_PACKAGE_DESCRIPTION "Python package of spheretree: build, measure and touch sphere-trees")
  endif()
  include(CPack)
endif()
