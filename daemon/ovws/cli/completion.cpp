#include <fmt/core.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>

#include "daemon/ovws/cli/command_line.hpp"
#include "daemon/ovws/text/mode_names.hpp"
#include "daemon/ovws/text/params.hpp"
#include "daemon/shared/schemas/schemas.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;
/// Space-separated words, keyed by "command", "command option", "command position", "method" or
/// "method key". Sorted, so that the generated script is reproducible.
using WordLists = std::map<std::string, std::string>;

struct Tables {
  WordLists options;  ///< options of a command; command " " is ovws itself
  WordLists valued;   ///< options that take a value
  WordLists choices;  ///< values of an option, or of the k-th positional of a command
  WordLists keys;     ///< keys of a method's params
  WordLists values;   ///< named values of a params key
};

void append(std::string& words, const std::string& word) {
  words += (words.empty() ? "" : " ") + word;
}

/// The option's choices, parsed from CLI11's type name "TEXT:{a,b,c}"; empty if it has none.
std::string choices_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const auto begin = type.find('{'), end = type.find('}');
  if (begin == std::string::npos || end == std::string::npos) return {};
  std::string words = type.substr(begin + 1, end - begin - 1);
  for (char& c : words) {
    if (c == ',') c = ' ';
  }
  return words;
}

void add_syntax(Tables& tables, const CLI::App& app, const std::string& command) {
  int place = 0;
  for (const CLI::Option* option : app.get_options()) {
    const std::string choices = choices_of(*option);
    if (!option->nonpositional()) {
      ++place;
      if (!choices.empty()) tables.choices[command + " " + std::to_string(place)] = choices;
      continue;
    }
    std::vector<std::string> names;
    for (const std::string& name : option->get_snames()) names.push_back("-" + name);
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    for (const std::string& name : names) {
      append(tables.options[command], name);
      if (option->get_items_expected_max() > 0) append(tables.valued[command], name);
      if (!choices.empty()) tables.choices[command + " " + name] = choices;
    }
  }
}

void add_method(Tables& tables, const std::string& method, const json& params) {
  append(tables.choices["call 1"], method);
  append(tables.choices["describe 1"], method);
  for (const ParamsKey& key : keys_of(params)) {
    append(tables.keys[method], key.path + (is_mode_list(key.schema) ? "." : "="));
    std::string& values = tables.values[method + " " + key.path];
    for (const json& value : key.schema.value("enum", json::array())) {
      if (value.is_string()) append(values, value.get<std::string>());
    }
    if (key.schema.value("type", json()) == "boolean") values = "true false";
  }
}

std::string table(const char* name, const WordLists& words) {
  std::string text = fmt::format("declare -gA {}=(\n", name);
  for (const auto& [key, value] : words) {
    if (!value.empty()) text += fmt::format("  [\"{}\"]=\"{}\"\n", key, value);
  }
  return text + ")\n";
}

// Bash splits words at "=", so that KEY=VALUE is three words.
constexpr std::string_view kFunctions = R"bash(
# Completes KEY=VALUE of a method: keys, modes of a list of modes, and named values.
_ovws_params() {
  local method=$1 cur=$2 key=$3 words name
  if [[ -n $key ]]; then
    words=${_ovws_values["$method $key"]}
  else
    words=${_ovws_keys[$method]}
    if [[ $cur == *.* && " $words " == *" ${cur%%.*}. "* ]]; then
      words=""
      for name in $_ovws_modes; do words+=" ${cur%%.*}.$name="; done
    fi
    compopt -o nospace 2> /dev/null
  fi
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$cur")
}

_ovws() {
  local cur=${COMP_WORDS[COMP_CWORD]} command=" " expecting="" method="" place=0 skip="" word i words
  local key=""
  COMPREPLY=()
  ((COMP_CWORD > 1)) && [[ ${COMP_WORDS[COMP_CWORD - 1]} == "=" ]] && key=${COMP_WORDS[COMP_CWORD - 2]}
  if [[ $cur == "=" ]]; then
    key=${COMP_WORDS[COMP_CWORD - 1]}
    cur=""
  fi
  for ((i = 1; i < COMP_CWORD; i++)); do
    word=${COMP_WORDS[i]}
    if [[ $word == "=" ]]; then
      continue
    elif [[ $word == ":" || -n $skip ]]; then  # bash splits tcp://HOST:PORT
      [[ $word == ":" ]] && skip=yes || skip=""
    elif [[ -n $expecting ]]; then
      expecting=""
    elif [[ " ${_ovws_valued[$command]} ${_ovws_valued[" "]} " == *" $word "* ]]; then
      expecting=$word
    elif [[ $word == -* ]]; then
      continue
    elif [[ $command == " " ]]; then
      command=$word
    else
      ((place++))
      [[ $place == 1 ]] && method=$word
    fi
  done
  if [[ -n $expecting ]]; then
    words=${_ovws_choices["$command $expecting"]}
  elif [[ $cur == -* ]]; then
    words="${_ovws_options[$command]} ${_ovws_options[" "]}"
  elif [[ $command == " " ]]; then
    words=$_ovws_commands
  elif [[ $command == call && -n $method ]]; then
    _ovws_params "$method" "$cur" "$key"
    return
  elif [[ $command == aberrate ]]; then
    mapfile -t COMPREPLY < <(compgen -S "=" -W "$_ovws_modes" -- "$cur")
    [[ -n $key ]] && COMPREPLY=()
    compopt -o nospace 2> /dev/null
    return
  elif [[ $command == loop && -n $method ]]; then
    _ovws_params "loop.$method" "$cur" "$key"
    return
  else
    words=${_ovws_choices["$command $((place + 1))"]}
  fi
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$cur" | sort -u)
}

# Complete file names if nothing else matches.
complete -o default -F _ovws ovws
)bash";

std::string bash_completion(const CLI::App& app) {
  Tables tables;
  std::string commands;
  add_syntax(tables, app, " ");
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    append(commands, command->get_name());
    add_syntax(tables, *command, command->get_name());
  }
  for (const Schema& one : schemas()) {
    if (one.json.contains("params")) add_method(tables, one.name, one.json["params"]);
  }
  std::string text =
      "# bash completion of ovws " OVWS_VERSION ", generated by: ovws completion bash\n";
  text += fmt::format("_ovws_commands=\"{}\"\n_ovws_modes=\"{}\"\n", commands,
                      fmt::join(mode_names(), " "));
  text += table("_ovws_options", tables.options) + table("_ovws_valued", tables.valued);
  text += table("_ovws_choices", tables.choices) + table("_ovws_keys", tables.keys);
  return text + table("_ovws_values", tables.values) + std::string(kFunctions);
}

}  // namespace

void add_completion(CLI::App& app) {
  auto* command = app.add_subcommand(
      "completion",
      "print a shell completion script for commands, options, methods and their keys: "
      "source <(ovws completion bash)");
  auto shell = std::make_shared<std::string>();
  command->add_option("shell", *shell, "shell")->required()->check(CLI::IsMember({"bash"}));
  command->callback([&app, shell] {
    if (*shell == "bash") print("{}", bash_completion(app));
  });
}

}  // namespace ovws::cli
