#include "stereo/options/completion.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "stereo/options/command_line.h"

namespace farshade {
namespace {

/// {0}: the program, {1}: cases that choose `command`, {2}: cases of options with a
/// value, {3}: the words of each command. Bash splits --mode=full at the sign, zsh does not.
constexpr const char* kScript = R"(# Completion of {0}, printed by {0} --completion
_farshade_{0}() {{
  local current=$2 previous=$3 prefix='' command='' words='' word
  COMPREPLY=()
  if [[ $current == '=' ]]; then
    previous=$previous= current=''
  elif [[ $previous == '=' ]]; then
    previous=${{COMP_WORDS[COMP_CWORD-2]}}=
  elif [[ $current == --*=* ]]; then
    previous=${{current%%=*}}= prefix=${{current%%=*}}= current=${{current#*=}}
  fi
  for word in "${{COMP_WORDS[@]:1:$((COMP_CWORD-1))}}"; do
    case $word in
{1}    esac
  done
  case $command:$previous in
{2}    *) case $command in
{3}    esac ;;
  esac
  COMPREPLY=($(compgen -P "$prefix" -W "$words" -- "$current"))
}}
complete -o bashdefault -o default -F _farshade_{0} {0}
)";

bool has_positional(const CLI::App& app) {
  return std::ranges::any_of(app.get_options(),
                             [](const CLI::Option* option) { return option->get_positional(); });
}

/// The words that an option takes, separated by spaces; empty if it takes anything else.
std::string words_of(const CLI::Option& option) {
  const std::string full = option.get_type_name(), type = full.substr(0, full.find(':'));
  if (type.find('|') == std::string::npos) return {};
  std::string words = type;
  std::ranges::replace(words, '|', ' ');
  return words;
}

/// A case for each option of `app` that takes a value. The value of an option that may stand alone follows
/// only after =.
std::string cases_of_values(const CLI::App& app, const std::string& command) {
  std::string cases;
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_items_expected_max() == 0) continue;
    for (const std::string& name : option->get_lnames()) {
      std::string pattern = fmt::format("{}:--{}=", command, name);
      if (option->get_expected_min() > 0) pattern = fmt::format("{}:--{} | {}", command, name, pattern);
      const std::string words = words_of(*option);
      cases += fmt::format("    {}) {} ;;\n", pattern,
                           words.empty() ? "return" : fmt::format("words='{}'", words));
    }
  }
  return cases;
}

}  // namespace

std::string completion_script(const CLI::App& app, Shell shell) {
  std::vector<std::string> words = options_of(app);
  std::string choose, values = cases_of_values(app, ""), lists;
  for (const CLI::App* command : commands_of(app)) {
    const std::string& name = command->get_name();
    words.push_back(name);
    choose += fmt::format("      {0}) command={0}; break ;;\n", name);
    values += cases_of_values(*command, name);
    // A value without an option is completed as a file.
    lists += fmt::format("      {}) {}words='{}' ;;\n", name,
                         has_positional(*command) ? "[[ $current == -* ]] || return; " : "",
                         fmt::join(options_of(*command), " "));
  }
  lists = fmt::format("      '') words='{}' ;;\n", fmt::join(words, " ")) + lists;
  const std::string script = fmt::format(kScript, app.get_name(), choose, values, lists);
  return shell == Shell::Zsh ? "autoload -U +X bashcompinit && bashcompinit\n" + script : script;
}

void add_completion_option(CLI::App& app) {
  const auto print = [&app](const std::string& shell) {
    fmt::print("{}", completion_script(app, shell == "zsh" ? Shell::Zsh : Shell::Bash));
    throw CLI::Success();
  };
  app.add_option_function<std::string>(
         "--completion", print, "print a script that completes this command line in the shell, and exit")
      ->type_name("bash|zsh")
      ->check(one_of({"bash", "zsh"}))
      ->configurable(false);
}

}  // namespace farshade
