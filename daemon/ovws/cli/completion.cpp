#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>

#include "daemon/ovws/cli/command_line.hpp"
#include "daemon/shared/schemas/schemas.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;
/// Space-separated words, keyed by "command", "command option", "command position", "method" or
/// "method key". Sorted, so that the generated script is reproducible.
using Words = std::map<std::string, std::string>;

struct Tables {
  Words options;  ///< options of a command; command " " is ovws itself
  Words valued;   ///< options that take a value
  Words choices;  ///< values of an option, or of the k-th positional of a command
  Words keys;     ///< keys of a method's params
  Words values;   ///< named values of a params key
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

void add_command(Tables& tables, const CLI::App& app, const std::string& command) {
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
  const json properties = params.value("properties", json::object());
  for (const auto& [key, schema] : properties.items()) {
    append(tables.keys[method], key);
    std::string& values = tables.values[method + " " + key];
    for (const json& value : schema.value("enum", json::array())) {
      if (value.is_string()) append(values, value.get<std::string>());
    }
    if (schema.value("type", json()) == "boolean") values = "true false";
  }
}

std::string table(const char* name, const Words& words) {
  std::string text = fmt::format("declare -gA {}=(\n", name);
  for (const auto& [key, value] : words) {
    if (!value.empty()) text += fmt::format("  [\"{}\"]=\"{}\"\n", key, value);
  }
  return text + ")\n";
}

// COMP_WORDS keeps the opening quote of a word; the replacement in COMPREPLY starts after it.
constexpr std::string_view kFunctions = R"bash(
# Completes the keys of a method's params and their named values: {"key": "value"}.
_ovws_params() {
  local method=$1 text=${2#\'} open="'" before key word
  [[ $2 == \'* ]] && open=""
  if [[ -z $text || $text == "{" ]]; then
    for word in ${_ovws_keys[$method]}; do COMPREPLY+=("$open{\"$word\": "); done
  elif [[ $text == *\"* ]]; then
    before=${text%\"*}
    if [[ $before =~ \"([a-z_]+)\":\ *$ ]]; then
      key=${BASH_REMATCH[1]}
      for word in ${_ovws_values["$method $key"]}; do COMPREPLY+=("$open$before\"$word\"}"); done
    else
      for word in ${_ovws_keys[$method]}; do COMPREPLY+=("$open$before\"$word\": "); done
    fi
  fi
  local all=("${COMPREPLY[@]}")
  COMPREPLY=()
  for word in "${all[@]}"; do [[ $word == "$open$text"* ]] && COMPREPLY+=("$word"); done
  # Add a second choice: bash would close the quote of a single one, but the value still follows.
  [[ ${#COMPREPLY[@]} == 1 && $COMPREPLY == *": " ]] && COMPREPLY+=("$COMPREPLY…")
  compopt -o nospace 2> /dev/null
}

_ovws() {
  local cur=${COMP_WORDS[COMP_CWORD]} command=" " expecting="" method="" place=0 skip="" word i words
  COMPREPLY=()
  [[ $cur == "=" ]] && cur=""
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
  elif [[ $command == call && $place == 1 ]]; then
    _ovws_params "$method" "$cur"
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
  add_command(tables, app, " ");
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    append(commands, command->get_name());
    add_command(tables, *command, command->get_name());
  }
  for (const Schema& one : schemas()) {
    if (one.json.contains("params")) add_method(tables, one.name, one.json["params"]);
  }
  std::string text =
      "# bash completion of ovws " OVWS_VERSION ", generated by: ovws completion bash\n";
  text += fmt::format("_ovws_commands=\"{}\"\n", commands);
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
  command->callback([&app] { print("{}", bash_completion(app)); });
}

}  // namespace ovws::cli
