# The target `manual` makes man pages and bash completion of both programs in the folder manual/ of the build, from what
# the programs print about themselves. `cmake --install` installs the programs, and of these files what was made.
include(GNUInstallDirs)
find_program(HELP2MAN help2man)

# farshade_manual(PROGRAM SUMMARY): SUMMARY is the line NAME of the man page.
function(farshade_manual program summary)
  set(folder ${PROJECT_BINARY_DIR}/manual)
  if(HELP2MAN)
    add_custom_command(OUTPUT ${folder}/${program}.1 ${folder}/${program}
      COMMAND ${CMAKE_COMMAND} -D HELP2MAN=${HELP2MAN} -D PROGRAM=$<TARGET_FILE:${program}> -D NAME=${program}
        -D SUMMARY=${summary} -D VERSION=${PROJECT_VERSION} -D FOLDER=${folder} -P ${PROJECT_SOURCE_DIR}/cmake/make_manual.cmake
      DEPENDS ${program} ${PROJECT_SOURCE_DIR}/cmake/make_manual.cmake
      COMMENT "Manual of ${program}" VERBATIM)
    add_custom_target(manual_${program} DEPENDS ${folder}/${program}.1 ${folder}/${program})
    add_dependencies(manual manual_${program})
  endif()
  install(TARGETS ${program})
  install(DIRECTORY ${folder}/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 OPTIONAL FILES_MATCHING PATTERN ${program}*.1)
  install(FILES ${folder}/${program} DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions OPTIONAL)
endfunction()

if(HELP2MAN)
  add_custom_target(manual)
endif()
farshade_manual(rt_server "traces shadows for thin stereo clients")
farshade_manual(vr_client "shows a scene to both eyes with shadows that a server traces")
