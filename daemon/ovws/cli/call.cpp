/// ovws call: any method of a daemon.
#include <unistd.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "daemon/ovws/cli/command_line.hpp"
#include "daemon/ovws/cli/request.hpp"
#include "daemon/ovws/text/answer.hpp"
#include "daemon/ovws/text/params.hpp"
#include "daemon/shared/schemas/schemas.hpp"
#include "proto/json_text.hpp"
#include "proto/reader.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;

struct CallOptions {
  std::string method;
  std::vector<std::string> params;  ///< words, see params_of
  bool wait = false;
};

constexpr const char* kParamsHelp =
    "Dots in a KEY nest. A list is written as 3,4,5 or as JSON. Lists of modes\n"
    "also accept LIST.MODE=NUMBER:\n"
    "  ovws call aberration.set modes.vertical-coma=0.2 modes.4=-0.1\n"
    "  ovws call loop.close modes=defocus,primary-spherical\n"
    "MODE is the OSA/ANSI index j, a name, or (not in a list with commas) n,m.\n"
    "Words of a name can be left out while it stays unique: spherical is\n"
    "primary-spherical. coma is refused, because it can be vertical-coma or\n"
    "horizontal-coma.";

/// Formats JSON with indents; arrays of primitive values stay on one line.
std::string readable(const json& value, const std::string& margin = "") {
  const auto is_plain = [](const json& one) { return one.is_primitive(); };
  const bool is_line = value.is_primitive() || value.empty() ||
                       (value.is_array() && std::all_of(value.begin(), value.end(), is_plain));
  if (is_line) return json_text(value);
  std::string text = value.is_array() ? "[" : "{";
  const std::string inner = margin + "  ";
  for (const auto& [key, one] : value.items()) {
    text += (text.size() == 1 ? "\n" : ",\n") + inner;
    if (value.is_object()) text += json_text(json(key)) + ": ";
    text += readable(one, inner);
  }
  return text + "\n" + margin + (value.is_array() ? "]" : "}");
}

/// The mistake of a name that is almost that of a method. None: it may be a method of another
/// program, e.g. of the twin, or of another version.
std::optional<Error> misspelt(const std::string& method) {
  std::vector<std::string> known;
  for (const Schema& one : schemas()) {
    if (one.json.contains("params")) known.push_back(one.name);
  }
  const auto near = nearest_name(method, known);
  if (!near) return std::nullopt;
  return Error{Errc::invalid, method, "unknown method; did you mean " + *near + "?"};
}

int call_method(const Common& common, const CallOptions& options) {
  const json& of_method = schema(options.method);
  const bool is_known = of_method.contains("params");
  if (const auto mistake = misspelt(options.method); !is_known && mistake) {
    return report_mistake(common, *mistake);
  }
  const auto params = params_of(is_known ? of_method.at("params") : any_params(), options.params);
  if (!params) return report_mistake(common, params.error());
  const json answer = needed(options.wait ? call_and_wait(common, options.method, *params)
                                          : call(common, options.method, *params));
  const bool is_for_people = !common.json && isatty(STDOUT_FILENO) != 0;
  return print_result(common, answer,
                      is_for_people ? answer_text(options.method, answer) : readable(answer),
                      kAnswerIndent);
}

}  // namespace

void add_call(CLI::App& app, const Common& common, int& status) {
  auto [command, options] = add_command(
      app, common, status, "call",
      "call any method of the daemon, e.g. ovws call camera.set exposure_us=2000 roi.width=512",
      call_method);
  command.footer(kParamsHelp);
  command.add_option("method", options.method, "name of the method; ovws describe lists all")
      ->required();
  command.add_option("params", options.params,
                     "KEY=VALUE, a JSON object, @FILE with a JSON object, or - for one on standard "
                     "input; later words override earlier ones");
  command.add_flag("--wait,-w", options.wait,
                   "if the method starts a job, wait for its end and print its result, or why it "
                   "failed; on a terminal also show its progress");
}

}  // namespace ovws::cli
