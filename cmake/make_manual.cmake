# Run by the target `manual` and by its test: writes FOLDER/NAME.1 and FOLDER/NAME, the man page and the bash completion
# of PROGRAM. Paths of the builder's home must not get into the page.
file(MAKE_DIRECTORY ${FOLDER})
execute_process(
  COMMAND ${CMAKE_COMMAND} -E env --unset=XDG_CONFIG_HOME --unset=XDG_CACHE_HOME HOME=~ ${HELP2MAN} --no-info --section=1
    --help-option=--help-all --version-string=${VERSION} --name=${SUMMARY} --source=Farshade --output=${FOLDER}/${NAME}.1 ${PROGRAM}
  COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${PROGRAM} --completion bash OUTPUT_FILE ${FOLDER}/${NAME} COMMAND_ERROR_IS_FATAL ANY)
