# Run by the target `manual` and by its test: writes into FOLDER the man pages NAME.1 and NAME-SUBCOMMAND.1, and the bash
# completion NAME, of PROGRAM. VERSION and SUMMARY get into the pages, paths of the builder's home do not.
file(MAKE_DIRECTORY ${FOLDER})

function(write_page words summary page)
  execute_process(
    COMMAND ${CMAKE_COMMAND} -E env --unset=XDG_CONFIG_HOME --unset=XDG_CACHE_HOME HOME=~ ${HELP2MAN} --no-info --section=1
      --version-string=${VERSION} "--source=Farshade ${VERSION}" --name=${summary} --output=${FOLDER}/${page}.1 "${PROGRAM}${words}"
    COMMAND_ERROR_IS_FATAL ANY)
endfunction()

write_page("" ${SUMMARY} ${NAME})
execute_process(COMMAND ${PROGRAM} --help OUTPUT_VARIABLE help COMMAND_ERROR_IS_FATAL ANY)
string(REGEX REPLACE ".*\nSubcommands:\n" "" subcommands "${help}")
string(REGEX REPLACE "\n\n.*" "\n" subcommands "${subcommands}")
string(REGEX MATCHALL "  [a-z]+ +[^\n]+\n" subcommands "${subcommands}")
foreach(line IN LISTS subcommands)
  string(REGEX MATCH "  ([a-z]+) +([^\n.]+)" matched "${line}")
  write_page(" ${CMAKE_MATCH_1}" "${CMAKE_MATCH_2}" ${NAME}-${CMAKE_MATCH_1})
endforeach()
execute_process(COMMAND ${PROGRAM} --completion bash OUTPUT_FILE ${FOLDER}/${NAME} COMMAND_ERROR_IS_FATAL ANY)
