# SPDX-License-Identifier: GPL-3.0-or-later
# Manual pages and shell completion, made by the programs of themselves.
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
  if(TARGET spheretree-import)
    spheretree_install_reference(spheretree-import)
  endif()
endif()
