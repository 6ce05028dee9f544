# cmake -D SOURCE=FOLDER -D INTO=FILE.cpp -P commit.cmake: defines kCommit for about.cpp: the commit of the
# sources, with "+" if files have changed since then, or an empty text if the sources are in no repository of their own.
cmake_minimum_required(VERSION 3.25)
set(commit "")
if(EXISTS ${SOURCE}/.git)
  execute_process(COMMAND git -C ${SOURCE} rev-parse --short=12 HEAD
    OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  execute_process(COMMAND git -C ${SOURCE} status --porcelain --untracked-files=no
    OUTPUT_VARIABLE changes OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  if(changes)
    string(APPEND commit "+")
  endif()
endif()
file(CONFIGURE OUTPUT ${INTO} CONTENT "namespace farshade {
extern const char kCommit[];
const char kCommit[] = \"${commit}\";
}  // namespace farshade
")
